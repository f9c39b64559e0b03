//! Baking in tests: default settings, aligned bytes.

use bdtree_build::basis::{Animation, Basis, BasisMode, RigidMotion};
use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_runtime::AlignedBytes;
use rand::RngExt;

use crate::fixtures::mesh::Mesh;
use crate::fixtures::{face, fields};
use crate::poses::{random_transform, rng};

/// The file of a mesh and a basis, default settings.
///
/// # Panics
/// When the bake fails.
pub fn baked(mesh: &RawMesh, basis: &Basis) -> AlignedBytes {
    baked_with(mesh, basis, &BakeSettings::default())
}

/// The file of a mesh and a basis.
///
/// # Panics
/// When the bake fails.
pub fn baked_with(mesh: &RawMesh, basis: &Basis, settings: &BakeSettings) -> AlignedBytes {
    let baked = bake_fields(mesh, basis, settings, &Provenance::default(), &Silent).expect("bake");
    AlignedBytes::copy_of(&baked.bytes)
}

/// A basis without modes.
pub fn rigid(mesh: &RawMesh) -> Basis {
    Basis {
        vertex_count: mesh.positions.len(),
        ..Basis::default()
    }
}

/// `mode_count` smooth fields: sines of the position with one to three half waves over the
/// bounding box, each scaled so that q = 1 moves its farthest vertex by 5 % of the diagonal.
pub fn smooth_basis(mesh: &RawMesh, mode_count: usize, seed: u64) -> Basis {
    let mut rng = rng(seed);
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for p in &mesh.positions {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    let diagonal = (0..3)
        .map(|k| (high[k] - low[k]).powi(2))
        .sum::<f64>()
        .sqrt()
        .max(f64::MIN_POSITIVE);
    let mut fields = Vec::with_capacity(mesh.positions.len() * mode_count);
    for _ in 0..mode_count {
        let waves: [[f64; 4]; 3] = [0; 3].map(|_| {
            let mut wave = [0; 4].map(|_| rng.random_range(-3.0..3.0));
            wave[3] *= 2.0;
            wave
        });
        let start = fields.len();
        for p in &mesh.positions {
            let t: Vec<f64> = (0..3).map(|k| (p[k] - low[k]) / diagonal).collect();
            fields.push(waves.map(|w| (w[0] * t[0] + w[1] * t[1] + w[2] * t[2] + w[3]).sin()));
        }
        let largest = fields[start..]
            .iter()
            .map(|u: &[f64; 3]| u.iter().map(|c| c * c).sum::<f64>().sqrt())
            .fold(f64::MIN_POSITIVE, f64::max);
        for u in &mut fields[start..] {
            *u = u.map(|c| c * 0.05 * diagonal / largest);
        }
    }
    Basis {
        vertex_count: mesh.positions.len(),
        fields,
        modes: vec![
            BasisMode {
                q_range: Some(1.0),
                ..BasisMode::default()
            };
            mode_count
        ],
        animation: None,
    }
}

/// `mode_count` local fields: each moves the vertices near one vertex and leaves the others exactly
/// at rest, so files of them list the modes of each vertex; scaled like [`smooth_basis`].
pub fn local_basis(mesh: &RawMesh, mode_count: usize, seed: u64) -> Basis {
    let plain = Mesh {
        positions: mesh.positions.clone(),
        triangles: mesh.triangles.clone(),
    };
    basis_of(&fields::local_fields(&plain, mode_count, seed))
}

/// A basis of these fields, all of range 1.
pub fn basis_of(fields: &[Vec<[f64; 3]>]) -> Basis {
    Basis {
        vertex_count: fields.first().map_or(0, Vec::len),
        fields: fields.concat(),
        modes: vec![
            BasisMode {
                q_range: Some(1.0),
                ..BasisMode::default()
            };
            fields.len()
        ],
        animation: None,
    }
}

/// The face of the fixtures and a basis of its 52 shapes.
pub fn face_with_shapes() -> (RawMesh, Basis) {
    let face = face::face();
    let shapes = face::face_shapes(&face);
    let mut basis = Basis {
        vertex_count: face.positions.len(),
        ..Basis::default()
    };
    for shape in shapes {
        basis.fields.extend(shape.field);
        basis.modes.push(BasisMode {
            name: Some(shape.name),
            q_range: Some(1.0),
            ..BasisMode::default()
        });
    }
    let mesh = RawMesh {
        name: "face.obj".into(),
        positions: face.positions,
        triangles: face.triangles,
        ..RawMesh::default()
    };
    (mesh, basis)
}

/// A UV sphere of radius 1 whose surface bulges: closed, about `2 n²` triangles.
pub fn bumpy_sphere(n: u32, seed: u64) -> RawMesh {
    let mut rng = rng(seed);
    let phase: [f64; 3] = [0; 3].map(|_| rng.random_range(0.0..6.0));
    let (rows, columns) = (n, 2 * n);
    let mut positions = vec![[0.0, 0.0, 1.0]];
    for i in 1..rows {
        let theta = core::f64::consts::PI * f64::from(i) / f64::from(rows);
        for j in 0..columns {
            let phi = core::f64::consts::TAU * f64::from(j) / f64::from(columns);
            let bump = 1.0
                + 0.1 * (3.0 * theta + phase[0]).sin() * (2.0 * phi + phase[1]).cos()
                + 0.05 * (5.0 * phi + phase[2]).sin() * theta.sin();
            positions.push([
                bump * theta.sin() * phi.cos(),
                bump * theta.sin() * phi.sin(),
                bump * theta.cos(),
            ]);
        }
    }
    positions.push([0.0, 0.0, -1.0]);
    let at = |i: u32, j: u32| 1 + (i - 1) * columns + j % columns;
    let south = positions.len() as u32 - 1;
    let mut triangles = Vec::new();
    for j in 0..columns {
        triangles.push([0, at(1, j), at(1, j + 1)]);
        for i in 1..rows - 1 {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
        triangles.push([at(rows - 1, j), south, at(rows - 1, j + 1)]);
    }
    RawMesh {
        name: "bumpy_sphere".into(),
        positions,
        triangles,
        ..RawMesh::default()
    }
}

/// A basis with frames: random q within `share` of the modes' ranges, random turns and moves,
/// times. The first frame is at rest.
pub fn with_frames(basis: Basis, frame_count: usize, share: f64, seed: u64) -> Basis {
    let mut rng = rng(seed);
    let mode_count = basis.mode_count();
    let mut q = vec![0.0; mode_count];
    let mut motions = vec![RigidMotion::IDENTITY];
    for _ in 1..frame_count {
        q.extend((0..mode_count).map(|_| share * rng.random_range(-1.0..1.0)));
        let place = random_transform(1.0, &mut rng);
        motions.push(RigidMotion {
            rotation: place.rotation,
            translation: place.translation,
        });
    }
    Basis {
        animation: Some(Animation {
            frame_count,
            times_s: Some((0..frame_count).map(|k| 0.04 * k as f64).collect()),
            q,
            motions,
        }),
        ..basis
    }
}
