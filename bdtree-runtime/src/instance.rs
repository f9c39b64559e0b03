//! One deforming body with everything that it needs.

use alloc::vec::Vec;
use core::sync::atomic::{AtomicBool, Ordering};

use crate::bones::{BoneMatrices, BoneSource, maps_in};
use crate::cache::{CacheSize, StepCache};
use crate::error::{PoseError, QueryError};
use crate::joint::JointMatrix;
use crate::model::Model;
use crate::motion::Motion;
use crate::pose::{Pose, PoseNumbers};
use crate::query::{Aabb, BoundingSphere, PairQuery, Query};
use crate::refined::RefinedPose;
use crate::transform::Transform;
use crate::workspace::Workspace;

/// The size of an instance's step cache unless another is given: 14 KB.
const CACHE: CacheSize = CacheSize {
    nodes: 64,
    leaves: 32,
};

/// One deforming body: a model, q, a placement, a step cache, its accumulated motion, and user data with collision
/// groups. `Send` and `Sync`; owns all its memory and allocates when it is made, not later. Its motion, which only
/// [`PairFront`](crate::PairFront)s need, is kept from the first [`Instance::against`] or [`Instance::pose`] on.
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use bdtree_runtime::{Ball, Contact, Instance, Model, Transform, Workspace};
///
/// # let bytes = bdtree_runtime::include_bdt!("../../fixtures/golden/sphere.bdt");
/// let model = Model::from_static(bytes)?;
/// let mut body = Instance::new(&model)?;
/// let mut workspace = Workspace::new();
/// let mut q = vec![0.0; model.asset().mode_count()];
/// q[0] = 0.05;
/// body.set_pose(&q, Transform::from_translation([0.0, 2.0, 0.0]))?;
/// let mut contacts: Vec<Contact> = Vec::new();
/// body.query(&mut workspace).contacts(Ball::new([0.0, 2.0, 0.0], 0.5), &mut contacts)?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Instance {
    model: Model,
    placement: Transform,
    /// Of the pose, and of the one to come: they change places when it is made.
    memory: Vec<f32>,
    spare: Vec<f32>,
    numbers: PoseNumbers,
    /// Advanced where somebody asks for it, else begun anew at each pose: rays, shapes and boxes need none.
    motion: Motion,
    is_motion_wanted: AtomicBool,
    cache: StepCache<'static>,
    /// Any number of the program's own, for example an entity id; default 0.
    pub user_data: u64,
    /// Collision group bits; default `u32::MAX`.
    pub collision_group: u32,
    /// Mask of the groups it collides with; default `u32::MAX`.
    pub collision_mask: u32,
}

impl Instance {
    /// An instance with q = 0 at the identity placement, with a step cache of 64 nodes and 32 leaves (14 KB).
    ///
    /// # Errors
    /// None for the models that `bdtree-build` writes: 0 is within all limits.
    pub fn new(model: &Model) -> Result<Self, PoseError> {
        Self::with_cache(model, CACHE)
    }

    /// The same with a step cache of another size: [`CacheSize::NONE`] for bodies that are queried once per step.
    ///
    /// # Errors
    /// Those of [`Instance::new`].
    pub fn with_cache(model: &Model, size: CacheSize) -> Result<Self, PoseError> {
        let asset = model.asset();
        let q = alloc::vec![0.0; asset.mode_count()];
        let mut memory = alloc::vec![0.0; asset.pose_len()];
        let spare = memory.clone();
        let mut cache = StepCache::new(size);
        let pose = asset.pose(&q, Transform::IDENTITY, &mut memory)?;
        cache.start(&pose);
        let (numbers, motion) = (pose.numbers(), Motion::of_instance(&pose));
        Ok(Self {
            model: model.clone(),
            placement: Transform::IDENTITY,
            memory,
            spare,
            numbers,
            motion,
            is_motion_wanted: AtomicBool::new(false),
            cache,
            user_data: 0,
            collision_group: u32::MAX,
            collision_mask: u32::MAX,
        })
    }

    /// Lets queries that use the step cache refine the pose, or parts of it, by themselves where a step asks so much that it pays,
    /// or not any more: [`StepCache::refining`], in memory that grows to some 65 bytes per triangle. Answers stay the same.
    pub fn set_refining(&mut self, on: bool) {
        self.cache.set_refining(on.then(RefinedPose::new));
    }

