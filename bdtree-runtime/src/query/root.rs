//! A sphere around a whole deformed mesh, from the root node alone.

use bdtree_format::LANES;

use crate::bound::Spheres;
use crate::error::QueryError;
use crate::math::{norm, sub};
use crate::pose::Pose;
use crate::rounding::MARGIN;
use crate::view::Asset;

/// A ball that holds something. World coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundingSphere {
    /// Centre.
    pub center: [f64; 3],
    /// Radius.
    pub radius: f64,
}

/// A sphere that holds every deformed triangle in the world, the leaf arithmetic's rounding
/// included: what a broad phase over instances compares. One node is evaluated; the sphere
/// follows q, but it is not the smallest one.
///
/// # Errors
/// A pose of another asset, a corrupt asset.
pub fn root_sphere(asset: &Asset<'_>, pose: &Pose<'_>) -> Result<BoundingSphere, QueryError> {
    if !pose.belongs_to(asset) {
        return Err(QueryError::PoseMismatch);
    }
    let root = asset.node(0)?;
    let spheres = asset.node_spheres(pose, 0)?;
    let (center, radius) = around(&spheres, root.inner_mask | root.leaf_mask);
    // No vertex is farther from the origin than B; a radius that is NaN is not smaller.
    let all = pose.reach + f64::from(pose.slack);
    let (center, radius) = if radius < all {
        (center, radius)
    } else {
        ([0.0; 3], all)
    };
    let center = pose.placement.world(center);
    let radius = radius + pose.placement.error(norm(center), pose.reach);
    Ok(BoundingSphere {
        center,
        radius: radius * pose.placement.world_per_stored() * (1.0 + MARGIN),
    })
}

/// A sphere around those of some lanes (stored units): about the middle of their box, which f32
/// holds exactly enough since the radius is formed about what it holds.
fn around(spheres: &Spheres, lanes: u8) -> ([f32; 3], f64) {
    let used = || (0..LANES).filter(|k| lanes & (1 << k) != 0);
    let center = [0, 1, 2].map(|axis| {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for k in used() {
            low = low.min(spheres.centre[axis][k] - spheres.radius[k]);
            high = high.max(spheres.centre[axis][k] + spheres.radius[k]);
        }
        0.5 * low + 0.5 * high
    });
    // Without lanes, which no sound root is, nothing is known.
    let mut radius = if lanes == 0 { f64::INFINITY } else { 0.0 };
    for k in used() {
        let apart = [0, 1, 2].map(|axis| f64::from(spheres.centre[axis][k]));
        let apart = norm(sub(apart, center.map(f64::from)));
        let reach = apart * (1.0 + MARGIN) + f64::from(spheres.radius[k]);
        // Anything but "not larger" counts, so that NaN stays.
        let within = reach <= radius;
        radius = if within { radius } else { reach };
        if reach.is_nan() {
            break;
        }
    }
    (center, radius)
}
