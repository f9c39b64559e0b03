//! Poses of skeletons: clips played and mixed.
#![allow(unsafe_code)] // names of functions: docs/design/unsafe.md

use bdtree_runtime::{BoneMatrices, LocalTransform, SkeletonPose};
use zerocopy::FromBytes;

use crate::border::{Handle, In, Kind, Out, done, give};
use crate::instance::BdtInstance;
use crate::model::{BdtModel, missing};
use crate::sink::put_all;
use crate::status::BdtStatus;
use crate::types::{BdtMatrix, BdtQuat, BdtVec3};

/// A pose of a model's skeleton with the memory that it takes. One thread at a time may use it.
pub struct BdtSkeletonPose {
    _opaque: [u8; 0],
}

impl Kind for BdtSkeletonPose {
    type Value = SkeletonPose;
    const TAG: u64 = u64::from_le_bytes(*b"bdtSKELE");
    const NAME: &'static str = "pose";
}

/// Makes a pose at rest.
/// Ownership: `*out` is yours, to be freed by `bdt_skeleton_pose_free`; NULL on errors. The model may be freed before it.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_NO_SKIN`, `_FORMAT` (a damaged file). Thread-safety: any number of
/// threads at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_new(
    model: Handle<BdtModel>,
    mut out: Out<*mut BdtSkeletonPose>,
) -> BdtStatus {
    give(&mut out, || Ok(SkeletonPose::new(model.shared()?)?))
}

/// Frees a pose. NULL is nothing.
/// Errors: `BDT_STATUS_ERROR_HANDLE`. Thread-safety: no other thread may use the handle meanwhile or afterwards.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_free(pose: Handle<BdtSkeletonPose>) -> BdtStatus {
    done(|| pose.free())
}

/// Goes to the pose at rest; q holds the default weights of morph targets.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_FORMAT` (a damaged file). Thread-safety: one thread at a time
/// per pose.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_rest(pose: Handle<BdtSkeletonPose>) -> BdtStatus {
    done(|| Ok(pose.exclusive()?.rest()?))
}

/// Goes to the pose of a clip at a time (seconds). A loop is `fmod(time, duration)`.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_INDEX` (no such clip), `_ARGUMENT` (a time that is not finite),
/// `_FORMAT` (a damaged file). Thread-safety: one thread at a time per pose.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_play(
    pose: Handle<BdtSkeletonPose>,
    clip: usize,
    time_s: f64,
) -> BdtStatus {
    done(|| Ok(pose.exclusive()?.play(clip, time_s)?))
}

/// Goes from the present pose towards that of a clip at a time, by `weight`: 0 stays, 1 is `bdt_skeleton_pose_play`.
/// Errors: those of `bdt_skeleton_pose_play`; `_ARGUMENT` (a weight that is not finite). Thread-safety: one thread at a
/// time per pose.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_blend(
    pose: Handle<BdtSkeletonPose>,
    clip: usize,
    time_s: f64,
    weight: f64,
) -> BdtStatus {
    done(|| Ok(pose.exclusive()?.blend_with(clip, time_s, weight)?))
}

/// From a node's space to its parent's.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
#[repr(C)]
pub struct BdtLocal {
    /// 0: the three parts, which clips animate; 1: `matrix`, which nothing animates.
    pub is_matrix: u32,
    /// 0.
    pub reserved: u32,
    /// In units of the parent's space.
    pub translation: BdtVec3,
    /// Normalised where it is used.
    pub rotation: BdtQuat,
    /// Of each axis; negative numbers mirror.
    pub scale: BdtVec3,
    /// Any affine map.
    pub matrix: BdtMatrix,
}

const _: () = assert!(size_of::<BdtLocal>() == 184);

impl From<LocalTransform> for BdtLocal {
    fn from(local: LocalTransform) -> Self {
        let matrix = local.to_matrix().into();
        match local {
            LocalTransform::Parts {
                translation,
                rotation,
                scale,
            } => Self {
                is_matrix: 0,
                reserved: 0,
                translation: translation.into(),
                rotation: rotation.into(),
                scale: scale.into(),
                matrix,
            },
            LocalTransform::Matrix(_) => Self {
                is_matrix: 1,
                matrix,
                ..LocalTransform::IDENTITY.into()
            },
        }
    }
}

