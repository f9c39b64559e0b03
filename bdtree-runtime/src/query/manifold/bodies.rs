//! One region's normal, area and depths.

use super::super::{ray, unit};
use super::contour::Contour;
use super::least::least_translation;
use super::{ContactManifold, ContactPoint};
use crate::cache::Posed;
use crate::contact::{PairContact, RayIntersection};
use crate::error::QueryError;
use crate::math::{add_scaled, dot, norm, scale, sub};
use crate::narrow::{Triangle, area_vector, closest_point};
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
            return self.single(pairs);
        };
        contour.begin_moments(normal);
        let (mut first, mut corners) = (None, None);
        for pair in pairs.clone().filter(|p| p.distance == 0.0) {
            let (a, b) = self.triangles(pair)?;
            contour.measure(&a, &b);
            if first.is_none() {
                (first, corners) = (Some(*pair), Some((a, b)));
            }
        }
        let (Some(place), Some(first), Some(corners)) = (contour.place(), first, corners) else {
            return self.single(pairs);
        };
        let share = place.area / 4.0;
        let middle = self.probe(place.center, normal, place.size, 0.0, &first, &corners)?;
        let mut points = [middle; 4];
        for (k, point) in points.iter_mut().enumerate() {
            let [u, v] = place.spread;
            let u = scale(u, if k & 1 == 0 { -1.0 } else { 1.0 });
            let v = scale(v, if k & 2 == 0 { -1.0 } else { 1.0 });
            let at = add_scaled(add_scaled(place.center, 1.0, u), 1.0, v);
            *point = self.probe(at, normal, place.size, share, &first, &corners)?;
        }
        Ok(Some(ContactManifold {
            normal1: normal,
            normal2: scale(normal, -1.0),
            area: place.area,
            depth: -middle.distance,
            triangles: [first.triangle1, first.triangle2],
            points,
            len: 4,
        }))
    }

    /// A region without a contour: one point.
    fn single<'c>(
        &mut self,
        pairs: impl Iterator<Item = &'c PairContact> + Clone,
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
        let area = area1.min(area2);
        let point = ContactPoint {
            point1: pair.point1,
            point2: pair.point2,
            distance: dist,
            area,
            triangle1: pair.triangle1,
            barycentric1: pair.barycentric1,
            triangle2: pair.triangle2,
            barycentric2: pair.barycentric2,
        };
        Ok(Some(ContactManifold {
            normal1: normal,
            normal2: scale(normal, -1.0),
            area,
            depth: (-dist).max(0.0),
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

    /// Where the line through `at` along the normal leaves both bodies, the first forwards and the
    /// second backwards. `size` is the region's.
    fn probe(
        &mut self,
        at: [f64; 3],
        normal: [f64; 3],
        size: f64,
        area: f64,
        first: &PairContact,
        (corners1, corners2): &(Triangle, Triangle),
    ) -> Result<ContactPoint, QueryError> {
        // Begun a little before, since the contour may lie in one of the surfaces.
        let back = size / (1 << 20) as f64;
        let against = scale(normal, -1.0);
        let hit1 = leaving(
            &mut self.posed1,
            add_scaled(at, -back, normal),
            normal,
            self.stack,
        )?;
        let hit2 = leaving(
            &mut self.posed2,
            add_scaled(at, back, normal),
            against,
            self.stack,
        )?;
        let (reach1, reach2) = (
            hit1.map_or(0.0, |h| h.distance - back),
            hit2.map_or(0.0, |h| h.distance - back),
        );
        let mut point = ContactPoint {
            point1: add_scaled(at, reach1, normal),
            point2: add_scaled(at, -reach2, normal),
            distance: -(reach1 + reach2).max(0.0),
            area,
            triangle1: first.triangle1,
            barycentric1: [0.0; 3],
            triangle2: first.triangle2,
            barycentric2: [0.0; 3],
        };
        match hit1 {
            Some(hit) => (point.triangle1, point.barycentric1) = (hit.triangle, hit.barycentric),
            None => point.barycentric1 = closest_point(point.point1, corners1).barycentric,
        }
        match hit2 {
            Some(hit) => (point.triangle2, point.barycentric2) = (hit.triangle, hit.barycentric),
            None => point.barycentric2 = closest_point(point.point2, corners2).barycentric,
        }
        Ok(point)
    }
}

/// The first triangle along a ray, if the ray leaves the body there.
fn leaving(
    posed: &mut Posed<'_>,
    origin: [f64; 3],
    direction: [f64; 3],
    stack: &mut [StackEntry],
) -> Result<Option<RayIntersection>, QueryError> {
    let (hit, _) = ray::first(posed.again(), &Ray::new(origin, direction), stack)?;
    let Some(hit) = hit else {
        return Ok(None);
    };
    let corners = posed.pose.deformed_triangle(hit.triangle)?;
    let outwards = dot(area_vector(&corners), direction) > 0.0;
    Ok(outwards.then_some(hit))
}

pub(super) fn area(triangle: &Triangle) -> f64 {
    norm(area_vector(triangle))
}
