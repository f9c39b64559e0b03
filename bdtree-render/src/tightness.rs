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

/// Colors for growth, evenly in the radius from 1 to [`GROWTH_RED`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// The paper's: dark blue, over blue, cyan, yellow and red, to dark red.
    #[default]
    Paper,
    /// Viridis: dark purple, over blue and green, to yellow. Its lightness alone tells growths apart, so it can be
    /// read without telling red from green.
    Viridis,
}

impl Scale {
    /// The color of a growth: the first of the scale at 1 and below, the last from [`GROWTH_RED`] on.
    pub fn colour(self, growth: f64) -> [u8; 3] {
        self.colour_to(GROWTH_RED, growth)
    }

    /// The same of a scale that ends at another growth, above 1.
    pub fn colour_to(self, end: f64, growth: f64) -> [u8; 3] {
        // Not a number counts as beyond all.
        let share = if growth.is_nan() {
            1.0
        } else {
            (growth - 1.0) / (end - 1.0)
        };
        let share = share.clamp(0.0, 1.0);
        match self {
            Self::Paper => paper(share),
            Self::Viridis => viridis(share),
        }
    }
}

/// The paper's color at a part of the scale.
fn paper(share: f64) -> [u8; 3] {
    const STOPS: [(f64, [f64; 3]); 6] = [
        (0.0, [0.0, 0.0, 135.0]),
        (0.125, [0.0, 25.5, 255.0]),
        (0.375, [0.0, 242.25, 255.0]),
        (0.625, [255.0, 242.25, 0.0]),
        (0.875, [255.0, 12.75, 0.0]),
        (1.0, [127.5, 0.0, 0.0]),
    ];
    let k = STOPS.iter().rposition(|(s, _)| *s <= share).unwrap_or(0);
    let k = k.min(STOPS.len() - 2);
    let ((from, a), (to, b)) = (STOPS[k], STOPS[k + 1]);
    between(a, b, (share - from) / (to - from))
}

/// Viridis at a part of the scale: every 17th of the 256 colors that matplotlib publishes (S. van der Walt and N.
/// Smith, 2015, `_cm_listed.py`, CC0), and what lies between them; at most 7 of 255 beside the others.
fn viridis(share: f64) -> [u8; 3] {
    const STOPS: [[u8; 3]; 16] = [
        [68, 1, 84],
        [72, 26, 108],
        [71, 47, 125],
        [65, 68, 135],
        [57, 86, 140],
        [49, 104, 142],
        [42, 120, 142],
        [35, 136, 142],
        [31, 152, 139],
        [34, 168, 132],
        [53, 183, 121],
        [84, 197, 104],
        [122, 209, 81],
        [165, 219, 54],
        [210, 226, 27],
        [253, 231, 37],
    ];
    let at = share * (STOPS.len() - 1) as f64;
    let k = (at as usize).min(STOPS.len() - 2);
    let [a, b] = [STOPS[k], STOPS[k + 1]].map(|stop| stop.map(f64::from));
    between(a, b, at - k as f64)
}

/// From one color to another.
fn between(a: [f64; 3], b: [f64; 3], part: f64) -> [u8; 3] {
    [0, 1, 2].map(|i| (a[i] + part * (b[i] - a[i])).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_s_scale_begins_dark_blue_and_ends_dark_red() {
        let colour = |growth| Scale::Paper.colour(growth);
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
        for (growth, same) in [(1.0, 1.0), (2.0, 1.22), (3.0, GROWTH_RED), (9.0, 9.0)] {
            assert_eq!(Scale::Paper.colour_to(3.0, growth), colour(same));
        }
        assert!(GROWTH_RED.powi(3) > 2.98 && GROWTH_RED.powi(3) < 3.0);
    }

    #[test]
    fn viridis_is_the_published_table_and_becomes_lighter_throughout() {
        let at = |share: f64| Scale::Viridis.colour(1.0 + share * (GROWTH_RED - 1.0));
        // Of the 256 published colors, those between ours too: numbers 0, 42, 77, 128, 201 and 255.
        for (number, published) in [
            (0.0, [68, 1, 84]),
            (42.0, [68, 57, 131]),
            (77.0, [52, 96, 141]),
            (128.0, [33, 145, 140]),
            (201.0, [115, 208, 86]),
            (255.0, [253, 231, 37]),
        ] {
            let found = at(number / 255.0);
            let differ = (0..3).map(|k| found[k].abs_diff(published[k])).max();
            assert!(differ <= Some(3), "{number}: {found:?} {published:?}");
        }
        let lightness = |[r, g, b]: [u8; 3]| {
            let of = |c: u8| (f64::from(c) / 255.0).powf(2.2);
            0.2126 * of(r) + 0.7152 * of(g) + 0.0722 * of(b)
        };
        let all: Vec<f64> = (0..=100)
            .map(|k| lightness(at(f64::from(k) / 100.0)))
            .collect();
        assert!(all.windows(2).all(|pair| pair[0] < pair[1]), "{all:?}");
    }

    #[test]
    fn growth_of_nothing_is_none() {
        assert_eq!(growth(0.0, 0.0), 1.0);
        assert_eq!(growth(3.0, 2.0), 1.5);
        assert_eq!(mean_and_max(&[]), None);
        assert_eq!(mean_and_max(&[1.0, f64::INFINITY, 2.0]), Some([1.5, 2.0]));
    }
}
