//! A pose whose bounds are exact: what pays where a step asks much.
//!
//! A walk of the tree costs what it visits, each node some ten nanoseconds and each leaf the deformation of its vertices.
//! Where a step asks thousands of rays, most of the tree is visited anyway, many times. [`RefinedPose::prepare`] then does
//! once what every visit would do: it deforms all vertices, puts the corners of each leaf side by side, and gives all nodes
//! boxes of what lies below them, which are much tighter than spheres that hold for any q. Where they come to one place,
//! a [`StepCache`](crate::StepCache) does the same for the branches there ([`branches`]). Answers keep their bits, since
//! triangles are the same.

mod branch;
mod branches;
mod by_itself;
mod prepare;
mod record;
mod sweep;
mod tops;
mod vertices;

pub(crate) use branches::Branches;
pub(crate) use by_itself::{Bounds, Refine, Refining, refining_cost};
pub use prepare::PreparePart;
use prepare::Slots;
pub(crate) use record::{Boxes, RefinedLeaf, RefinedNode};

use bdtree_format::TriangleRecord;

use crate::bound::WideSpheres;
use crate::cache::CHUNK;
use crate::error::{FormatError, QueryError};
use crate::pose::Pose;
use crate::rounding::{BOX_CENTER, round_up};
use crate::simd::{Compact, Lanes};
use crate::view::Asset;
use crate::workspace::Memory;
use vertices::Deformed;

/// Exact boxes of all nodes and the deformed corners of all triangles of one pose; made by [`RefinedPose::prepare`] and used by
/// [`Query::refined`](crate::Query::refined). One serves any number of assets and poses, one after the other, and once it is
/// prepared any number of threads at a time.
///
/// It pays from some 300 rays a step on for 36 000 triangles and from some 3000 on for 480 000: preparing takes 8 to 12 ns per
/// triangle, and then a ray, a ball or a nearest point takes 0.2 to 0.5 of its time (`docs/measured/benchmarks.md`, refined
/// poses). Pairs gain little. [`StepCache::refining`](crate::StepCache::refining) decides by itself, and refines parts alone where
/// a step asks about these.
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # use bdtree_runtime::{Asset, Ray, RefinedPose, Transform, Workspace, include_bdt};
/// # let asset = Asset::open(include_bdt!("../../../fixtures/golden/sphere.bdt"))?;
/// # let (q, mut memory) = (vec![0.0; asset.mode_count()], vec![0.0; asset.pose_len()]);
/// # let pose = asset.pose(&q, Transform::IDENTITY, &mut memory)?;
/// let mut refined = RefinedPose::new();
/// refined.prepare(&pose)?; // in each step, where it asks some hundreds of rays or more
/// let mut workspace = Workspace::new();
/// let mut query = pose.query(&mut workspace).refined(&refined);
/// let hit = query.cast_ray(&Ray::new([0.0, 5.0, 0.0], [0.0, -1.0, 0.0]))?;
/// # assert!(hit.is_some());
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct RefinedPose<'m> {
    memory: Memory<'m>,
    counts: Counts,
    triangles: usize,
    /// What is added to radii of spheres around boxes.
    added: f32,
    /// What identifies the pose; `None` before it is whole.
    fingerprint: Option<u64>,
}

/// How much there is of what memory holds.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Counts {
    nodes: usize,
    /// Of up to four triangles of a leaf.
    leaves: usize,
    vertices: usize,
}

impl Counts {
    /// # Errors
    /// Leaves that hold more triangles than there are.
    fn of(asset: &Asset<'_>) -> Result<Self, FormatError> {
        let mut left = asset.triangle_count() as u64;
        let mut leaves = 0;
        for node in asset.nodes() {
            let triangles = node.leaf_counts.iter().map(|count| u64::from(*count)).sum();
            left = asset.fewer(left, triangles)?;
            leaves += record::groups_in(&node.leaf_counts);
        }
        Ok(Self {
            nodes: asset.node_count(),
            leaves: leaves as usize,
            vertices: asset.vertex_count(),
        })
    }

    fn slots(self) -> [usize; 3] {
        [self.nodes, self.leaves, self.vertices]
    }

    fn bytes(self) -> usize {
        let nodes = size_of::<RefinedNode>().saturating_mul(self.nodes);
        let leaves = size_of::<RefinedLeaf>().saturating_mul(self.leaves);
        let vertices = size_of::<[f32; 4]>().saturating_mul(self.vertices);
        nodes.saturating_add(leaves).saturating_add(vertices)
    }
}

#[cfg(feature = "alloc")]
impl RefinedPose<'static> {
    /// One that holds nothing yet, and grows to what the largest asset so far has needed.
    pub const fn new() -> Self {
        Self {
            memory: Memory::Owned(alloc::vec::Vec::new()),
            counts: Counts {
                nodes: 0,
                leaves: 0,
                vertices: 0,
            },
            triangles: 0,
            added: 0.0,
            fingerprint: None,
        }
    }
}

