//! What an instance keeps during a step: node spheres and deformed leaves, in the caller's memory.
//!
//! The paper updates a node when a step first visits it and reuses the result from then on (3.4). Here
//! the result goes into a [`StepCache`] of whatever size the caller grants: a slot that is taken by
//! another node only means that the node is evaluated again. Queries return the same with and
//! without.

use bdtree_format::{LANES, Row, TriangleRecord, row_count};

use crate::bound::{Spheres, WideSpheres, evaluate};
use crate::deform::RecentVertices;
use crate::epoch::Drift;
use crate::error::{FormatError, PoseError};
use crate::pose::Pose;
use crate::proxy::DepthLimit;
use crate::simd::{Lanes, Reference, prefetch};
use crate::view::Asset;

/// Triangles of a leaf that are kept together.
pub(crate) const CHUNK: usize = 4;

/// Memory for one node's spheres.
#[derive(Debug, Clone, Copy)]
pub struct NodeSlot {
    /// Step and node; 0 for none.
    tag: u64,
    spheres: Spheres,
}

impl NodeSlot {
    /// A slot that holds nothing, to fill memory with.
    pub const EMPTY: Self = Self {
        tag: 0,
        spheres: Spheres {
            centre: [[0.0; LANES]; 3],
            radius: [0.0; LANES],
        },
    };
}

/// Memory for up to four deformed triangles of a leaf.
#[derive(Debug, Clone, Copy)]
pub struct LeafSlot {
    /// Step and first triangle slot; 0 for none.
    tag: u64,
    pub(crate) leaf: LeafChunk,
}

impl LeafSlot {
    /// A slot that holds nothing, to fill memory with.
    pub const EMPTY: Self = Self {
        tag: 0,
        leaf: LeafChunk::EMPTY,
    };
}

/// Up to four triangles that stand together in a leaf, deformed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LeafChunk {
    /// Stored units: of each corner, of each coordinate, that of the four. Places beyond `len` repeat
    /// the first triangle.
    pub(crate) corners: [[[f32; CHUNK]; 3]; 3],
    pub(crate) ids: [u32; CHUNK],
    /// How many there are.
    pub(crate) len: u32,
}

impl LeafChunk {
    pub(crate) const EMPTY: Self = Self {
        corners: [[[0.0; CHUNK]; 3]; 3],
        ids: [0; CHUNK],
        len: 0,
    };

    /// The corners of triangle `k`, below 4 (stored units).
    #[inline(always)]
    pub(crate) fn stored(&self, k: usize) -> [[f32; 3]; 3] {
        let mut corners = [[0.0; 3]; 3];
        for i in 0..3 {
            for axis in 0..3 {
                corners[i][axis] = self.corners[i][axis][k & (CHUNK - 1)];
            }
        }
        corners
    }

    /// Deforms `records`, of which the first four are taken.
    #[inline(always)]
    pub(crate) fn deform<const LISTED: bool>(
        &mut self,
        asset: &Asset<'_>,
        pose: &Pose<'_>,
        records: &[TriangleRecord],
        recent: &mut RecentVertices,
    ) -> Result<(), FormatError> {
        let len = records.len().min(CHUNK);
        let mut stored = [[[0.0; 3]; 3]; CHUNK];
        for k in 0..CHUNK {
            // Beyond the end the first one again: a NaN there would be a lane that is never rejected.
            let Some(record) = records.get(if k < len { k } else { 0 }) else {
                break; // there is none at all
            };
            stored[k] = asset.stored_triangle::<LISTED>(pose, record, recent)?;
            self.ids[k] = record.id;
        }
        let [a, b, c, d] = &stored;
        for i in 0..3 {
            for axis in 0..3 {
                self.corners[i][axis] = [a[i][axis], b[i][axis], c[i][axis], d[i][axis]];
            }
        }
        self.len = len as u32;
        Ok(())
    }
}

