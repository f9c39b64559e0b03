//! Which boxes a shape may touch: not only if it certainly touches nothing of what they hold.

use bdtree_runtime::{Capsule, Cuboid, HalfSpace, Shape};
use bevy_math::{DMat3, DQuat, DVec3};

use crate::bounds::DeformedBounds;

/// What boxes of shapes are made larger by, in shares of the largest coordinate; quaternions may be off by 1e-3, and are
/// normalised.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Whether a shape may touch what is in a box. True of shapes that are not allowed: the query then says what is wrong.
pub(super) fn may_touch(shape: &Shape, bounds: &DeformedBounds) -> bool {
    match shape {
        Shape::Ball(ball) => !(bounds.distance_to(ball.center) > ball.radius.abs()),
        Shape::Capsule(capsule) => match capsule_box(capsule) {
            Some(around) => overlaps(&around, bounds),
            None => true,
        },
        Shape::Cuboid(cuboid) => overlaps(&cuboid_box(cuboid), bounds),
        Shape::HalfSpace(half_space) => reaches_below(half_space, bounds),
        // Shapes to come.
        _ => true,
    }
}

fn overlaps(shape: &DeformedBounds, bounds: &DeformedBounds) -> bool {
    (0..3).all(|k| {
        let room = ROUNDING * (shape.min[k].abs().max(shape.max[k].abs()));
        !(shape.min[k] - room > bounds.max[k]) && !(shape.max[k] + room < bounds.min[k])
    })
}

/// `None` of numbers that are not finite.
fn capsule_box(capsule: &Capsule) -> Option<DeformedBounds> {
    let (a, b) = (DVec3::from_array(capsule.a), DVec3::from_array(capsule.b));
    let radius = capsule.radius.abs();
    (a.is_finite() && b.is_finite() && radius.is_finite()).then(|| DeformedBounds {
        min: (a.min(b) - radius).to_array(),
        max: (a.max(b) + radius).to_array(),
    })
}

fn cuboid_box(cuboid: &Cuboid) -> DeformedBounds {
    let center = DVec3::from_array(cuboid.center);
    let turn = DMat3::from_quat(DQuat::from_array(cuboid.rotation).normalize());
    let half = DVec3::from_array(cuboid.half_extents).abs();
    let reach = turn.abs() * half + ROUNDING * (half.element_sum() + center.abs().max_element());
    DeformedBounds {
        min: (center - reach).to_array(),
        max: (center + reach).to_array(),
    }
}

fn reaches_below(half_space: &HalfSpace, bounds: &DeformedBounds) -> bool {
    let normal = DVec3::from_array(half_space.normal);
    let normal = (normal / normal.abs().max_element()).normalize();
    let (min, max) = (DVec3::from_array(bounds.min), DVec3::from_array(bounds.max));
    // Half of each, since the sum of two large numbers may be none.
    let (center, half) = (0.5 * min + 0.5 * max, 0.5 * max - 0.5 * min);
    let lowest = normal.dot(center) - normal.abs().dot(half);
    let largest = center.abs().element_sum() + half.element_sum() + half_space.offset.abs();
    !(lowest > half_space.offset + ROUNDING * largest)
}
