//! What carries the meshes of a file in which skins or animated nodes do: joints, bones and the nodes above them.

use std::collections::{HashMap, HashSet};

use bdtree_format::{BONE_COUNT_MAX, SKELETON_NODES_MAX};
use gltf::json::animation::Property;
use gltf::json::validation::Checked;
use serde::Deserialize;

use super::accessor::{Accessors, Purpose};
use super::affine::{self, Affine};
use super::document::Document;
use super::nodes::Scene;
use super::notes::Notes;
use crate::input::{RawBone, RawSkeletonNode, Rows};

/// Larger numbers of an inverse bind matrix are refused (SPEC 7.8).
const MATRIX_MAX: f64 = (1_u128 << 80) as f64;

/// A skin as the document has it.
#[derive(Debug, Deserialize)]
struct Skin {
    joints: Vec<usize>,
    #[serde(rename = "inverseBindMatrices")]
    inverse_bind_matrices: Option<usize>,
}

/// The bones of a file, and which of them each placed mesh uses.
#[derive(Debug, Default)]
pub(super) struct Rig {
    pub(super) joints: Vec<u32>,
    pub(super) bones: Vec<RawBone>,
    pub(super) skeleton: Vec<RawSkeletonNode>,
    /// The place in `skeleton` of a node of the document.
    pub(super) place: HashMap<usize, u32>,
    /// By skin of the document: the bone of each of its joints.
    skins: HashMap<usize, Vec<u16>>,
    /// By node of a mesh without a skin: its bone.
    whole: HashMap<usize, u16>,
    joint_of: HashMap<usize, u32>,
    bone_of: HashMap<(u32, [[u64; 4]; 3]), u16>,
}

/// The bones that a placed mesh uses.
#[derive(Debug, Clone, Copy)]
pub(super) enum Carriers<'a> {
    /// A bone for each joint of its skin.
    Skin(&'a [u16]),
    /// One for all vertices.
    One(u16),
}

/// The nodes whose placement any animation changes. A node with a matrix has no parts to change: glTF 2.0 forbids to
/// animate it.
pub(super) fn animated_nodes(document: &Document) -> HashSet<usize> {
    let channels = document.root.animations.iter().flat_map(|a| &a.channels);
    let moving = channels.filter(|channel| {
        let path = channel.target.path;
        matches!(path, Checked::Valid(path) if path != Property::MorphTargetWeights)
    });
    let nodes = moving.map(|channel| channel.target.node.value());
    let has_parts = |node: &usize| {
        document
            .exact
            .nodes
            .get(*node)
            .is_some_and(|n| n.matrix.is_none())
    };
    nodes.filter(has_parts).collect()
}

/// The bones of the scene's meshes; `None` if nothing needs any, or after noting what is wrong. Meshes that a skin
/// moves, and those whose placement cannot be undone, then stand in their own coordinates.
pub(super) fn read(
    document: &Document,
    scene: &mut Scene,
    accessors: &Accessors<'_>,
    notes: &mut Notes,
) -> Option<Rig> {
    let needed = |i: &super::nodes::Instance| i.skin.is_some() || i.is_animated;
    if !scene.instances.iter().any(needed) {
        return None;
    }
    let mut rig = Rig::default();
    let mut used: Vec<usize> = scene.instances.iter().filter_map(|i| i.skin).collect();
    used.sort_unstable();
    used.dedup();
    for skin in used {
        rig.add_skin(document, accessors, skin, notes)?;
    }
    for instance in &mut scene.instances {
        let Some(node) = instance.node else {
            continue;
        };
        if instance.skin.is_some() {
            // The joints say where it stands (glTF 2.0, 3.7.3.3).
            instance.world = Affine::IDENTITY;
            continue;
        }
        let inverse = instance.world.inverse().unwrap_or_else(|| {
            instance.world = Affine::IDENTITY;
            Affine::IDENTITY
        });
        let joint = rig.joint(node);
        let bone = rig.bone(joint, inverse.rows(), notes)?;
        rig.whole.insert(node, bone);
    }
    rig.add_skeleton(document, scene, notes)?;
    Some(rig)
}

