//! Regions of contact of a pair, as JSON.

use bdtree_runtime::{ContactManifold, ContactPoint, PairContact, PairQuery, QueryError};
use serde::Serialize;

/// A region of contact.
#[derive(Debug, Serialize)]
pub struct RegionLine {
    triangles: [u32; 2],
    normal: [f64; 3],
    area: f64,
    depth: f64,
    points: Vec<PointLine>,
}

/// One of its points.
#[derive(Debug, Serialize)]
pub struct PointLine {
    point1: [f64; 3],
    point2: [f64; 3],
    dist: f64,
    area: f64,
    triangle1: u32,
    barycentric1: [f64; 3],
    triangle2: u32,
    barycentric2: [f64; 3],
}

impl RegionLine {
    /// Whether all numbers are finite.
    pub(super) fn is_finite(&self) -> bool {
        let points = self.points.iter().all(|p| {
            let vectors = [p.point1, p.point2, p.barycentric1, p.barycentric2];
            vectors.iter().flatten().all(|x| x.is_finite())
                && p.dist.is_finite()
                && p.area.is_finite()
        });
        let own = self.normal.iter().chain([&self.area, &self.depth]);
        points && own.into_iter().all(|x| x.is_finite())
    }
}

impl From<&ContactManifold> for RegionLine {
    fn from(region: &ContactManifold) -> Self {
        Self {
            triangles: region.triangles.map(|id| id.0),
            normal: region.normal1,
            area: region.area,
            depth: region.depth,
            points: region.points().iter().map(PointLine::from).collect(),
        }
    }
}

impl From<&ContactPoint> for PointLine {
    fn from(point: &ContactPoint) -> Self {
        Self {
            point1: point.point1,
            point2: point.point2,
            dist: point.distance,
            area: point.area,
            triangle1: point.triangle1.0,
            barycentric1: point.barycentric1,
            triangle2: point.triangle2.0,
            barycentric2: point.barycentric2,
        }
    }
}

/// The regions of contact of what a pair query found.
pub(super) fn regions(
    query: &mut PairQuery<'_, '_, '_>,
    pairs: &mut [PairContact],
) -> Result<Vec<RegionLine>, QueryError> {
    let mut regions: Vec<ContactManifold> = Vec::new();
    query.condense(pairs, &mut regions)?;
    Ok(regions.iter().map(RegionLine::from).collect())
}
