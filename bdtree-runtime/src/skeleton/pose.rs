//! A pose of a skeleton with the memory that it takes.

use alloc::vec::Vec;

use super::{LocalTransform, Skeleton, SkeletonError, blend, blend_q};
use crate::joint::{self, JointMatrix};
use crate::model::Model;
use crate::view::Asset;

/// Plays and mixes the clips of a model: local transforms, q and the matrices of joints. Owns all its memory and
/// allocates when it is made, not later.
///
/// ```no_run
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use bdtree_runtime::{Model, SkeletonPose};
///
/// # let bytes = std::fs::read("walker.bdt")?;
/// let model = Model::from_bytes(&bytes)?;
/// let mut pose = SkeletonPose::new(&model)?;
/// pose.play(0, 1.25)?; // a clip alone
/// pose.blend_with(1, 0.4, 0.3)?; // and three tenths of another
/// let (joints, q) = (pose.joints(), pose.q()); // for an instance of the model
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct SkeletonPose {
    model: Model,
    locals: Vec<LocalTransform>,
    q: Vec<f32>,
    /// Of a clip that is mixed in.
    other: Vec<LocalTransform>,
    other_q: Vec<f32>,
    nodes: Vec<JointMatrix>,
    joints: Vec<JointMatrix>,
}

impl SkeletonPose {
    /// The pose at rest, as [`SkeletonPose::rest`].
    ///
    /// # Errors
    /// [`SkeletonError::NoSkin`]; a file that breaks the format's rules.
    pub fn new(model: &Model) -> Result<Self, SkeletonError> {
        let skeleton = skeleton(model.asset())?;
        let (nodes, modes) = (skeleton.node_count(), model.asset().mode_count());
        let mut pose = Self {
            locals: alloc::vec![LocalTransform::IDENTITY; nodes],
            q: alloc::vec![0.0; modes],
            other: alloc::vec![LocalTransform::IDENTITY; nodes],
            other_q: alloc::vec![0.0; modes],
            nodes: alloc::vec![joint::IDENTITY; nodes],
            joints: alloc::vec![joint::IDENTITY; skeleton.joint_count()],
            model: model.clone(),
        };
        pose.rest()?;
        Ok(pose)
    }

    /// Goes to the pose at rest, as the source shows the mesh without an animation: q holds the default weights of morph
    /// targets ([`Asset::default_q`](crate::Asset::default_q)), and 0 for other modes.
    ///
    /// # Errors
    /// A file that breaks the format's rules.
    pub fn rest(&mut self) -> Result<(), SkeletonError> {
        let skeleton = skeleton(self.model.asset())?;
        skeleton.rest(&mut self.locals)?;
        self.q.fill(0.0);
        for (q, weight) in self.q.iter_mut().zip(self.model.asset().default_q()) {
            *q = weight.unwrap_or(0.0) as f32;
        }
        self.update()
    }

    /// Goes to the pose of a clip at a time; see [`Clip::sample`](crate::Clip::sample).
    ///
    /// # Errors
    /// No such clip, a time that is not finite, a file that breaks the format's rules: the matrices of joints stay.
    pub fn play(&mut self, clip: usize, time_s: f64) -> Result<(), SkeletonError> {
        let clip = self::clip(&skeleton(self.model.asset())?, clip)?;
        clip.sample(time_s, &mut self.locals, &mut self.q)?;
        self.update()
    }

    /// Goes from the present pose towards that of a clip at a time, by `weight`: up to rounding, 0 stays and 1 is
    /// [`SkeletonPose::play`].
    ///
    /// # Errors
    /// Those of [`SkeletonPose::play`]; a weight that is not finite.
    pub fn blend_with(
        &mut self,
        clip: usize,
        time_s: f64,
        weight: f64,
    ) -> Result<(), SkeletonError> {
        let clip = self::clip(&skeleton(self.model.asset())?, clip)?;
        clip.sample(time_s, &mut self.other, &mut self.other_q)?;
        blend(&mut self.locals, &self.other, weight)?;
        blend_q(&mut self.q, &self.other_q, weight)?;
        self.update()
    }

    /// The matrices of nodes and joints of the local transforms as they are: after changes through
    /// [`SkeletonPose::locals_mut`].
    ///
    /// # Errors
    /// A file that breaks the format's rules.
    pub fn update(&mut self) -> Result<(), SkeletonError> {
        let skeleton = skeleton(self.model.asset())?;
        skeleton.model_space(&self.locals, &mut self.nodes)?;
        skeleton.joints(&self.nodes, &mut self.joints)
    }

    /// The transforms of all nodes to their parents.
    pub fn locals(&self) -> &[LocalTransform] {
        &self.locals
    }

    /// The same, to be changed: a head that looks somewhere, a ragdoll. Call [`SkeletonPose::update`] afterwards.
    pub fn locals_mut(&mut self) -> &mut [LocalTransform] {
        &mut self.locals
    }

    /// From the space of each node to the model's (mesh units): where to hang a sword.
    pub fn nodes(&self) -> &[JointMatrix] {
        &self.nodes
    }

    /// From each joint's space to the model's (mesh units): what
    /// [`Instance::set_joints`](crate::Instance::set_joints) takes.
    pub fn joints(&self) -> &[JointMatrix] {
        &self.joints
    }

    /// One number per mode.
    pub fn q(&self) -> &[f32] {
        &self.q
    }
}

fn skeleton<'m>(asset: &Asset<'m>) -> Result<Skeleton<'m>, SkeletonError> {
    asset.skeleton().ok_or(SkeletonError::NoSkin)
}

fn clip<'m>(skeleton: &Skeleton<'m>, index: usize) -> Result<super::Clip<'m>, SkeletonError> {
    let count = skeleton.clip_count();
    let missing = SkeletonError::NoClip {
        count,
        found: index,
    };
    skeleton.clip(index).ok_or(missing)
}