/// What one instance keeps during a step, in memory of the caller's: slices, arrays or vectors of
/// [`NodeSlot`]s (136 bytes) and [`LeafSlot`]s (176 bytes), of any length. [`Asset::node_count`] node
/// slots keep every node, half as many leaf slots as [`Asset::triangle_count`] every leaf.
///
/// ```
/// # use bdtree_runtime::{StepCache, NodeSlot, LeafSlot};
/// let cache = StepCache::new([NodeSlot::EMPTY; 64], [LeafSlot::EMPTY; 64]);
/// ```
#[derive(Debug, Clone)]
pub struct StepCache<N, L> {
    nodes: N,
    leaves: L,
    /// The step that leaves were deformed in, above 0 and below [`STEP_END`].
    step: u32,
    /// The step that nodes were evaluated in, and what identifies its pose.
    epoch: u32,
    reference: Option<u64>,
}

impl<N: AsMut<[NodeSlot]>, L: AsMut<[LeafSlot]>> StepCache<N, L> {
    /// A cache over this memory, emptied.
    pub fn new(mut nodes: N, mut leaves: L) -> Self {
        clear(nodes.as_mut(), leaves.as_mut());
        Self {
            nodes,
            leaves,
            step: 0,
            epoch: 0,
            reference: None,
        }
    }

    /// Forgets everything, in constant time, and serves `pose` from now on.
    pub fn start<'s>(&'s mut self, pose: &'s Pose<'s>) -> CachedPose<'s> {
        self.next_step();
        self.epoch = self.step;
        self.reference = Some(pose.fingerprint());
        self.serve(pose, None)
    }

    /// Serves `pose` with the node spheres of the last [`StepCache::start`], whose pose was `reference`:
    /// they grow by δR ‖q − q₀‖, one multiply-add per sphere instead of a node update (paper, eq. 8);
    /// nodes first visited now are evaluated at `reference` too, so that errors do not add up over
    /// steps. Leaves are deformed anew. Spheres are looser than evaluated ones: start again
    /// when [`CachedPose::growth`] is no longer small beside the radius of a leaf.
    ///
    /// # Errors
    /// [`PoseError::Reference`] if `reference` is not the pose of the last start, or `pose` one of
    /// another asset.
    pub fn follow<'s>(
        &'s mut self,
        asset: &Asset<'_>,
        reference: &'s Pose<'s>,
        pose: &'s Pose<'s>,
    ) -> Result<CachedPose<'s>, PoseError> {
        if self.reference != Some(reference.fingerprint()) {
            return Err(PoseError::Reference);
        }
        let drift = Drift::new(asset, reference, pose).ok_or(PoseError::Reference)?;
        let epoch = self.epoch;
        self.next_step();
        if self.epoch != epoch {
            return Ok(self.start(pose)); // the count began anew and everything is forgotten
        }
        Ok(self.serve(pose, Some((reference, drift))))
    }

    /// Counts on; at the end of the count everything is forgotten.
    fn next_step(&mut self) {
        self.step += 1;
        if self.step == STEP_END {
            clear(self.nodes.as_mut(), self.leaves.as_mut());
            (self.step, self.epoch, self.reference) = (1, 0, None);
        }
    }

    fn serve<'s>(
        &'s mut self,
        pose: &'s Pose<'s>,
        drift: Option<(&'s Pose<'s>, Drift)>,
    ) -> CachedPose<'s> {
        CachedPose {
            pose,
            drift,
            nodes: self.nodes.as_mut(),
            leaves: self.leaves.as_mut(),
            step: self.step,
            epoch: self.epoch,
        }
    }
}

fn clear(nodes: &mut [NodeSlot], leaves: &mut [LeafSlot]) {
    for slot in nodes {
        slot.tag = 0;
    }
    for slot in leaves {
        slot.tag = 0;
    }
}

