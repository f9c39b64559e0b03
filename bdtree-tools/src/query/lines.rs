//! What a query answers, as JSON lines.

use bdtree_runtime::{
    Contact, ContactManifold, ContactPoint, FrustumState, PairContact, PointProjection, Proxy,
    RayIntersection,
};
use serde::Serialize;

/// One line.
#[derive(Debug, Serialize)]
pub(crate) struct Line {
    /// Index of the query in the scene.
    pub(super) query: usize,
    /// The query's kind.
    pub(super) kind: &'static str,
    /// What it found.
    #[serde(flatten)]
    pub(super) answer: Answer,
    /// What stands for the part of the answer below the scene's `max_depth`, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) proxies: Option<Vec<ProxyLine>>,
    /// What it left out, where visits are limited.
    #[serde(flatten)]
    pub(super) certificate: Option<Certificate>,
    /// Node bounds evaluated, when asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) nodes_visited: Option<u64>,
}

/// The part of a line that its kind decides.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Answer {
    /// ball, plane, capsule, box: ids, ascending, and contacts in the same order.
    Contacts {
        triangles: Vec<u32>,
        contacts: Vec<ContactLine>,
    },
    /// closest, ray
    Nearest(NearestLine),
    /// rays: one entry per ray.
    Rays { hits: Vec<Hits> },
    /// frustum: inside, intersects or outside.
    State { state: &'static str },
    /// pair: ids in a and b, ascending, and where they touch, when asked for.
    Pairs {
        triangles: Vec<[u32; 2]>,
        #[serde(skip_serializing_if = "Option::is_none")]
        contacts: Option<Vec<RegionLine>>,
    },
    /// distance: all null when there is nothing within the limit.
    Distance {
        distance: Option<f64>,
        point1: Option<[f64; 3]>,
        point2: Option<[f64; 3]>,
        triangles: Option<[u32; 2]>,
    },
}

/// What a ray of many meets, by what was asked for.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub(super) enum Hits {
    First(NearestLine),
    /// By distance, then id.
    All(Vec<NearestLine>),
    Any(bool),
}

/// What a query left out.
#[derive(Debug, Serialize)]
pub(super) struct Certificate {
    /// Nothing was left out.
    pub(super) complete: bool,
    /// Nothing that was left out is nearer (ball: has a smaller `dist`); null: nothing is there at
    /// all.
    pub(super) at_least: f64,
    /// ball: at most so many triangles were not looked at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) unseen: Option<u64>,
}

/// One sphere.
#[derive(Debug, Serialize)]
pub(super) struct ProxyLine {
    center: [f64; 3],
    radius: f64,
}

/// The nearest point, or a hit of a ray; all null when there is nothing.
#[derive(Debug, Serialize)]
pub(super) struct NearestLine {
    triangle: Option<u32>,
    point: Option<[f64; 3]>,
    /// From the given point or origin.
    distance: Option<f64>,
    barycentric: Option<[f64; 3]>,
}

/// One contact.
#[derive(Debug, Serialize)]
pub(super) struct ContactLine {
    triangle: u32,
    point: [f64; 3],
    normal: [f64; 3],
    dist: f64,
    barycentric: [f64; 3],
}

/// A region of contact of a pair.
#[derive(Debug, Serialize)]
pub(super) struct RegionLine {
    triangles: [u32; 2],
    normal: [f64; 3],
    area: f64,
    depth: f64,
    points: Vec<PointLine>,
}

/// One of its points.
#[derive(Debug, Serialize)]
struct PointLine {
    point1: [f64; 3],
    point2: [f64; 3],
    dist: f64,
    area: f64,
    triangle1: u32,
    barycentric1: [f64; 3],
    triangle2: u32,
    barycentric2: [f64; 3],
}

impl Line {
    /// Whether all numbers are finite, which only bytes that were not checked can prevent.
    pub(super) fn is_finite(&self) -> bool {
        let mut proxies = self.proxies.iter().flatten();
        proxies.all(|p| finite(&[p.center], &[p.radius])) && self.answer.is_finite()
    }
}

