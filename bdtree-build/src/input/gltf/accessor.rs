//! Accessors: numbers in buffers, checked before they are read.
//!
//! Not the crate's readers: they multiply extents unchecked, unwrap on sparse data that ends early,
//! and take any component type for the one they expect.

use gltf::json::accessor::{Accessor, ComponentType, Type, sparse};
use gltf::json::validation::Checked;

use super::buffers::Buffers;
use super::elements::{Elements, Strided};
use super::notes::Notes;

/// Most elements of an accessor that has no bytes of its own.
const VIRTUAL_COUNT_MAX: usize = 1 << 20;

/// What an accessor is read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Rest positions; `quantised`: integers too.
    Positions { quantised: bool },
    /// Displacements of a morph target; zeros where there are no bytes.
    Displacements { quantised: bool },
    /// Corner indices.
    Indices,
    /// Times of key frames.
    Times,
    /// Weights of morph targets.
    Weights,
    /// Joints of a skin.
    Joints,
    /// Weights of joints.
    JointWeights,
    /// Inverse bind matrices.
    Matrices,
    /// Translations and scales over time.
    Vectors,
    /// Rotations over time.
    Rotations,
}

impl Purpose {
    fn kind(self) -> (Type, &'static str) {
        match self {
            Purpose::Positions { .. } | Purpose::Displacements { .. } => (Type::Vec3, "VEC3"),
            Purpose::Vectors => (Type::Vec3, "VEC3"),
            Purpose::Joints | Purpose::JointWeights | Purpose::Rotations => (Type::Vec4, "VEC4"),
            Purpose::Matrices => (Type::Mat4, "MAT4"),
            Purpose::Indices | Purpose::Times | Purpose::Weights => (Type::Scalar, "SCALAR"),
        }
    }

    /// The component types that are read, in words, if `component` is none of them.
    fn refuses(self, component: ComponentType, normalized: bool) -> Option<&'static str> {
        use ComponentType::{F32, I8, I16, U8, U16, U32};
        let small = matches!(component, I8 | U8 | I16 | U16);
        match self {
            Purpose::Positions { quantised } | Purpose::Displacements { quantised } => {
                let message = if quantised {
                    "FLOAT or, by KHR_mesh_quantization, BYTE or SHORT"
                } else {
                    "FLOAT (integers belong to KHR_mesh_quantization, which is not named)"
                };
                (component != F32 && !(quantised && small)).then_some(message)
            }
            Purpose::Indices => (!matches!(component, U8 | U16 | U32))
                .then_some("UNSIGNED_BYTE, UNSIGNED_SHORT or UNSIGNED_INT"),
            Purpose::Times | Purpose::Matrices | Purpose::Vectors => {
                (component != F32).then_some("FLOAT")
            }
            Purpose::Joints => (!matches!(component, U8 | U16) || normalized)
                .then_some("UNSIGNED_BYTE or UNSIGNED_SHORT, not normalized"),
            Purpose::JointWeights => {
                let is_share = normalized && matches!(component, U8 | U16);
                let message = "FLOAT or normalized UNSIGNED_BYTE or UNSIGNED_SHORT";
                (component != F32 && !is_share).then_some(message)
            }
            Purpose::Weights | Purpose::Rotations => (component != F32 && !(small && normalized))
                .then_some("FLOAT or normalized BYTE or SHORT"),
        }
    }
}

/// A document's accessors.
pub(super) struct Accessors<'a> {
    pub(super) list: &'a [Accessor],
    pub(super) buffers: Buffers<'a>,
}

