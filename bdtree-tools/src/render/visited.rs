//! What a scene's queries visit of a file.
//!
//! The queries are answered as by `bdtree query`, with memory for all nodes of every instance; the nodes
//! that are in it afterwards are those that were visited. A frustum that the root's sphere alone decides
//! visits nothing else and is not in it.

use bdtree_format::NodeRecord;
use bdtree_render::NodeSphere;
use bdtree_runtime::{LeafSlot, NodeSlot, StepCache, Transform};

use super::body::{Body, Posture};
use super::picture::{Content, Frame, of_nodes};
use super::questions::shapes;
use super::{Arguments, title};
use crate::AssetFile;
use crate::error::ToolError;
use crate::q::counted;
use crate::query::{PoseMemory, solve_all};
use crate::scene::Scene;

/// The scene with the spheres in which its queries ended in the file's instances.
///
/// # Errors
/// No instance of the file, a corrupt asset.
pub(super) fn shown<'a>(
    arguments: &Arguments,
    file: &AssetFile,
    scene: &'a Scene,
) -> Result<Frame<'a>, ToolError> {
    let own = file.path().canonicalize().ok();
    let is_file: Vec<bool> = scene
        .instances
        .iter()
        .map(|instance| scene.files[instance.asset].path().canonicalize().ok() == own)
        .collect();
    if !is_file.contains(&true) {
        let message = format!("no instance of {}", file.path().display());
        return Err(ToolError::input(&scene.source, message));
    }
    let visited = visited(scene)?;
    let mut content = Vec::with_capacity(scene.instances.len());
    let mut count = 0;
    let mut assets = Vec::new();
    for ((instance, visited), is_file) in scene.instances.iter().zip(visited).zip(is_file) {
        let from = &scene.files[instance.asset];
        let posture = Posture {
            q: instance.q.clone(),
            transform: instance.transform,
        };
        let body = Body::new(from, from.asset()?, posture)?;
        let mut spheres = Vec::new();
        if is_file {
            count += visited.len() as u64;
            assets.push(body.asset);
            spheres = drawn(arguments, &body, &visited)?;
        }
        content.push(Content {
            body,
            spheres,
            is_file,
        });
    }
    let queries = counted(scene.queries.len(), "query").replace("querys", "queries");
    Ok(Frame {
        title: title(&arguments.file),
        about: vec![format!("{queries}: visited {}", of_nodes(count, &assets))],
        number: None,
        questions: shapes(scene, &content),
        content,
        nodes_visited: Some(count),
    })
}

/// Gives the instances of the file another q, and the motion of the frame that it is from.
///
/// # Errors
/// A placement that both together are too large for.
pub(super) fn put(
    scene: &mut Scene,
    file: &AssetFile,
    (q, motion): &(Vec<f32>, Transform),
) -> Result<(), ToolError> {
    let own = file.path().canonicalize().ok();
    for instance in &mut scene.instances {
        if scene.files[instance.asset].path().canonicalize().ok() == own {
            instance.q.clone_from(q);
            let place = instance.transform.after(*motion);
            instance.transform = place.map_err(|e| ToolError::input("--frame", e.to_string()))?;
        }
    }
    Ok(())
}

/// The nodes that the scene's queries visit, by instance.
fn visited(scene: &Scene) -> Result<Vec<Vec<u32>>, ToolError> {
    let mut memory = PoseMemory::of(scene)?;
    let poses = memory.poses(scene)?;
    let cache = |nodes: usize| StepCache::new(vec![NodeSlot::EMPTY; nodes], [LeafSlot::EMPTY; 0]);
    let mut caches: Vec<_> = poses
        .iter()
        .map(|(asset, _)| cache(asset.node_count()))
        .collect();
    let mut placed: Vec<_> = poses
        .iter()
        .zip(&mut caches)
        .map(|((asset, pose), cache)| (*asset, cache.start(pose)))
        .collect();
    solve_all(scene, &mut placed, true, |_, _| Ok(()))?;
    let visited = placed.iter().map(|(asset, pose)| {
        let nodes = 0..asset.node_count() as u32;
        nodes.filter(|node| pose.keeps(*node)).collect()
    });
    Ok(visited.collect())
}

/// The spheres of visited nodes that lead to no visited node, or those of a level.
fn drawn(
    arguments: &Arguments,
    body: &Body<'_>,
    visited: &[u32],
) -> Result<Vec<NodeSphere>, ToolError> {
    let spheres =
        body.spheres(|asset, pose| NodeSphere::of_nodes(asset, pose, visited.iter().copied()))?;
    let nodes = body.asset.nodes();
    let level = |node: u32| {
        nodes
            .get(node as usize)
            .map(|n: &NodeRecord| usize::from(n.level))
    };
    let is_drawn = |sphere: &NodeSphere| match arguments.spheres {
        Some(wanted) => level(sphere.node) == Some(wanted),
        None => sphere
            .child
            .is_none_or(|child| visited.binary_search(&child).is_err()),
    };
    Ok(spheres.into_iter().filter(is_drawn).collect())
}
