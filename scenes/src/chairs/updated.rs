//! Which spheres a step's queries update (the paper's figure 7).
//!
//! A world counts the nodes that it updates and does not say which they are, so the step's queries are asked again level by
//! level: a node is updated if it is a root of a pair, or hangs on a sphere that is near a sphere of the other body on the
//! same level, or near the ground. That is a little more than a walk updates, which may find out halfway down one of the
//! trees that nothing is near.

use std::error::Error;

use bdtree_dynamics::BodyId;
use bdtree_render::{NodeSphere, Sphere};
use bdtree_runtime::{HalfSpace, LaneId, Pose, Workspace, broad};
use nalgebra::Vector3;

use super::scene::Chairs;

/// Opacity of spheres.
const OPACITY: u8 = 70;

/// Of levels, the root's first; those below have the last one's colour.
const COLOURS: [[u8; 3]; 4] = [
    [92, 104, 116],
    [44, 110, 178],
    [240, 150, 30],
    [214, 40, 40],
];

/// The updated spheres of a step, and how many nodes they belong to.
pub(super) struct Updated {
    /// Those below which nothing was updated.
    pub(super) spheres: Vec<Sphere>,
    pub(super) nodes: usize,
}

/// Of the last step, whose poses the world's instances still have.
pub(super) fn updated(scene: &Chairs) -> Result<Updated, Box<dyn Error>> {
    let world = &scene.world;
    let count = world.len();
    let (spheres, step_s) = (&scene.spheres, world.options().step_s);
    let nodes_each = scene.nodes_each()[1];
    // As far as bodies may move from the middle of the step, for which they are posed.
    let mut moves = Vec::with_capacity(count);
    for body in 0..count {
        let state = world.state(BodyId(body))?;
        let spin = Vector3::from(world.angular_velocity(BodyId(body))?).norm();
        let turned = step_s * spin * scene.extent;
        moves.push((Vector3::from(state.velocity) * step_s, turned));
    }
    let mut workspace = Workspace::new();
    let poses: Vec<Pose<'_>> = world.instances().iter().map(|own| own.pose()).collect();
    let mut roots = Vec::new();
    for (pose, (way, turned)) in poses.iter().zip(&moves) {
        let mut root = pose.bounding_sphere()?;
        root.radius += spheres.reach() + turned + way.norm();
        roots.push(root);
    }
    let mut near: Vec<[usize; 2]> = Vec::new();
    broad::pairs(&roots, 0.0, &mut workspace, &mut near)?;
    let mut is_updated = vec![false; count * nodes_each];
    for level in 0..spheres.level + 1 {
        for [a, b] in &near {
            let apart = (moves[*a].0 - moves[*b].0).norm() + moves[*a].1 + moves[*b].1;
            let mut unused = Workspace::new();
            let mut pairs: Vec<[LaneId; 2]> = Vec::new();
            let (first, second) = (
                poses[*a].query(&mut workspace),
                poses[*b].query(&mut unused),
            );
            let mut query = first.against(second);
            query.level_spheres([level; 2], apart, 2.0 * spheres.reach(), &mut pairs)?;
            for body in [*a, *b] {
                is_updated[body * nodes_each] = true;
            }
            for [lane_a, lane_b] in pairs {
                enter(scene, *a, lane_a, &mut is_updated);
                enter(scene, *b, lane_b, &mut is_updated);
            }
        }
        for (body, pose) in poses.iter().enumerate() {
            if roots[body].center[1] > roots[body].radius {
                continue;
            }
            let (way, turned) = &moves[body];
            let height = spheres.reach() + turned + way.y.abs();
            let ground = HalfSpace::new([0.0, 1.0, 0.0], height);
            let mut lanes: Vec<LaneId> = Vec::new();
            let mut query = pose.query(&mut workspace);
            query.level_spheres(level, ground, &mut lanes)?;
            is_updated[body * nodes_each] = true;
            for lane in lanes {
                enter(scene, body, lane, &mut is_updated);
            }
        }
    }
    let mut found = Vec::new();
    for (pose, own) in poses.iter().zip(is_updated.chunks_exact(nodes_each)) {
        let nodes = (0..nodes_each as u32).filter(|node| own[*node as usize]);
        for sphere in NodeSphere::of_nodes(pose, nodes)? {
            let child = sphere.child.and_then(|child| own.get(child as usize));
            if child != Some(&true) && sphere.radius.is_finite() {
                let [r, g, b] = COLOURS[sphere.level.min(COLOURS.len() - 1)];
                found.push(Sphere {
                    center: sphere.center.map(|x| x as f32),
                    radius: sphere.radius as f32,
                    colour: [r, g, b, OPACITY],
                });
            }
        }
    }
    Ok(Updated {
        spheres: found,
        nodes: is_updated.iter().filter(|is| **is).count(),
    })
}

/// The node that hangs on a lane is updated, if it is one that contacts are sought in.
fn enter(scene: &Chairs, body: usize, lane: LaneId, is_updated: &mut [bool]) {
    let each = scene.nodes_each()[1];
    let node = scene.model.asset().nodes().get(lane.node as usize);
    let child = node.and_then(|node| node.child(usize::from(lane.lane)));
    if let Some(child) = child.map(|child| child as usize)
        && child < each
    {
        is_updated[body * each + child] = true;
    }
}