impl Answer {
    /// Contacts in any order.
    pub(super) fn contacts(mut contacts: Vec<Contact>) -> Self {
        contacts.sort_unstable_by_key(|c| c.triangle);
        Self::Contacts {
            triangles: contacts.iter().map(|c| c.triangle.0).collect(),
            contacts: contacts.iter().map(ContactLine::from).collect(),
        }
    }

    /// Pairs in any order.
    pub(super) fn pairs(pairs: &[PairContact], regions: Option<Vec<ContactManifold>>) -> Self {
        let ids = |p: &PairContact| [p.triangle1.0, p.triangle2.0];
        let mut triangles: Vec<[u32; 2]> = pairs.iter().map(ids).collect();
        triangles.sort_unstable();
        let lines = |regions: Vec<_>| regions.iter().map(RegionLine::from).collect();
        Self::Pairs {
            triangles,
            contacts: regions.map(lines),
        }
    }

    /// The nearest pair, if there is one.
    pub(super) fn distance(hit: Option<PairContact>) -> Self {
        Self::Distance {
            distance: hit.map(|h| h.distance),
            point1: hit.map(|h| h.point1),
            point2: hit.map(|h| h.point2),
            triangles: hit.map(|h| [h.triangle1.0, h.triangle2.0]),
        }
    }

    fn is_finite(&self) -> bool {
        match self {
            Self::Contacts { contacts, .. } => contacts
                .iter()
                .all(|c| finite(&[c.point, c.normal, c.barycentric], &[c.dist])),
            Self::Nearest(nearest) => nearest.is_finite(),
            Self::Rays { hits } => hits.iter().all(|hits| match hits {
                Hits::First(hit) => hit.is_finite(),
                Hits::All(hits) => hits.iter().all(NearestLine::is_finite),
                Hits::Any(_) => true,
            }),
            Self::State { .. } => true,
            Self::Pairs { contacts, .. } => contacts.iter().flatten().all(|region| {
                let is_finite = |p: &PointLine| {
                    let vectors = [p.point1, p.point2, p.barycentric1, p.barycentric2];
                    finite(&vectors, &[p.dist, p.area])
                };
                finite(&[region.normal], &[region.area, region.depth])
                    && region.points.iter().all(is_finite)
            }),
            Self::Distance {
                distance,
                point1,
                point2,
                ..
            } => finite([point1, point2].into_iter().flatten(), distance),
        }
    }
}

impl NearestLine {
    fn is_finite(&self) -> bool {
        let vectors = [&self.point, &self.barycentric];
        finite(vectors.into_iter().flatten(), &self.distance)
    }
}

fn finite<'n>(
    vectors: impl IntoIterator<Item = &'n [f64; 3]>,
    numbers: impl IntoIterator<Item = &'n f64>,
) -> bool {
    let mut all = vectors.into_iter().flatten().chain(numbers);
    all.all(|x| x.is_finite())
}

impl From<FrustumState> for Answer {
    fn from(state: FrustumState) -> Self {
        let state = match state {
            FrustumState::Inside => "inside",
            FrustumState::Intersects => "intersects",
            FrustumState::Outside => "outside",
        };
        Self::State { state }
    }
}

impl From<&Proxy> for ProxyLine {
    fn from(proxy: &Proxy) -> Self {
        Self {
            center: proxy.center,
            radius: proxy.radius,
        }
    }
}

impl From<&Contact> for ContactLine {
    fn from(contact: &Contact) -> Self {
        Self {
            triangle: contact.triangle.0,
            point: contact.point,
            normal: contact.normal,
            dist: contact.distance,
            barycentric: contact.barycentric,
        }
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

impl From<Option<PointProjection>> for NearestLine {
    fn from(hit: Option<PointProjection>) -> Self {
        Self {
            triangle: hit.map(|h| h.triangle.0),
            point: hit.map(|h| h.point),
            distance: hit.map(|h| h.distance),
            barycentric: hit.map(|h| h.barycentric),
        }
    }
}

impl From<Option<RayIntersection>> for NearestLine {
    fn from(hit: Option<RayIntersection>) -> Self {
        Self {
            triangle: hit.map(|h| h.triangle.0),
            point: hit.map(|h| h.point),
            distance: hit.map(|h| h.distance),
            barycentric: hit.map(|h| h.barycentric),
        }
    }
}
