//! What a query answers, as JSON lines.

use super::{Certificate, RegionLine};
use bdtree_runtime::{Contact, FrustumState, PairContact, PointProjection, Proxy, RayIntersection};
use serde::Serialize;

/// One line.
#[derive(Debug, Serialize)]
pub struct Line {
    /// Index of the query in the scene.
    pub query: usize,
    /// The query's kind.
    pub kind: &'static str,
    /// What it found.
    #[serde(flatten)]
    pub answer: Answer,
    /// What stands for the part of the answer below the scene's `max_depth`, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proxies: Option<Vec<ProxyLine>>,
    /// What it left out, where visits are limited.
    #[serde(flatten)]
    pub certificate: Option<Certificate>,
    /// Node bounds evaluated, when asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes_visited: Option<u64>,
}

/// The part of a line that its kind decides.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Answer {
    /// ball, plane, capsule, box
    Contacts {
        /// Ids, ascending.
        triangles: Vec<u32>,
        /// In the same order.
        contacts: Vec<ContactLine>,
    },
    /// closest, ray
    Nearest(NearestLine),
    /// rays, mode first
    First {
        /// One per ray.
        hits: Vec<NearestLine>,
    },
    /// rays, mode all
    All {
        /// One list per ray, by distance, then id.
        hits: Vec<Vec<NearestLine>>,
    },
    /// rays, mode any
    Any {
        /// One per ray.
        hits: Vec<bool>,
    },
    /// frustum
    State {
        /// inside, intersects or outside
        state: &'static str,
    },
    /// pair
    Pairs {
        /// Ids in a and b, ascending.
        triangles: Vec<[u32; 2]>,
        /// Where they touch, when asked for.
        #[serde(skip_serializing_if = "Option::is_none")]
        contacts: Option<Vec<RegionLine>>,
    },
    /// distance: all null when there is nothing within the limit.
    Distance {
        /// 0 when they touch.
        distance: Option<f64>,
        /// The point of a.
        point1: Option<[f64; 3]>,
        /// The point of b.
        point2: Option<[f64; 3]>,
        /// Ids in a and b.
        triangles: Option<[u32; 2]>,
    },
}

/// One sphere.
#[derive(Debug, Serialize)]
pub struct ProxyLine {
    center: [f64; 3],
    radius: f64,
}

impl ProxyLine {
    /// Whether all numbers are finite, as [`Answer::is_finite`].
    pub fn is_finite(&self) -> bool {
        self.center.iter().all(|x| x.is_finite()) && self.radius.is_finite()
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

/// The nearest point, or a hit of a ray; all null when there is nothing.
#[derive(Debug, Serialize)]
pub struct NearestLine {
    triangle: Option<u32>,
    point: Option<[f64; 3]>,
    /// From the given point or origin.
    distance: Option<f64>,
    barycentric: Option<[f64; 3]>,
}

/// One contact.
#[derive(Debug, Serialize)]
pub struct ContactLine {
    triangle: u32,
    point: [f64; 3],
    normal: [f64; 3],
    dist: f64,
    barycentric: [f64; 3],
}

impl Answer {
    /// Contacts in any order.
    pub fn contacts(mut contacts: Vec<Contact>) -> Self {
        contacts.sort_unstable_by_key(|c| c.triangle);
        Self::Contacts {
            triangles: contacts.iter().map(|c| c.triangle.0).collect(),
            contacts: contacts.iter().map(ContactLine::from).collect(),
        }
    }

    /// Pairs in any order.
    pub fn pairs(pairs: &[PairContact], contacts: Option<Vec<RegionLine>>) -> Self {
        let mut triangles: Vec<[u32; 2]> = pairs
            .iter()
            .map(|p| [p.triangle1.0, p.triangle2.0])
            .collect();
        triangles.sort_unstable();
        Self::Pairs {
            triangles,
            contacts,
        }
    }

    /// The nearest pair, if there is one.
    pub fn distance(hit: Option<PairContact>) -> Self {
        Self::Distance {
            distance: hit.map(|h| h.distance),
            point1: hit.map(|h| h.point1),
            point2: hit.map(|h| h.point2),
            triangles: hit.map(|h| [h.triangle1.0, h.triangle2.0]),
        }
    }

    /// Whether all numbers are finite, which only bytes that were not checked can prevent.
    pub fn is_finite(&self) -> bool {
        let finite = |x: &f64| x.is_finite();
        match self {
            Self::Contacts { contacts, .. } => contacts.iter().all(|c| {
                let vectors = [c.point, c.normal, c.barycentric];
                vectors.iter().flatten().all(finite) && c.dist.is_finite()
            }),
            Self::Nearest(nearest) => nearest.is_finite(),
            Self::First { hits } => hits.iter().all(NearestLine::is_finite),
            Self::All { hits } => hits.iter().flatten().all(NearestLine::is_finite),
            Self::Any { .. } | Self::State { .. } => true,
            Self::Pairs { contacts, .. } => contacts.iter().flatten().all(RegionLine::is_finite),
            Self::Distance {
                distance,
                point1,
                point2,
                ..
            } => distance.iter().all(finite) && point1.iter().chain(point2).flatten().all(finite),
        }
    }
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

impl NearestLine {
    fn is_finite(&self) -> bool {
        let vectors = [self.point, self.barycentric];
        let numbers = vectors.iter().flatten().flatten().chain(&self.distance);
        numbers.into_iter().all(|x| x.is_finite())
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
