//! Queries that stop at a level: every triangle of the full answer is reported or lies in a sphere that
//! is.

use bdtree_runtime::narrow::{OrientedBox, Triangle};
use bdtree_runtime::{Asset, Contact, Pose, Posed, Proxy, StackEntry, Transform, query};

use crate::body::Body;
use crate::compare::{extent, kernels};
use crate::oracle;

/// Balls, planes, capsules and boxes at every level, with every kernel.
///
/// # Panics
/// When a triangle is neither reported nor held, or kernels differ.
pub fn check_bounded(asset: &Asset<'_>, q: &[f32], place: Transform) {
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = Pose::new(asset, q, place, &mut memory).expect("pose");
    let body = oracle::deformed_triangles(asset, &pose);
    for t in [0, body.len() / 2] {
        let question = Question {
            point: body[t][0],
            size: 0.1 * extent(&body),
        };
        for kind in 0..4 {
            let expected = question.expected(&body, kind);
            for level in 0..=asset.depth() {
                let answers: Vec<_> = kernels(*asset)
                    .map(|asset| question.ask(&asset, &pose, level, kind))
                    .collect();
                let (exact, proxies) = &answers[0];
                assert!(answers.iter().all(|other| *other == answers[0]));
                for id in &expected {
                    let is_held = || proxies.iter().any(|p| holds(p, &body[*id as usize]));
                    assert!(
                        exact.binary_search(id).is_ok() || is_held(),
                        "triangle {id}, level {level}, kind {kind}"
                    );
                }
                assert!(exact.iter().all(|id| expected.binary_search(id).is_ok()));
                if level + 1 >= asset.depth() {
                    assert_eq!((exact, proxies.len()), (&expected, 0));
                }
            }
        }
    }
}

/// What is asked: a ball, a plane, a capsule, a box about a point.
struct Question {
    point: [f64; 3],
    size: f64,
}

const TURNED: [f64; 4] = [0.0, 0.6, 0.0, 0.8];

impl Question {
    fn end(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.point[k] + self.size * (k as f64 - 0.7))
    }

    fn half(&self) -> [f64; 3] {
        [self.size, 0.3 * self.size, 2.0 * self.size]
    }

    fn ask(
        &self,
        asset: &Asset<'_>,
        pose: &Pose<'_>,
        level: usize,
        kind: usize,
    ) -> (Vec<u32>, Vec<Proxy>) {
        let mut stack = vec![StackEntry::default(); asset.stack_len()];
        let mut found: Vec<Contact> = Vec::new();
        let mut proxies = Vec::new();
        let posed = Posed::from(pose).bounded(level, &mut proxies);
        let (at, size, stack, sink) = (self.point, self.size, &mut stack, &mut found);
        let outcome = match kind {
            0 => query::ball(asset, posed, at, size, stack, sink),
            1 => query::plane(asset, posed, [1.0, 0.0, 0.0], at[0] - size, stack, sink),
            2 => query::capsule(asset, posed, at, self.end(), 0.2 * size, stack, sink),
            _ => query::cuboid(asset, posed, at, TURNED, self.half(), stack, sink),
        };
        assert!(!outcome.expect("a sound asset").truncated);
        let mut ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
        ids.sort_unstable();
        (ids, proxies)
    }

    fn expected(&self, body: &Body, kind: usize) -> Vec<u32> {
        let (at, size) = (self.point, self.size);
        let ids = |all: Vec<(u32, f64)>| all.into_iter().map(|hit| hit.0).collect();
        match kind {
            0 => ids(oracle::ball(body, at, size)),
            1 => oracle::plane(body, [1.0, 0.0, 0.0], at[0] - size),
            2 => ids(oracle::capsule(body, [at, self.end()], 0.2 * size)),
            _ => ids(oracle::cuboid(
                body,
                &OrientedBox::new(at, TURNED, self.half()),
            )),
        }
    }
}

/// Whether a sphere holds a triangle.
fn holds(proxy: &Proxy, triangle: &Triangle) -> bool {
    triangle.iter().all(|x| {
        let square: f64 = (0..3).map(|k| (x[k] - proxy.center[k]).powi(2)).sum();
        square.sqrt() <= proxy.radius
    })
}
