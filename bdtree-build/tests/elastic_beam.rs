//! Elastic modes against beam theory: convergence, locking, orientation, symmetry.

use crate::elastic_support::V3;
use bdtree_build::basis::Basis;
use bdtree_build::basis::elastic::{ElasticOptions, ElasticReport, elastic_basis};
use bdtree_build::input::RawMesh;
use bdtree_build::progress::Silent;

fn boxed(size: V3) -> RawMesh {
    crate::elastic_support::boxed([0.0; 3], size)
}

/// Turns about the axis (1, 2, 3) by `angle`.
fn rotated(mut mesh: RawMesh, angle: f64) -> RawMesh {
    let n = 14f64.sqrt();
    let k = [1.0 / n, 2.0 / n, 3.0 / n];
    for p in &mut mesh.positions {
        let d: f64 = (0..3).map(|a| k[a] * p[a]).sum();
        let c: V3 = std::array::from_fn(|a| {
            k[(a + 1) % 3] * p[(a + 2) % 3] - k[(a + 2) % 3] * p[(a + 1) % 3]
        });
        *p = std::array::from_fn(|a| {
            p[a] * angle.cos() + c[a] * angle.sin() + k[a] * d * (1.0 - angle.cos())
        });
    }
    mesh
}

fn options(resolution: Option<u32>, modes: usize) -> ElasticOptions {
    ElasticOptions {
        resolution,
        mode_count: modes,
        young_pa: 1.0,
        density_kg_m3: 1.0,
        poisson: 0.3,
        ..ElasticOptions::default()
    }
}

fn solve(mesh: &RawMesh, options: &ElasticOptions) -> (Basis, ElasticReport) {
    elastic_basis(mesh, options, &Silent, &mut Vec::new()).expect("modes")
}

fn omegas(basis: &Basis) -> Vec<f64> {
    basis.modes.iter().map(|m| m.omega_rad_s.unwrap()).collect()
}

/// First bending frequency of a free-free Timoshenko beam with a square section, E = ρ = 1, by
/// bisection on the determinant of its boundary conditions.
fn timoshenko(length: f64, side: f64, poisson: f64) -> f64 {
    let shear = 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson) / (2.0 * (1.0 + poisson));
    let (area, inertia) = (side * side, side.powi(4) / 12.0);
    // y'' + … with solutions cos a x, cosh b x about the middle (symmetric mode); moment and
    // shear vanish at the ends.
    let determinant = |w: f64| {
        let (p, q) = (w * w, w * w / shear); // ω²ρ/E, ω²ρ/(κG)
        let c = w * w * area / inertia; // ω²ρA/(EI)
        let root = (0.25 * (p - q) * (p - q) + c).sqrt();
        let a = (0.5 * (p + q) + root).sqrt();
        let b = (root - 0.5 * (p + q)).sqrt();
        // y = C cos(a x) + D cosh(b x); slope ψ: κGA (y'' - ψ') = -ρAω² y.
        // ψ' = y'' + q y;  ψ = integral.
        let h = 0.5 * length;
        let moment = [(q - a * a) * (a * h).cos(), (q + b * b) * (b * h).cosh()];
        // Shear κGA (y' − ψ) = −q ∫ y.
        let force = [(a * h).sin() / a, (b * h).sinh() / b];
        moment[0] * force[1] - moment[1] * force[0]
    };
    let guess = 4.730_041f64.powi(2) / (length * length) * (inertia / area).sqrt();
    let (mut lo, mut hi) = (0.5 * guess, 1.1 * guess);
    assert!(determinant(lo) * determinant(hi) < 0.0);
    for _ in 0..100 {
        let mid = 0.5 * (lo + hi);
        if determinant(lo) * determinant(mid) <= 0.0 {
            hi = mid;
        } else {
            lo = mid;
        }
    }
    lo
}

/// The mode that moves along the beam: its index in `basis`.
fn axial(basis: &Basis, axis: V3) -> Option<usize> {
    (0..basis.mode_count()).find(|&j| {
        let (mut along, mut all) = (0.0, 0.0);
        for u in basis.field(j) {
            along += (0..3).map(|a| u[a] * axis[a]).sum::<f64>().powi(2);
            all += u.iter().map(|x| x * x).sum::<f64>();
        }
        along > 0.8 * all
    })
}

