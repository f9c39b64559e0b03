//! One region's normal, area and depths.

use super::super::{project, ray, unit};
use super::contour::Contour;
use super::least::least_translation;
use super::{ContactManifold, ContactPoint};
use crate::cache::Posed;
use crate::contact::{PairContact, RayIntersection, TriangleId};
use crate::error::QueryError;
use crate::math::{add_scaled, dot, norm, scale, sub};
use crate::narrow::{Triangle, area_vector};
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
        let mut first = None;
        for pair in pairs.clone().filter(|p| p.distance == 0.0) {
            let (a, b) = self.triangles(pair)?;
            contour.measure(&a, &b);
            first = first.or(Some(*pair));
        }
        let (Some(place), Some(first)) = (contour.place(), first) else {
            return self.single(pairs);
        };
        let share = place.area / 4.0;
        let middle = self.probe(place.center, normal, place.size, 0.0)?;
        let mut points = [middle; 4];
        for (k, point) in points.iter_mut().enumerate() {
            let [u, v] = place.spread;
            let u = scale(u, if k & 1 == 0 { -1.0 } else { 1.0 });
            let v = scale(v, if k & 2 == 0 { -1.0 } else { 1.0 });
            let at = add_scaled(add_scaled(place.center, 1.0, u), 1.0, v);
            *point = self.probe(at, normal, place.size, share)?;
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
    /// second backwards. `size` is the region's. On a body that the line does not leave, the point nearest to `at`
    /// stands for it and adds nothing to the depth.
    fn probe(
        &mut self,
        at: [f64; 3],
        normal: [f64; 3],
        size: f64,
        area: f64,
    ) -> Result<ContactPoint, QueryError> {
        // Begun a little before, since the contour may lie in one of the surfaces.
        let back = size / (1 << 20) as f64;
        let against = scale(normal, -1.0);
        let mut side =
            |posed: &mut Posed<'_>, along: [f64; 3]| -> Result<(f64, Place), QueryError> {
                let from = add_scaled(at, -back, along);
                match leaving(posed, from, along, self.stack)? {
                    Some(hit) => Ok((hit.distance - back, Place::of(&hit, at, along, back))),
                    None => Ok((0.0, Place::nearest(posed, at, self.stack)?)),
                }
            };
        let (reach1, place1) = side(&mut self.posed1, normal)?;
        let (reach2, place2) = side(&mut self.posed2, against)?;
        Ok(ContactPoint {
            point1: place1.point,
            point2: place2.point,
            distance: -(reach1 + reach2).max(0.0),
            area,
            triangle1: place1.triangle,
            barycentric1: place1.barycentric,
            triangle2: place2.triangle,
            barycentric2: place2.barycentric,
        })
    }
}

/// A point of a body.
struct Place {
    point: [f64; 3],
    triangle: TriangleId,
    barycentric: [f64; 3],
}

impl Place {
    /// Where a ray that was begun `back` before `at` leaves it.
    fn of(hit: &RayIntersection, at: [f64; 3], along: [f64; 3], back: f64) -> Self {
        Self {
            point: add_scaled(at, hit.distance - back, along),
            triangle: hit.triangle,
            barycentric: hit.barycentric,
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
