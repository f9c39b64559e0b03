//! A box as a mesh.

use bdtree_build::input::RawMesh;

pub(crate) type V3 = [f64; 3];

const CUBE_FACES: [[u32; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

/// The box of this size with this lower corner.
pub(crate) fn boxed(from: V3, size: V3) -> RawMesh {
    let positions = (0..8)
        .map(|i| std::array::from_fn(|a| from[a] + if i >> a & 1 == 1 { size[a] } else { 0.0 }))
        .collect();
    RawMesh {
        name: "box.obj".into(),
        positions,
        triangles: CUBE_FACES.to_vec(),
        ..RawMesh::default()
    }
}