/// Relative errors of the first two bending modes and the first axial one.
fn beam_errors(mesh: &RawMesh, across: u32) -> ([f64; 2], f64, ElasticReport) {
    let (lo, hi) = mesh
        .positions
        .iter()
        .fold(([f64::MAX; 3], [f64::MIN; 3]), |(l, h), p| {
            (
                std::array::from_fn(|a| l[a].min(p[a])),
                std::array::from_fn(|a| h[a].max(p[a])),
            )
        });
    let longest = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f64::max);
    let resolution = (longest * f64::from(across)).round() as u32;
    let (basis, report) = solve(mesh, &options(Some(resolution), 12));
    let w = omegas(&basis);
    let axis: V3 = std::array::from_fn(|a| (mesh.positions[1][a] - mesh.positions[0][a]) / 20.0);
    let theory = timoshenko(20.0, 1.0, 0.3);
    let bar = std::f64::consts::PI / 20.0;
    let axial = axial(&basis, axis).expect("an axial mode among twelve");
    assert!(report.residual_max <= 1e-6, "{report:?}");
    assert!(report.inertia_checked);
    (
        [w[0] / theory - 1.0, w[1] / theory - 1.0],
        w[axial] / bar - 1.0,
        report,
    )
}

#[test]
fn slender_beam_meets_theory_and_converges() {
    let beam = boxed([20.0, 1.0, 1.0]);
    let mut last = f64::INFINITY;
    for (across, tolerance) in [(1, 2e-3), (2, 5e-4), (4, 5e-4), (6, 5e-4)] {
        let (bend, axial, report) = beam_errors(&beam, across);
        println!(
            "aligned {across}: bending {bend:+.4?} axial {axial:+.4} {}",
            report.dofs
        );
        assert!(bend[0].abs() < tolerance && axial.abs() < tolerance);
        assert!((bend[1] - bend[0]).abs() < 1e-9, "the pair is equal");
        // Theory itself is right to about 1e-4 here.
        assert!(bend[0].abs() < last + 1e-4, "finer is not worse");
        last = bend[0].abs();
        assert!((report.mass_kg - 20.0).abs() < 1e-6);
    }
}

fn turned_beam_meets_theory(angle: f64, sizes: &[(u32, f64)]) {
    let beam = rotated(boxed([20.0, 1.0, 1.0]), angle);
    let mut last = f64::INFINITY;
    for (across, tolerance) in sizes {
        let (bend, axial, report) = beam_errors(&beam, *across);
        println!(
            "turned {angle} {across}: bending {bend:+.4?} axial {axial:+.4} {}",
            report.dofs
        );
        assert!(bend[0].abs() < *tolerance && bend[1].abs() < *tolerance);
        assert!(axial.abs() < 1e-3);
        assert!(bend[1].abs() < last + 1e-4, "finer is not worse");
        last = bend[1].abs();
        assert!((report.mass_kg - 20.0).abs() < 1e-3);
    }
}

#[test]
fn turned_beam_meets_theory_and_converges() {
    // Six cells across would take three times as long.
    turned_beam_meets_theory(0.5, &[(1, 5e-3), (2, 1e-3), (4, 1e-3)]);
}

#[test]
fn beam_turned_farther_meets_theory_and_converges() {
    turned_beam_meets_theory(1.1, &[(1, 5e-3), (2, 1e-3), (4, 1e-3)]);
}

