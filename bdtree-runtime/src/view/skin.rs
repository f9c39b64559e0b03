//! The skin of an opened file: influences, bones, skeleton and clips, as they lie in it.

use bdtree_format::{
    BONE_ROWS_FIXED, BONE_ROWS_PER_ENTRY, BoneEntry, BoneRecord, ChannelRecord, ClipRecord,
    InfluenceRecord, Row, SectionKind, SkeletonNode, SkinRecord,
};

use super::Asset;
use crate::contact::VertexId;
use crate::error::{Datum, FormatError};

/// The sections of a skin (SPEC 5.9, 6.10, 7.7 to 7.9): all of one length per vertex, node or bone as the format says,
/// checked when the file was opened.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Skin<'a> {
    pub(crate) record: &'a SkinRecord,
    /// One per vertex, and one that ends the last.
    pub(crate) influence_starts: &'a [u32],
    pub(crate) influences: &'a [InfluenceRecord],
    pub(crate) bones: &'a [BoneRecord],
    /// Bone-major, M each.
    pub(crate) bone_fields: &'a [f32],
    /// One per node, and one that ends the last.
    pub(crate) list_starts: &'a [u32],
    pub(crate) lists: &'a [BoneEntry],
    pub(crate) rows: &'a [Row],
    pub(crate) skeleton: &'a [SkeletonNode],
    /// Nodes of the skeleton.
    pub(crate) joints: &'a [u32],
    pub(crate) names: &'a [u8],
    pub(crate) clips: &'a [ClipRecord],
    pub(crate) channels: &'a [ChannelRecord],
    pub(crate) keys: &'a [f32],
}

/// What the lanes of a node have of its bones (SPEC 6.10).
#[derive(Debug, Clone, Copy)]
pub struct NodeBones<'a> {
    /// The bone of each lane, entry by entry. It counts where β is above 0.
    pub entries: &'a [BoneEntry],
    /// S and ε.
    pub fixed: &'a [Row; BONE_ROWS_FIXED],
    /// β and g of each entry.
    pub weights: &'a [[Row; BONE_ROWS_PER_ENTRY]],
}

impl<'a> Skin<'a> {
    /// The influences of a vertex; `None` where there is no such vertex or its entries lie outside the file.
    #[inline]
    pub(crate) fn influences_of(&self, vertex: usize) -> Option<&'a [InfluenceRecord]> {
        let [start, end] = self
            .influence_starts
            .get(vertex..)?
            .first_chunk::<2>()?
            .map(|entry| entry as usize);
        self.influences.get(start..end)
    }

    /// The bones of a node and their rows; `None` where they lie outside the file.
    #[inline]
    pub(crate) fn node_bones(&self, node: usize) -> Option<NodeBones<'a>> {
        let [start, end] = self
            .list_starts
            .get(node..)?
            .first_chunk::<2>()?
            .map(|entry| entry as usize);
        let entries = self.lists.get(start..end)?;
        let first = node
            .checked_mul(BONE_ROWS_FIXED)?
            .checked_add(start.checked_mul(BONE_ROWS_PER_ENTRY)?)?;
        let (fixed, rest) = self.rows.get(first..)?.split_first_chunk()?;
        let (weights, _) = rest.as_chunks::<BONE_ROWS_PER_ENTRY>();
        Some(NodeBones {
            entries,
            fixed,
            weights: weights.get(..entries.len())?,
        })
    }

    /// A name of the skeleton or of a clip; empty where it lies outside the file or is not UTF-8.
    pub(crate) fn name(&self, start: u32, bytes: u32) -> &'a str {
        let start = start as usize;
        let bytes = self
            .names
            .get(start..start.saturating_add(bytes as usize))
            .unwrap_or_default();
        core::str::from_utf8(bytes).unwrap_or_default()
    }
}

impl<'a> Asset<'a> {
    /// True if bones carry the vertices: `p' = Σ_b w_b T_b (p + U q)`.
    pub fn has_skin(&self) -> bool {
        self.skin.is_some()
    }

    /// Number of joints: the length of what [`Instance::set_joints`](crate::Instance::set_joints) takes. 0 without a
    /// skin.
    pub fn joint_count(&self) -> usize {
        self.skin.map_or(0, |skin| skin.joints.len())
    }

    /// Number of bones, each a joint with an inverse bind matrix: the length of what
    /// [`Instance::set_skinning_matrices`](crate::Instance::set_skinning_matrices) takes. 0 without a skin.
    pub fn bone_count(&self) -> usize {
        self.skin.map_or(0, |skin| skin.bones.len())
    }

    /// The bones, in the order of [`InfluenceRecord::bone`]; none without a skin.
    pub fn bones(&self) -> &'a [BoneRecord] {
        self.skin.map_or(&[], |skin| skin.bones)
    }

    /// What holds for the whole skin, if there is one.
    pub fn skin_record(&self) -> Option<&'a SkinRecord> {
        self.skin.map(|skin| skin.record)
    }

    /// The bones of a vertex with their weights, bones ascending; none without a skin.
    ///
    /// # Errors
    /// No such vertex, entries outside of the file.
    pub fn influences(&self, vertex: VertexId) -> Result<&'a [InfluenceRecord], FormatError> {
        let Some(skin) = self.skin else {
            return Ok(&[]);
        };
        let i = vertex.0 as usize;
        skin.influences_of(i).ok_or_else(|| {
            self.out_of_range(SectionKind::INFLUENCE_STARTS, i, self.positions.len(), 4)
        })
    }

    /// The bones of a node and their rows; `None` without a skin.
    ///
    /// # Errors
    /// No such node, rows outside of the file.
    pub fn node_bones(&self, node: u32) -> Result<Option<NodeBones<'a>>, FormatError> {
        let Some(skin) = self.skin else {
            return Ok(None);
        };
        match skin.node_bones(node as usize) {
            Some(bones) => Ok(Some(bones)),
            None => Err(self.bones_of_node(node)),
        }
    }

    /// The error for the bones of a node that are not in the file.
    #[cold]
    pub(crate) fn bones_of_node(&self, node: u32) -> FormatError {
        let len = self.skin.map_or(0, |skin| skin.list_starts.len());
        self.out_of_range(SectionKind::BONE_LIST_STARTS, node as usize, len, 4)
    }

    /// The error for a bone in a node's list that is not in the file.
    #[cold]
    pub(crate) fn unknown_bone_of_node(&self, node: u32) -> FormatError {
        let starts = self.skin.map_or(&[][..], |skin| skin.list_starts);
        let first = starts.get(node as usize).copied().unwrap_or(0) as usize;
        let place = size_of::<BoneEntry>();
        FormatError {
            found: Datum::Text("another bone"),
            ..self.out_of_range(SectionKind::BONE_LISTS, first, self.bone_count(), place)
        }
    }

    /// The error for an influence on a vertex by a bone that is not in the file.
    #[cold]
    pub(crate) fn unknown_bone(&self, vertex: usize) -> FormatError {
        FormatError {
            found: Datum::Text("another bone"),
            ..self.out_of_range(SectionKind::INFLUENCE_STARTS, vertex, self.bone_count(), 4)
        }
    }
}
