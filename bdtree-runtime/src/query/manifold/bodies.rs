//! One region's normal, area and depths.

use super::super::{project, ray, unit};
use super::contour::Contour;
use super::least::least_translation;
use super::{ContactManifold, ContactPoint};
use crate::cache::Posed;
use crate::contact::{PairContact, TriangleId};
use crate::error::QueryError;
use crate::math::{add_scaled, dot, norm, scale, sub};
use crate::narrow::{Triangle, area_vector, combine, triangle_distance};
use crate::shape::Ray;
use crate::traverse::StackEntry;

pub(super) struct Bodies<'n, 's> {
    pub(super) posed1: Posed<'n>,
    pub(super) posed2: Posed<'n>,
    pub(super) stack: &'s mut [StackEntry],
}

impl Bodies<'_, '_> {
    /// The region of these pairs, which are sorted by ids.
    pub(super) fn region<'c>(
        &mut self,
        pairs: impl Iterator<Item = &'c PairContact> + Clone,
    ) -> Result<Option<ContactManifold>, QueryError> {
        let mut contour = Contour::default();
        for pair in pairs.clone().filter(|p| p.distance == 0.0) {
            let (a, b) = self.triangles(pair)?;
            contour.outline(&a, &b);
        }
        let Some(normal) = contour.normal() else {
            return self.single(pairs, f64::INFINITY);
        };
        contour.begin_moments(normal);
        let mut first = None;
        for pair in pairs.clone().filter(|p| p.distance == 0.0) {
            let (a, b) = self.triangles(pair)?;
            contour.measure(&a, &b);
            first = first.or(Some(*pair));
        }
        let (Some(place), Some(first)) = (contour.place(), first) else {
            return self.single(pairs, contour.area());
        };
        let share = place.area / 4.0;
        let middle = self.probe(place.center, normal, place.size, 0.0)?;
        let mut points = [middle; 4];
        let mut depth = (-middle.distance).max(0.0);
        for (k, point) in points.iter_mut().enumerate() {
            let [u, v] = place.spread;
            let u = scale(u, if k & 1 == 0 { -1.0 } else { 1.0 });
            let v = scale(v, if k & 2 == 0 { -1.0 } else { 1.0 });
            let at = add_scaled(add_scaled(place.center, 1.0, u), 1.0, v);
            *point = self.probe(at, normal, place.size, share)?;
            depth = depth.max(-point.distance);
        }
        Ok(Some(ContactManifold {
            normal1: normal,
            normal2: scale(normal, -1.0),
            area: place.area,
            depth,
            triangles: [first.triangle1, first.triangle2],
            points,
            len: 4,
        }))
    }

    /// A region without a contour that has points inside: one point. Its area is at most `largest_area`.
    fn single<'c>(
        &mut self,
        pairs: impl Iterator<Item = &'c PairContact> + Clone,
        largest_area: f64,
    ) -> Result<Option<ContactManifold>, QueryError> {
        let Some(first) = pairs.clone().next() else {
            return Ok(None);
        };
        // The nearest pair, or the deepest of those that touch.
        let mut best: Option<(f64, [f64; 3], &PairContact)> = None;
        let (mut area1, mut area2, mut last) = (0.0, 0.0, None);
        for pair in pairs {
            let (a, b) = self.triangles(pair)?;
            // Each triangle of the first once; those of the second at most once for each of these.
            if last != Some(pair.triangle1) {
                area1 += area(&a);
                last = Some(pair.triangle1);
            }
            area2 += area(&b);
            let (dist, normal) = if pair.distance > 0.0 {
                let towards = unit(sub(pair.point2, pair.point1), "");
                (pair.distance, towards.unwrap_or([0.0, 0.0, 1.0]))
            } else {
                let (depth, normal) = least_translation(&a, &b);
                (-depth, normal)
            };
            if best.is_none_or(|best| dist < best.0) {
                best = Some((dist, normal, pair));
            }
        }
        let Some((dist, normal, pair)) = best else {
            return Ok(None);
        };
        let area = area1.min(area2).min(largest_area);
        let (mut point1, mut point2) = (pair.point1, pair.point2);
        let (mut barycentric1, mut barycentric2) = (pair.barycentric1, pair.barycentric2);
        if pair.distance == 0.0 {
            // The points that meet once the first triangle has moved back by its depth: so they are that
            // far apart.
            let (a, b) = self.triangles(pair)?;
            let meeting = triangle_distance(&a.map(|x| add_scaled(x, dist, normal)), &b);
            (barycentric1, barycentric2) = (meeting.barycentric1, meeting.barycentric2);
            point1 = combine(&a, barycentric1);
            // Without depth they share the point.
            point2 = if dist < 0.0 {
                combine(&b, barycentric2)
            } else {
                point1
            };
        }
        let place1 = Place {
            point: point1,
            triangle: pair.triangle1,
            barycentric: barycentric1,
        };
        let place2 = Place {
            point: point2,
            triangle: pair.triangle2,
            barycentric: barycentric2,
        };
        let point = place1.contact(&place2, normal, area);
        Ok(Some(ContactManifold {
            normal1: normal,
            normal2: scale(normal, -1.0),
            area,
            depth: (-point.distance).max(0.0),
            triangles: [first.triangle1, first.triangle2],
            points: [point; 4],
            len: 1,
        }))
    }

    fn triangles(&self, pair: &PairContact) -> Result<(Triangle, Triangle), QueryError> {
        Ok((
            self.posed1.pose.deformed_triangle(pair.triangle1)?,
            self.posed2.pose.deformed_triangle(pair.triangle2)?,
        ))
    }

    /// The contact on the line through `at` along the normal, between the points where the line leaves the first
    /// body forwards and the second backwards. `size` is the contour's length.
    fn probe(
        &mut self,
        at: [f64; 3],
        normal: [f64; 3],
        size: f64,
        area: f64,
    ) -> Result<ContactPoint, QueryError> {
        let against = scale(normal, -1.0);
        let left1 = leaving(&mut self.posed1, at, normal, size, self.stack)?;
        let left2 = leaving(&mut self.posed2, at, against, size, self.stack)?;
        if let (Some(place1), Some(place2)) = (left1, left2) {
            return Ok(place1.contact(&place2, normal, area));
        }
        // Both nearest points, since one alone and a far end of the other body would make a depth of that body's
        // length where the two do not overlap.
        let place1 = Place::nearest(&mut self.posed1, at, self.stack)?;
        let place2 = Place::nearest(&mut self.posed2, at, self.stack)?;
        Ok(place1.contact(&place2, normal, area))
    }
}

