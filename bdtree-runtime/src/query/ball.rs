//! The triangles within a ball.

use bdtree_format::Row;
use core::ops::ControlFlow;

use super::{beyond_four, length, point};
use crate::bound::WideSpheres;
use crate::cache::Posed;
use crate::contact::{Contact, Sink, TriangleId};
use crate::error::QueryError;
use crate::math::{cross, length_bound, norm, scale, sub};
use crate::narrow::four::closest_four;
use crate::narrow::{Triangle, closest_point};
use crate::placement::Placement;
use crate::pose::Pose;
use crate::refined::Boxes;
use crate::rounding::{BALL_RADIUS, POINT, SKIP, round_up};
use crate::shape;
use crate::simd::{Lanes, Quad, Quad3, dot3, splat3, sub3};
use crate::traverse::{Four, StackEntry, Visitor, Walk, one};

/// Reports every triangle whose distance to the center is at most the radius: `distance` is distance
/// minus radius (≤ 0), `point` the triangle's nearest point, `normal` from there to the center
/// (the triangle's own normal where the two coincide).
///
/// # Errors
/// A center or radius that is not finite or beyond 2^100, a negative radius, a corrupt asset.
pub(super) fn contacts(
    posed: Posed<'_>,
    ball: &shape::Ball,
    stack: &mut [StackEntry],
    sink: &mut dyn Sink<Contact>,
) -> Result<Walk, QueryError> {
    let mut visitor = Ball::new(posed.pose, ball, sink)?;
    one(posed, stack, &mut visitor)
}

pub(super) struct Ball<'s> {
    stored: [f32; 3],
    reach: f32,
    center: [f64; 3],
    radius: f64,
    sink: &'s mut (dyn Sink<Contact> + 's),
}

impl<'s> Ball<'s> {
    pub(super) fn new(
        pose: &Pose<'_>,
        ball: &shape::Ball,
        sink: &'s mut (dyn Sink<Contact> + 's),
    ) -> Result<Self, QueryError> {
        let center = point(
            ball.center,
            "center: a coordinate is not finite or beyond 2^100",
        )?;
        let radius = length(ball.radius, "radius: negative, not finite or beyond 2^100")?;
        let stored = pose.placement.point_to_stored(center);
        let far = length_bound(stored);
        // Reach in stored units: the radius, the f64 errors, the center's rounding to f32.
        let reach = radius / pose.placement.world_per_stored() * (1.0 + BALL_RADIUS)
            + pose
                .placement
                .error(length_bound(center) + radius, pose.reach)
            + POINT * far;
        Ok(Self {
            stored: stored.map(|x| x as f32),
            reach: round_up(reach),
            center,
            radius,
            sink,
        })
    }
}

impl Visitor for Ball<'_> {
    const ORDERED: bool = false;
    const IN_FOURS: bool = true;
    const HAS_BOXES: bool = true;

    #[inline(always)]
    fn lanes<L: Lanes>(&self, spheres: WideSpheres<L>, _keys: &mut Row) -> u8 {
        spheres.within(self.stored, self.reach, SKIP)
    }

    #[inline(always)]
    fn boxes<L: Lanes>(&self, boxes: &Boxes, _keys: &mut Row) -> u8 {
        let squared = boxes.squared_distances::<L>(self.stored);
        let reach = L::splat(self.reach);
        !squared.mul(L::splat(SKIP)).above(reach.mul(reach))
    }

    #[inline(always)]
    fn misses_four<Q: Quad>(&self, corners: &[[[f32; 4]; 3]; 3]) -> u8 {
        beyond_four::<Q>(corners, self.stored, f64::from(self.reach))
    }

    #[inline(always)]
    fn fours<Q: Quad>(&mut self, frame: &Placement, fours: &[Four; 2]) -> ControlFlow<()> {
        if fours[1].len == 0 {
            let found = self.nearest::<Q>(frame, &fours[0]);
            return self.report(frame, &fours[0], &found);
        }
        let found = [
            self.nearest::<Q>(frame, &fours[0]),
            self.nearest::<Q>(frame, &fours[1]),
        ];
        self.report(frame, &fours[0], &found[0])?;
        self.report(frame, &fours[1], &found[1])
    }

    #[inline(never)]
    fn triangle(&mut self, id: TriangleId, corners: &Triangle) -> ControlFlow<()> {
        let closest = closest_point(self.center, corners);
        if closest.distance > self.radius {
            return ControlFlow::Continue(());
        }
        self.sink.push(Contact {
            triangle: id,
            point: closest.point,
            normal: direction(closest.point, self.center).unwrap_or_else(|| normal(corners)),
            distance: closest.distance - self.radius,
            barycentric: closest.barycentric,
        })
    }
}

