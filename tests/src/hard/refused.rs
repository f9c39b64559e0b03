//! What is no hard case but no asset: each is refused in words.

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;

use crate::bake;

/// A mesh and fields that cannot be baked, and what is said.
#[derive(Debug, Clone)]
pub struct Refused {
    /// As docs/hard-cases.md calls it.
    pub name: &'static str,
    /// The mesh.
    pub mesh: RawMesh,
    /// Its fields.
    pub basis: Basis,
    /// What the error says, in each of its lines.
    pub message: &'static str,
}

/// Every case.
pub fn refused_cases() -> Vec<Refused> {
    let mesh = bake::bumpy_sphere(4, 3);
    let basis = bake::smooth_basis(&mesh, 2, 5);
    let with = |name, message, change: &dyn Fn(&mut RawMesh, &mut Basis)| {
        let (mut mesh, mut basis) = (mesh.clone(), basis.clone());
        change(&mut mesh, &mut basis);
        Refused {
            name,
            mesh,
            basis,
            message,
        }
    };
    vec![
        with(
            "no triangles",
            "bumpy_sphere: the mesh has no triangles",
            &|mesh, _| mesh.triangles.clear(),
        ),
        with(
            "NaN in a position",
            "vertex 3: position [NaN, 0.0, 1.0] is not finite",
            &|mesh, _| mesh.positions[3] = [f64::NAN, 0.0, 1.0],
        ),
        with(
            "infinite position",
            "vertex 0: position [0.0, inf, 0.0] is not finite",
            &|mesh, _| mesh.positions[0] = [0.0, f64::INFINITY, 0.0],
        ),
        with(
            "NaN in a field",
            "mode 1, vertex 2: displacement [0.0, NaN, 0.0] is not finite",
            &|mesh, basis| basis.fields[mesh.positions.len() + 2] = [0.0, f64::NAN, 0.0],
        ),
        with(
            "corner without a vertex",
            "triangle 5: corners [0, 1, 26] are not all below 26 vertices",
            &|mesh, _| mesh.triangles[5] = [0, 1, 26],
        ),
        with(
            "1e31 large",
            "cannot be stored: sizes lie within 2^±100 mesh units, positions within 2^80 of the origin",
            &|mesh, basis| {
                for p in mesh.positions.iter_mut().chain(&mut basis.fields) {
                    *p = p.map(|x| 1e31 * x);
                }
            },
        ),
        with(
            "1e-32 large",
            "cannot be stored: sizes lie within 2^±100 mesh units, positions within 2^80 of the origin",
            &|mesh, basis| {
                for p in mesh.positions.iter_mut().chain(&mut basis.fields) {
                    *p = p.map(|x| 1e-32 * x);
                }
            },
        ),
        with(
            "1e25 away",
            "cannot be stored: sizes lie within 2^±100 mesh units, positions within 2^80 of the origin",
            &|mesh, _| {
                for p in &mut mesh.positions {
                    p[0] += 1e25;
                }
            },
        ),
        with(
            "a box larger than f64",
            "the box around all vertices is larger than f64 can measure",
            &|mesh, _| {
                mesh.positions[0] = [1e308; 3];
                mesh.positions[1] = [-1e308; 3];
            },
        ),
        with(
            "fields 1e40 times the mesh",
            "is too large for f32",
            &|_, basis| {
                for u in &mut basis.fields {
                    *u = u.map(|x| 1e40 * x);
                }
            },
        ),
    ]
}