/// A pose together with what queries on it have computed so far; made by [`StepCache::start`] or
/// [`StepCache::follow`]. Queries take `&mut` of it in place of `&Pose`.
#[derive(Debug)]
pub struct CachedPose<'s> {
    pose: &'s Pose<'s>,
    /// Where nodes are evaluated, if not at `pose`.
    drift: Option<(&'s Pose<'s>, Drift)>,
    nodes: &'s mut [NodeSlot],
    leaves: &'s mut [LeafSlot],
    step: u32,
    epoch: u32,
}

impl<'s> CachedPose<'s> {
    /// The pose.
    pub fn pose(&self) -> &'s Pose<'s> {
        self.pose
    }

    /// What following a reference has added to the radii of the root's lanes, at most (world units):
    /// about as much as to all others, since δR hardly shrinks with depth.
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn growth(&self, asset: &Asset<'_>) -> Result<f64, FormatError> {
        let Some((_, drift)) = &self.drift else {
            return Ok(0.0);
        };
        let added = drift.added(asset.node_rows(asset.node(0)?)?.steps);
        let largest = added.into_iter().fold(0.0_f32, f32::max);
        Ok(f64::from(largest) * self.pose.frame.world_per_stored())
    }
}

/// A pose to query, with what a step keeps or without: queries take anything that becomes one.
#[derive(Debug)]
pub struct Posed<'s> {
    pub(crate) pose: &'s Pose<'s>,
    drift: Option<(&'s Pose<'s>, Drift)>,
    nodes: &'s mut [NodeSlot],
    leaves: &'s mut [LeafSlot],
    step: u32,
    epoch: u32,
    pub(crate) limit: Option<DepthLimit<'s>>,
}

impl<'s> From<&'s Pose<'_>> for Posed<'s> {
    fn from(pose: &'s Pose<'_>) -> Self {
        Self {
            pose,
            drift: None,
            nodes: &mut [],
            leaves: &mut [],
            step: 1,
            epoch: 1,
            limit: None,
        }
    }
}

impl<'s> From<&'s mut CachedPose<'_>> for Posed<'s> {
    fn from(cached: &'s mut CachedPose<'_>) -> Self {
        Self {
            pose: cached.pose,
            drift: cached.drift,
            nodes: cached.nodes,
            leaves: cached.leaves,
            step: cached.step,
            epoch: cached.epoch,
            limit: None,
        }
    }
}

/// What one query keeps for itself where the caller grants no [`StepCache`].
#[derive(Default)]
pub(crate) struct OwnCache {
    nodes: Option<[NodeSlot; 32]>,
    leaves: Option<[LeafSlot; 16]>,
}

impl<'s> Posed<'s> {
    /// The same for a shorter time.
    pub(crate) fn shorter<'t>(self) -> Posed<'t>
    where
        's: 't,
    {
        Posed {
            pose: self.pose,
            drift: self.drift,
            nodes: self.nodes,
            leaves: self.leaves,
            step: self.step,
            epoch: self.epoch,
            // Spelled out, since nothing that borrows a sink may be shortened as a whole.
            limit: self.limit.map(|limit| DepthLimit {
                level: limit.level,
                sink: limit.sink,
            }),
        }
    }

    /// The same, with room for all nodes of `asset` or as many as `spare` holds, which must be empty
    /// slots.
    pub(crate) fn at_least<'t>(self, asset: &Asset<'_>, spare: &'t mut [NodeSlot]) -> Posed<'t>
    where
        's: 't,
    {
        let mut posed = self.shorter();
        if posed.nodes.len() < spare.len().min(asset.node_count()) {
            posed.nodes = spare;
        }
        posed
    }

    /// The same, with `own` to keep things in if there is nothing else.
    pub(crate) fn or_keep<'t>(self, own: &'t mut OwnCache) -> Posed<'t>
    where
        's: 't,
    {
        let mut posed = self.shorter();
        if posed.nodes.is_empty() && posed.leaves.is_empty() {
            posed.nodes = own.nodes.insert([NodeSlot::EMPTY; 32]);
            posed.leaves = own.leaves.insert([LeafSlot::EMPTY; 16]);
        }
        posed
    }

    /// The same with another limit, which may live shorter.
    pub(crate) fn limited<'t>(self, limit: DepthLimit<'t>) -> Posed<'t>
    where
        's: 't,
    {
        let mut posed = Self {
            limit: None,
            ..self
        }
        .shorter();
        posed.limit = Some(limit);
        posed
    }
}

