//! What queries answer. World coordinates and lengths.

use bdtree_runtime::{
    Contact, ContactManifold, ContactPoint, LaneId, LaneTriangle, PairContact, PointProjection,
    Proxy, RayIntersection, Stats, TriangleId, TrianglePair,
};
use zerocopy::FromBytes;

use crate::types::{BDT_NONE, BdtVec3};

/// A shape touches a triangle.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtContact {
    /// The triangle: its number among the source's.
    pub triangle: u32,
    /// Of a world's answer the body, else 0.
    pub body: u32,
    /// The triangle's point.
    pub point: BdtVec3,
    /// Unit, from the triangle towards the shape.
    pub normal: BdtVec3,
    /// Negative is penetration depth. To separate the two at `point`, move the mesh by distance · normal.
    pub distance: f64,
    /// Weights of the triangle's corners that give `point`; their sum is 1.
    pub barycentric: BdtVec3,
}

impl From<Contact> for BdtContact {
    fn from(contact: Contact) -> Self {
        Self {
            triangle: contact.triangle.0,
            body: 0,
            point: contact.point.into(),
            normal: contact.normal.into(),
            distance: contact.distance,
            barycentric: contact.barycentric.into(),
        }
    }
}

/// The point of a mesh that a ray meets, or that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtHit {
    /// The triangle, the lowest number of those at the same distance; `BDT_NONE` when nothing was found, and then all
    /// other numbers are 0.
    pub triangle: u32,
    /// Where several rays, instances or bodies are asked at once: the one that it is of, as the function says. Else 0.
    pub index: u32,
    /// The point.
    pub point: BdtVec3,
    /// Unit. Of a ray: the triangle's, on the side that the ray comes from. Of a nearest point: from it towards the given
    /// point, or the triangle's own where the two coincide.
    pub normal: BdtVec3,
    /// From the ray's origin or the given point.
    pub distance: f64,
    /// Weights of the triangle's corners that give `point`; their sum is 1.
    pub barycentric: BdtVec3,
}

impl BdtHit {
    const ZERO: BdtVec3 = BdtVec3 {
        x: 0.0,
        y: 0.0,
        z: 0.0,
    };

    /// Nothing.
    pub(crate) const MISS: Self = Self {
        triangle: BDT_NONE,
        index: 0,
        point: Self::ZERO,
        normal: Self::ZERO,
        distance: 0.0,
        barycentric: Self::ZERO,
    };
}

impl From<RayIntersection> for BdtHit {
    #[inline]
    fn from(hit: RayIntersection) -> Self {
        Self {
            triangle: hit.triangle.0,
            index: 0,
            point: hit.point.into(),
            normal: hit.normal.into(),
            distance: hit.distance,
            barycentric: hit.barycentric.into(),
        }
    }
}

impl From<PointProjection> for BdtHit {
    fn from(near: PointProjection) -> Self {
        Self {
            triangle: near.triangle.0,
            index: 0,
            point: near.point.into(),
            normal: near.normal.into(),
            distance: near.distance,
            barycentric: near.barycentric.into(),
        }
    }
}

impl<T: Into<BdtHit>> From<Option<T>> for BdtHit {
    #[inline]
    fn from(found: Option<T>) -> Self {
        found.map_or(Self::MISS, T::into)
    }
}

impl From<(usize, RayIntersection)> for BdtHit {
    fn from((ray, hit): (usize, RayIntersection)) -> Self {
        Self {
            index: ray as u32,
            ..hit.into()
        }
    }
}

/// Two triangles touch, or are near each other.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtPairContact {
    /// The first mesh's triangle; `BDT_NONE` when nothing was found, and then all other numbers are 0.
    pub triangle1: u32,
    /// The second mesh's triangle.
    pub triangle2: u32,
    /// The first triangle's point.
    pub point1: BdtVec3,
    /// The second triangle's point; equal to `point1` when they touch.
    pub point2: BdtVec3,
    /// Unit, at `point1`: towards `point2`; where the triangles touch, the first triangle's own normal.
    pub normal1: BdtVec3,
    /// Unit, at `point2`: towards `point1`; where the triangles touch, the second triangle's own normal.
    pub normal2: BdtVec3,
    /// 0 when they touch.
    pub distance: f64,
    /// Weights of the first triangle's corners that give `point1`.
    pub barycentric1: BdtVec3,
    /// Weights of the second triangle's corners that give `point2`.
    pub barycentric2: BdtVec3,
}