impl Accessors<'_> {
    /// The elements of accessor `index`. What is wrong is noted at `place`, which names its user.
    pub(super) fn read(
        &self,
        index: usize,
        purpose: Purpose,
        place: &str,
        notes: &mut Notes,
    ) -> Option<Elements<'_>> {
        let name = format!("accessors[{index}]");
        let Some(accessor) = self.list.get(index) else {
            return notes.refuse(place, format!("there is no {name}"));
        };
        let (kind, wanted) = purpose.kind();
        let (Checked::Valid(component), Checked::Valid(found)) =
            (accessor.component_type, accessor.type_)
        else {
            return notes.refuse(place, format!("{name} has an unknown type"));
        };
        let component = component.0;
        if found != kind {
            return notes.refuse(place, format!("{name} is not of type {wanted}"));
        }
        if let Some(wanted) = purpose.refuses(component, accessor.normalized) {
            let code = component.as_gl_enum();
            let message = format!(
                "{name}: componentType {code} ({}) is not {wanted}",
                word(component)
            );
            return notes.refuse(place, message);
        }
        let Some(count) = u32::try_from(accessor.count.0).ok().map(|n| n as usize) else {
            return notes.refuse(
                place,
                format!("{name} has more elements than 32 bits count"),
            );
        };
        let size = component.size() * kind.multiplicity();
        let base = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                let span = Span {
                    view: view.value(),
                    offset,
                    count,
                    size,
                };
                Some(self.strided(span, &name, place, notes)?)
            }
            None => None,
        };
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(self.sparse(sparse, count, size, &name, place, notes)?),
            None => None,
        };
        let is_virtual = base.is_none() && !matches!(purpose, Purpose::Displacements { .. });
        if is_virtual && (sparse.is_none() || count > VIRTUAL_COUNT_MAX) {
            let message = format!("{name} has no bufferView: its data may be in an extension");
            return notes.refuse(place, message);
        }
        Some(Elements {
            count,
            component,
            normalized: accessor.normalized,
            base,
            sparse,
        })
    }

    fn sparse(
        &self,
        sparse: &sparse::Sparse,
        count: usize,
        size: usize,
        name: &str,
        place: &str,
        notes: &mut Notes,
    ) -> Option<(Vec<u32>, Strided<'_>)> {
        let Checked::Valid(component) = sparse.indices.component_type else {
            return notes.refuse(place, format!("{name}.sparse.indices has an unknown type"));
        };
        let component = component.0;
        let Some(changed) = usize::try_from(sparse.count.0).ok().filter(|&n| n <= count) else {
            let message = format!(
                "{name}.sparse replaces {} of {count} elements",
                sparse.count.0
            );
            return notes.refuse(place, message);
        };
        let span = Span {
            view: sparse.indices.buffer_view.value(),
            offset: sparse.indices.byte_offset.0,
            count: changed,
            size: component.size(),
        };
        let indices = self.strided(span, &format!("{name}.sparse.indices"), place, notes)?;
        let span = Span {
            view: sparse.values.buffer_view.value(),
            offset: sparse.values.byte_offset.0,
            count: changed,
            size,
        };
        let values = self.strided(span, &format!("{name}.sparse.values"), place, notes)?;
        // No loss: indices are integers of at most 32 bits.
        let indices: Vec<u32> = (0..changed)
            .map(|i| indices.element::<1>(i, component, false)[0] as u32)
            .collect();
        let out = indices.iter().position(|&i| i as usize >= count);
        let unsorted = indices.windows(2).position(|pair| pair[0] >= pair[1]);
        let message = match (out, unsorted) {
            (Some(i), _) => format!(
                "index {i} is {}, but {name} has {count} elements",
                indices[i]
            ),
            (None, Some(i)) => format!("index {} is not above the one before it", i + 1),
            (None, None) => return Some((indices, values)),
        };
        notes.refuse(place, format!("{name}.sparse.indices: {message}"))
    }

    /// The bytes of a span, if its view has them all.
    fn strided(
        &self,
        span: Span,
        name: &str,
        place: &str,
        notes: &mut Notes,
    ) -> Option<Strided<'_>> {
        let Span {
            view,
            offset,
            count,
            size,
        } = span;
        let (bytes, stride) = self.buffers.view(view, place, notes)?;
        let stride = stride.filter(|&stride| stride > 0).unwrap_or(size);
        if stride < size {
            let message = format!("{name}: stride {stride} of bufferViews[{view}] is below {size}");
            return notes.refuse(place, message);
        }
        let length = match count.checked_sub(1) {
            Some(steps) => steps.checked_mul(stride).and_then(|n| n.checked_add(size)),
            None => Some(0),
        };
        let range = usize::try_from(offset)
            .ok()
            .zip(length)
            .and_then(|(start, length)| bytes.get(start..start.checked_add(length)?));
        if range.is_none() {
            let message = format!(
                "{name}: {count} elements of {size} bytes, {stride} apart from byte {offset}, end beyond \
                 bufferViews[{view}], which has {} bytes",
                bytes.len()
            );
            notes.problem(place, message);
        }
        Some(Strided {
            bytes: range?,
            stride,
        })
    }
}

/// Where elements lie in a buffer view.
#[derive(Debug, Clone, Copy)]
struct Span {
    view: usize,
    offset: u64,
    count: usize,
    /// Bytes of an element.
    size: usize,
}

fn word(component: ComponentType) -> &'static str {
    match component {
        ComponentType::I8 => "BYTE",
        ComponentType::U8 => "UNSIGNED_BYTE",
        ComponentType::I16 => "SHORT",
        ComponentType::U16 => "UNSIGNED_SHORT",
        ComponentType::U32 => "UNSIGNED_INT",
        ComponentType::F32 => "FLOAT",
    }
}
