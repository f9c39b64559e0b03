//! Modes of volume meshes as they come: of several parts and materials, odd, extreme, random.

use crate::volume_support::{BAR, bar, block, five_tetrahedra, hertz, join, of, run, solve, steel};
use bdtree_build::basis::modal::modal_basis;
use bdtree_build::basis::volume::{MassMatrix, VolumeOptions, volume_modes};
use bdtree_build::input::volume::{RawMaterial, RawVolume};
use bdtree_build::progress::Silent;

fn assert_close(a: &[f64], b: &[f64], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (x, y) in a.iter().zip(b) {
        assert!((x / y - 1.0).abs() < tolerance, "{a:?} {b:?}");
    }
}

#[test]
fn parts_and_materials_are_each_their_own() {
    // A bar of the file's two materials, beside one of the same kind, and a node that nobody uses.
    let material = |young_pa| RawMaterial {
        name: None,
        young_pa,
        poisson: 0.3,
        density_kg_m3: 1000.0,
    };
    let mut first = bar();
    first.materials = vec![material(1e9), material(4e9)];
    first.material_of = vec![0; 32];
    let options = VolumeOptions {
        mode_count: 3,
        ..VolumeOptions::default()
    };
    let soft = run(&first, &options).unwrap();
    let mut second = first.clone();
    for p in &mut second.nodes {
        p[1] += 5.0;
    }
    let mut both = join(first.clone(), &second);
    both.nodes.push([50.0, 0.0, 0.0]);
    both.material_of = [vec![0; 32], vec![1; 32]].concat();
    let options = VolumeOptions {
        mode_count: 6,
        ..options
    };
    let mut warnings = Vec::new();
    let (modes, report) = volume_modes(&both, &options, &Silent, &mut warnings).unwrap();
    assert_eq!((report.components, report.elements), (2, 64));
    assert_eq!(report.nodes + 1, both.nodes.len());
    assert!((report.mass_kg - 8000.0).abs() < 1e-9);
    // Four times as stiff: twice the frequency; the modes of both interleave.
    let mut want: Vec<f64> = soft.iter().flat_map(|f| [*f, 2.0 * f]).collect();
    let more = run(
        &first,
        &VolumeOptions {
            mode_count: 6,
            ..options.clone()
        },
    )
    .unwrap();
    want.extend(&more[3..]);
    want.sort_by(f64::total_cmp);
    assert_close(&hertz(&modes), &want[..6], 1e-9);
    let middle = first.nodes.len();
    for mode in &modes.modes {
        let still = |part: &[[f64; 3]]| part.iter().flatten().all(|x| *x == 0.0);
        let (a, b) = mode.field.split_at(middle);
        assert!(still(a) != still(&b[..middle]));
        assert_eq!(b[middle], [0.0; 3]);
    }
    assert!(warnings.is_empty(), "{warnings:?}");
    // One mode belongs to one of them, and the other one is named.
    let options = VolumeOptions {
        mode_count: 1,
        ..options
    };
    volume_modes(&both, &options, &Silent, &mut warnings).unwrap();
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("1 of 2 parts"), "{warnings:?}");
    assert!(warnings[0].contains(&format!("node {}", middle + 1)));
    // A part that is held altogether is no reason to refuse the other one.
    let options = VolumeOptions {
        mode_count: 3,
        fixes: vec!["xyz:-1,4,-1,9,9,9".parse().unwrap()],
        ..options
    };
    assert_close(&run(&both, &options).unwrap(), &soft, 1e-9);
}

#[test]
fn joints_are_told() {
    let mut volume = block([2, 2, 1], [2.0, 2.0, 1.0]);
    volume.hexahedra = vec![volume.hexahedra[0], volume.hexahedra[3]];
    let mut warnings = Vec::new();
    let (modes, _) = volume_modes(&volume, &steel(4), &Silent, &mut warnings).unwrap();
    assert!(modes.modes[0].omega_rad_s > 1.0);
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("2 blocks"), "{warnings:?}");
    // A chain of more of them than are worth the work is refused.
    let mut chain = block([300, 2, 1], [300.0, 2.0, 1.0]);
    let all = std::mem::take(&mut chain.hexahedra);
    chain
        .hexahedra
        .extend((0..300).map(|x| all[x + 300 * (x % 2)]));
    let error = run(&chain, &steel(4)).expect_err("an error").to_string();
    assert!(error.contains("300 blocks"), "{error}");
}

