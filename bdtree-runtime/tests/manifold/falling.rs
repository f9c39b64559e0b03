//! Forces from contact regions move bodies as springs would.

use bdtree_fixtures::bake;
use bdtree_runtime::Transform;

use super::{contact, place, rigid, sheet, sphere};

/// A body falls on a sheet, held up by `k · depth + c · approach` per area (Kelvin and Voigt), its modes
/// driven by the same forces. Returns the energies at the start, and the largest and the last one without
/// contact.
fn drop(basis_modes: usize, damping: f64) -> [f64; 3] {
    const STEP: f64 = 1.0 / 2048.0;
    let (gravity, stiffness, mass) = (9.81, 4e4, 20.0);
    let body = sphere(16);
    let body = bake::baked(&body, &bake::smooth_basis(&body, basis_modes, 3));
    let floor = rigid(&sheet(8));
    let (body, floor) = (body.asset(), floor.asset());
    let on = (floor.pose(&[], Transform::IDENTITY, &mut [])).expect("pose");
    // Modal stiffness per unit of modal mass.
    let omega_squared: Vec<f64> = (0..basis_modes).map(|j| 900.0 * (1.0 + j as f64)).collect();
    let modal_mass = 0.5;
    let (mut height, mut speed) = (1.3, 0.0);
    let (mut q, mut rates) = (vec![0.0; basis_modes], vec![0.0; basis_modes]);
    let energy = |height: f64, speed: f64, q: &[f64], rates: &[f64]| {
        let modal: f64 = (0..basis_modes)
            .map(|j| rates[j] * rates[j] + omega_squared[j] * q[j] * q[j])
            .sum();
        mass * (gravity * height + 0.5 * speed * speed) + 0.5 * modal_mass * modal
    };
    let start = energy(height, speed, &q, &rates);
    let (mut largest, mut last, mut touched) = (0.0_f64, start, 0);
    for _ in 0..4096 {
        let mut memory = vec![0.0; body.pose_len()];
        let q32: Vec<f32> = q.iter().map(|x| *x as f32).collect();
        let pose = body
            .pose(&q32, place([0.1, 0.2, height]), &mut memory)
            .expect("pose");
        let (pairs, regions) = contact(&pose, &on, 0.0);
        let mut force = -mass * gravity;
        let mut modal = vec![0.0; basis_modes];
        for region in &regions {
            for point in region.points() {
                let approach = speed * region.normal1[2];
                let pressure = (-stiffness * point.distance + damping * approach).max(0.0);
                let push = region.normal1.map(|n| -n * pressure * point.area);
                force += push[2];
                let (id, weights) = (point.triangle1, point.barycentric1);
                pose.add_generalized_force(id, weights, push, &mut modal)
                    .expect("force");
            }
        }
        touched += usize::from(!regions.is_empty());
        // Velocities first: the integrator itself keeps the energy of springs.
        speed += STEP * force / mass;
        height += STEP * speed;
        for j in 0..basis_modes {
            rates[j] += STEP * (modal[j] / modal_mass - omega_squared[j] * q[j]);
            q[j] += STEP * rates[j];
        }
        if pairs.is_empty() {
            last = energy(height, speed, &q, &rates);
            largest = largest.max(last);
        }
    }
    assert!(touched > 20, "it has bounced: {touched}");
    [start, largest, last]
}

#[test]
fn penalty_forces_do_not_raise_the_energy_of_a_falling_body() {
    // The integrator's own ripple is of the order of ω · step: 1 % of the modal energy.
    let [start, largest, last] = drop(0, 0.0);
    assert!(
        largest < 1.01 * start && last > 0.9 * start,
        "{start} {largest} {last}"
    );
    let [start, largest, last] = drop(3, 0.0);
    assert!(largest < 1.02 * start, "{start} {largest} {last}");
    let [start, largest, last] = drop(3, 400.0);
    assert!(
        largest < 1.01 * start && last < 0.95 * start,
        "{start} {largest} {last}"
    );
}