impl Rig {
    /// The bones of a mesh at `node` that `skin` moves, or nothing.
    pub(super) fn carriers(
        &self,
        node: Option<usize>,
        skin: Option<usize>,
    ) -> Option<Carriers<'_>> {
        match skin {
            Some(skin) => self.skins.get(&skin).map(|bones| Carriers::Skin(bones)),
            None => self.whole.get(&node?).map(|&bone| Carriers::One(bone)),
        }
    }

    /// The bones of the joints of each skin, by ascending skin.
    pub(super) fn skins(&self) -> Vec<(usize, &[u16])> {
        let mut skins: Vec<_> = self
            .skins
            .iter()
            .map(|(&skin, bones)| (skin, &bones[..]))
            .collect();
        skins.sort_unstable_by_key(|(skin, _)| *skin);
        skins
    }

    /// Where each bone puts its mesh at rest: joint matrix times inverse bind matrix.
    pub(super) fn rests(&self) -> Vec<Affine> {
        let mut nodes: Vec<Affine> = Vec::with_capacity(self.skeleton.len());
        for node in &self.skeleton {
            let local = Affine::of_local(&node.local);
            // Parents stand before their children.
            let parent = node.parent.and_then(|parent| nodes.get(parent as usize));
            nodes.push(parent.map_or(local, |parent| parent.after(&local)));
        }
        let rest = |bone: &RawBone| {
            let node = self.joints[bone.joint as usize];
            nodes[node as usize].after(&Affine::of_rows(&bone.inverse_bind))
        };
        self.bones.iter().map(rest).collect()
    }

    /// The joint of a node, a new one if it has none.
    fn joint(&mut self, node: usize) -> u32 {
        let next = self.joint_of.len() as u32;
        let joint = *self.joint_of.entry(node).or_insert(next);
        if joint == next {
            // Its place in the skeleton comes later.
            self.joints.push(node as u32);
        }
        joint
    }

    /// The bone of a joint with this matrix, a new one if there is none.
    fn bone(&mut self, joint: u32, inverse_bind: Rows, notes: &mut Notes) -> Option<u16> {
        let inverse_bind = inverse_bind.map(|row| row.map(|x| x + 0.0));
        let key = (joint, inverse_bind.map(|row| row.map(f64::to_bits)));
        if let Some(&bone) = self.bone_of.get(&key) {
            return Some(bone);
        }
        if self.bones.len() == BONE_COUNT_MAX || self.joints.len() > BONE_COUNT_MAX {
            let message = format!(
                "more than {BONE_COUNT_MAX} joints, or pairs of a joint and an inverse bind matrix, move the meshes"
            );
            return notes.refuse("skins", message);
        }
        // No loss: below 4096.
        let bone = self.bones.len() as u16;
        self.bones.push(RawBone {
            joint,
            inverse_bind,
        });
        self.bone_of.insert(key, bone);
        Some(bone)
    }

    fn add_skin(
        &mut self,
        document: &Document,
        accessors: &Accessors<'_>,
        index: usize,
        notes: &mut Notes,
    ) -> Option<()> {
        let place = format!("skins[{index}]");
        let Some(value) = document.skins.get(index) else {
            return notes.refuse(place, "there is no such element, but a node names it");
        };
        let skin = match Skin::deserialize(value) {
            Ok(skin) => skin,
            Err(error) => return notes.refuse(place, error.to_string()),
        };
        if skin.joints.is_empty() {
            return notes.refuse(format!("{place}.joints"), "has no joints");
        }
        if skin.joints.len() > BONE_COUNT_MAX {
            let message = format!(
                "{} joints; at most {BONE_COUNT_MAX} are read",
                skin.joints.len()
            );
            return notes.refuse(format!("{place}.joints"), message);
        }
        let node_count = document.root.nodes.len();
        if let Some(i) = skin.joints.iter().position(|&node| node >= node_count) {
            let message = format!("there is no nodes[{}]", skin.joints[i]);
            return notes.refuse(format!("{place}.joints[{i}]"), message);
        }
        let matrices = match skin.inverse_bind_matrices {
            Some(accessor) => matrices(accessor, skin.joints.len(), accessors, &place, notes)?,
            None => vec![Affine::IDENTITY.rows(); skin.joints.len()],
        };
        let mut bones = Vec::with_capacity(skin.joints.len());
        for (&node, matrix) in skin.joints.iter().zip(matrices) {
            let joint = self.joint(node);
            bones.push(self.bone(joint, matrix, notes)?);
        }
        self.skins.insert(index, bones);
        Some(())
    }

    /// The joints and all nodes above them; joints become places among them.
    fn add_skeleton(
        &mut self,
        document: &Document,
        scene: &Scene,
        notes: &mut Notes,
    ) -> Option<()> {
        let parents = Parents::of(document);
        let mut chain = Vec::new();
        for i in 0..self.joints.len() {
            let mut node = Some(self.joints[i] as usize);
            chain.clear();
            while let Some(own) = node.filter(|own| !self.place.contains_key(own)) {
                if let Some(message) = parents.wrong(own) {
                    return notes.refuse(format!("nodes[{own}]"), message);
                }
                if chain.len() > document.root.nodes.len() {
                    return notes.refuse(format!("nodes[{own}]"), "is a node below itself");
                }
                chain.push(own);
                node = parents.first[own];
            }
            for &own in chain.iter().rev() {
                self.add_node(document, scene, &parents, own, notes)?;
            }
        }
        for joint in &mut self.joints {
            *joint = self.place.get(&(*joint as usize)).copied().unwrap_or(0);
        }
        Some(())
    }

    /// A node whose parent is there already.
    fn add_node(
        &mut self,
        document: &Document,
        scene: &Scene,
        parents: &Parents,
        index: usize,
        notes: &mut Notes,
    ) -> Option<()> {
        let at = format!("nodes[{index}]");
        if self.skeleton.len() == SKELETON_NODES_MAX {
            let message = format!("more than {SKELETON_NODES_MAX} joints and nodes above them");
            return notes.refuse(at, message);
        }
        let node = document.exact.nodes.get(index)?;
        if !scene.is_placed.get(index).copied().unwrap_or(false) {
            match Affine::of_node(node) {
                Ok((_, None)) => {}
                Ok((_, Some(odd))) => notes.warn(&at, odd),
                Err(message) => return notes.refuse(at, message),
            }
        }
        let name = document
            .root
            .nodes
            .get(index)
            .and_then(|node| node.name.clone());
        let place = self.skeleton.len() as u32;
        self.skeleton.push(RawSkeletonNode {
            name: name.unwrap_or(at),
            parent: parents.first[index].and_then(|parent| self.place.get(&parent).copied()),
            local: affine::local(node),
        });
        self.place.insert(index, place);
        Some(())
    }
}

