//! What a query answers, as JSON lines.

use bdtree_runtime::{ClosestPoint, Contact, PairContact, RayHit};
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
    /// Node bounds evaluated, when asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nodes_visited: Option<u64>,
}

/// The part of a line that its kind decides.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Answer {
    /// ball, plane
    Contacts {
        /// Ids, ascending.
        triangles: Vec<u32>,
        /// In the same order.
        contacts: Vec<ContactLine>,
    },
    /// closest, ray: all null when there is nothing.
    Nearest {
        /// Its id.
        triangle: Option<u32>,
        /// Its point.
        point: Option<[f64; 3]>,
        /// From the given point or origin.
        distance: Option<f64>,
        /// Weights of its corners that give the point.
        barycentric: Option<[f64; 3]>,
    },
    /// pair
    Pairs {
        /// Ids in a and b, ascending.
        triangles: Vec<[u32; 2]>,
    },
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
    pub fn pairs(pairs: &[PairContact]) -> Self {
        let mut triangles: Vec<[u32; 2]> = pairs
            .iter()
            .map(|p| [p.triangle1.0, p.triangle2.0])
            .collect();
        triangles.sort_unstable();
        Self::Pairs { triangles }
    }

    /// Whether all numbers are finite, which only bytes that were not checked can prevent.
    pub fn is_finite(&self) -> bool {
        let finite = |x: &f64| x.is_finite();
        match self {
            Self::Contacts { contacts, .. } => contacts.iter().all(|c| {
                let vectors = [c.point, c.normal, c.barycentric];
                vectors.iter().flatten().all(finite) && c.dist.is_finite()
            }),
            Self::Nearest {
                point,
                distance,
                barycentric,
                ..
            } => {
                point.iter().flatten().all(finite)
                    && distance.iter().all(finite)
                    && barycentric.iter().flatten().all(finite)
            }
            Self::Pairs { .. } => true,
        }
    }
}

impl From<&Contact> for ContactLine {
    fn from(contact: &Contact) -> Self {
        Self {
            triangle: contact.triangle.0,
            point: contact.point,
            normal: contact.normal,
            dist: contact.dist,
            barycentric: contact.barycentric,
        }
    }
}

impl From<Option<ClosestPoint>> for Answer {
    fn from(hit: Option<ClosestPoint>) -> Self {
        Self::Nearest {
            triangle: hit.map(|h| h.triangle.0),
            point: hit.map(|h| h.point),
            distance: hit.map(|h| h.distance),
            barycentric: hit.map(|h| h.barycentric),
        }
    }
}

impl From<Option<RayHit>> for Answer {
    fn from(hit: Option<RayHit>) -> Self {
        Self::Nearest {
            triangle: hit.map(|h| h.triangle.0),
            point: hit.map(|h| h.point),
            distance: hit.map(|h| h.distance),
            barycentric: hit.map(|h| h.barycentric),
        }
    }
}