#[test]
fn tetrahedra_of_soft_rubber_are_warned_about() {
    let volume = five_tetrahedra(bar(), BAR);
    let mut warnings = Vec::new();
    volume_modes(&volume, &of(1e6, 0.45, 1000.0, 2), &Silent, &mut warnings).unwrap();
    assert!(warnings.iter().any(|w| w.contains("0.45")), "{warnings:?}");
    warnings.clear();
    volume_modes(&bar(), &of(1e6, 0.45, 1000.0, 2), &Silent, &mut warnings).unwrap();
    assert!(warnings.is_empty());
}

/// Whatever the element, one alone has its modes; masses at the nodes only lower them.
#[test]
fn single_elements_vibrate() {
    let cube = block([1; 3], [1.0; 3]);
    let mut tetrahedron = five_tetrahedra(cube.clone(), [1; 3]);
    tetrahedron.tetrahedra.truncate(1);
    for (volume, count) in [(cube, 18), (tetrahedron, 6)] {
        let consistent = run(&volume, &steel(count)).unwrap();
        let lumped = VolumeOptions {
            mass: MassMatrix::Lumped,
            ..steel(count)
        };
        let lumped = run(&volume, &lumped).unwrap();
        for (l, c) in lumped.iter().zip(&consistent) {
            assert!(*l > 0.0 && l <= c, "{lumped:?} {consistent:?}");
        }
        assert!(run(&volume, &steel(count + 1)).is_err());
    }
}

/// Hexahedra with two edges that are points: two of them in each cell of a bar.
#[test]
fn wedges_are_hexahedra_with_coinciding_corners() {
    let n = [16, 4, 4];
    let whole = block(n, [4.0, 1.0, 1.0]);
    let mut wedges = whole.clone();
    wedges.hexahedra = (whole.hexahedra.iter())
        .flat_map(|c| {
            let half = |[a, b, d]: [usize; 3]| [a, b, d, d, a + 4, b + 4, d + 4, d + 4];
            [[0, 1, 2], [0, 2, 3]].map(|ends| half(ends).map(|k| c[k]))
        })
        .collect();
    let want = run(&whole, &steel(8)).unwrap();
    let (modes, report) = solve(&wedges, &steel(8));
    assert!((report.mass_kg / (4.0 * 7800.0) - 1.0).abs() < 1e-12);
    // Triangles are stiffer than squares, by a tenth across their long sides.
    assert_close(&hertz(&modes), &want, 0.12);
    let lumped = VolumeOptions {
        mass: MassMatrix::Lumped,
        ..steel(8)
    };
    assert_close(&run(&wedges, &lumped).unwrap(), &want, 0.12);
}

#[test]
fn units_and_modal_masses() {
    let volume = block([16, 2, 2], [4.0, 0.4, 0.4]);
    let options = of(2e11, 0.0, 7800.0, 12);
    let (modes, report) = solve(&volume, &options);
    let mass = 4.0 * 0.4 * 0.4 * 7800.0;
    assert!((report.mass_kg / mass - 1.0).abs() < 1e-12);
    let count = volume.nodes.len();
    let mut warnings = Vec::new();
    let fields = modes.on_vertices(<[[f64; 3]]>::to_vec);
    let basis = modal_basis(count, fields, &mut warnings);
    assert!(warnings.is_empty());
    let mut axial = 0;
    for (j, mode) in basis.modes.iter().enumerate() {
        let lengths = basis
            .field(j)
            .iter()
            .map(|u| u.map(|x| x * x).iter().sum::<f64>());
        assert!((lengths.fold(0.0, f64::max) - 1.0).abs() < 1e-12);
        assert_eq!(mode.omega_rad_s, Some(modes.modes[j].omega_rad_s));
        let across = basis.field(j).iter().map(|u| u[1].abs().max(u[2].abs()));
        if across.fold(0.0, f64::max) < 1e-6 {
            // A bar's mode is a cosine: half of its mass at unit tip motion, but for the steps
            // (2.5 % for the second one).
            axial += 1;
            assert!((mode.modal_mass_kg.unwrap() / (0.5 * mass) - 1.0).abs() < 0.03);
        }
    }
    assert!(axial > 0);
    // The same mesh in millimetres: lengths a thousandth, frequencies a thousandfold.
    let small = VolumeOptions {
        scale_m: 1e-3,
        ..options
    };
    let (small, report) = solve(&volume, &small);
    assert!((report.mass_kg / (mass * 1e-9) - 1.0).abs() < 1e-12);
    for (a, b) in modes.modes.iter().zip(&small.modes) {
        assert!((b.omega_rad_s / a.omega_rad_s / 1e3 - 1.0).abs() < 1e-9);
    }
    // A mode that an embedding leaves out is told.
    let still = |_: &[[f64; 3]]| vec![[0.0; 3]; 2];
    let basis = modal_basis(2, small.on_vertices(still), &mut warnings);
    assert_eq!((basis.mode_count(), warnings.len()), (12, 12));
}

