//! Where bodies begin: in a grid, above a point, at the camera.

use nalgebra::Vector3;

use super::simulation::{GRAVITY, Simulation};

/// Distance of neighbors in the grid, in sums of reaches: bodies that turn do not meet.
const SPACING: f64 = 1.05;
/// From what is below to a body that is dropped, in reaches of the body.
const FALL: f64 = 1.0;
/// rad/s of what is thrown.
const SPIN_RAD_S: f64 = 3.0;
/// A thrown body is aimed at where it is after so many seconds at most.
const FLIGHT_MAX_S: f64 = 1.0;
/// In reaches, from the camera to what it throws.
const BEFORE_CAMERA: f64 = 1.5;

const AT_REST: [[f64; 3]; 2] = [[0.0; 3]; 2];

/// Adds so many bodies in two layers of a square grid above the ground, one kind after the other.
///
/// # Errors
/// What the first file that cannot fall lacks, if none can.
pub fn fill(simulation: &mut Simulation, count: usize) -> Result<(), String> {
    let kinds: Vec<usize> = (0..simulation.kinds().len())
        .filter(|kind| simulation.kinds()[*kind].able.is_ok())
        .collect();
    if kinds.is_empty() {
        return simulation.able(0).map(drop);
    }
    let reach = |kind: &usize| simulation.kinds()[*kind].reach();
    let largest = kinds.iter().map(reach).fold(0.0, f64::max);
    let spacing = 2.0 * SPACING * largest;
    let side = (0.5 * count as f64).sqrt().ceil().max(1.0) as usize;
    for k in 0..count {
        let along = |at: usize| (at as f64 - 0.5 * (side as f64 - 1.0)) * spacing;
        let layer = k / (side * side);
        let height = largest * (1.1 + 0.3 * simulation.chance()) + 1.2 * layer as f64 * spacing;
        let center = [along(k % side), height, along(k / side % side)];
        simulation.add(kinds[k % kinds.len()], center, AT_REST)?;
    }
    Ok(())
}

/// Adds a body above a point, so high that it touches nothing there.
///
/// # Errors
/// What its file lacks.
pub fn drop_above(
    simulation: &mut Simulation,
    kind: usize,
    [x, y, z]: [f64; 3],
) -> Result<(), String> {
    let reach = simulation.able(kind)?.reach;
    let mut height = y.max(0.0) + (1.0 + FALL) * reach;
    // Between what falls already, if there is room: up, until nothing is in the way.
    loop {
        let above = |([a, b, c], other): ([f64; 3], f64)| {
            let (both, aside) = (reach + other, (a - x).hypot(c - z));
            let away = (both * both - aside * aside).max(0.0).sqrt();
            ((height - b).abs() < away).then_some(b + away)
        };
        let free = simulation.balls().filter_map(above);
        let free = free.fold(height, f64::max);
        if !(free > height) {
            break;
        }
        height = free;
    }
    simulation.add(kind, [x, height, z], AT_REST).map(drop)
}

/// A throw from a camera.
#[derive(Debug, Clone, Copy)]
pub struct Throw {
    /// Where the camera is.
    pub eye: [f64; 3],
    /// Where to, unit.
    pub direction: [f64; 3],
    /// How far away what it is aimed at is.
    pub distance: f64,
    /// m/s.
    pub speed: f64,
}

/// Adds a body before the camera that flies where it is aimed at: gravity bends it there.
///
/// # Errors
/// What its file lacks; no room before the camera.
pub fn throw(simulation: &mut Simulation, kind: usize, throw: Throw) -> Result<(), String> {
    let reach = simulation.able(kind)?.reach;
    let direction = Vector3::from(throw.direction);
    let mut start = Vector3::from(throw.eye) + direction * (BEFORE_CAMERA * reach);
    start.y = start.y.max(1.05 * reach);
    if !simulation.is_free(start.into(), reach) {
        return Err(
            "nothing can be thrown: a body is at the camera; move the camera away".to_string(),
        );
    }
    let aim = Vector3::from(throw.eye) + direction * throw.distance;
    let way = aim - start;
    let flight_s = (way.norm() / throw.speed).min(FLIGHT_MAX_S);
    let toward = way.try_normalize(0.0).unwrap_or(direction);
    let velocity = toward * throw.speed + Vector3::y() * (0.5 * GRAVITY * flight_s);
    // About an axis across the flight, one way or the other.
    let across = Vector3::y().cross(&toward);
    let spin = across * (SPIN_RAD_S * (2.0 * simulation.chance() - 1.0));
    let motion = [velocity.into(), spin.into()];
    simulation.add(kind, start.into(), motion).map(drop)
}