/// What each node hangs from.
struct Parents {
    first: Vec<Option<usize>>,
    /// A second parent.
    second: HashMap<usize, usize>,
}

impl Parents {
    fn of(document: &Document) -> Self {
        let nodes = &document.root.nodes;
        let mut parents = Self {
            first: vec![None; nodes.len()],
            second: HashMap::new(),
        };
        for (parent, node) in nodes.iter().enumerate() {
            for child in node.children.iter().flatten() {
                match parents.first.get_mut(child.value()) {
                    Some(first @ None) => *first = Some(parent),
                    Some(Some(_)) => {
                        parents.second.insert(child.value(), parent);
                    }
                    None => {}
                }
            }
        }
        parents
    }

    /// Why the place of a node is not one.
    fn wrong(&self, node: usize) -> Option<String> {
        let (first, second) = (
            self.first.get(node).copied().flatten()?,
            self.second.get(&node)?,
        );
        Some(format!(
            "reached from nodes[{first}] and from nodes[{second}]; a node has one parent"
        ))
    }
}

/// The inverse bind matrices of a skin, one for each joint.
fn matrices(
    accessor: usize,
    count: usize,
    accessors: &Accessors<'_>,
    place: &str,
    notes: &mut Notes,
) -> Option<Vec<Rows>> {
    let place = format!("{place}.inverseBindMatrices");
    let elements = accessors.read(accessor, Purpose::Matrices, &place, notes)?;
    if elements.count < count {
        let message = format!("{} matrices for {count} joints", elements.count);
        return notes.refuse(place, message);
    }
    let mut out = Vec::with_capacity(count);
    let mut is_rounded = false;
    for (i, m) in elements.all::<16>().iter().take(count).enumerate() {
        if !m.iter().all(|x| x.abs() <= MATRIX_MAX) {
            let message = format!("matrix {i}: a number is not finite or beyond 2^80");
            return notes.refuse(place, message);
        }
        match Affine::of_columns(m) {
            Ok((affine, rounded)) => {
                is_rounded |= rounded;
                out.push(affine.rows());
            }
            Err(message) => return notes.refuse(place, format!("matrix {i}: {message}")),
        }
    }
    if is_rounded {
        notes.warn(
            place,
            "last rows are taken as 0, 0, 0, 1, which they nearly are",
        );
    }
    Some(out)
}
