//! Clips and animations that the file itself holds.

use bdtree_runtime::{AssetId, Model, SampleError, SkeletonError};
use bevy_asset::Assets;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_math::{DQuat, DVec3};
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;
use bevy_time::Time;
use bevy_transform::components::Transform;
use bevy_utils::Parallel;
use thiserror::Error;

use crate::asset::BdtModel;
use crate::faults::{PoseFaults, PoseStage};
use crate::placement::affine;
use crate::pose::{Deformation, DeformingMesh};
use crate::sources::scratch::Scratch;

/// Plays a clip of the skeleton, or the animation, that is in the entity's own file: writes q and, of a clip, the joints of
/// its [`Deformation`], in [`BdtreeSystems::Play`](crate::BdtreeSystems::Play).
///
/// Where the bake took a rigid motion out of the frames of an animation, it goes into the entity's `Transform`: to place
/// such an entity, make it the child of another. Without one the `Transform` stays as it is.
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Default, Clone, PartialEq)]
#[require(Deformation, ClipMemory)]
pub struct ClipPlayer {
    /// What is played.
    pub clip: ClipRef,
    /// Where in it, in seconds. Each frame adds `speed` times what `Time` has gone on.
    pub time_s: f64,
    /// Seconds of the clip per second; negative plays backwards, 0 holds.
    pub speed: f64,
    /// Whether it begins anew at its end; else it stays there.
    pub is_looping: bool,
}

impl Default for ClipPlayer {
    /// The first clip from its start, over and over.
    fn default() -> Self {
        Self {
            clip: ClipRef::default(),
            time_s: 0.0,
            speed: 1.0,
            is_looping: true,
        }
    }
}

/// One of the movements of a file.
#[derive(Reflect, Debug, Clone, PartialEq, Eq)]
pub enum ClipRef {
    /// A clip of the skeleton, counted from 0.
    Index(usize),
    /// The first clip of the skeleton with this name.
    Name(String),
    /// The frames of the compressed animation, which move modes alone.
    Frames,
}

impl Default for ClipRef {
    fn default() -> Self {
        Self::Index(0)
    }
}

/// What is known of the model that was played last.
#[derive(Component, Debug, Default)]
pub(crate) struct ClipMemory {
    asset: Option<AssetId>,
    /// Whether frames have a rigid motion of their own.
    is_moving: bool,
}

/// Why a clip cannot be played.
#[derive(Debug, Error)]
enum ClipError {
    #[error(transparent)]
    Skeleton(#[from] SkeletonError),
    #[error(transparent)]
    Frames(#[from] SampleError),
    #[error("the file has no clip {0:?}: its clips are {1}")]
    Name(String, String),
    #[error("ClipPlayer: time_s or speed is not a finite number")]
    Time,
}

/// Moves players on and writes the poses that they have come to.
pub(crate) fn play_clips(
    time: Option<Res<Time>>,
    models: Res<Assets<BdtModel>>,
    mut players: Query<(
        Entity,
        &DeformingMesh,
        &mut ClipPlayer,
        &mut ClipMemory,
        &mut Deformation,
        &mut Transform,
        &mut PoseFaults,
    )>,
    mut scratches: Local<Parallel<Scratch>>,
) {
    scratches.iter_mut().for_each(Scratch::start_frame);
    let scratches = &*scratches;
    let passed = time.map_or(0.0, |time| time.delta_secs_f64());
    players.par_iter_mut().for_each_init(
        || scratches.borrow_local_mut(),
        |scratch, (entity, mesh, mut player, mut memory, mut deformation, mut transform, mut faults)| {
            let Some(asset) = models.get(&mesh.0) else {
                return;
            };
            let is_new = memory.asset != Some(asset.model.asset().id());
            if !is_new && !player.is_changed() && (passed == 0.0 || player.speed == 0.0) {
                return;
            }
            memory.start(&asset.model);
            let played = duration_s(&asset.model, &player.clip).and_then(|duration| {
                player.time_s = moved_on(&player, passed, duration)?;
                memory.play(&asset.model, &player, scratch, &mut deformation, &mut transform)
            });
            PoseFaults::tell(&mut faults, entity, PoseStage::Clip, played);
        },
    );
}

/// The time of a player some seconds later.
fn moved_on(player: &ClipPlayer, passed: f64, duration: f64) -> Result<f64, ClipError> {
    let time = player.time_s + player.speed * passed;
    if !time.is_finite() {
        return Err(ClipError::Time);
    }
    Ok(if player.is_looping && duration > 0.0 {
        // What is within stays to the bit, the end included.
        if (0.0..=duration).contains(&time) {
            time
        } else {
            time.rem_euclid(duration)
        }
    } else {
        time.clamp(0.0, duration.max(0.0))
    })
}

impl ClipMemory {
    /// Finds out whether frames move, when the model has changed.
    fn start(&mut self, model: &Model) {
        let asset = model.asset();
        if self.asset == Some(asset.id()) {
            return;
        }
        let frames = (0..asset.frame_count()).filter_map(|k| asset.frame(k));
        self.is_moving = frames
            .into_iter()
            .any(|frame| frame.transform() != bdtree_runtime::Transform::IDENTITY);
        self.asset = Some(asset.id());
    }

    fn play(
        &self,
        model: &Model,
        player: &ClipPlayer,
        scratch: &mut Scratch,
        deformation: &mut Mut<'_, Deformation>,
        transform: &mut Mut<'_, Transform>,
    ) -> Result<(), ClipError> {
        let Some(clip) = index(model, &player.clip)? else {
            scratch.q.resize(model.asset().mode_count(), 0.0);
            let motion = model.asset().sample(player.time_s, &mut scratch.q)?;
            deformation.q.clone_from(&scratch.q);
            if self.is_moving {
                transform.rotation = DQuat::from_array(motion.rotation).as_quat().normalize();
                transform.translation = DVec3::from_array(motion.translation).as_vec3();
            }
            return Ok(());
        };
        let pose = scratch.pose(model)?;
        pose.play(clip, player.time_s)?;
        deformation.q.clear();
        deformation.q.extend_from_slice(pose.q());
        deformation.joints.clear();
        deformation.joints.extend(pose.joints().iter().map(affine));
        Ok(())
    }
}

/// Seconds of what is played.
fn duration_s(model: &Model, clip: &ClipRef) -> Result<f64, ClipError> {
    let asset = model.asset();
    let Some(index) = index(model, clip)? else {
        return asset.duration_s().ok_or(if asset.frame_count() == 0 {
            ClipError::Frames(SampleError::NoFrames)
        } else {
            ClipError::Frames(SampleError::NoTimes)
        });
    };
    let skeleton = asset.skeleton().ok_or(SkeletonError::NoSkin)?;
    let count = skeleton.clip_count();
    let clip = skeleton.clip(index).ok_or(SkeletonError::NoClip {
        count,
        found: index,
    })?;
    Ok(clip.duration_s())
}

/// The clip's number; `None` for frames.
fn index(model: &Model, clip: &ClipRef) -> Result<Option<usize>, ClipError> {
    match clip {
        ClipRef::Frames => Ok(None),
        ClipRef::Index(index) => Ok(Some(*index)),
        ClipRef::Name(name) => {
            let skeleton = model.asset().skeleton().ok_or(SkeletonError::NoSkin)?;
            if let Some(index) = skeleton.clip_index(name) {
                return Ok(Some(index));
            }
            let names: Vec<_> = skeleton.clips().map(|clip| clip.name()).collect();
            Err(ClipError::Name(name.clone(), format!("{names:?}")))
        }
    }
}
