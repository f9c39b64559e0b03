//! Which meshes stand where: the scene's nodes, depth first, children in order.

use std::collections::HashSet;

use super::affine::Affine;
use super::document::Document;
use super::notes::Notes;

/// A mesh as one node places it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Instance {
    /// The node; `None` where there is no scene and a mesh stands for itself.
    pub(super) node: Option<usize>,
    pub(super) mesh: usize,
    /// From the mesh's coordinates to where its vertices are read: the scene's, unless bones carry it.
    pub(super) world: Affine,
    /// The skin that the node names.
    pub(super) skin: Option<usize>,
    /// An animation moves the node or one above it.
    pub(super) is_animated: bool,
}

/// What the scene places.
#[derive(Debug, Default)]
pub(super) struct Scene {
    /// Meshes in order.
    pub(super) instances: Vec<Instance>,
    /// Per node of the document, whether the scene has it.
    pub(super) is_placed: Vec<bool>,
}

impl Instance {
    /// The name for people: the node's, else the mesh's, else the place in the file.
    pub(super) fn name(&self, document: &Document) -> String {
        let node = self.node.and_then(|node| document.root.nodes.get(node));
        let mesh = document.root.meshes.get(self.mesh);
        let name = node.and_then(|node| node.name.as_ref());
        let name = name.or_else(|| mesh.and_then(|mesh| mesh.name.as_ref()));
        match (name, self.node) {
            (Some(name), _) => name.clone(),
            (None, Some(node)) => format!("nodes[{node}]"),
            (None, None) => format!("meshes[{}]", self.mesh),
        }
    }
}

/// The instances of the default scene, else of the first, else every mesh once in its own
/// coordinates (glTF 2.0, 3.5.1: without scenes a file is a library of meshes).
///
/// Notes nodes that are reached twice and placements that are none. The walk keeps its own stack:
/// any depth will do. `animated` are the nodes that animations move.
pub(super) fn scene(document: &Document, animated: &HashSet<usize>, notes: &mut Notes) -> Scene {
    let root = &document.root;
    let default = root.scene.map_or(0, |scene| scene.value());
    let Some(scene) = root.scenes.get(default) else {
        notes.warn(
            "",
            "no scene: every mesh is read in its own coordinates, no node is",
        );
        let alone = |mesh: usize| Instance {
            node: None,
            mesh,
            world: Affine::IDENTITY,
            skin: None,
            is_animated: false,
        };
        return Scene {
            instances: (0..root.meshes.len()).map(alone).collect(),
            is_placed: vec![false; root.nodes.len()],
        };
    };
    let mut instances = Vec::new();
    let mut parents: Vec<Option<Parent>> = vec![None; root.nodes.len()];
    let mut stack: Vec<(usize, Parent, Affine, bool)> = Vec::new();
    let roots = scene.nodes.iter().rev();
    let root_of = |node: usize| (node, Parent::Scene(default), Affine::IDENTITY, false);
    stack.extend(roots.map(|node| root_of(node.value())));
    while let Some((index, parent, outer, is_below)) = stack.pop() {
        let (Some(node), Some(known)) = (root.nodes.get(index), parents.get_mut(index)) else {
            notes.problem(parent, format!("there is no nodes[{index}]"));
            continue;
        };
        if let Some(first) = known.replace(parent) {
            let message = format!("reached from {first} and from {parent}; a node has one parent");
            notes.problem(format!("nodes[{index}]"), message);
            if notes.is_full() {
                break;
            }
            continue;
        }
        let own = match document.exact.nodes.get(index).map(Affine::of_node) {
            Some(Ok((own, odd))) => {
                if let Some(odd) = odd {
                    notes.warn(format!("nodes[{index}]"), odd);
                }
                own
            }
            Some(Err(message)) => {
                notes.problem(format!("nodes[{index}]"), message);
                Affine::IDENTITY
            }
            None => Affine::IDENTITY,
        };
        let world = outer.after(&own);
        let is_animated = is_below || animated.contains(&index);
        if let Some(mesh) = node.mesh {
            instances.push(Instance {
                node: Some(index),
                mesh: mesh.value(),
                world,
                skin: node.skin.as_ref().map(|skin| skin.value()),
                is_animated,
            });
        }
        let children = node.children.iter().flatten().rev();
        let below = |child: usize| (child, Parent::Node(index), world, is_animated);
        stack.extend(children.map(|child| below(child.value())));
    }
    Scene {
        instances,
        is_placed: parents.iter().map(Option::is_some).collect(),
    }
}

/// What a node hangs from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Parent {
    Scene(usize),
    Node(usize),
}

impl std::fmt::Display for Parent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Parent::Scene(scene) => write!(f, "scenes[{scene}]"),
            Parent::Node(node) => write!(f, "nodes[{node}]"),
        }
    }
}
