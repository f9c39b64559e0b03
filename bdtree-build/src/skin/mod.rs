//! A skin as the file stores it (SPEC 5.9, 7.7 to 7.9): weights in f32, bones in stored units, skeleton and clips.

mod clips;
mod names;
mod place;
mod rest;
mod skeleton;
pub mod weights;

use bdtree_format::{
    BONE_COUNT_MAX, BoneRecord, ChannelRecord, ClipRecord, INFLUENCES_MAX, InfluenceRecord,
    SKELETON_NODES_MAX, SkeletonNode, SkinRecord,
};

pub use place::tree_positions;
pub use weights::Weights;

use crate::error::{BakeError, Part, Place};
use crate::input::{RawMesh, RawSkin};
use crate::wrap::StoredShape;
use names::Names;

/// The sections of a skin but for what nodes have of it.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredSkin {
    /// What holds for the whole skin; the longest list of a node comes with the lists
    /// ([`WrappedBones`](crate::wrap::WrappedBones)).
    pub record: SkinRecord,
    /// First influence of each vertex, and the end of the last one's.
    pub starts: Vec<u32>,
    /// Influences, vertex by vertex.
    pub influences: Vec<InfluenceRecord>,
    /// Bones.
    pub bones: Vec<BoneRecord>,
    /// Bone-major, M each.
    pub bone_fields: Vec<f32>,
    /// Nodes of the skeleton.
    pub skeleton: Vec<SkeletonNode>,
    /// The node of each joint.
    pub joints: Vec<u32>,
    /// Names of nodes, then of clips.
    pub names: Vec<u8>,
    /// Clips.
    pub clips: Vec<ClipRecord>,
    /// Channels of all clips.
    pub channels: Vec<ChannelRecord>,
    /// Times and values of the channels' keys.
    pub keys: Vec<f32>,
}

impl StoredSkin {
    /// The influences of a vertex, which is below N.
    pub(crate) fn of(&self, vertex: usize) -> &[InfluenceRecord] {
        &self.influences[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

/// `skin` for the vertices and fields of `shape`, its weights taken as `weights` says. Fields that its clips move are
/// modes. Warnings go to `warnings`.
///
/// # Errors
/// Counts that do not fit each other or the format, weights that are none, matrices and keys that f32 cannot hold: each
/// kind once, with the first place of it.
pub fn store(
    mesh: &RawMesh,
    skin: &RawSkin,
    weights: Weights,
    shape: &StoredShape,
    warnings: &mut Vec<String>,
) -> Result<StoredSkin, BakeError> {
    check_counts(mesh, skin, shape.mode_count())?;
    let taken = weights::take(&mesh.name, &skin.influences, weights)?;
    let mut names = Names::default();
    let skeleton = skeleton::store(skin, &mut names)?;
    let mut bones = rest::bones(skin, &skeleton, shape)?;
    rest::add_boxes(&mut bones, &taken, shape);
    let minor_share = rest::add_cores(&mut bones, &taken, shape);
    let bone_fields = rest::fields(bones.len(), &taken, shape);
    let clips = clips::store(skin, shape, &mut names, warnings)?;
    Ok(StoredSkin {
        record: SkinRecord {
            influences_max: taken.most,
            node_bones_max: 0,
            weight_defect: taken.defect,
            minor_share,
            reserved: [0; 4],
        },
        starts: taken.starts,
        influences: taken.list,
        bones,
        bone_fields,
        skeleton,
        joints: skin.joints.clone(),
        names: names.bytes,
        clips: clips.records,
        channels: clips.channels,
        keys: clips.keys,
    })
}

/// Counts that fit the file and each other, and numbers of things that exist.
fn check_counts(mesh: &RawMesh, skin: &RawSkin, mode_count: usize) -> Result<(), BakeError> {
    let fail = |message: String| Err(BakeError::one("skin", Place::file(&mesh.name), message));
    for (what, count, most) in [
        ("bones", skin.bones.len(), BONE_COUNT_MAX),
        ("joints", skin.joints.len(), BONE_COUNT_MAX),
        (
            "nodes of the skeleton",
            skin.skeleton.len(),
            SKELETON_NODES_MAX,
        ),
    ] {
        if !(1..=most).contains(&count) {
            return fail(format!("{count} {what}: a skin has 1 to {most}"));
        }
    }
    let (vertices, own) = (mesh.positions.len(), skin.influences.vertex_count());
    if own != vertices {
        return fail(format!(
            "the skin has weights of {own} vertices, the mesh has {vertices}"
        ));
    }
    let mut is_joint = vec![false; skin.skeleton.len()];
    for (j, &node) in skin.joints.iter().enumerate() {
        match is_joint.get_mut(node as usize) {
            Some(known @ false) => *known = true,
            Some(true) => return fail(format!("joint {j}: node {node} is a joint already")),
            None => return fail(format!("joint {j}: there is no node {node}")),
        }
    }
    for (b, bone) in skin.bones.iter().enumerate() {
        if bone.joint as usize >= skin.joints.len() {
            return fail(format!("bone {b}: there is no joint {}", bone.joint));
        }
    }
    for (i, node) in skin.skeleton.iter().enumerate() {
        if node.parent.is_some_and(|parent| parent as usize >= i) {
            return fail(format!("node {i} of the skeleton stands before its parent"));
        }
    }
    for i in 0..own {
        let influences = skin.influences.of(i);
        let is_sorted = influences.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let exists = influences
            .last()
            .is_none_or(|last| usize::from(last.0) < skin.bones.len());
        if !is_sorted || !exists || influences.len() > INFLUENCES_MAX {
            let message = format!(
                "its bones are not ascending numbers below {}, {INFLUENCES_MAX} at most",
                skin.bones.len()
            );
            return Err(BakeError::one("skin", Part::Vertex(i), message));
        }
    }
    clips::check(skin, mode_count).or_else(fail)
}
