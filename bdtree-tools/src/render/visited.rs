//! What a scene's queries visit of a file.
//!
//! The queries are answered as by `bdtree query`, with memory for all nodes of every instance; the nodes
//! that are in it afterwards are those that were visited. A frustum that the root's sphere alone decides
//! visits nothing else and is not in it.

use bdtree_render::NodeSphere;
use bdtree_runtime::CacheSize;

use super::arguments::Arguments;
use super::body::{Body, Content};
use super::picture::Frame;
use super::queries::shapes;
use crate::AssetFile;
use crate::error::ToolError;
use crate::posture::Posture;
use crate::q::counted;
use crate::query::solve_all;
use crate::scene::Scene;

/// The scene with the spheres in which its queries ended in the file's instances; `replaced` names the pose that these
/// have instead of the scene's, if one was given.
///
/// # Errors
/// No instance of the file, a corrupt asset.
pub(super) fn shown<'a>(
    arguments: &Arguments,
    file: &AssetFile,
    scene: &'a Scene,
    replaced: Option<&str>,
) -> Result<Frame<'a>, ToolError> {
    let is_file = are_of(scene, file);
    if !is_file.contains(&true) {
        let message = format!("no instance of {}", file.path().display());
        return Err(ToolError::input(&scene.source, message));
    }
    let mut bodies = scene.bodies(|index| {
        let file = &scene.files[scene.instances[index].file];
        let nodes = file.asset().node_count();
        CacheSize { nodes, leaves: 0 }
    })?;
    solve_all(scene, &mut bodies, |_, _| Ok(()))?;
    let mut content = Vec::with_capacity(bodies.len());
    let mut count = 0;
    for ((placed, mut instance), is_file) in scene.instances.iter().zip(bodies).zip(is_file) {
        let from = &scene.files[placed.file];
        let all = 0..from.asset().node_count() as u32;
        let visited: Vec<u32> = all.filter(|node| instance.keeps(*node)).collect();
        let body = Body::new(from, instance)?;
        let mut spheres = Vec::new();
        if is_file {
            count += visited.len() as u64;
            spheres = drawn(arguments, &body, &visited)?;
        }
        content.push(Content {
            body,
            spheres,
            is_file,
        });
    }
    let queries = counted(scene.queries.len(), "query");
    let instances = content.iter().filter(|content| content.is_file).count();
    let visited = of_nodes(count, instances, file.asset().node_count());
    let pose = replaced.map_or(String::new(), |pose| format!("{pose}; "));
    Ok(Frame {
        about: format!("{pose}{queries}: visited {visited}"),
        number: None,
        queries: shapes(scene, &content),
        content,
        nodes_visited: Some(count),
    })
}

/// How many nodes of instances with so many each.
fn of_nodes(count: u64, instances: usize, each: usize) -> String {
    let each = counted(each, "node");
    match instances {
        1 => format!("{count} of {each}"),
        _ => format!("{count} of {instances} \u{d7} {each}"),
    }
}

/// Gives the instances of the file another q and other joints, and the motion of the frame that they are from.
///
/// # Errors
/// A placement that both together are too large for.
pub(super) fn put(scene: &mut Scene, file: &AssetFile, posture: &Posture) -> Result<(), ToolError> {
    let is_file = are_of(scene, file);
    for (instance, is_file) in scene.instances.iter_mut().zip(is_file) {
        if is_file {
            instance.q.clone_from(&posture.q);
            instance.joints.clone_from(&posture.joints);
            let place = instance.transform.after(posture.transform);
            instance.transform = place.map_err(|e| ToolError::input("--frame", e.to_string()))?;
        }
    }
    Ok(())
}

/// Which instances are of a file.
fn are_of(scene: &Scene, file: &AssetFile) -> Vec<bool> {
    let own = file.path().canonicalize().ok();
    let is_own = |file: &AssetFile| file.path().canonicalize().ok() == own;
    let instances = scene.instances.iter();
    instances.map(|i| is_own(&scene.files[i.file])).collect()
}

/// The spheres of visited nodes that lead to no visited node, or those of a level.
fn drawn(
    arguments: &Arguments,
    body: &Body<'_>,
    visited: &[u32],
) -> Result<Vec<NodeSphere>, ToolError> {
    let spheres = body.spheres(|pose| NodeSphere::of_nodes(pose, visited.iter().copied()))?;
    let is_drawn = |sphere: &NodeSphere| match arguments.spheres {
        Some(wanted) => sphere.level == wanted,
        None => sphere
            .child
            .is_none_or(|child| visited.binary_search(&child).is_err()),
    };
    Ok(spheres.into_iter().filter(is_drawn).collect())
}

#[cfg(test)]
mod tests {
    use super::of_nodes;

    #[test]
    fn nodes_are_counted_of_those_of_all_instances() {
        assert_eq!(of_nodes(12, 1, 778), "12 of 778 nodes");
        assert_eq!(of_nodes(284, 2, 778), "284 of 2 × 778 nodes");
    }
}
