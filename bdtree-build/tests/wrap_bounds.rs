//! What the bounds of a lane must be beyond containing its vertices.

use crate::tree_support::*;
use bdtree_build::basis::Basis;

fn norm(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn center(file: &Decoded, i: usize, k: usize) -> [f64; 3] {
    std::array::from_fn(|axis| f64::from(file.value(&file.nodes[i], axis, k)))
}

/// P06: some vertex touches each sphere, to one ulp of its radius.
#[test]
fn some_vertex_touches_every_sphere() {
    let mesh = grid(40);
    let file = bake_default(&mesh, &waves(&mesh, 3));
    for (i, k) in file.lanes() {
        let c = center(&file, i, k);
        let radius = file.value(&file.nodes[i], 3, k);
        let farthest = file
            .vertices_below(i, k)
            .iter()
            .map(|&v| norm(sub(file.positions[v].map(f64::from), c)))
            .fold(0.0, f64::max);
        assert!(farthest <= f64::from(radius));
        // f64 leaves 2⁻⁴⁸ of doubt, so the ulp below may fail to be below by that much.
        assert!(f64::from(radius.next_down()) <= farthest * (1.0 + 2f64.powi(-47)));
    }
}

/// P20: translations leave all radii as they are, but for the rounding of Ū to its grid: radii
/// grow by less than √3/2 units of Ū and one of ΔR, and no unit is above 2⁻¹⁴ of the largest Ū.
#[test]
fn translation_fields_hardly_grow_anything() {
    let mesh = grid(20);
    let file = bake_default(
        &mesh,
        &basis(&mesh, 3, |j, _| {
            std::array::from_fn(|axis| if axis == j { 1.1 } else { 0.3 })
        }),
    );
    for (i, k) in file.lanes() {
        let node = &file.nodes[i];
        for j in 0..3 {
            let limit = f64::from(file.modes[j].q_limit.get());
            let growth = f64::from(file.value(node, 4 + 6 * j + 3, k)) * limit;
            let [center_unit, growth_unit, _] = file.units(node);
            assert!(growth <= 0.867 * center_unit + growth_unit);
            assert!(growth <= 2f64.powi(-14) * 1.5 * limit);
        }
        let q = [0.5, -2.0, 0.1];
        let (_, square, reach) = file.sphere(i, k, &q);
        let radius = f64::from(file.value(node, 3, k));
        let cross = 2.0 * file.units(node)[2] * file.shares(&q);
        assert!(square <= reach * reach + cross && reach <= radius + 4e-4);
    }
}

/// P22 (appendix A, eqs. 12–15): ΔR_j ≤ 2 L_j R with L_j the Lipschitz constant of the field over
/// the lane's vertices; by Jung's theorem 1.22 L_j R for a ball-centered Ū_j.
#[test]
fn growth_is_bounded_by_the_smoothness_of_the_field() {
    let mesh = grid(24);
    let file = bake_default(&mesh, &waves(&mesh, 3));
    for (i, k) in file.lanes() {
        let vertices = file.vertices_below(i, k);
        if vertices.len() > 200 {
            continue;
        }
        for j in 0..3 {
            let u = |v: usize| file.displacements[v * 3 + j].map(f64::from);
            let p = |v: usize| file.positions[v].map(f64::from);
            let mut lipschitz = 0.0f64;
            for &a in &vertices {
                for &b in &vertices {
                    if p(a) != p(b) {
                        lipschitz = lipschitz.max(norm(sub(u(a), u(b))) / norm(sub(p(a), p(b))));
                    }
                }
            }
            let growth = f64::from(file.value(&file.nodes[i], 4 + 6 * j + 3, k));
            let radius = f64::from(file.value(&file.nodes[i], 3, k));
            // Ū and ΔR lie on grids.
            let [center_unit, growth_unit, _] = file.units(&file.nodes[i]);
            let rounded = (center_unit + growth_unit) / f64::from(file.modes[j].q_limit.get());
            assert!(growth <= 2.0 * lipschitz * radius * (1.0 + 1e-6) + 1e-7 + rounded);
        }
    }
}

/// P51: an object that shrinks to a point keeps R' = R |1 − q|.
#[test]
fn uniform_scaling_is_exact() {
    let mesh = grid(40);
    let file = bake_default(&mesh, &basis(&mesh, 1, |_, p| p.map(|x| -x)));
    for (i, k) in file.lanes() {
        let radius = f64::from(file.value(&file.nodes[i], 3, k));
        for q in [-2.0f32, -0.5, 0.0, 0.3, 0.9, 1.0, 1.5, 7.0] {
            let (_, square, _) = file.sphere(i, k, &[q]);
            let wanted = radius * (1.0 - f64::from(q)).abs();
            // b is rounded up by at most a unit, ΔR by one, Ū to √3/2 units.
            let [center, growth, cross] = file.units(&file.nodes[i]);
            let share = file.shares(&[q]);
            let around = radius * (1.0 + f64::from(q.abs())) + share * (center + growth);
            let tolerance = 2.0 * share * (cross + 2.0 * around * (center + growth));
            assert!(
                (square - wanted * wanted).abs() <= tolerance + 1e-12,
                "{i} {k} {q}"
            );
        }
    }
}

/// R' is never above the paper's R + Σ ΔR_j |q_j|.
#[test]
fn second_order_bound_is_never_above_the_first() {
    let mesh = grid(30);
    let file = bake_default(&mesh, &waves(&mesh, 5));
    let mut rng = rng(3);
    for _ in 0..20 {
        let q = file.random_q(&mut rng);
        for (i, k) in file.lanes() {
            let (_, square, reach) = file.sphere(i, k, &q);
            let rounded = 2.0 * file.units(&file.nodes[i])[2] * file.shares(&q);
            assert!(square <= reach * reach * (1.0 + 1e-6) + rounded);
        }
    }
}

/// δR bounds the motion of every vertex per step of q, plain and scaled (eq. 11).
#[test]
fn step_bounds_hold_and_are_tight_for_one_mode() {
    let mesh = grid(20);
    let check = |basis: &Basis, modes: usize, seed: u64| {
        let file = bake_default(&mesh, basis);
        let mut rng = rng(seed);
        for _ in 0..10 {
            let step = file.random_q(&mut rng);
            let plain = step
                .iter()
                .map(|q| f64::from(*q).powi(2))
                .sum::<f64>()
                .sqrt();
            let scaled = step
                .iter()
                .zip(&file.modes)
                .map(|(q, m)| (f64::from(*q) / f64::from(m.step_scale.get())).powi(2))
                .sum::<f64>()
                .sqrt();
            let moved = file.deform(&step);
            for (i, k) in file.lanes() {
                let node = &file.nodes[i];
                let rows = 4 + 6 * usize::from(node.mode_count);
                let longest = file
                    .vertices_below(i, k)
                    .iter()
                    .map(|&v| norm(sub(moved[v], file.positions[v].map(f64::from))))
                    .fold(0.0, f64::max);
                for (row, size) in [(rows, plain), (rows + 1, scaled)] {
                    let bound = f64::from(file.value(node, row, k)) * size;
                    // p + U q − p cancels in f64.
                    let cancelled = 2f64.powi(-50) * (1.0 + longest);
                    assert!(longest <= bound * (1.0 + 1e-12) + cancelled);
                    assert!(modes > 1 || bound <= longest * (1.0 + 1e-6) + cancelled);
                }
            }
        }
    };
    check(&waves(&mesh, 1), 1, 1);
    check(&waves(&mesh, 7), 7, 2);
}
