//! Bullet's torus: the same solver on the element that its modes were made with.
//!
//! The spectrum shipped with Bullet's reduced torus is that of a network of bars along the edges
//! of the tetrahedra (E A = 10 N, ρ A = 0.1 kg/m, mass at the nodes), not that of a solid. With such
//! bars as elements its forty eigenvalues and modes must come out.

use std::borrow::Cow;

use faer::Mat;

use crate::elastic::assemble::Source;
use crate::elastic::assemble::dissection::dissect_mesh;
use crate::elastic::assemble::system::System;
use crate::elastic::element::{ElementMatrices, NodeLists};
use crate::elastic::solve::{Limits, Solution, solve};
use crate::progress::Silent;
use crate::vec3::{norm, sub};

/// Stiffness and lumped mass of a bar.
fn bar(a: [f64; 3], b: [f64; 3]) -> ElementMatrices {
    let d = sub(b, a);
    let length = norm(d);
    let block: [f64; 9] =
        std::array::from_fn(|n| 10.0 * d[n / 3] * d[n % 3] / (length * length * length));
    let m = 0.1 * length / 2.0;
    ElementMatrices {
        stiffness: vec![block, block.map(|k| -k), block.map(|k| -k), block],
        mass: vec![m, 0.0, 0.0, m],
    }
}

/// The lines of a legacy VTK file after the one that begins so: as many as it says.
fn table<'t>(text: &'t str, name: &str) -> Vec<&'t str> {
    let mut lines = text.lines().skip_while(|l| !l.starts_with(name));
    let count = lines.next().and_then(|l| l.split(' ').nth(1));
    let count = count.and_then(|c| c.parse().ok()).expect("a count");
    lines.take(count).collect()
}

fn numbers(line: &str) -> Vec<f64> {
    line.split(' ').filter_map(|w| w.parse().ok()).collect()
}

fn solve_bars(nodes: &[[f64; 3]], bars: &NodeLists, wanted: usize) -> Solution {
    let source = Source {
        order: dissect_mesh(nodes, bars),
        positions: nodes.to_vec(),
        elements: Cow::Borrowed(bars),
        ..Source::default()
    };
    let system = |_| {
        System::assemble(&source, |e| {
            let [a, b] = [0, 1].map(|k| nodes[bars.get(e)[k] as usize]);
            Some(Cow::Owned(bar(a, b)))
        })
    };
    let limits = Limits {
        wanted,
        bytes: 1 << 30,
        verify_dof_max: 70_000,
        threads: 2,
    };
    solve(&[nodes.len()], system, limits, &Silent).expect("modes")
}

#[test]
fn bullet_torus_has_its_known_modes() {
    let file = |name: &str| {
        let test = "bullet_torus_has_its_known_modes";
        bdtree_fixtures::corpus::path(test, &format!("modal/bullet_torus.{name}"))
    };
    let (Some(mesh), Some(values), Some(modes)) =
        (file("vtk"), file("eigenvalues.txt"), file("modes.f64"))
    else {
        return;
    };
    let mesh = std::fs::read_to_string(mesh).expect("a file");
    let point = |l: &&str| <[f64; 3]>::try_from(numbers(l)).expect("three numbers");
    let nodes: Vec<[f64; 3]> = table(&mesh, "POINTS").iter().map(point).collect();
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for line in table(&mesh, "CELLS") {
        let own: Vec<u32> = numbers(line)[1..].iter().map(|&n| n as u32).collect();
        for (i, &a) in own.iter().enumerate() {
            edges.extend(own[i + 1..].iter().map(|&b| [a.min(b), a.max(b)]));
        }
    }
    edges.sort_unstable();
    edges.dedup();
    let mut bars = NodeLists::default();
    edges.iter().for_each(|e| bars.push(*e));

    let text = std::fs::read_to_string(values).expect("a file");
    let known: Vec<f64> = (text.lines().filter(|l| !l.starts_with('#')))
        .flat_map(numbers)
        .collect();
    let (known, masses) = known.split_at(40);
    assert_eq!(masses.len(), nodes.len());
    let mut own = vec![0.0; nodes.len()];
    for e in 0..bars.len() {
        let [a, b] = [0, 1].map(|k| bars.get(e)[k] as usize);
        let m = bar(nodes[a], nodes[b]).mass[0];
        own[a] += m;
        own[b] += m;
    }
    for (m, known) in own.iter().zip(masses) {
        assert!((m / known - 1.0).abs() < 1e-12);
    }

    let solution = solve_bars(&nodes, &bars, 40);
    assert!(solution.checked);
    let mut worst = 0.0f64;
    for (mode, known) in solution.modes.iter().zip(known) {
        worst = worst.max((mode.value / known - 1.0).abs());
    }
    println!("eigenvalues agree to {worst:.1e}");
    assert!(worst < 1e-10, "{worst}");

    // Mass-orthonormal in both files: the forty modes span the same space, mode by mode.
    let bytes = std::fs::read(modes).expect("a file");
    let size = 3 * nodes.len();
    let given = |i: usize, j: usize| {
        let at = 4 + 8 * (j * size + i);
        f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
    };
    let given = Mat::from_fn(size, 40, given);
    let ours = Mat::from_fn(size, 40, |i, j| masses[i / 3] * solution.modes[j].vector[i]);
    let overlap = given.transpose() * ours;
    for j in 0..40 {
        for k in 0..40 {
            let want = if j == k { 1.0 } else { 0.0 };
            assert!((overlap[(j, k)].abs() - want).abs() < 1e-6, "{j} {k}");
        }
    }
}
