//! What bounds are worth: how many nodes a query as small as a point visits.

use bdtree_runtime::{Asset, Ball, Contact, Transform, VertexId, Workspace};
use serde::Serialize;

use super::random::Random;

/// Poses within q_range, and points on the surface of each.
const POSES: usize = 8;
const POINTS: usize = 16;

/// Above this share of the nodes bounds are said to exclude little. Counted, not measured: a node is
/// about 13 M operations in each of eight lanes, a vertex 6 M, and there are some ten vertices per
/// node; so a query that visits a quarter of the nodes costs four tenths of moving every vertex.
const USELESS_SHARE: f64 = 0.25;

/// Fewer nodes are visited quickly anyway.
const NODES_MIN: usize = 64;

/// Mean number of nodes that a ball of radius 0 on the surface visits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Visits {
    /// At rest.
    pub rest: f64,
    /// With every q_j anywhere within its range.
    pub range: f64,
}

/// Visits over the same random poses and points in every run. `None` for assets that cannot be
/// queried (corrupt ones).
pub(crate) fn visits(asset: &Asset<'_>) -> Option<Visits> {
    let mut random = Random::new();
    let mut memory = vec![0.0; asset.pose_len()];
    let mut workspace = Workspace::new();
    let mut contacts: Vec<Contact> = Vec::new();
    let mut q = vec![0.0; asset.mode_count()];
    let mut mean = |poses: usize, extent: f64| -> Option<f64> {
        let mut sum = 0;
        for _ in 0..poses {
            for (q, mode) in q.iter_mut().zip(asset.modes()) {
                *q = (extent * (2.0 * random.unit() - 1.0)) as f32 * mode.q_range.get();
            }
            let pose = asset.pose(&q, Transform::IDENTITY, &mut memory).ok()?;
            for _ in 0..POINTS {
                let slot = random.bits() % asset.triangle_count() as u64;
                let corners = asset.triangles().get(slot as usize)?.corners;
                let mut center = [0.0; 3];
                for corner in corners {
                    let p = pose.deformed(VertexId(corner)).ok()?;
                    center = std::array::from_fn(|k| center[k] + p[k] / 3.0);
                }
                contacts.clear();
                let mut query = pose.query(&mut workspace);
                query.contacts(Ball::new(center, 0.0), &mut contacts).ok()?;
                sum += query.stats().nodes_visited;
            }
        }
        Some(sum as f64 / (poses * POINTS) as f64)
    };
    Some(Visits {
        rest: mean(POSES, 0.0)?,
        range: mean(POSES, 1.0)?,
    })
}

/// A warning with its figures when bounds hardly exclude anything (the paper, section 6: bases
/// that are not reduced, or not smooth).
pub(crate) fn warning(visits: Visits, nodes: usize, modes: usize) -> Option<String> {
    let is_useless = |visits: f64| nodes >= NODES_MIN && visits / nodes as f64 > USELESS_SHARE;
    if is_useless(visits.rest) {
        return Some(format!(
            "a point on the surface visits {:.0} of {nodes} nodes even at rest: the triangles are long and thin, and \
             spheres around them overlap; queries are slow unless the mesh is divided more evenly",
            visits.rest
        ));
    }
    is_useless(visits.range).then(|| {
        format!(
            "at q_range a point on the surface visits {:.0} of {nodes} nodes ({:.0} at rest): \
             bounds with these {modes} modes exclude little, and updating every vertex may be \
             faster; keep fewer or smoother modes (--modes), or expect small q only",
            visits.range, visits.rest
        )
    })
}