#[test]
fn equal_input_gives_equal_bytes() {
    let volume = five_tetrahedra(bar(), BAR);
    let first = solve(&volume, &steel(8)).0;
    let second = std::thread::spawn(move || solve(&volume, &steel(8)).0);
    assert_eq!(first, second.join().unwrap());
}

/// Extremes either have modes near those of the plain body or are refused in words.
#[test]
fn extremes_work_or_are_refused() {
    let n = [8, 4, 4];
    let plain = block(n, [2.0, 1.0, 1.0]);
    let want = run(&plain, &steel(6)).unwrap();
    for thin in [1e-3, 1e-6, 1e-9, 1e-12, 0.0] {
        let mut layer = plain.clone();
        for p in layer.nodes.iter_mut().filter(|p| p[0] == 0.25) {
            p[0] = thin;
        }
        match run(&layer, &steel(6)) {
            Ok(f) => assert_close(&f, &want, 0.02),
            Err(e) => assert!(thin < 1e-8, "{e}"),
        }
        // A tetrahedron that is nearly flat.
        let mut sliver = five_tetrahedra(plain.clone(), n);
        sliver.nodes[(2 * 5 + 2) * 9 + 4][0] += 0.25 * (1.0 - thin);
        match run(&sliver, &steel(6)) {
            Ok(f) => assert_close(&f, &want, 0.15),
            Err(e) => assert!(thin < 1e-8, "{e}"),
        }
    }
    for poisson in [0.49, 0.499, 0.4999, 0.499_999, 0.499_999_999_999] {
        match run(&plain, &of(2e11, poisson, 7800.0, 6)) {
            Ok(f) => assert_close(&f, &want, 0.08),
            Err(e) => assert!(poisson > 0.499_999, "{e}"),
        }
    }
    let mut far = plain.clone();
    for p in &mut far.nodes {
        *p = [p[0] + 1e6, p[1] - 3e6, p[2] + 1e5];
    }
    assert_close(&run(&far, &steel(6)).unwrap(), &want, 1e-7);
    let mut tiny = plain.clone();
    for p in &mut tiny.nodes {
        *p = p.map(|x| 1e-30 * x);
    }
    let scaled = VolumeOptions {
        scale_m: 1e30,
        ..steel(6)
    };
    assert_close(&run(&tiny, &scaled).unwrap(), &want, 1e-9);
    let nothing = VolumeOptions {
        scale_m: 1e-90,
        ..steel(6)
    };
    assert!(run(&tiny, &nothing).is_err());
}

/// Whatever the elements, the answer is modes or an error.
#[test]
fn random_elements_never_panic() {
    let mut state = 7u64;
    let mut next = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / (1u64 << 31) as f64
    };
    let mut solved = 0;
    for case in 0..300 {
        let mut volume = RawVolume::default();
        let count = 4 + (next() * 12.0) as usize;
        let steps = [2.0, 4.0, 1e6][case % 3];
        for _ in 0..count {
            volume
                .nodes
                .push(std::array::from_fn(|_| (next() * steps).floor() / steps));
        }
        for _ in 0..1 + case % 7 {
            let mut t: [u32; 4] = std::array::from_fn(|_| (next() * count as f64) as u32);
            let [a, b, c, d] = t.map(|n| volume.nodes[n as usize]);
            let [b, c, d] = [b, c, d].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
            let six: f64 = (0..3)
                .map(|k| (b[(k + 1) % 3] * c[(k + 2) % 3] - b[(k + 2) % 3] * c[(k + 1) % 3]) * d[k])
                .sum();
            if six < 0.0 {
                t.swap(2, 3);
            }
            if six != 0.0 || case % 11 == 0 {
                volume.tetrahedra.push(t);
            }
        }
        let mut options = of(1.0, 0.3, 1.0, 1 + case % 5);
        if case % 4 == 1 {
            options.fixes = vec!["xz:0,0,0,0.3,1,1".parse().unwrap()];
        }
        match run(&volume, &options) {
            Ok(f) => solved += usize::from(f[0] > 0.0),
            Err(e) => assert!(!e.problems.is_empty()),
        }
    }
    assert!(solved > 100, "{solved}");
}