impl From<BdtLocal> for LocalTransform {
    fn from(local: BdtLocal) -> Self {
        if local.is_matrix != 0 {
            return Self::Matrix(local.matrix.rows);
        }
        Self::Parts {
            translation: local.translation.into(),
            rotation: local.rotation.into(),
            scale: local.scale.into(),
        }
    }
}

/// Writes the transform of a node of the skeleton to its parent.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_INDEX`. Thread-safety: several threads may read a pose at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_local(
    pose: Handle<BdtSkeletonPose>,
    node: usize,
    mut out: Out<BdtLocal>,
) -> BdtStatus {
    done(|| {
        let locals = pose.shared()?.locals();
        let local = locals
            .get(node)
            .ok_or(missing("node", locals.len(), node))?;
        out.one("out")?.write((*local).into());
        Ok(())
    })
}

/// Sets the transform of a node of the skeleton to its parent: a head that looks somewhere. Call
/// `bdt_skeleton_pose_update` after the last one.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_INDEX`. Thread-safety: one thread at a time per pose.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_set_local(
    pose: Handle<BdtSkeletonPose>,
    node: usize,
    local: In<BdtLocal>,
) -> BdtStatus {
    done(|| {
        let local = *local.one("local")?;
        let mut pose = pose.exclusive()?;
        let count = pose.locals().len();
        let slot = pose.locals_mut().get_mut(node);
        *slot.ok_or(missing("node", count, node))? = local.into();
        Ok(())
    })
}

/// Computes the matrices of nodes and joints from the transforms of nodes.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_FORMAT` (a damaged file). Thread-safety: one thread at a time
/// per pose.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_update(pose: Handle<BdtSkeletonPose>) -> BdtStatus {
    done(|| Ok(pose.exclusive()?.update()?))
}

/// Writes one matrix per joint of the model, from its space to the model's (mesh units): what `bdt_instance_set_joints`
/// takes.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_LENGTH`. Thread-safety: several threads may read a pose at
/// once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_joints(
    pose: Handle<BdtSkeletonPose>,
    mut joints: Out<BdtMatrix>,
    count: usize,
) -> BdtStatus {
    done(|| put_all("matrices", pose.shared()?.joints(), &mut joints, count))
}

/// Writes one matrix per node of the skeleton, from its space to the model's (mesh units): where to hang a sword.
/// Errors and thread-safety: as `bdt_skeleton_pose_joints`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_nodes(
    pose: Handle<BdtSkeletonPose>,
    mut nodes: Out<BdtMatrix>,
    count: usize,
) -> BdtStatus {
    done(|| put_all("matrices", pose.shared()?.nodes(), &mut nodes, count))
}

/// Writes q of the pose, one number per mode.
/// Errors and thread-safety: as `bdt_skeleton_pose_joints`.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_skeleton_pose_q(
    pose: Handle<BdtSkeletonPose>,
    mut q: Out<f32>,
    count: usize,
) -> BdtStatus {
    done(|| put_all("entries of q", pose.shared()?.q(), &mut q, count))
}

/// Gives an instance of the model q and joints of the pose; its placement stays. On errors it stays as it was.
/// Errors: `BDT_STATUS_ERROR_NULL`, `_HANDLE`, `_BUSY`, `_NO_SKIN`, `_LENGTH` (of another model), `_POSE`. Thread-safety:
/// one thread at a time per instance; several threads may read a pose at once.
#[unsafe(no_mangle)]
pub extern "C" fn bdt_instance_set_skeleton_pose(
    instance: Handle<BdtInstance>,
    pose: Handle<BdtSkeletonPose>,
) -> BdtStatus {
    done(|| {
        let pose = pose.shared()?;
        let mut instance = instance.exclusive()?;
        let (bones, at) = (BoneMatrices::Joints(pose.joints()), instance.placement());
        Ok(instance.set_pose_with_bones(pose.q(), bones, at)?)
    })
}