    /// Whether the whole pose is refined now: [`StepCache::is_refined`].
    pub fn is_refined(&self) -> bool {
        self.cache.is_refined()
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// q as queries use it.
    pub fn q(&self) -> &[f32] {
        &self.memory[..self.model.asset().mode_count()]
    }

    /// The placement, as it was given.
    pub fn placement(&self) -> Transform {
        self.placement
    }

    /// Sets q, one number per mode, the weights of the fields; placement and bones stay. An error leaves the instance as it
    /// was.
    ///
    /// Of a vibration mode, `q_j = 1` moves the farthest vertex by one mesh unit; of a morph target, 1 is the whole target;
    /// of principal components, 1 has no fixed meaning: the values that occur are those of the baked frames, which
    /// [`Asset::sample`](crate::Asset::sample) gives at a time.
    /// [`Asset::modes`](crate::Asset::modes) has what is typical for each mode (`q_range`), and beyond what it is refused
    /// (`q_limit`).
    ///
    /// # Errors
    /// q of another length than the asset has modes, NaN, infinite or over the asset's hard limit.
    pub fn set_q(&mut self, q: &[f32]) -> Result<(), PoseError> {
        self.set_pose(q, self.placement)
    }

    /// Moves its bones: one matrix per joint of the asset, from the joint's space to model space, *without* inverse bind
    /// matrices. Model space is what the placement maps to the world ([`Transform::joint_in_model`] makes matrices of
    /// world space relative to it). q and placement stay; an error leaves it as it was.
    ///
    /// # Errors
    /// An asset without a skin, another number of matrices than [`Asset::joint_count`](crate::Asset::joint_count), one
    /// with an element that is not finite or that moves vertices beyond 2⁶⁰ stored units.
    pub fn set_joints(&mut self, joints: &[JointMatrix]) -> Result<(), PoseError> {
        self.change(
            None,
            Bones::New(BoneMatrices::Joints(joints)),
            self.placement,
        )
    }

    /// Moves its bones: one matrix per bone of the asset, joint matrix times inverse bind matrix (that of
    /// [`Asset::bones`](crate::Asset::bones), which a bake may have brought to another bind space), as skinning shaders
    /// take them. q and placement stay; an error leaves it as it was.
    ///
    /// # Errors
    /// As for [`Instance::set_joints`], with [`Asset::bone_count`](crate::Asset::bone_count).
    pub fn set_skinning_matrices(&mut self, matrices: &[JointMatrix]) -> Result<(), PoseError> {
        let bones = Bones::New(BoneMatrices::Skinning(matrices));
        self.change(None, bones, self.placement)
    }

    /// Deforms it, moves its bones and places it, which takes less time than one after the other. An error leaves it as it
    /// was.
    ///
    /// # Errors
    /// Those of [`Instance::set_q`], [`Instance::set_joints`] and [`Instance::set_placement`].
    pub fn set_pose_with_bones(
        &mut self,
        q: &[f32],
        bones: BoneMatrices<'_>,
        at: impl Into<Transform>,
    ) -> Result<(), PoseError> {
        self.change(Some(q), Bones::New(bones), at.into())
    }

    /// Sets the placement. An error leaves the instance as it was. The step cache stays valid, since it does not depend
    /// on the placement.
    ///
    /// # Errors
    /// A placement that [`Transform`] does not allow.
    pub fn set_placement(&mut self, at: impl Into<Transform>) -> Result<(), PoseError> {
        let at = at.into();
        let before = self.current();
        let pose = before.placed(at)?;
        let motion = moved(self.motion, &self.is_motion_wanted, || before, &pose);
        let numbers = pose.numbers();
        (self.numbers, self.motion, self.placement) = (numbers, motion, at);
        Ok(())
    }

    /// Sets q and the placement, faster than one after the other. An error leaves the instance as it was.
    ///
    /// # Errors
    /// Those of [`Instance::set_q`] and [`Instance::set_placement`].
    pub fn set_pose(&mut self, q: &[f32], at: impl Into<Transform>) -> Result<(), PoseError> {
        self.change(Some(q), Bones::Same, at.into())
    }

    /// What is `None` or [`Bones::Same`] stays.
    fn change(
        &mut self,
        q: Option<&[f32]>,
        bones: Bones<'_>,
        at: Transform,
    ) -> Result<(), PoseError> {
        let asset = self.model.asset();
        let q = q.unwrap_or(&self.memory[..asset.mode_count()]);
        let bones = match bones {
            Bones::New(matrices) => BoneSource::Matrices(matrices),
            Bones::Same => BoneSource::Maps(maps_in(asset, &self.memory)),
        };
        let pose = asset.pose_within(q, bones, at, 0.0, &mut self.spare)?;
        let before = || Pose::again(asset, &self.numbers, &self.memory, self.motion);
        let motion = moved(self.motion, &self.is_motion_wanted, before, &pose);
        self.cache.start(&pose);
        (self.numbers, self.motion, self.placement) = (pose.numbers(), motion, at);
        core::mem::swap(&mut self.memory, &mut self.spare);
        Ok(())
    }

    /// The current pose. It can be queried from several threads at once; these queries do not use the step cache.
    #[inline]
    pub fn pose(&self) -> Pose<'_> {
        // Written once, so that threads that ask do not take the line from each other.
        if !self.is_motion_wanted.load(Ordering::Relaxed) {
            self.is_motion_wanted.store(true, Ordering::Relaxed);
        }
        self.current()
    }

