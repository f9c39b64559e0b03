//! Frequencies against theory and published tests: NAFEMS, plates, beams, bars, shafts.
//!
//! `cargo test --release -p bdtree-build --test volume_references -- --ignored --nocapture` prints
//! the table of docs/reference/volumes.md.

mod cases;
#[path = "../volume_support/mod.rs"]
mod volume_support;

use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::basis::volume::VolumeOptions;
use bdtree_build::input::volume::RawVolume;
use bdtree_build::progress::Silent;
use cases::{cube, lines, plates};
use volume_support::{V3, five_tetrahedra, hexahedra, of, solve, surface};

/// A body, what holds it, and what its frequencies should be.
struct Case {
    name: &'static str,
    /// Cells per axis → the body.
    body: fn([usize; 3]) -> RawVolume,
    young_pa: f64,
    poisson: f64,
    density: f64,
    fixes: Vec<String>,
    /// Modes to compute, and which of them to compare: share of the motion that counts.
    modes: usize,
    kind: Kind,
    reference: Vec<f64>,
    runs: Vec<Run>,
}

/// Which modes are compared.
#[derive(Clone, Copy)]
enum Kind {
    All,
    /// Those that move along an axis.
    Along(usize),
    /// Those that turn about x.
    Torsion,
}

/// A way to compute it, and the largest error it has (in %).
struct Run {
    way: Way,
    error: f64,
}

#[derive(Clone, Copy)]
enum Way {
    Hexahedra([usize; 3]),
    Tetrahedra([usize; 3]),
    /// Lattice of that many cells along the longest side.
    Lattice(u32),
}

fn hexes(n: [usize; 3], error: f64) -> Run {
    Run {
        way: Way::Hexahedra(n),
        error,
    }
}

fn tets(n: [usize; 3], error: f64) -> Run {
    Run {
        way: Way::Tetrahedra(n),
        error,
    }
}

fn lattice(cells: u32, error: f64) -> Run {
    Run {
        way: Way::Lattice(cells),
        error,
    }
}

/// How much of a mode is of the kind.
fn share(kind: Kind, positions: &[V3], field: &[V3]) -> f64 {
    let (mut part, mut all) = (0.0, 0.0);
    for (p, u) in positions.iter().zip(field) {
        all += u.iter().map(|x| x * x).sum::<f64>();
        part += match kind {
            Kind::All => u.iter().map(|x| x * x).sum::<f64>(),
            Kind::Along(axis) => u[axis] * u[axis],
            Kind::Torsion => {
                let radius = p[1] * p[1] + p[2] * p[2];
                (p[1] * u[2] - p[2] * u[1]).powi(2) / radius.max(1e-12)
            }
        };
    }
    part / all
}

impl Case {
    /// The compared frequencies, in Hz, and how many unknowns there were.
    fn frequencies(&self, way: Way) -> (Vec<f64>, usize) {
        let fixes = self.fixes.iter().map(|f| f.parse().unwrap()).collect();
        let mut found = Vec::new();
        let dofs;
        match way {
            Way::Hexahedra(n) | Way::Tetrahedra(n) => {
                let mut volume = (self.body)(n);
                if matches!(way, Way::Tetrahedra(_)) {
                    volume = five_tetrahedra(volume, n);
                }
                let options = VolumeOptions {
                    fixes,
                    ..of(self.young_pa, self.poisson, self.density, self.modes)
                };
                let (modes, report) = solve(&volume, &options);
                assert!(report.inertia_checked);
                dofs = report.dofs;
                for mode in &modes.modes {
                    let share = share(self.kind, &volume.nodes, &mode.field);
                    found.push((mode.omega_rad_s, share));
                }
            }
            Way::Lattice(cells) => {
                let finest = match self.runs[0].way {
                    Way::Hexahedra(n) => n,
                    _ => [1; 3],
                };
                let mesh = surface(&(self.body)(finest));
                let options = ElasticOptions {
                    fixes,
                    mode_count: self.modes,
                    resolution: Some(cells),
                    young_pa: self.young_pa,
                    poisson: self.poisson,
                    density_kg_m3: self.density,
                    ..ElasticOptions::default()
                };
                let (basis, report) =
                    elastic_basis(&mesh, &options, &Silent, &mut Vec::new()).expect("modes");
                dofs = report.dofs;
                for (j, mode) in basis.modes.iter().enumerate() {
                    let share = share(self.kind, &mesh.positions, basis.field(j));
                    found.push((mode.omega_rad_s.unwrap(), share));
                }
            }
        }
        let kept = found.iter().filter(|(_, share)| *share > 0.7);
        let hertz = kept.map(|(w, _)| w / std::f64::consts::TAU);
        (hertz.take(self.reference.len()).collect(), dofs)
    }

