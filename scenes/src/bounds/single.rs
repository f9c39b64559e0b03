//! One body against a ball or a ray: what a bound makes the traversal do.

use bdtree_runtime::narrow::{Ray, closest_point, ray_hit};

use super::overlap::{RayLine, entry, meets_ball};
use super::posed::Posed;
use super::shape::Ball;

/// What a query of one body did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Visits of nodes.
    pub visits: u64,
    /// Triangles in leaf lanes that were reached.
    pub triangles: u64,
    /// Triangles that the ball or the ray meets.
    pub found: u64,
}

/// All triangles that touch a ball.
pub fn ball(posed: &mut Posed<'_>, ball: &Ball) -> Counts {
    let mut counts = Counts::default();
    let mut stack = vec![0];
    let directions = &posed.wrapped.directions;
    while let Some(node) = stack.pop() {
        posed.visit(node);
        counts.visits += 1;
        for lane in posed.lanes(node) {
            if !meets_ball(posed.shape(lane), directions, ball) {
                continue;
            }
            if !posed.is_leaf(lane) {
                stack.push(posed.body.child(lane));
                continue;
            }
            for corners in posed.triangles(lane) {
                counts.triangles += 1;
                let nearest = closest_point(ball.centre.into(), &corners);
                counts.found += u64::from(nearest.distance <= ball.radius);
            }
        }
    }
    counts
}

/// The nearest triangle that a ray hits: nearest lanes first, those behind the best hit left out.
/// Returns where, too.
pub fn ray(posed: &mut Posed<'_>, line: &RayLine) -> (Counts, Option<f64>) {
    let mut counts = Counts::default();
    let exact = Ray::new(line.0.into(), line.1.into());
    let mut best = f64::INFINITY;
    let mut stack = vec![(0.0, 0)];
    let directions = &posed.wrapped.directions;
    while let Some((near, node)) = stack.pop() {
        if near > best {
            continue;
        }
        posed.visit(node);
        counts.visits += 1;
        let mut lanes: Vec<(f64, usize)> = posed
            .lanes(node)
            .filter_map(|lane| Some((entry(posed.shape(lane), directions, line)?, lane)))
            .collect();
        lanes.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (near, lane) in &lanes {
            if *near > best || !posed.is_leaf(*lane) {
                continue;
            }
            for corners in posed.triangles(*lane) {
                counts.triangles += 1;
                best = best.min(ray_hit(&exact, &corners, best).map_or(best, |hit| hit.t));
            }
        }
        for (near, lane) in lanes.iter().rev() {
            if !posed.is_leaf(*lane) {
                stack.push((*near, posed.body.child(*lane)));
            }
        }
    }
    counts.found = u64::from(best.is_finite());
    (counts, best.is_finite().then_some(best))
}