impl From<PairContact> for BdtPairContact {
    fn from(pair: PairContact) -> Self {
        Self {
            triangle1: pair.triangle1.0,
            triangle2: pair.triangle2.0,
            point1: pair.point1.into(),
            point2: pair.point2.into(),
            normal1: pair.normal1.into(),
            normal2: pair.normal2.into(),
            distance: pair.distance,
            barycentric1: pair.barycentric1.into(),
            barycentric2: pair.barycentric2.into(),
        }
    }
}

impl From<Option<PairContact>> for BdtPairContact {
    fn from(found: Option<PairContact>) -> Self {
        let nothing = PairContact {
            triangle2: TriangleId(0),
            ..PairContact::EMPTY
        };
        found.unwrap_or(nothing).into()
    }
}

impl From<BdtPairContact> for PairContact {
    fn from(pair: BdtPairContact) -> Self {
        Self {
            triangle1: TriangleId(pair.triangle1),
            triangle2: TriangleId(pair.triangle2),
            point1: pair.point1.into(),
            point2: pair.point2.into(),
            normal1: pair.normal1.into(),
            normal2: pair.normal2.into(),
            distance: pair.distance,
            barycentric1: pair.barycentric1.into(),
            barycentric2: pair.barycentric2.into(),
        }
    }
}

/// Two numbers that belong together: triangles of two meshes, or two instances or spheres of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes)]
#[repr(C)]
pub struct BdtIndexPair {
    /// Of the first.
    pub first: u32,
    /// Of the second.
    pub second: u32,
}

impl From<TrianglePair> for BdtIndexPair {
    fn from(pair: TrianglePair) -> Self {
        Self {
            first: pair.triangle1.0,
            second: pair.triangle2.0,
        }
    }
}

impl From<[usize; 2]> for BdtIndexPair {
    fn from([first, second]: [usize; 2]) -> Self {
        Self {
            first: first as u32,
            second: second as u32,
        }
    }
}

/// A point of a region of contact.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtManifoldPoint {
    /// On the first mesh: where a line along the region's `normal1` leaves it.
    pub point1: BdtVec3,
    /// On the second mesh: where the same line, followed backwards, leaves it.
    pub point2: BdtVec3,
    /// (point2 - point1) · normal1: negative is penetration depth, positive a gap.
    pub distance: f64,
    /// The part of the region's area that it stands for.
    pub area: f64,
    /// Weights of the corners of `triangle1` that give `point1`.
    pub barycentric1: BdtVec3,
    /// Weights of the corners of `triangle2` that give `point2`.
    pub barycentric2: BdtVec3,
    /// The first mesh's triangle.
    pub triangle1: u32,
    /// The second mesh's triangle.
    pub triangle2: u32,
}

impl BdtManifoldPoint {
    const EMPTY: Self = Self {
        point1: BdtHit::ZERO,
        point2: BdtHit::ZERO,
        distance: 0.0,
        area: 0.0,
        barycentric1: BdtHit::ZERO,
        barycentric2: BdtHit::ZERO,
        triangle1: BDT_NONE,
        triangle2: BDT_NONE,
    };
}

impl From<ContactPoint> for BdtManifoldPoint {
    fn from(point: ContactPoint) -> Self {
        Self {
            point1: point.point1.into(),
            point2: point.point2.into(),
            distance: point.distance,
            area: point.area,
            barycentric1: point.barycentric1.into(),
            barycentric2: point.barycentric2.into(),
            triangle1: point.triangle1.0,
            triangle2: point.triangle2.0,
        }
    }
}

/// A connected region of contact, condensed to one point or four.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtManifold {
    /// Unit, from the first mesh to the second.
    pub normal1: BdtVec3,
    /// Unit, from the second mesh to the first.
    pub normal2: BdtVec3,
    /// Of the region's projection along the normal (world units²).
    pub area: f64,
    /// How far the two overlap along the normal; 0 where they do not.
    pub depth: f64,
    /// The first mesh's triangle of the region's lowest pair.
    pub triangle1: u32,
    /// The second mesh's triangle of the region's lowest pair.
    pub triangle2: u32,
    /// How many of `points` there are: 1 or 4.
    pub point_count: u32,
    /// 0.
    pub reserved: u32,
    /// Its points; those behind `point_count` are 0, their triangles `BDT_NONE`.
    pub points: [BdtManifoldPoint; 4],
}