/// A rod along the diagonal of the cells, one or two cells thick: its cells touch along edges, and
/// a lattice that hinged there would have modes far below theory.
#[test]
fn thin_diagonal_rod_has_no_hinges() {
    for (direction, cells) in [
        ([1.0, 1.0, 0.0], 14),
        ([1.0, 1.0, 0.0], 15),
        ([1.0, 1.0, 0.0], 29),
        ([1.0, 1.0, 1.0], 12),
        ([1.0, 1.0, 1.0], 24),
    ] {
        let l = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        let x: V3 = direction.map(|d: f64| d / l);
        let s = 0.5f64.sqrt();
        let y: V3 = [-s, s, 0.0];
        let z: V3 = std::array::from_fn(|a| {
            x[(a + 1) % 3] * y[(a + 2) % 3] - x[(a + 2) % 3] * y[(a + 1) % 3]
        });
        let mut rod = boxed([20.0, 1.0, 1.0]);
        for p in &mut rod.positions {
            let q = *p;
            *p = std::array::from_fn(|a| q[0] * x[a] + q[1] * y[a] + q[2] * z[a]);
        }
        let (basis, report) = solve(&rod, &options(Some(cells), 6));
        let w = omegas(&basis);
        let theory = timoshenko(20.0, 1.0, 0.3);
        println!(
            "rod {direction:?} {cells}: {:.3} {:.3} cell {:.2}",
            w[0] / theory,
            w[1] / theory,
            report.cell_size
        );
        assert!(w[0] > 0.995 * theory, "a hinge: {w:?}");
        assert!(w[1] < 1.005 * theory, "locked: {w:?}");
        // The pair of the second bending mode follows; nothing hides in between.
        assert!(w[2] > 2.0 * w[0]);
    }
}

#[test]
fn cube_keeps_all_its_equal_modes() {
    let cube = boxed([1.0; 3]);
    let mut o = options(Some(10), 20);
    let (basis, report) = solve(&cube, &o);
    assert!(report.inertia_checked && report.residual_max < 1e-6);
    let w = omegas(&basis);
    // Multiplicities of a cube's lowest modes follow from its symmetry: 2, 3, 3, then 1 and 2.
    println!("{w:.5?}");
    for (first, last) in [(0, 1), (2, 4), (5, 7)] {
        assert!(w[last] / w[first] - 1.0 < 1e-9);
        assert!(w[last + 1] / w[last] - 1.0 > 1e-3);
    }
    // Fewer modes are the same modes, even where the request cuts a triplet.
    o.mode_count = 4;
    let (few, _) = solve(&cube, &o);
    for j in 0..4 {
        for (a, b) in few.field(j).iter().zip(basis.field(j)) {
            for axis in 0..3 {
                assert!((a[axis] - b[axis]).abs() < 1e-6);
            }
        }
    }
    // FinEtools, after Puso and Solberg 2006: 0.263 Hz at a Poisson's ratio of 0.499.
    o.poisson = 0.499;
    let (basis, _) = solve(&cube, &o);
    let f = omegas(&basis)[0] / std::f64::consts::TAU;
    assert!((f / 0.263 - 1.0).abs() < 0.02, "{f}");
}

#[test]
fn equal_input_gives_equal_bytes() {
    let beam = rotated(boxed([5.0, 1.0, 1.0]), 0.7);
    let o = options(Some(24), 8);
    let (first, _) = solve(&beam, &o);
    let handle = std::thread::spawn(move || solve(&beam, &o).0);
    let second = handle.join().unwrap();
    let bits = |b: &Basis| -> Vec<u64> { b.fields.iter().flatten().map(|x| x.to_bits()).collect() };
    assert_eq!(bits(&first), bits(&second));
    assert_eq!(first, second);
}

#[test]
fn modal_mass_and_units() {
    let beam = boxed([20.0, 1.0, 1.0]);
    let mut o = options(Some(40), 12);
    o.young_pa = 2e9;
    o.density_kg_m3 = 1000.0;
    let (basis, report) = solve(&beam, &o);
    assert!((report.mass_kg - 20_000.0).abs() < 1e-3);
    let j = axial(&basis, [1.0, 0.0, 0.0]).unwrap();
    // A bar's mode is a cosine: half of its mass at unit tip motion.
    let m = basis.modes[j].modal_mass_kg.unwrap();
    assert!((m / 10_000.0 - 1.0).abs() < 0.01, "{m}");
    for k in 0..basis.mode_count() {
        let field = basis.field(k);
        let farthest = field
            .iter()
            .map(|u| u.iter().map(|x| x * x).sum::<f64>().sqrt())
            .fold(0.0, f64::max);
        assert!((farthest - 1.0).abs() < 1e-12);
    }
    // The same mesh in millimetres: lengths a thousandth, frequencies a thousandfold.
    o.scale_m = 1e-3;
    let (small, report) = solve(&beam, &o);
    assert!((report.mass_kg - 2e-5).abs() < 1e-11);
    for (a, b) in basis.modes.iter().zip(&small.modes) {
        let w = b.omega_rad_s.unwrap() / a.omega_rad_s.unwrap();
        let m = b.modal_mass_kg.unwrap() / a.modal_mass_kg.unwrap();
        assert!((w / 1e3 - 1.0).abs() < 1e-9 && (m / 1e-9 - 1.0).abs() < 1e-9);
    }
    assert_eq!(basis.fields.len(), small.fields.len());
}

