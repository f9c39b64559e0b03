//! The bodies, what holds them, and what their frequencies should be.

use std::f64::consts::{PI, TAU};

use bdtree_build::input::volume::RawVolume;

use super::volume_support::hexahedra;
use super::{Case, Kind, hexes, lattice, tets};

/// A box from the origin; the plates' thickness is about z = 0.
fn boxed<const X: u32, const Y: u32, const Z: u32>(n: [usize; 3]) -> RawVolume {
    let size = [X, Y, Z].map(|mm| f64::from(mm) / 1000.0);
    hexahedra(n, |p| {
        [p[0] * size[0], p[1] * size[1], (p[2] - 0.5) * size[2]]
    })
}

/// 1 m long, 20 mm high (y), 10 mm wide (z), about the x axis.
fn beam(n: [usize; 3]) -> RawVolume {
    hexahedra(n, |p| [p[0], 0.02 * (p[1] - 0.5), 0.01 * (p[2] - 0.5)])
}

/// 10 m long, 5 m wide at x = 0, 1 m at the other end, 0.05 m thick.
fn membrane(n: [usize; 3]) -> RawVolume {
    hexahedra(n, |p| {
        [
            10.0 * p[0],
            (5.0 - 4.0 * p[0]) * (p[1] - 0.5),
            0.05 * (p[2] - 0.5),
        ]
    })
}

/// 10 m long, 1 m across: the section is a square bent to a circle.
fn shaft(n: [usize; 3]) -> RawVolume {
    hexahedra(n, |p| {
        let [y, z] = [p[1], p[2]].map(|x| 2.0 * x - 1.0);
        let round = |a: f64, b: f64| 0.5 * a * (1.0 - 0.5 * b * b).sqrt();
        [10.0 * p[0], round(y, z), round(z, y)]
    })
}

/// The NAFEMS tests and their like: E = 200 GPa, ν = 0.3, ρ = 8000 kg/m³.
fn steel(
    name: &'static str,
    body: fn([usize; 3]) -> RawVolume,
    modes: usize,
    kind: Kind,
    reference: &[f64],
) -> Case {
    Case {
        name,
        body,
        young_pa: 200e9,
        poisson: 0.3,
        density: 8000.0,
        fixes: Vec::new(),
        modes,
        kind,
        reference: reference.to_vec(),
        runs: Vec::new(),
    }
}

/// The four sides of a square of 10 m between two heights, held along two axes each.
fn sides(across: &str, along: &str, low: f64, high: f64) -> Vec<String> {
    vec![
        format!("{across}:0,0,{low},0,10,{high}"),
        format!("{across}:10,0,{low},10,10,{high}"),
        format!("{along}:0,0,{low},10,0,{high}"),
        format!("{along}:0,10,{low},10,10,{high}"),
    ]
}

/// Plates and a membrane.
pub(crate) fn plates() -> Vec<Case> {
    let solid = boxed::<10_000, 10_000, 1000>;
    let thin = boxed::<10_000, 10_000, 50>;
    vec![
        Case {
            fixes: sides("z", "z", -0.5, -0.5),
            runs: vec![
                hexes([8, 8, 3], 4.35),
                hexes([16, 16, 4], 4.19),
                tets([16, 16, 4], 30.12),
                lattice(10, 5.04),
                lattice(30, 9.52),
            ],
            ..steel(
                "FV52",
                solid,
                7,
                Kind::All,
                &[45.897, 109.44, 109.44, 167.89, 193.59, 206.19, 206.19],
            )
        },
        Case {
            fixes: sides("yz", "xz", -0.5, 0.5),
            runs: vec![
                hexes([12, 12, 2], 8.78),
                hexes([24, 24, 2], 3.66),
                tets([16, 16, 4], 45.16),
                lattice(20, 1.00),
            ],
            ..steel(
                "Test 21",
                solid,
                30,
                Kind::Along(2),
                &[
                    45.897, 109.44, 109.44, 167.89, 204.51, 204.51, 256.50, 256.50,
                ],
            )
        },
        Case {
            runs: vec![
                hexes([24, 24, 1], 0.40),
                hexes([40, 40, 1], 0.88),
                lattice(40, 0.98),
            ],
            ..steel(
                "FV12",
                thin,
                7,
                Kind::All,
                &[1.622, 2.360, 2.922, 4.233, 4.233, 7.416, 7.416],
            )
        },
        Case {
            fixes: sides("z", "z", -0.025, 0.025),
            runs: vec![
                hexes([24, 24, 1], 6.58),
                hexes([40, 40, 1], 1.15),
                lattice(40, 0.41),
            ],
            ..steel(
                "thin plate",
                thin,
                8,
                Kind::All,
                &[2.377, 5.942, 5.942, 9.507, 11.884, 11.884, 15.449, 15.449],
            )
        },
        Case {
            fixes: vec![
                "xy:0,-9,-1,0,9,1".into(),
                "z:0,-9,-0.025,10,9,-0.025".into(),
            ],
            runs: vec![
                hexes([16, 8, 1], 3.35),
                hexes([32, 16, 1], 0.81),
                tets([32, 16, 1], 3.64),
                lattice(40, 0.07),
            ],
            ..steel(
                "FV32",
                membrane,
                6,
                Kind::All,
                &[44.623, 130.03, 162.70, 246.05, 379.90, 391.44],
            )
        },
    ]
}