/// What is known of four triangles.
struct Found {
    contacts: [Contact; 4],
    /// Those that may touch.
    touching: u8,
    /// Those whose contact is right: the others, slivers and points on the center, are tested one by one.
    plain: u8,
}

impl Ball<'_> {
    #[inline(always)]
    fn nearest<Q: Quad>(&self, frame: &Placement, four: &Four) -> Found {
        let [a, b, c] = &four.corners;
        let corners = [
            frame.world_four::<Q>(a),
            frame.world_four::<Q>(b),
            frame.world_four::<Q>(c),
        ];
        let closest = closest_four(self.center, &corners);
        let radius = Q::splat(self.radius);
        let away = Q::bits(closest.distance.above(radius)) & closest.fair;
        let v = sub3(splat3(self.center), closest.point);
        let n = dot3(v, v).sqrt();
        let point = store3(closest.point);
        let normal = store3([v[0].div(n), v[1].div(n), v[2].div(n)]);
        let barycentric = store3(closest.barycentric);
        let distance = closest.distance.sub(radius).store();
        let mut contacts = [Contact::EMPTY; 4];
        for k in 0..4 {
            contacts[k] = Contact {
                triangle: TriangleId(four.ids[k]),
                point: [point[0][k], point[1][k], point[2][k]],
                normal: [normal[0][k], normal[1][k], normal[2][k]],
                distance: distance[k],
                barycentric: [barycentric[0][k], barycentric[1][k], barycentric[2][k]],
            };
        }
        Found {
            contacts,
            touching: !away & !(u8::MAX << four.len),
            plain: Q::bits(n.above(Q::splat(SHORT))) & closest.fair,
        }
    }

    #[inline(always)]
    fn report(&mut self, frame: &Placement, four: &Four, found: &Found) -> ControlFlow<()> {
        let mut left = found.touching;
        while left != 0 {
            let k = (left.trailing_zeros() & 3) as usize;
            left &= left - 1;
            let contact = found.contacts[k];
            if found.plain & (1 << k) == 0 {
                self.triangle(contact.triangle, &four.world(frame, k))?;
                continue;
            }
            self.sink.push(contact)?;
        }
        ControlFlow::Continue(())
    }
}

/// Squares of shorter vectors lose digits.
const SHORT: f64 = f64::from_bits((1023 - 400) << 52);

#[inline(always)]
fn store3<Q: Quad>([x, y, z]: Quad3<Q>) -> [[f64; 4]; 3] {
    [x.store(), y.store(), z.store()]
}

/// The unit vector from one point to another, if they differ.
pub(super) fn direction(from: [f64; 3], to: [f64; 3]) -> Option<[f64; 3]> {
    let v = sub(to, from);
    let n = norm(v);
    if n > SHORT {
        return Some([v[0] / n, v[1] / n, v[2] / n]);
    }
    super::unit(v, "").ok()
}

/// A triangle's unit normal by its corner order; for one of zero area some unit vector across
/// its longest edge, +z for a single point.
#[inline]
pub(super) fn normal(corners: &Triangle) -> [f64; 3] {
    let [a, b, c] = *corners;
    let (ab, ac) = (sub(b, a), sub(c, a));
    let n = cross(ab, ac);
    let length = norm(n);
    if (SHORT..1.0 / SHORT).contains(&length) {
        return n.map(|c| c / length);
    }
    tiny_normal(ab, ac)
}

/// [`normal`] by two edges whose cross product may be 0, or lose digits.
#[cold]
fn tiny_normal(ab: [f64; 3], ac: [f64; 3]) -> [f64; 3] {
    let largest = ab.iter().chain(&ac).fold(0.0_f64, |m, x| m.max(x.abs()));
    if largest == 0.0 {
        return [0.0, 0.0, 1.0];
    }
    // Scaled first, so that the product of tiny edges does not vanish.
    let (ab, ac) = (scale(ab, 1.0 / largest), scale(ac, 1.0 / largest));
    if let Ok(n) = super::unit(cross(ab, ac), "") {
        return n;
    }
    let edge = if norm(ab) >= norm(ac) { ab } else { ac };
    let axis = if edge[0].abs() <= 0.5 * norm(edge) {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    super::unit(cross(edge, axis), "").unwrap_or([0.0, 0.0, 1.0])
}
