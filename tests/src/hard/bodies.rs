//! The cases.

use bdtree_build::basis::Basis;
use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::basis::pca::{About, Modes, PcaOptions, pca_basis};
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::input::{RawMesh, read_mesh};
use bdtree_build::progress::Silent;

use super::HardCase;
use crate::{bake, fixtures};

/// Every case, in the order of docs/hard-cases.md.
///
/// # Panics
/// When a fixture cannot be read or has no modes where it should.
pub fn hard_cases() -> Vec<HardCase> {
    let mut all = meshes();
    all.extend(collapsing());
    all.extend(fields());
    all.extend(animations());
    all
}

fn fixture(name: &str) -> RawMesh {
    read_mesh(&fixtures::path(name)).expect("a fixture")
}

fn case(name: &'static str, mesh: RawMesh, basis: Basis) -> HardCase {
    HardCase {
        name,
        mesh,
        basis,
        qs: Vec::new(),
        is_star: false,
    }
}

/// Hard as meshes, under smooth or local fields.
fn meshes() -> Vec<HardCase> {
    let smooth = |name: &'static str, modes: usize| {
        let mesh = fixture(name);
        let basis = bake::smooth_basis(&mesh, modes, 5);
        case(name, mesh, basis)
    };
    let local = |name: &'static str, modes: usize| {
        let mesh = fixture(name);
        let basis = bake::local_basis(&mesh, modes, 5);
        case(name, mesh, basis)
    };
    let star = |case: HardCase| HardCase {
        is_star: true,
        ..case
    };
    let mut all = vec![
        smooth("slivers", 3),
        star(smooth("duplicates", 3)),
        smooth("non_manifold", 3),
        open(),
        local("pieces", 6),
        smooth("components", 2),
        star(smooth("far", 3)),
        star(smooth("far_8", 3)),
        tiny(),
        smooth("sizes", 3),
        touching(),
        star(smooth("icosphere", 3)),
        smooth("line", 2),
        smooth("rod", 2),
    ];
    // Equal eigenvalues: a pair and triples.
    let cube = fixture("cube");
    let options = ElasticOptions {
        resolution: Some(6),
        mode_count: 8,
        ..ElasticOptions::default()
    };
    let (basis, _) = elastic_basis(&cube, &options, &Silent, &mut Vec::new()).expect("modes");
    all.push(star(case("cube", cube, basis)));
    all
}

/// Half of a ball, with a ragged border.
fn open() -> HardCase {
    let mut mesh = fixture("icosphere");
    mesh.triangles.truncate(640);
    let basis = bake::local_basis(&mesh, 6, 5);
    case("open", mesh, basis)
}

/// A ball of a micrometre, if the unit is metres: in some places of the list all of it is one point.
fn tiny() -> HardCase {
    let mut mesh = fixture("duplicates");
    for p in &mut mesh.positions {
        *p = p.map(|x| 1e-6 * x);
    }
    let basis = bake::smooth_basis(&mesh, 3, 5);
    case("1e-6 large", mesh, basis)
}

/// A basis of fields given by the position.
fn given(mesh: &RawMesh, fields: &[&dyn Fn([f64; 3]) -> [f64; 3]]) -> Basis {
    let all = fields.iter().map(|field| {
        let own = mesh.positions.iter().map(|p| field(*p));
        own.collect::<Vec<_>>()
    });
    bake::basis_of(&all.collect::<Vec<_>>())
}

/// Sheets that stay in one plane and on each other's lines at every q: shifts and shears in the plane.
fn touching() -> HardCase {
    let mesh = fixture("touching");
    let basis = given(
        &mesh,
        &[
            &|_| [0.0, 0.0, 0.5],
            &|[_, y, _]| [y, 0.0, 0.0],
            &|[x, ..]| [0.0, 0.5 * x, 0.0],
        ],
    );
    HardCase {
        qs: vec![vec![0.25, 0.5, -0.25], vec![-1.0, 0.0, 2.0]],
        ..case("touching", mesh, basis)
    }
}

