//! How large a model gets, before anything is read: a short file can name the same data many times.

use gltf::json::mesh::{Mesh, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Root};

use super::nodes::Instance;
use super::notes::Notes;

/// Most vertices, triangles, displacements, joint weights and animated weights of a model, each.
pub(super) const ELEMENTS_MAX: u64 = 1 << 27;

/// Most primitives.
const PRIMITIVES_MAX: u64 = 1 << 20;

/// Most morph targets; far more than a file has modes, for those that are dropped.
const TARGETS_MAX: u64 = 1 << 16;

/// What is counted, and how much of it is read.
const LIMITS: [(&str, u64); 6] = [
    ("vertices", ELEMENTS_MAX),
    ("triangles", ELEMENTS_MAX),
    ("displacements of morph targets", ELEMENTS_MAX),
    ("primitives", PRIMITIVES_MAX),
    ("morph targets", TARGETS_MAX),
    ("weights of joints", ELEMENTS_MAX),
];

/// Counts in the order of [`LIMITS`], never too small.
type Size = [u64; 6];

/// Notes a model that would be too large.
pub(super) fn check(root: &Root, instances: &[Instance], notes: &mut Notes) {
    let sizes: Vec<Size> = root.meshes.iter().map(|m| mesh(root, m)).collect();
    let placed = instances.iter().filter_map(|i| {
        let mut size = sizes.get(i.mesh).copied()?;
        if i.skin.is_none() {
            // Not read.
            size[5] = 0;
        }
        Some(size)
    });
    for (count, (what, limit)) in sum(placed).into_iter().zip(LIMITS) {
        if count > limit {
            let message = format!(
                "{count} {what} with every node's mesh written out; at most {limit} are read"
            );
            notes.problem("", message);
        }
    }
}

fn sum(sizes: impl Iterator<Item = Size>) -> Size {
    sizes.fold(Size::default(), |sum, size| {
        std::array::from_fn(|k| sum[k].saturating_add(size[k]))
    })
}

fn mesh(root: &Root, mesh: &Mesh) -> Size {
    let targets = mesh.primitives.iter().flat_map(|p| &p.targets);
    let [vertices, triangles, displacements, primitives, _, weights] =
        sum(mesh.primitives.iter().map(|p| primitive(root, p)));
    let targets = targets.map(Vec::len).max().unwrap_or(0) as u64;
    [
        vertices,
        triangles,
        displacements,
        primitives,
        targets,
        weights,
    ]
}

fn primitive(root: &Root, primitive: &Primitive) -> Size {
    let accessor = |index: usize| root.accessors.get(index);
    let count = |index: usize| accessor(index).map_or(0, |a: &Accessor| a.count.0);
    let positions = primitive
        .attributes
        .get(&Checked::Valid(Semantic::Positions));
    let vertices = positions.map_or(0, |index| count(index.value()));
    // A strip or a fan has about a triangle per corner.
    let triangles = primitive
        .indices
        .map_or(vertices, |index| count(index.value()));
    let targets = primitive.targets.iter().flatten();
    let displacements = targets
        .filter_map(|target| accessor(target.positions?.value()))
        .map(|a| match (&a.buffer_view, &a.sparse) {
            (None, Some(sparse)) => sparse.count.0,
            (None, None) => 0,
            (Some(_), _) => a.count.0,
        })
        .fold(0, u64::saturating_add);
    let joints = primitive
        .attributes
        .iter()
        .filter(|(semantic, _)| matches!(semantic, Checked::Valid(Semantic::Joints(_))));
    let weights = joints
        .map(|(_, index)| count(index.value()).saturating_mul(4))
        .fold(0, u64::saturating_add);
    [vertices, triangles, displacements, 1, 0, weights]
}