impl Posed<'_> {
    /// The same, for one of several queries.
    pub(crate) fn again(&mut self) -> Posed<'_> {
        Posed {
            pose: self.pose,
            drift: self.drift,
            nodes: self.nodes,
            leaves: self.leaves,
            step: self.step,
            epoch: self.epoch,
            limit: match &mut self.limit {
                Some(limit) => Some(DepthLimit {
                    level: limit.level,
                    sink: &mut *limit.sink,
                }),
                None => None,
            },
        }
    }

    /// Whether leaves are kept.
    #[inline(always)]
    pub(crate) fn keeps_leaves(&self) -> bool {
        !self.leaves.is_empty()
    }

    /// Whether node `index` is kept.
    #[inline(always)]
    pub(crate) fn keeps_node(&self, index: u32) -> bool {
        let slot = self.nodes.get(place(index as usize, self.nodes.len()));
        slot.is_some_and(|slot| slot.tag == tag(self.epoch, index))
    }

    /// Whether the triangles from `start` on are kept.
    #[inline(always)]
    pub(crate) fn keeps_leaf(&self, start: u32) -> bool {
        let slot = self.leaves.get(leaf_place(start, self.leaves.len()));
        slot.is_some_and(|slot| slot.tag == tag(self.step, start))
    }

    /// Asks for a node's record and, if it is not kept, the beginning of its rows; reading on is the
    /// processor's own habit. Where the rows are follows from the index if all modes act on all
    /// nodes, which is the usual case; otherwise the record would have to be waited for.
    #[inline(always)]
    pub(crate) fn prefetch_node(&self, asset: &Asset<'_>, index: u32) {
        /// Of 64 bytes: two rows each, or four of 16 bits.
        const LINES: usize = 8;
        let kept = self.keeps_node(index);
        let index = index as usize;
        let Some(node) = asset.nodes.get(index) else {
            return; // the visit says so
        };
        prefetch(node);
        let stride = row_count(asset.modes.len());
        if !kept && asset.nodes.len().checked_mul(stride) == Some(asset.rows.len()) {
            let start = index * stride;
            if let Some(rows) = asset.rows.get(start..start + 2 * LINES) {
                let (lines, _) = rows.as_chunks::<2>();
                for line in lines {
                    prefetch(line);
                }
            }
        }
    }

    /// The spheres of node `index`, which is `node`, and whether they had to be evaluated.
    #[inline(always)]
    pub(crate) fn spheres<L: Lanes>(
        &mut self,
        asset: &Asset<'_>,
        index: u32,
    ) -> Result<(WideSpheres<L>, bool), FormatError> {
        let Some((reference, drift)) = self.drift else {
            return self.spheres_at::<L>(asset, index, self.pose);
        };
        let (spheres, evaluated) = self.spheres_at::<L>(asset, index, reference)?;
        let rows = asset.node_rows(asset.node(index)?)?;
        Ok((spheres.grown(drift.wide(rows.steps)), evaluated))
    }

    /// [`Posed::spheres`] at the pose where nodes are evaluated.
    #[inline(always)]
    fn spheres_at<L: Lanes>(
        &mut self,
        asset: &Asset<'_>,
        index: u32,
        pose: &Pose<'_>,
    ) -> Result<(WideSpheres<L>, bool), FormatError> {
        let tag = tag(self.epoch, index);
        let place = place(index as usize, self.nodes.len());
        if let Some(slot) = self.nodes.get(place)
            && slot.tag == tag
        {
            return Ok((WideSpheres::load(&slot.spheres), false));
        }
        let node = asset.node(index)?;
        let (rows, modes) = (asset.node_rows(node)?, asset.node_modes(node)?);
        // Spelled out: behind a function that takes `evaluate` it would not be compiled with the
        // instruction set of the caller.
        let Some(spheres) = evaluate::<L>(&rows, modes, &pose.bound()) else {
            return Err(asset.unknown_mode(node.mode_list_start));
        };
        if let Some(slot) = self.nodes.get_mut(place) {
            slot.tag = tag;
            slot.spheres = spheres.store();
        }
        Ok((spheres, true))
    }

    /// [`Posed::spheres`] of the reference kernel, which are kept apart from others.
    pub(crate) fn reference_spheres(
        &mut self,
        asset: &Asset<'_>,
        index: u32,
    ) -> Result<(Spheres, bool), FormatError> {
        let tag = tag(self.epoch | STEP_END, index);
        let place = place(index as usize, self.nodes.len());
        let node = asset.node(index)?;
        let rows = asset.node_rows(node)?;
        let kept = self.nodes.get(place).filter(|slot| slot.tag == tag);
        let (spheres, evaluated) = match kept {
            Some(slot) => (slot.spheres, false),
            None => {
                let pose = self.drift.map_or(self.pose, |(reference, _)| reference);
                let modes = asset.node_modes(node)?;
                let Some(spheres) = evaluate::<Reference>(&rows, modes, &pose.bound()) else {
                    return Err(asset.unknown_mode(node.mode_list_start));
                };
                (spheres.store(), true)
            }
        };
        if evaluated && let Some(slot) = self.nodes.get_mut(place) {
            *slot = NodeSlot { tag, spheres };
        }
        let Some((_, drift)) = self.drift else {
            return Ok((spheres, evaluated));
        };
        let grown = WideSpheres::<Reference>::load(&spheres).grown(drift.wide(rows.steps));
        Ok((grown.store(), evaluated))
    }

    /// The first four of `records`, the triangles from `start` on, deformed: kept, or made in `spare`.
    #[inline(always)]
    pub(crate) fn leaf<'l, const LISTED: bool>(
        &'l mut self,
        asset: &Asset<'_>,
        start: u32,
        records: &[TriangleRecord],
        recent: &mut RecentVertices,
        spare: &'l mut LeafChunk,
    ) -> Result<&'l LeafChunk, FormatError> {
        let tag = tag(self.step, start);
        let len = records.len().min(CHUNK) as u32;
        let place = leaf_place(start, self.leaves.len());
        let Some(slot) = self.leaves.get_mut(place) else {
            spare.deform::<LISTED>(asset, self.pose, records, recent)?;
            return Ok(spare);
        };
        // In a corrupt file one slot may begin leaves of several lengths.
        if slot.tag != tag || slot.leaf.len != len {
            slot.tag = 0; // until it is whole
            slot.leaf
                .deform::<LISTED>(asset, self.pose, records, recent)?;
            slot.tag = tag;
        }
        Ok(&slot.leaf)
    }
}

/// Steps are below this bit, which marks what the reference kernel computed.
const STEP_END: u32 = 1 << 31;

/// Where key `key` is kept among `len` slots.
#[inline(always)]
fn place(key: usize, len: usize) -> usize {
    if key < len || len == 0 {
        key
    } else {
        // The low bits, as many as there are slots for.
        key & (usize::MAX >> len.leading_zeros() >> 1)
    }
}

/// Where the triangles from `start` on are kept among `len` slots: leaves that follow each other
/// begin about four triangles apart.
#[inline(always)]
fn leaf_place(start: u32, len: usize) -> usize {
    place(start as usize / 2, len)
}

/// What a slot's tag is when it holds `key` of `step`.
#[inline(always)]
fn tag(step: u32, key: u32) -> u64 {
    u64::from(step) << 32 | u64::from(key)
}

/// What the documentation of [`StepCache`] says.
const _: () = assert!(size_of::<NodeSlot>() == 8 + 4 * size_of::<Row>());
const _: () = assert!(size_of::<LeafSlot>() == 176);
