//! Which meshes stand where: the scene's nodes, depth first, children in order.

use super::affine::Affine;
use super::document::Document;
use super::notes::Notes;

/// A mesh as one node places it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Instance {
    /// The node; `None` where there is no scene and a mesh stands for itself.
    pub(super) node: Option<usize>,
    pub(super) mesh: usize,
    /// From the mesh's coordinates to the scene's.
    pub(super) world: Affine,
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
/// any depth will do.
pub(super) fn instances(document: &Document, notes: &mut Notes) -> Vec<Instance> {
    let root = &document.root;
    let default = root.scene.map_or(0, |scene| scene.value());
    let Some(scene) = root.scenes.get(default) else {
        notes.warn(
            "",
            "no scene: every mesh is read in its own coordinates, no node is",
        );
        return (0..root.meshes.len())
            .map(|mesh| Instance {
                node: None,
                mesh,
                world: Affine::IDENTITY,
            })
            .collect();
    };
    let mut instances = Vec::new();
    let mut skinned = 0;
    let mut parents: Vec<Option<Parent>> = vec![None; root.nodes.len()];
    let mut stack: Vec<(usize, Parent, Affine)> = Vec::new();
    let roots = scene.nodes.iter().rev();
    stack.extend(roots.map(|node| (node.value(), Parent::Scene(default), Affine::IDENTITY)));
    while let Some((index, parent, outer)) = stack.pop() {
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
        if let Some(mesh) = node.mesh {
            skinned += usize::from(node.skin.is_some());
            instances.push(Instance {
                node: Some(index),
                mesh: mesh.value(),
                world,
            });
        }
        let children = node.children.iter().flatten().rev();
        stack.extend(children.map(|child| (child.value(), Parent::Node(index), world)));
    }
    if skinned > 0 {
        let nodes = if skinned == 1 {
            "1 mesh node is"
        } else {
            &format!("{skinned} mesh nodes are")
        };
        let message = format!(
            "{nodes} skinned, and bones are not read: the mesh is baked in its bind pose. To bake its motion, export \
             the frames of an animation (a folder of .obj files, .pc2 or .mdd) and give them as --animation"
        );
        notes.warn("", message);
    }
    instances
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
