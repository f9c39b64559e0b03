//! What one update takes: a sphere of ours and of the paper's (P42), all spheres of the layered hierarchy (P47).

use std::error::Error;
use std::hint::black_box;
use std::rc::Rc;

use bdtree_format::LANES;
use bdtree_measure::clock::Clock;
use bdtree_measure::deform::Deformer;
use bdtree_measure::paper_tree::{PaperTree, Step};
use bdtree_measure::peers::{LayeredPeer, Obvhs, Peer, Target};
use bdtree_measure::stats::median;
use bdtree_measure::{Body, Place};
use bdtree_runtime::{Asset, Transform};
use serde_json::{Value, json};

/// Nodes whose numbers stay in near caches.
const NEAR: usize = 64;

/// Times on an asset, each a median.
pub(super) fn measure(asset: &Asset<'_>, repeats: usize) -> Result<Value, Box<dyn Error>> {
    let q: Vec<f32> = asset
        .modes()
        .iter()
        .map(|mode| 0.5 * mode.q_range.get())
        .collect();
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(&q, Transform::IDENTITY, &mut memory)?;
    let tree = Rc::new(PaperTree::build(asset));
    let mut step = Step::default();
    step.prepare(&pose);
    let near = NEAR.min(asset.node_count());
    let ours = span(repeats, || {
        for i in 0..near {
            black_box(pose.node_spheres(i as u32).ok());
        }
    });
    let near_theirs = NEAR.min(tree.node_count());
    let theirs = span(repeats, || {
        for i in 0..near_theirs {
            black_box(tree.sphere(&step, i));
        }
    });
    let body = Body::of_asset(asset)?;
    let deformer = Deformer::new(&body);
    let (mut layered, mut boxes) = (LayeredPeer::new(tree, &deformer), Obvhs::new(&body));
    let mut scratch = Vec::new();
    let to = Target::without_bones(&deformer, &q, &Place::IDENTITY);
    let mut refit = |peer: &mut dyn Peer| {
        let all: Vec<f64> = (0..repeats.max(1))
            .map(|_| {
                let update = peer.update(to, &mut scratch);
                update.deform + update.refit
            })
            .collect();
        median(&all)
    };
    Ok(
        json!({"modes": asset.mode_count(), "triangles": asset.triangle_count(), "times": {
        "ours_ns_per_sphere": 1e9 * ours / (near * LANES) as f64,
        "paper_ns_per_sphere": 1e9 * theirs / near_theirs as f64,
        "layered_ms": 1e3 * refit(&mut layered), "boxes_ms": 1e3 * refit(&mut boxes)}}),
    )
}

/// Seconds of a call, the median of many spans of some calls each.
fn span(repeats: usize, mut call: impl FnMut()) -> f64 {
    const CALLS: usize = 20;
    let spans: Vec<f64> = (0..20 * repeats.max(1))
        .map(|_| {
            let start = Clock::start();
            (0..CALLS).for_each(|_| call());
            start.seconds() / CALLS as f64
        })
        .collect();
    median(&spans)
}