    /// Runs those ways that `take` says, prints their rows and holds them to their errors.
    fn check(&self, take: impl Fn(Way) -> bool) {
        let numbers = |list: &[f64]| {
            let digits = |x: &f64| match x.abs() {
                100.0.. => format!("{x:.1}"),
                10.0.. => format!("{x:.2}"),
                _ => format!("{x:.3}"),
            };
            list.iter().map(digits).collect::<Vec<_>>().join(" ")
        };
        for run in self.runs.iter().filter(|run| take(run.way)) {
            let (hertz, dofs) = self.frequencies(run.way);
            assert_eq!(hertz.len(), self.reference.len(), "{} {hertz:?}", self.name);
            let errors = hertz.iter().zip(&self.reference);
            let errors: Vec<f64> = errors.map(|(f, want)| 100.0 * (f / want - 1.0)).collect();
            let way = match run.way {
                Way::Hexahedra([a, b, c]) => format!("hexahedra {a} × {b} × {c}"),
                Way::Tetrahedra([a, b, c]) => format!("tetrahedra 5 × {a} × {b} × {c}"),
                Way::Lattice(cells) => format!("lattice, {cells} cells long"),
            };
            let text: Vec<String> = errors.iter().map(|e| format!("{e:+.2}")).collect();
            println!(
                "| {} | {way}; {dofs} | {} | {} | {} |",
                self.name,
                numbers(&hertz),
                numbers(&self.reference),
                text.join(" ")
            );
            let worst = errors.iter().fold(0.0f64, |w, e| w.max(e.abs()));
            assert!(worst <= run.error, "{}: {worst} %", self.name);
        }
    }
}

/// The small ones of the given meshes.
#[test]
fn volumes_meet_their_references() {
    for case in [plates(), lines(), cube()].into_iter().flatten() {
        case.check(|way| match way {
            Way::Hexahedra(n) => n.iter().product::<usize>() <= 1024,
            Way::Tetrahedra(n) => n.iter().product::<usize>() <= 512,
            Way::Lattice(_) => false,
        });
    }
}

#[test]
#[ignore = "a minute: the whole table of docs/reference/volumes.md"]
fn table() {
    println!("| test | elements; unknowns | Hz | reference | error in % |\n|---|---|---|---|---|");
    for case in [plates(), lines(), cube()].into_iter().flatten() {
        case.check(|_| true);
    }
}

/// Time and memory of docs/reference/volumes.md: three bodies of 10 000 nodes each.
#[test]
#[ignore = "seconds to time, in the release profile"]
fn ten_thousand_nodes() {
    for (n, size) in [
        ([21, 21, 21], [1.0, 1.0, 1.0]),
        ([60, 12, 12], [5.0, 1.0, 1.0]),
        ([45, 45, 4], [1.0, 1.0, 0.1]),
    ] {
        // Sheared, so that no plane of nodes lies across an axis.
        let sheared = |p: V3| {
            let [x, y, z]: V3 = std::array::from_fn(|a| size[a] * p[a]);
            [x + 0.3 * y, y + 0.2 * z, z + 0.25 * x]
        };
        let hexahedra = hexahedra(n, sheared);
        for volume in [five_tetrahedra(hexahedra.clone(), n), hexahedra] {
            let begin = std::time::Instant::now();
            let (_, report) = solve(&volume, &of(2e9, 0.3, 1000.0, 20));
            let nodes: usize = n.iter().map(|cells| cells + 1).product();
            assert_eq!(report.nodes, nodes);
            assert!(report.residual_max <= 1e-6, "{}", report.residual_max);
            println!(
                "{n:?}: {} nodes, {} elements, {:.1} s, {} MB predicted",
                report.nodes,
                report.elements,
                begin.elapsed().as_secs_f64(),
                report.predicted_bytes >> 20
            );
        }
    }
}