/// Bodies that shrink, grow, fold and turn inside out.
fn collapsing() -> Vec<HardCase> {
    let sphere = bake::bumpy_sphere(6, 3);
    let mut all = vec![HardCase {
        qs: [0.5, 0.9, 0.999_999, 1.0, 1.000_001, 2.0]
            .map(|q| vec![q])
            .to_vec(),
        ..case(
            "shrinks to a point",
            sphere.clone(),
            given(&sphere, &[&|p| p.map(|x| -x)]),
        )
    }];
    let cube = fixture("cube");
    all.push(HardCase {
        // At 1 all in one plane, beyond it a mirror image; at 1 and 1 on one line; then a point.
        qs: [
            [1.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 1.0, 1.0],
            [2.0, 2.0, 2.0],
            [-3.0, 0.5, 1.5],
        ]
        .map(Vec::from)
        .to_vec(),
        ..case(
            "flattens and turns inside out",
            cube.clone(),
            given(
                &cube,
                &[
                    &|[x, ..]| [-x, 0.0, 0.0],
                    &|[_, y, _]| [0.0, -y, 0.0],
                    &|[.., z]| [0.0, 0.0, -z],
                ],
            ),
        )
    });
    all.push(HardCase {
        // At 1 one half lies exactly on the other.
        qs: [[1.0], [2.0], [0.5]].map(Vec::from).to_vec(),
        ..case(
            "folds onto itself",
            cube.clone(),
            given(&cube, &[&|[x, ..]| [-2.0 * x.max(0.0), 0.0, 0.0]]),
        )
    });
    // Everything in one place, and fields that pull it apart.
    let mut point = sphere.clone();
    let places = std::mem::replace(
        &mut point.positions,
        vec![[5.0, -7.0, 11.0]; sphere.positions.len()],
    );
    let apart = bake::basis_of(&[
        places.clone(),
        places.iter().map(|p| [p[2], p[0], 0.0]).collect(),
    ]);
    all.push(HardCase {
        qs: vec![vec![1.0, 0.0], vec![0.5, -0.25]],
        ..case("grows from a point", point, apart)
    });
    all
}

/// Fields that say the same, nothing, or differ in size by 10¹⁸; coordinates that vanish beside others.
fn fields() -> Vec<HardCase> {
    let mesh = bake::bumpy_sphere(7, 3);
    let two = bake::smooth_basis(&mesh, 2, 5);
    let [u, v] = [0, 1].map(|j| two.field(j).to_vec());
    let times = |field: &[[f64; 3]], s: f64| -> Vec<[f64; 3]> {
        field.iter().map(|u| u.map(|x| s * x)).collect()
    };
    let sum: Vec<[f64; 3]> = (u.iter().zip(&v))
        .map(|(u, v)| [0, 1, 2].map(|k| u[k] + v[k]))
        .collect();
    let zero = vec![[0.0; 3]; u.len()];
    let dependent = [
        u.clone(),
        times(&u, 2.0),
        times(&u, -1.0),
        zero,
        v.clone(),
        sum,
    ];
    let ratios = [times(&u, 1e-9), times(&v, 1e9)];
    let mut flat = mesh.clone();
    for p in &mut flat.positions {
        *p = [p[0], 1e-37 * p[1], 1e-30 * p[2]];
    }
    let mut tiny = mesh.clone();
    for p in &mut tiny.positions {
        *p = p.map(|x| 1e-28 * x);
    }
    let [flat_basis, tiny_basis] = [&flat, &tiny].map(|mesh| bake::smooth_basis(mesh, 3, 5));
    vec![
        HardCase {
            // Fields that cancel each other exactly.
            qs: vec![
                vec![1.0, -0.5, 0.0, 7.0, 0.0, 0.0],
                vec![1.0, 0.0, 1.0, 0.0, 1.0, -1.0],
            ],
            ..case("dependent fields", mesh.clone(), bake::basis_of(&dependent))
        },
        HardCase {
            qs: vec![vec![1e9, 1e-9], vec![-1e9, 0.0]],
            ..case("fields 1e18 apart", mesh, bake::basis_of(&ratios))
        },
        case("coordinates 1e37 apart", flat, flat_basis),
        case("1e-28 large", tiny, tiny_basis),
    ]
}

/// Frames whose components are fewer than the frames and modes asked for.
fn animations() -> Vec<HardCase> {
    let of = |name: &'static str, mesh: &str, frames: &str| {
        let mesh = fixture(mesh);
        let sequence = FrameSequence::open(&fixtures::path(frames), Some(&mesh), None, &Silent);
        let sequence = sequence.expect("frames");
        let options = PcaOptions {
            modes: Modes::Count(8),
            about: About::Mean,
            ..PcaOptions::default()
        };
        let mut warnings = Vec::new();
        let pca = pca_basis(&mesh, &sequence, &options, &Silent, &mut warnings).expect("modes");
        assert!(
            warnings.iter().any(|w| w.contains("of 8 modes")),
            "{name}: {warnings:?}"
        );
        case(name, pca.mesh, pca.basis)
    };
    vec![
        of("frames of one component", "cube", "cube_swells.npy"),
        of("frames of three components", "wave/wave_00.obj", "wave.npy"),
    ]
}