    /// [`Instance::pose`] without its motion, which then need not be kept: for those who use no
    /// [`PairFront`](crate::PairFront).
    #[inline]
    pub fn snapshot(&self) -> Pose<'_> {
        let mut pose = self.current();
        pose.motion = None;
        pose
    }

    /// The pose with its motion as far as that is kept.
    #[inline]
    fn current(&self) -> Pose<'_> {
        Pose::again(self.model.asset(), &self.numbers, &self.memory, self.motion)
    }

    /// Starts a query that uses the step cache; needs `&mut self`.
    #[inline]
    pub fn query<'q, 'm>(&'q mut self, workspace: &'q mut Workspace<'m>) -> Query<'q, 'm> {
        let (pose, cache) = self.parts();
        Query::with_cache(pose, cache, workspace)
    }

    /// Starts a query of this body and another that uses the step caches of both. `get_disjoint_mut` borrows two
    /// instances of a slice.
    #[inline]
    pub fn against<'q, 'm, 'f>(
        &'q mut self,
        other: &'q mut Self,
        workspace: &'q mut Workspace<'m>,
    ) -> PairQuery<'q, 'm, 'f> {
        *self.is_motion_wanted.get_mut() = true;
        *other.is_motion_wanted.get_mut() = true;
        PairQuery::with_caches([self.parts(), other.parts()], workspace)
    }

    /// Whether the step cache holds the spheres of a node: [`StepCache::keeps`].
    pub fn keeps(&mut self, node: u32) -> bool {
        self.cache.keeps(node)
    }

    fn parts(&mut self) -> (Pose<'_>, &mut StepCache<'static>) {
        let asset = self.model.asset();
        let pose = Pose::again(asset, &self.numbers, &self.memory, self.motion);
        (pose, &mut self.cache)
    }

    /// A box that holds the deformed body in the world: [`Pose::aabb`].
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn aabb(&self) -> Result<Aabb, QueryError> {
        self.current().aabb()
    }

    /// A sphere that holds the deformed body in the world: [`Pose::bounding_sphere`].
    ///
    /// # Errors
    /// A corrupt asset.
    pub fn bounding_sphere(&self) -> Result<BoundingSphere, QueryError> {
        self.current().bounding_sphere()
    }

    /// True if each one's `collision_group` shares a bit with the other's `collision_mask`.
    pub fn may_meet(&self, other: &Self) -> bool {
        self.collision_group & other.collision_mask != 0
            && other.collision_group & self.collision_mask != 0
    }
}

/// The bones of a step.
enum Bones<'b> {
    Same,
    New(BoneMatrices<'b>),
}

/// The motion after a step.
fn moved<'p>(
    mut motion: Motion,
    is_wanted: &AtomicBool,
    from: impl FnOnce() -> Pose<'p>,
    to: &Pose<'_>,
) -> Motion {
    if !is_wanted.load(Ordering::Relaxed) {
        motion.forget();
        return motion;
    }
    let from = from();
    motion.begin(&from);
    match motion.step(&from, to) {
        Ok(()) => motion,
        // A corrupt root: fronts begin anew, and queries say so.
        Err(_) => Motion::of_instance(to),
    }
}

/// A body may be asked by any thread.
const _: () = {
    const fn is_shareable<T: Send + Sync>() {}
    is_shareable::<Instance>();
};