/// Beams by Euler and Bernoulli, bars and a shaft by d'Alembert.
pub(crate) fn lines() -> Vec<Case> {
    let (young, density) = (200e9f64, 8000.0f64);
    let clamp = |x: i32| format!("xyz:{x},-1,-1,{x},1,1");
    let pin = |x: i32| format!("y:{x},0,-1,{x},0,1");
    let free = vec![4.730041, 7.853205, 10.995608, 14.137165];
    let bending = [
        (
            "beam, clamped-free",
            vec![clamp(0)],
            vec![1.875104, 4.694091, 7.854757, 10.995541],
        ),
        ("beam, free-free", vec![], free.clone()),
        ("beam, clamped-clamped", vec![clamp(0), clamp(1)], free),
        (
            "beam, pinned-pinned",
            vec![pin(0), pin(1)],
            [1.0, 2.0, 3.0, 4.0].map(|n| n * PI).to_vec(),
        ),
        (
            "beam, clamped-pinned",
            vec![clamp(0), pin(1)],
            vec![3.926602, 7.068583, 10.210176, 13.351769],
        ),
    ];
    let mut cases = Vec::new();
    for (name, fixes, beta) in bending {
        let factor = (young * 0.02f64.powi(2) / 12.0 / density).sqrt() / TAU;
        let reference: Vec<f64> = beta.iter().map(|b| b * b * factor).collect();
        let tetrahedra = name == "beam, clamped-free";
        let mut runs = vec![hexes([40, 2, 2], 0.87), lattice(100, 1.56)];
        if tetrahedra {
            runs.push(tets([100, 2, 2], 34.57));
            runs.push(tets([200, 8, 4], 4.32));
        }
        cases.push(Case {
            fixes,
            runs,
            ..steel(name, beam, 16, Kind::Along(1), &reference)
        });
    }
    let speed = (young / density).sqrt();
    let bar = boxed::<10_000, 1000, 1000>;
    cases.push(Case {
        runs: vec![
            hexes([20, 2, 2], 0.24),
            tets([20, 2, 2], 0.08),
            lattice(20, 0.33),
        ],
        ..steel(
            "bar, free-free",
            bar,
            16,
            Kind::Along(0),
            &[speed / 20.0, 2.0 * speed / 20.0],
        )
    });
    cases.push(Case {
        fixes: vec!["xyz:0,0,-1,0,1,1".into()],
        runs: vec![
            hexes([20, 2, 2], 0.66),
            tets([20, 2, 2], 0.83),
            lattice(20, 0.38),
        ],
        ..steel(
            "bar, clamped-free",
            bar,
            16,
            Kind::Along(0),
            &[speed / 40.0, 3.0 * speed / 40.0],
        )
    });
    let twist = speed / 2.6f64.sqrt();
    for (name, fixes, factors) in [
        ("shaft, free-free", vec![], [1.0 / 20.0, 2.0 / 20.0]),
        (
            "shaft, clamped-free",
            vec!["xyz:0,-1,-1,0,1,1".to_owned()],
            [1.0 / 40.0, 3.0 / 40.0],
        ),
    ] {
        cases.push(Case {
            fixes,
            runs: vec![
                hexes([20, 6, 6], 0.26),
                tets([20, 6, 6], 34.24),
                lattice(40, 0.01),
            ],
            ..steel(name, shaft, 16, Kind::Torsion, &factors.map(|f| f * twist))
        });
    }
    cases
}

/// A cube of rubber.
pub(crate) fn cube() -> Vec<Case> {
    vec![Case {
        name: "cube, ν = 0.499",
        body: boxed::<1000, 1000, 1000>,
        young_pa: 1.0,
        poisson: 0.499,
        density: 1.0,
        fixes: Vec::new(),
        modes: 1,
        kind: Kind::All,
        reference: vec![0.263],
        runs: vec![
            hexes([4, 4, 4], 6.50),
            hexes([10, 10, 10], 1.01),
            tets([10, 10, 10], 6.89),
            lattice(10, 0.10),
        ],
    }]
}