/// A point of a body.
struct Place {
    point: [f64; 3],
    triangle: TriangleId,
    barycentric: [f64; 3],
}

impl Place {
    /// The contact between this point, of the first body, and one of the second.
    fn contact(&self, second: &Self, normal: [f64; 3], area: f64) -> ContactPoint {
        ContactPoint {
            point1: self.point,
            point2: second.point,
            // + 0 makes −0 a plain 0.
            distance: dot(sub(second.point, self.point), normal) + 0.0,
            area,
            triangle1: self.triangle,
            barycentric1: self.barycentric,
            triangle2: second.triangle,
            barycentric2: second.barycentric,
        }
    }

    /// The point nearest to `at`, which is there where the body has a triangle.
    fn nearest(
        posed: &mut Posed<'_>,
        at: [f64; 3],
        stack: &mut [StackEntry],
    ) -> Result<Self, QueryError> {
        let (found, _) = project::project(posed.again(), at, f64::INFINITY, stack)?;
        Ok(match found {
            Some(nearest) => Self {
                point: nearest.point,
                triangle: nearest.triangle,
                barycentric: nearest.barycentric,
            },
            // Pairs of a body without triangles there are none.
            None => Self {
                point: at,
                triangle: TriangleId(u32::MAX),
                barycentric: [0.0; 3],
            },
        })
    }
}

/// Where the line through `at` in the direction `along` leaves a body: ahead, or, where `at` is outside, behind it
/// by at most half of `size`, the contour's length. `None` if the first triangle either way is one where the line
/// enters.
fn leaving(
    posed: &mut Posed<'_>,
    at: [f64; 3],
    along: [f64; 3],
    size: f64,
    stack: &mut [StackEntry],
) -> Result<Option<Place>, QueryError> {
    // Begun a little before, since the contour may lie in the surface.
    let before = size / (1 << 20) as f64;
    // Behind, the region's own surface is no farther than the contour is wide; what lies beyond is another part.
    for (direction, reach) in [(along, f64::INFINITY), (scale(along, -1.0), 0.5 * size)] {
        let from = add_scaled(at, -before, direction);
        let ray = Ray::new(from, direction).with_max_distance(reach);
        let (hit, _) = ray::first(posed.again(), &ray, stack)?;
        let Some(hit) = hit else {
            continue;
        };
        let corners = posed.pose.deformed_triangle(hit.triangle)?;
        if dot(area_vector(&corners), along) > 0.0 {
            return Ok(Some(Place {
                point: hit.point,
                triangle: hit.triangle,
                barycentric: hit.barycentric,
            }));
        }
    }
    Ok(None)
}

pub(super) fn area(triangle: &Triangle) -> f64 {
    norm(area_vector(triangle))
}
