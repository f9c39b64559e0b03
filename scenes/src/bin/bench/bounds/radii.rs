//! How much radii grow, by level of the tree.

use bdtree_build::tree::LaneKind;
use bdtree_format::LANES;
use bdtree_scenes::bounds::body::Body;
use bdtree_scenes::bounds::bound::{Bound, Wrapped};
use bdtree_scenes::bounds::contenders::contenders;

use super::contact::{Bodies, Frame};
use super::table::Table;

const COLUMNS: [&str; 6] = [
    "root", "level 1", "level 2", "level 3", "level 4", "level 5",
];

/// By how many per cent R' is above the smallest one about the product's centre: means over lanes by
/// the level of their node.
pub(super) fn table(bodies: &Bodies, title: &str, frames: &[Frame]) -> Table {
    let mut table = Table::new(&format!("radii, {title}"), &COLUMNS);
    let body = &bodies.body;
    let levels = levels(body);
    let best = radii(bodies, frames, Bound::Wrapped);
    let mut done = Vec::new();
    for contender in contenders() {
        let bound = contender.bound;
        let balls = matches!(
            bound,
            Bound::Ball(_) | Bound::Affine(_) | Bound::BestOf(_) | Bound::Smallest
        );
        if !balls || done.contains(&bound) {
            continue;
        }
        done.push(bound);
        let mut sums = [[0.0; 2]; COLUMNS.len()];
        for (own, best) in radii(bodies, frames, bound).iter().zip(&best) {
            for (lane, (own, best)) in own.iter().zip(best).enumerate() {
                let level = levels[lane / LANES].min(COLUMNS.len() - 1);
                if *best > 0.0 {
                    sums[level] = [sums[level][0] + own / best, sums[level][1] + 1.0];
                }
            }
        }
        let means = sums.map(|[sum, count]| 100.0 * (sum / f64::max(count, 1.0) - 1.0));
        table.push(contender.name, means.to_vec());
    }
    table
}

/// By pose and lane, 0 for empty lanes.
fn radii(bodies: &Bodies, frames: &[Frame], bound: Bound) -> Vec<Vec<f64>> {
    let body = &bodies.body;
    let wrapped = Wrapped::new(body, bound);
    let one = |frame: &Frame| {
        let vertices = body.deformed(&frame.qa);
        let radius = |lane| match body.kind(lane) {
            LaneKind::Empty => 0.0,
            _ => {
                let shape = wrapped.at(body, lane, &frame.qa, &vertices);
                shape.ball.map_or(0.0, |ball| ball.radius)
            }
        };
        (0..body.lane_count()).map(radius).collect()
    };
    frames.iter().map(one).collect()
}

fn levels(body: &Body) -> Vec<usize> {
    let mut levels = vec![0; body.tree.nodes.len()];
    // Children come after their parents.
    for lane in 0..body.lane_count() {
        if body.kind(lane) == LaneKind::Inner {
            levels[body.child(lane)] = levels[lane / LANES] + 1;
        }
    }
    levels
}
