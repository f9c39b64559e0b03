//! Who else writes a [`Deformation`](crate::Deformation): clips of the file, Bevy's morph weights, Bevy's joints.

mod clip;
mod joints;
mod morphs;
mod scratch;

pub use clip::{ClipPlayer, ClipRef};
pub use joints::{JointOrder, PoseFromJoints};
pub use morphs::{MorphOrder, PoseFromMorphs};

pub(crate) use clip::play_clips;
pub(crate) use joints::read_joints;
pub(crate) use morphs::read_morphs;
