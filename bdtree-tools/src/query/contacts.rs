//! Regions of contact of a pair, as JSON.

use bdtree_runtime::query::{self, ContactPoint, ContactRegion, ManifoldSlot};
use bdtree_runtime::{PairContact, QueryError, StackEntry};
use serde::Serialize;

use super::{Solver, two};

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

impl From<&ContactRegion> for RegionLine {
    fn from(region: &ContactRegion) -> Self {
        Self {
            triangles: region.triangles.map(|id| id.0),
            normal: region.normal,
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
            dist: point.dist,
            area: point.area,
            triangle1: point.triangle1.0,
            barycentric1: point.barycentric1,
            triangle2: point.triangle2.0,
            barycentric2: point.barycentric2,
        }
    }
}

impl Solver<'_, '_> {
    /// The regions of contact of what a pair query found.
    pub(super) fn regions(
        &mut self,
        a: usize,
        b: usize,
        pairs: &mut [PairContact],
    ) -> Result<Vec<RegionLine>, QueryError> {
        let [(asset_a, pose_a), (asset_b, pose_b)] = two(self.placed, a, b)?;
        let needed = asset_a.stack_len().max(asset_b.stack_len());
        if self.stack.len() < needed {
            self.stack.resize(needed, StackEntry::default());
        }
        let mut memory = vec![ManifoldSlot::default(); ManifoldSlot::count(pairs.len())];
        let mut regions = Vec::new();
        query::manifold(
            (asset_a, pose_a),
            (asset_b, pose_b),
            pairs,
            &mut memory,
            &mut self.stack,
            &mut regions,
        )?;
        Ok(regions.iter().map(RegionLine::from).collect())
    }
}
