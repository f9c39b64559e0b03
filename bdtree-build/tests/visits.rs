//! Bases that make bounds useless are warned about, with figures; smooth ones are not.

use crate::tree_support::*;
use bdtree_build::basis::{Basis, BasisMode};
use bdtree_build::pipeline::BakeSettings;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Every vertex goes its own way: the paper's "unreduced" case, not smooth at all.
fn noise(vertex_count: usize, modes: usize) -> Basis {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut number = || random.random_range(-1.0..1.0);
    Basis {
        vertex_count,
        fields: (0..vertex_count * modes)
            .map(|_| [number(), number(), number()])
            .collect(),
        modes: vec![BasisMode::default(); modes],
        animation: None,
    }
}

#[test]
fn noise_is_warned_about_with_figures() {
    let mesh = grid(60);
    let basis = noise(mesh.positions.len(), 24);
    let baked = bake_with(&mesh, &basis, &BakeSettings::default());
    let report = &baked.report;
    assert!(report.visits.range > 0.25 * report.nodes as f64);
    let warning = report.warnings.iter().find(|w| w.contains("visits"));
    let warning = warning.expect("a warning");
    for figure in [report.visits.range, report.visits.rest, report.nodes as f64] {
        assert!(warning.contains(&format!("{figure:.0}")), "{warning}");
    }
}

#[test]
fn smooth_fields_are_not() {
    let mesh = grid(60);
    let baked = bake_with(&mesh, &waves(&mesh, 4), &BakeSettings::default());
    let report = &baked.report;
    assert!(report.visits.rest >= 1.0 && report.visits.rest < 12.0);
    assert!(report.visits.range < 0.25 * report.nodes as f64);
    assert!(!report.warnings.iter().any(|w| w.contains("visits")));
}
