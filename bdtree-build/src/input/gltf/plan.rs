//! How large a model gets, before anything is read: a short file can name the same data many times.

use gltf::json::Root;
use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::validation::Checked;

use super::nodes::Instance;
use super::notes::Notes;

/// Most vertices, triangles and displacements of a model, each.
pub(super) const ELEMENTS_MAX: u64 = 1 << 27;

/// Vertices, triangles and displacements, at most.
type Size = [u64; 3];

/// Notes a model that would be too large.
pub(super) fn check(root: &Root, instances: &[Instance], notes: &mut Notes) {
    let sizes: Vec<Size> = root
        .meshes
        .iter()
        .map(|mesh| sum(mesh.primitives.iter().map(|p| primitive(root, p))))
        .collect();
    let placed = instances.iter().filter_map(|i| sizes.get(i.mesh).copied());
    let [vertices, triangles, displacements] = sum(placed);
    for (count, what) in [
        (vertices, "vertices"),
        (triangles, "triangles"),
        (displacements, "displacements of morph targets"),
    ] {
        if count > ELEMENTS_MAX {
            let message = format!(
                "{count} {what} with every node's mesh written out; at most {ELEMENTS_MAX} are read"
            );
            notes.problem("", message);
        }
    }
}

fn sum(sizes: impl Iterator<Item = Size>) -> Size {
    sizes.fold([0; 3], |sum, size| {
        std::array::from_fn(|k| sum[k].saturating_add(size[k]))
    })
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
    [vertices, triangles, displacements]
}