#[cfg(feature = "alloc")]
impl Default for RefinedPose<'static> {
    fn default() -> Self {
        Self::new()
    }
}

impl<'m> RefinedPose<'m> {
    /// One in these bytes, at any address; what they hold does not matter. [`RefinedPose::bytes_for`] tells how many.
    pub fn in_bytes(memory: &'m mut [u8]) -> Self {
        Self {
            memory: Memory::of_bytes(memory),
            counts: Counts::default(),
            triangles: 0,
            added: 0.0,
            fingerprint: None,
        }
    }

    /// Bytes that suffice for poses of an asset: some 65 per triangle.
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn bytes_for(asset: &Asset<'_>) -> Result<usize, FormatError> {
        Ok(Counts::of(asset)?.bytes() + align_of::<RefinedNode>())
    }

    /// Refines this pose, wherever it is placed; what it held before is forgotten.
    ///
    /// # Errors
    /// [`QueryError::Memory`] where there are too few bytes; a corrupt asset. It then holds nothing.
    pub fn prepare(&mut self, pose: &Pose<'_>) -> Result<(), QueryError> {
        self.prepare_in_parts(pose, 1, |parts| parts.iter_mut().for_each(PreparePart::run))
    }

    /// [`RefinedPose::prepare`], with the same bytes, split into about so many parts, at most 33, that may run at the same time.
    /// `run` is called twice, and must have every part run before it returns, on threads of the caller's:
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # use bdtree_runtime::{Asset, RefinedPose, Transform, include_bdt};
    /// # let asset = Asset::open(include_bdt!("../../../fixtures/golden/sphere.bdt"))?;
    /// # let (q, mut memory) = (vec![0.0; asset.mode_count()], vec![0.0; asset.pose_len()]);
    /// # let pose = asset.pose(&q, Transform::IDENTITY, &mut memory)?;
    /// # let mut refined = RefinedPose::new();
    /// refined.prepare_in_parts(&pose, 4, |parts| {
    ///     std::thread::scope(|scope| {
    ///         for part in parts {
    ///             scope.spawn(|| part.run());
    ///         }
    ///     })
    /// })?;
    /// # assert!(refined.serves(&pose));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// Those of [`RefinedPose::prepare`]; a part that was not run.
    pub fn prepare_in_parts(
        &mut self,
        pose: &Pose<'_>,
        parts: usize,
        mut run: impl FnMut(&mut [PreparePart<'_>]),
    ) -> Result<(), QueryError> {
        self.fingerprint = None;
        self.counts = Counts::of(pose.asset)?;
        self.triangles = pose.asset.triangle_count();
        let (nodes, leaves, vertices) = self.memory.three_slots(self.counts.slots())?;
        let slots = Slots {
            nodes,
            leaves,
            vertices,
        };
        prepare::prepare(pose, slots, parts, &mut run)?;
        self.added = round_up(BOX_CENTER * (pose.reach + f64::from(pose.slack)));
        self.fingerprint = Some(pose.fingerprint());
        Ok(())
    }

    /// Whether it holds this pose, wherever that is placed.
    pub fn serves(&self, pose: &Pose<'_>) -> bool {
        self.fingerprint == Some(pose.fingerprint())
    }

    /// What queries see of it.
    pub(crate) fn view(&self) -> Refined<'_> {
        let (nodes, leaves, vertices) = self
            .memory
            .three_to_read(self.counts.slots())
            .unwrap_or_default();
        Refined {
            nodes,
            leaves,
            vertices,
            added: self.added,
        }
    }
}

/// A refined pose as a walk sees it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Refined<'r> {
    pub(crate) nodes: &'r [RefinedNode],
    pub(crate) leaves: &'r [RefinedLeaf],
    /// Deformed (stored units); the fourth number is not used.
    vertices: &'r [[f32; 4]],
    /// Of [`Boxes::spheres`].
    pub(crate) added: f32,
}

impl Refined<'_> {
    /// Puts the spheres of a node into `out`.
    ///
    /// # Errors
    /// A node that the asset does not have.
    #[inline(always)]
    pub(crate) fn spheres<L: Lanes>(
        &self,
        asset: &Asset<'_>,
        index: u32,
        out: &mut WideSpheres<L>,
    ) -> Result<(), FormatError> {
        match self.nodes.get(index as usize) {
            Some(node) => *out = node.boxes.spheres(self.added),
            None => _ = asset.node(index)?, // says that it does not exist
        }
        Ok(())
    }

    /// Puts the corners of four triangles side by side.
    ///
    /// # Errors
    /// A vertex that the asset does not have.
    #[inline(always)]
    pub(crate) fn corners(
        &self,
        asset: &Asset<'_>,
        four: [&TriangleRecord; 4],
        out: &mut [[[f32; CHUNK]; 3]; 3],
    ) -> Result<(), FormatError> {
        self.vertices
            .corners::<Compact>(asset, four, |i, axis, of| {
                out[i][axis] = of.store();
            })
    }
}
