//! That nothing is below the ground.

use std::error::Error;

use super::scene::Chairs;
use crate::falling::Scene;
use crate::falling::check::centers;

/// Bodies whose spheres are compared with the ground in a step.
const LOW: usize = 8;

/// The lowest center of any contact sphere of some bodies near the ground, other bodies in every step, and the number of
/// centers that are below it by more than the largest radius. No bodies are near it: not a number.
pub(super) fn ground(scene: &Chairs) -> Result<(f64, u64), Box<dyn Error>> {
    let at = scene.positions()?;
    let mut low: Vec<usize> = (0..at.len())
        .filter(|body| at[*body][1] < scene.extent)
        .collect();
    let first = scene.world.steps() as usize * LOW;
    if !low.is_empty() {
        let by = first % low.len();
        low.rotate_left(by);
    }
    let radius = scene.spheres().radii().iter().copied().fold(0.0, f64::max);
    let (mut lowest, mut below) = (f64::NAN, 0);
    for body in low.into_iter().take(LOW) {
        for center in centers(scene, body)? {
            lowest = lowest.min(center.y);
            // Not a number is below, too.
            below += u64::from(!(center.y > -radius));
        }
    }
    Ok((lowest, below))
}
