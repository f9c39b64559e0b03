//! One mesh of the file in its own coordinates: positions, triangles, morph targets.

use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::{Accessors, Purpose};
use super::document::Document;
use super::notes::Notes;
use super::topology;
use super::weights::{self, JointWeights};

/// Vertex and displacement, by ascending vertex.
pub(super) type Displacements = Vec<(u32, [f64; 3])>;

/// A mesh of the file.
#[derive(Debug, Default)]
pub(super) struct MeshData {
    /// Those made of triangles.
    pub(super) primitives: Vec<PrimitiveData>,
    /// Number of morph targets, the same for all primitives.
    pub(super) target_count: usize,
}

/// A primitive made of triangles.
#[derive(Debug)]
pub(super) struct PrimitiveData {
    /// Its place in the mesh.
    pub(super) index: usize,
    pub(super) positions: Vec<[f64; 3]>,
    /// Corners are indices into `positions`.
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) material: Option<usize>,
    /// Per morph target the displacements that are not zero; `None` where the target does not speak
    /// of positions.
    pub(super) targets: Vec<Option<Displacements>>,
    /// The joints of its vertices, where a skin moves the mesh.
    pub(super) joints: Option<JointWeights>,
}

/// Mesh `index`, with what is wrong in it noted. `is_skinned`: a skin moves it somewhere.
pub(super) fn read(
    document: &Document,
    accessors: &Accessors<'_>,
    quantised: bool,
    (index, is_skinned): (usize, bool),
    notes: &mut Notes,
) -> MeshData {
    let mut data = MeshData::default();
    let Some(mesh) = document.root.meshes.get(index) else {
        return data;
    };
    let mut first: Option<(usize, usize)> = None;
    for (i, primitive) in mesh.primitives.iter().enumerate() {
        let Checked::Valid(mode) = primitive.mode else {
            continue;
        };
        match mode {
            Mode::Points => notes.points += 1,
            Mode::Lines | Mode::LineLoop | Mode::LineStrip => notes.lines += 1,
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => {
                let count = primitive.targets.as_ref().map_or(0, Vec::len);
                let (other, known) = *first.get_or_insert((i, count));
                if count != known {
                    let message = format!(
                        "{count} morph targets, but primitives[{other}] of the same mesh has {known}"
                    );
                    notes.problem(format!("meshes[{index}].primitives[{i}]"), message);
                }
                let reader = Reader {
                    accessors,
                    quantised,
                    is_skinned,
                    place: format!("meshes[{index}].primitives[{i}]"),
                    notes: &mut *notes,
                };
                data.primitives.extend(reader.primitive(i, primitive, mode));
            }
        }
    }
    data.target_count = first.map_or(0, |(_, count)| count);
    data
}

struct Reader<'a, 'b> {
    accessors: &'a Accessors<'b>,
    quantised: bool,
    is_skinned: bool,
    /// JSON path of the primitive.
    place: String,
    notes: &'a mut Notes,
}

impl Reader<'_, '_> {
    fn primitive(
        mut self,
        index: usize,
        primitive: &Primitive,
        mode: Mode,
    ) -> Option<PrimitiveData> {
        // Validation made sure that there are positions.
        let accessor = primitive
            .attributes
            .get(&Checked::Valid(Semantic::Positions))?;
        let positions = self.positions(accessor.value())?;
        let corners = match primitive.indices {
            Some(accessor) => self.indices(accessor.value(), positions.len())?,
            // No loss: the reader counts elements in 32 bits.
            None => (0..positions.len() as u32).collect(),
        };
        let triangles = match topology::triangles(mode, &corners) {
            Ok(triangles) => triangles,
            Err(message) => {
                return self.notes.refuse(&self.place, message);
            }
        };
        let targets = primitive.targets.iter().flatten().enumerate();
        let targets = targets
            .map(|(k, target)| {
                let accessor = target.positions?;
                self.displacements(k, accessor.value(), positions.len())
            })
            .collect();
        let joints = if self.is_skinned {
            let count = positions.len();
            Some(weights::read(
                primitive,
                count,
                self.accessors,
                &self.place,
                self.notes,
            )?)
        } else {
            None
        };
        Some(PrimitiveData {
            index,
            joints,
            positions,
            triangles,
            material: primitive.material.map(|material| material.value()),
            targets,
        })
    }

    fn positions(&mut self, accessor: usize) -> Option<Vec<[f64; 3]>> {
        let place = format!("{}.attributes.POSITION", self.place);
        let purpose = Purpose::Positions {
            quantised: self.quantised,
        };
        let positions = self
            .accessors
            .read(accessor, purpose, &place, self.notes)?
            .all();
        for (i, p) in positions.iter().enumerate() {
            if !p.iter().all(|x| x.is_finite()) {
                self.notes
                    .problem(&place, format!("vertex {i}: {p:?} is not finite"));
            }
        }
        Some(positions)
    }

    fn indices(&mut self, accessor: usize, vertex_count: usize) -> Option<Vec<u32>> {
        let place = format!("{}.indices", self.place);
        let elements = self
            .accessors
            .read(accessor, Purpose::Indices, &place, self.notes)?;
        let largest = elements.largest();
        let mut is_sound = true;
        let mut corners = Vec::with_capacity(elements.count);
        for (i, [corner]) in elements.all().into_iter().enumerate() {
            if corner == largest {
                let message = format!("index {i} is {corner}: glTF 2.0 has no primitive restart");
                self.notes.problem(&place, message);
                is_sound = false;
            } else if corner >= vertex_count as f64 {
                let message =
                    format!("index {i} is {corner}, but there are {vertex_count} vertices");
                self.notes.problem(&place, message);
                is_sound = false;
            }
            // No loss: an integer of at most 32 bits.
            corners.push(corner as u32);
        }
        is_sound.then_some(corners)
    }

    fn displacements(
        &mut self,
        target: usize,
        accessor: usize,
        vertex_count: usize,
    ) -> Option<Displacements> {
        let place = format!("{}.targets[{target}].POSITION", self.place);
        let purpose = Purpose::Displacements {
            quantised: self.quantised,
        };
        let elements = self.accessors.read(accessor, purpose, &place, self.notes)?;
        if elements.count != vertex_count {
            let message = format!(
                "{} displacements for {vertex_count} vertices",
                elements.count
            );
            return self.notes.refuse(&place, message);
        }
        let displacements = elements.nonzero();
        for (i, u) in &displacements {
            if !u.iter().all(|x| x.is_finite()) {
                self.notes
                    .problem(&place, format!("vertex {i}: {u:?} is not finite"));
            }
        }
        Some(displacements)
    }
}
