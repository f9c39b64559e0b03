//! Smallest enclosing balls, exact up to rounding.
//!
//! The scheme: grow the ball of a support of at most four points by the farthest point outside
//! it, until none is outside (B. Gärtner, "Fast and robust smallest enclosing balls", ESA 1999,
//! with the small problem solved by enumeration instead of a pivot rule). Candidates of the small
//! problem are compared by the farthest of its at most five points, so degenerate supports
//! (collinear, coplanar, cospherical, repeated points) need no tolerance: their circumspheres
//! are either good or lose. Why not a library: docs/design/decisions/smallest-balls.md.

use crate::vec3::{add, cross, dot, norm2, scale, sub};

/// Rounds after which the best ball so far is returned: never met in practice, because the radius
/// grows in every round but the last few.
const ROUNDS_MAX: usize = 1000;

/// Rounds in which neither the radius grows nor a better ball is found before the best one is returned.
/// Among points on nearly one sphere the radius grows by less than its rounding while the support is not yet
/// the right one: giving up at once left balls too large by up to 10⁻⁸.
const IDLE_MAX: usize = 4;

/// A ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Its center.
    pub center: [f64; 3],
    /// Its radius: the largest distance of a point from the center before the center was rounded
    /// to coordinates far from 0.
    pub radius: f64,
}

/// The smallest ball around `points`, a ball of radius 0 at 0 when there are none. Coordinates
/// are finite and below 2¹⁵⁰; those that differ do so by 2⁻²⁰⁰ at least. Expected O(n).
///
/// The result depends on the order of points only in the last bits. Points that are all the same
/// give that point exactly.
pub fn smallest_ball(points: &[[f64; 3]]) -> Ball {
    let Some(&base) = points.first() else {
        return Ball {
            center: [0.0; 3],
            radius: 0.0,
        };
    };
    // Everything is relative to the first point, so that far away sets lose nothing.
    let relative = |i: usize| sub(points[i], base);
    let (first, _) = farthest(points, base, [0.0; 3]);
    let (second, _) = farthest(points, base, relative(first));
    let mut active = Active::default();
    active.push(relative(first));
    let mut center = relative(first);
    let mut best = (center, f64::INFINITY);
    let mut reach = -1.0;
    let mut outside = second;
    let mut idle = 0;
    for _ in 0..ROUNDS_MAX {
        let (grown, support, radius2) = active.with(relative(outside));
        active = support;
        center = grown;
        let (next, next2) = farthest(points, base, center);
        if next2 >= best.1 && radius2 <= reach {
            idle += 1;
        }
        if next2 < best.1 {
            best = (center, next2);
        }
        reach = reach.max(radius2);
        if next2 <= radius2 || idle == IDLE_MAX {
            break;
        }
        outside = next;
    }
    if !best.1.is_finite() {
        best = (center, farthest(points, base, center).1);
    }
    Ball {
        center: add(base, best.0),
        radius: best.1.sqrt(),
    }
}

/// The point farthest from `base + center`, and its squared distance.
fn farthest(points: &[[f64; 3]], base: [f64; 3], center: [f64; 3]) -> (usize, f64) {
    let mut best = (0, -1.0);
    for (i, &point) in points.iter().enumerate() {
        let d2 = norm2(sub(sub(point, base), center));
        if d2 > best.1 {
            best = (i, d2);
        }
    }
    best
}

/// At most four points that a ball rests on.
#[derive(Debug, Clone, Copy, Default)]
struct Active {
    points: [[f64; 3]; 4],
    count: usize,
}

impl Active {
    fn push(&mut self, point: [f64; 3]) {
        if let Some(place) = self.points.get_mut(self.count) {
            *place = point;
            self.count += 1;
        }
    }

    /// The smallest ball around these points and `new`, which is outside their ball and so on
    /// the surface of the new one: center, support, squared radius.
    fn with(&self, new: [f64; 3]) -> ([f64; 3], Active, f64) {
        let mut best = (new, Active::default(), f64::INFINITY);
        for subset in 0u32..1 << self.count {
            if subset.count_ones() > 3 {
                continue;
            }
            let mut support = Active::default();
            for (i, &point) in self.points.iter().enumerate().take(self.count) {
                if subset >> i & 1 == 1 {
                    support.push(point);
                }
            }
            let arm = |i: usize| sub(support.points[i], new);
            let center = match support.count {
                0 => new,
                1 => add(new, scale(arm(0), 0.5)),
                2 => add(new, circumcenter2(arm(0), arm(1))),
                _ => add(new, circumcenter3(arm(0), arm(1), arm(2))),
            };
            let radius2 = self.points[..self.count]
                .iter()
                .map(|&point| norm2(sub(point, center)))
                .fold(norm2(sub(new, center)), f64::max);
            // False for the NaN of a degenerate support.
            if norm2(center).is_finite() && radius2 < best.2 {
                support.push(new);
                best = (center, support, radius2);
            }
        }
        best
    }
}

/// Center, relative to a third point, of the circle through it and two others at `a` and `b`.
fn circumcenter2(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let normal = cross(a, b);
    let numerator = sub(scale(b, norm2(a)), scale(a, norm2(b)));
    scale(cross(numerator, normal), 0.5 / norm2(normal))
}

/// Center, relative to a fourth point, of the sphere through it and three others.
fn circumcenter3(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [f64; 3] {
    let bc = cross(b, c);
    let sum = add(
        scale(bc, norm2(a)),
        add(scale(cross(c, a), norm2(b)), scale(cross(a, b), norm2(c))),
    );
    scale(sum, 0.5 / dot(a, bc))
}
