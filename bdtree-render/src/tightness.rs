//! How tight spheres are, and the colours for it.
//!
//! The paper (figure 4): "Throughout the paper, dark red denotes at least 3 times greater sphere volume
//! (or ≥ 1.44 × radius) than the undeformed wrapped BD-Tree sphere, and dark blue implies a negligible
//! size increase." So growth is a sphere's radius over that of the wrapped sphere of the same node at
//! rest. [`Against::Deformed`] divides by the smallest ball around what the sphere holds as it is deformed
//! now instead: how much larger it is than it would have to be.

use bdtree_build::wrap::ball::smallest_ball;
use bdtree_runtime::{Asset, FormatError};

use crate::level::{NodeSphere, below};

/// Growth that is dark red: ∛3, to the paper's digits.
pub const GROWTH_RED: f64 = 1.44;

/// What radii are divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Against {
    /// The wrapped sphere at rest, as in the paper.
    #[default]
    Rest,
    /// The smallest ball around the deformed vertices below.
    Deformed,
}

/// Growth of every sphere. `positions` are the deformed vertices, where the spheres are.
///
/// # Errors
/// A corrupt asset.
pub fn growths(
    asset: &Asset<'_>,
    spheres: &[NodeSphere],
    positions: &[[f64; 3]],
    against: Against,
) -> Result<Vec<f64>, FormatError> {
    let of = |sphere: &NodeSphere| {
        let best = match against {
            Against::Rest => sphere.rest_radius,
            Against::Deformed => {
                let vertices = below(asset, sphere.node, sphere.lane)?;
                let at = |v: &u32| positions.get(*v as usize).copied();
                let points: Vec<[f64; 3]> = vertices.iter().filter_map(at).collect();
                smallest_ball(&points).radius
            }
        };
        Ok(growth(sphere.radius, best))
    };
    spheres.iter().map(of).collect()
}

/// A radius over another; 1 where both are 0.
pub fn growth(radius: f64, best: f64) -> f64 {
    if radius == best { 1.0 } else { radius / best }
}

/// Mean and largest of some growths, those that are not finite left out; `None` of none.
pub fn mean_and_max(growths: &[f64]) -> Option<[f64; 2]> {
    let finite = || growths.iter().filter(|g| g.is_finite());
    let count = finite().count();
    let max = finite().copied().reduce(f64::max)?;
    Some([finite().sum::<f64>() / count as f64, max])
}

/// The colour of a growth: dark blue at 1 and below, over blue, cyan, yellow and red, to dark red from
/// [`GROWTH_RED`] on, evenly in the radius.
pub fn colour(growth: f64) -> [u8; 3] {
    // Not a number counts as beyond all.
    let share = if growth.is_nan() {
        1.0
    } else {
        (growth - 1.0) / (GROWTH_RED - 1.0)
    };
    at(share.clamp(0.0, 1.0))
}

/// The colour at a part of the scale.
fn at(share: f64) -> [u8; 3] {
    const STOPS: [(f64, [f64; 3]); 6] = [
        (0.0, [0.0, 0.0, 0.53]),
        (0.125, [0.0, 0.1, 1.0]),
        (0.375, [0.0, 0.95, 1.0]),
        (0.625, [1.0, 0.95, 0.0]),
        (0.875, [1.0, 0.05, 0.0]),
        (1.0, [0.5, 0.0, 0.0]),
    ];
    let k = STOPS.iter().rposition(|(s, _)| *s <= share).unwrap_or(0);
    let k = k.min(STOPS.len() - 2);
    let ((from, a), (to, b)) = (STOPS[k], STOPS[k + 1]);
    let t = (share - from) / (to - from);
    [0, 1, 2].map(|i| (255.0 * (a[i] + t * (b[i] - a[i]))).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_begins_dark_blue_and_ends_dark_red() {
        for growth in [0.0, 0.9, 1.0] {
            assert_eq!(colour(growth), [0, 0, 135]);
        }
        for growth in [GROWTH_RED, 3.0, f64::INFINITY, f64::NAN] {
            assert_eq!(colour(growth), [128, 0, 0]);
        }
        let [r, g, b] = colour(1.22);
        assert!(
            g > 200 && r > 100 && b > 100,
            "the middle is light: {r} {g} {b}"
        );
        assert!(GROWTH_RED.powi(3) > 2.98 && GROWTH_RED.powi(3) < 3.0);
    }

    #[test]
    fn growth_of_nothing_is_none() {
        assert_eq!(growth(0.0, 0.0), 1.0);
        assert_eq!(growth(3.0, 2.0), 1.5);
        assert_eq!(mean_and_max(&[]), None);
        assert_eq!(mean_and_max(&[1.0, f64::INFINITY, 2.0]), Some([1.5, 2.0]));
    }
}