#[test]
fn clamped_beam_and_plate_on_edges() {
    // Clamped at one end: β₁L = 1.875104; shear lowers it a little at 20:1.
    let beam = boxed([20.0, 1.0, 1.0]);
    let mut o = options(Some(80), 2);
    o.fixes = vec!["xyz:-0.01,-1,-1,0.01,2,2".parse().unwrap()];
    let (basis, _) = solve(&beam, &o);
    let euler = 1.875_104f64.powi(2) / 400.0 / 12f64.sqrt();
    for w in omegas(&basis) {
        assert!((w / euler - 1.0).abs() < 0.01, "{w} {euler}");
    }
    // NAFEMS FV52: 10 × 10 × 1 m, z held along the four bottom edges; three rigid motions remain.
    // (Held lines give way as a lattice grows finer, so this is a test at one coarse size.)
    let plate = boxed([10.0, 10.0, 1.0]);
    let mut o = ElasticOptions {
        resolution: Some(10),
        mode_count: 7,
        young_pa: 200e9,
        poisson: 0.3,
        density_kg_m3: 8000.0,
        ..ElasticOptions::default()
    };
    o.fixes = [
        "z:0,0,0,10,0,0",
        "z:0,10,0,10,10,0",
        "z:0,0,0,0,10,0",
        "z:10,0,0,10,10,0",
    ]
    .map(|f| f.parse().unwrap())
    .to_vec();
    let (basis, report) = solve(&plate, &o);
    assert!(report.inertia_checked);
    let want = [45.897, 109.44, 109.44, 167.89, 193.59, 206.19, 206.19];
    let hz: Vec<f64> = omegas(&basis)
        .iter()
        .map(|w| w / std::f64::consts::TAU)
        .collect();
    println!("FV52 {hz:.3?}");
    for (f, want) in hz.iter().zip(want) {
        assert!((f / want - 1.0).abs() < 0.05, "{hz:?}");
    }
}

/// NAFEMS FV12: free plate 10 × 10 × 0.05 m, as a sheet far thinner than the cells.
fn check_sheet(angle: f64, tolerance: f64) {
    let n = 10u32;
    let mut plate = RawMesh::default();
    for y in 0..=n {
        for x in 0..=n {
            plate.positions.push([f64::from(x), f64::from(y), 3.0]);
        }
    }
    for y in 0..n {
        for x in 0..n {
            let v = y * (n + 1) + x;
            plate.triangles.push([v, v + 1, v + n + 2]);
            plate.triangles.push([v, v + n + 2, v + n + 1]);
        }
    }
    let o = ElasticOptions {
        resolution: Some(40),
        mode_count: 7,
        young_pa: 200e9,
        poisson: 0.3,
        density_kg_m3: 8000.0,
        thickness: Some(0.05),
        ..ElasticOptions::default()
    };
    let mesh = rotated(plate, angle);
    let (basis, report) = solve(&mesh, &o);
    assert!((report.mass_kg / 40_000.0 - 1.0).abs() < 0.01);
    let want = [1.622, 2.360, 2.922, 4.233, 4.233, 7.416, 7.416];
    let hz: Vec<f64> = omegas(&basis)
        .iter()
        .map(|w| w / std::f64::consts::TAU)
        .collect();
    println!("FV12 {angle} {hz:.3?} cell {}", report.cell_size);
    for (f, want) in hz.iter().zip(want).take(5) {
        assert!((f / want - 1.0).abs() < tolerance, "{hz:?}");
    }
}

#[test]
fn sheet_bends_with_its_own_thickness() {
    check_sheet(0.0, 0.02);
}

#[test]
fn turned_sheet_bends_with_its_own_thickness() {
    check_sheet(0.6, 0.02);
}
