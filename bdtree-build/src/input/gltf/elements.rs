//! The values of accessors that were checked: floats, integers, normalized integers, sparse ones.

use gltf::json::accessor::ComponentType;

/// Numbers at equal distances; every element lies inside `bytes`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strided<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) stride: usize,
}

/// The elements of an accessor.
#[derive(Debug)]
pub(super) struct Elements<'a> {
    /// Number of elements.
    pub(super) count: usize,
    pub(super) component: ComponentType,
    pub(super) normalized: bool,
    /// Zeros if `None`.
    pub(super) base: Option<Strided<'a>>,
    /// Ascending elements that are replaced, and by what.
    pub(super) sparse: Option<(Vec<u32>, Strided<'a>)>,
}

impl Strided<'_> {
    /// Element `i` of W components.
    pub(super) fn element<const W: usize>(
        &self,
        i: usize,
        component: ComponentType,
        normalized: bool,
    ) -> [f64; W] {
        let bytes = self.bytes.get(i * self.stride..).unwrap_or_default();
        let size = component.size();
        std::array::from_fn(|k| {
            number(
                bytes.get(k * size..).unwrap_or_default(),
                component,
                normalized,
            )
        })
    }
}

impl Elements<'_> {
    /// All elements in order. W is 1 for SCALAR, 3 for VEC3, 4 for VEC4, 16 for MAT4.
    pub(super) fn all<const W: usize>(&self) -> Vec<[f64; W]> {
        let mut all = match self.base {
            Some(base) => (0..self.count)
                .map(|i| base.element(i, self.component, self.normalized))
                .collect(),
            None => vec![[0.0; W]; self.count],
        };
        if let Some((indices, values)) = &self.sparse {
            for (k, &i) in indices.iter().enumerate() {
                // Checked: below the count.
                all[i as usize] = values.element(k, self.component, self.normalized);
            }
        }
        all
    }

    /// The elements that are not zero, ascending.
    pub(super) fn nonzero<const W: usize>(&self) -> Vec<(u32, [f64; W])> {
        let value = |values: &Strided<'_>, i| values.element(i, self.component, self.normalized);
        let mut found: Vec<(u32, [f64; W])> = match (&self.base, &self.sparse) {
            (None, None) => Vec::new(),
            (None, Some((indices, values))) => indices
                .iter()
                .enumerate()
                .map(|(k, &i)| (i, value(values, k)))
                .collect(),
            // The count fits: it was checked against 32 bits.
            (Some(_), _) => (0..).zip(self.all()).collect(),
        };
        found.retain(|(_, x)| x.iter().any(|&x| x != 0.0));
        found
    }

    /// The value that the component type cannot exceed, for integers.
    pub(super) fn largest(&self) -> f64 {
        match self.component {
            ComponentType::I8 => i8::MAX.into(),
            ComponentType::U8 => u8::MAX.into(),
            ComponentType::I16 => i16::MAX.into(),
            ComponentType::U16 => u16::MAX.into(),
            ComponentType::U32 => u32::MAX.into(),
            ComponentType::F32 => f64::INFINITY,
        }
    }
}

/// The number at the start of `bytes`; glTF is little-endian. Normalized integers are shares of
/// their largest value, −1 at least (glTF 2.0, 3.11).
fn number(bytes: &[u8], component: ComponentType, normalized: bool) -> f64 {
    fn take<const N: usize>(bytes: &[u8]) -> [u8; N] {
        bytes.first_chunk().copied().unwrap_or([0; N])
    }
    let (value, largest): (f64, f64) = match component {
        ComponentType::I8 => (i8::from_le_bytes(take(bytes)).into(), i8::MAX.into()),
        ComponentType::U8 => (u8::from_le_bytes(take(bytes)).into(), u8::MAX.into()),
        ComponentType::I16 => (i16::from_le_bytes(take(bytes)).into(), i16::MAX.into()),
        ComponentType::U16 => (u16::from_le_bytes(take(bytes)).into(), u16::MAX.into()),
        ComponentType::U32 => return u32::from_le_bytes(take(bytes)).into(),
        ComponentType::F32 => return f32::from_le_bytes(take(bytes)).into(),
    };
    if normalized {
        (value / largest).max(-1.0)
    } else {
        value
    }
}