impl From<ContactManifold> for BdtManifold {
    fn from(region: ContactManifold) -> Self {
        let mut points = [BdtManifoldPoint::EMPTY; 4];
        for (point, of) in points.iter_mut().zip(region.points()) {
            *point = (*of).into();
        }
        let [triangle1, triangle2] = region.triangles;
        Self {
            normal1: region.normal1.into(),
            normal2: region.normal2.into(),
            area: region.area,
            depth: region.depth,
            triangle1: triangle1.0,
            triangle2: triangle2.0,
            point_count: region.points().len() as u32,
            reserved: 0,
            points,
        }
    }
}

/// A lane of a node of the tree: one of its eight children.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes)]
#[repr(C)]
pub struct BdtLane {
    /// The node.
    pub node: u32,
    /// Below 8.
    pub lane: u32,
}

impl From<LaneId> for BdtLane {
    fn from(lane: LaneId) -> Self {
        Self {
            node: lane.node,
            lane: lane.lane.into(),
        }
    }
}

/// Lanes of two trees whose spheres are near each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes)]
#[repr(C)]
pub struct BdtLanePair {
    /// Of the first mesh.
    pub first: BdtLane,
    /// Of the second mesh.
    pub second: BdtLane,
}

impl From<[LaneId; 2]> for BdtLanePair {
    fn from([first, second]: [LaneId; 2]) -> Self {
        Self {
            first: first.into(),
            second: second.into(),
        }
    }
}

/// A lane of the first tree and a triangle of the second mesh that is near its sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes)]
#[repr(C)]
pub struct BdtLaneTriangle {
    /// Of the first mesh.
    pub lane: BdtLane,
    /// Of the second mesh.
    pub triangle: u32,
}

impl From<LaneTriangle> for BdtLaneTriangle {
    fn from(found: LaneTriangle) -> Self {
        Self {
            lane: found.lane.into(),
            triangle: found.triangle.0,
        }
    }
}

/// A sphere of a query that ends at a level: it holds the deformed triangles below a lane.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtProxy {
    /// The lane.
    pub lane: BdtLane,
    /// Its center.
    pub center: BdtVec3,
    /// Its radius.
    pub radius: f64,
}

impl From<Proxy> for BdtProxy {
    fn from(proxy: Proxy) -> Self {
        Self {
            lane: proxy.lane.into(),
            center: proxy.center.into(),
            radius: proxy.radius,
        }
    }
}

/// What the last query of a workspace looked at; of a batch the sum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes)]
#[repr(C)]
pub struct BdtStats {
    /// Nodes whose spheres were tested.
    pub nodes_visited: u64,
    /// Of them, those whose spheres were evaluated: all but what a step cache kept.
    pub nodes_updated: u64,
    /// Pairs of spheres that the broad phase compared.
    pub sphere_tests: u64,
}

impl From<Stats> for BdtStats {
    fn from(stats: Stats) -> Self {
        Self {
            nodes_visited: stats.nodes_visited,
            nodes_updated: stats.nodes_updated,
            sphere_tests: stats.sphere_tests,
        }
    }
}

/// What a query within a number of visits may have missed.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtBound {
    /// 1 if nothing was left out: the answer is the one without a limit.
    pub is_complete: u32,
    /// 0.
    pub reserved: u32,
    /// Certified: without a limit the distance is not below this; of contacts that were left out, no distance is.
    pub at_least: f64,
    /// Of contacts: at most so many triangles were neither tested nor ruled out.
    pub unseen_triangles: u64,
}

// What other languages lay out by hand.
const _: () = {
    assert!(size_of::<BdtContact>() == 88);
    assert!(size_of::<BdtHit>() == 88);
    assert!(size_of::<BdtPairContact>() == 160);
    assert!(size_of::<BdtIndexPair>() == 8);
    assert!(size_of::<BdtManifoldPoint>() == 120);
    assert!(size_of::<BdtManifold>() == 560);
    assert!(size_of::<BdtLane>() == 8);
    assert!(size_of::<BdtLanePair>() == 16);
    assert!(size_of::<BdtLaneTriangle>() == 12);
    assert!(size_of::<BdtProxy>() == 40);
    assert!(size_of::<BdtStats>() == 24);
    assert!(size_of::<BdtBound>() == 24);
};
