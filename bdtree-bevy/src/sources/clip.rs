//! Clips and animations that the file itself holds.

use std::sync::{Mutex, PoisonError};

use bdtree_runtime::{AssetId, Model, SampleError, SkeletonError, SkeletonPose};
use bevy_asset::Assets;
use bevy_ecs::prelude::*;
use bevy_ecs::reflect::ReflectComponent;
use bevy_math::{DQuat, DVec3};
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;
use bevy_time::Time;
use bevy_transform::components::Transform;
use thiserror::Error;

use crate::asset::BdtModel;
use crate::faults::{PoseFaults, PoseStage};
use crate::placement::affine;
use crate::pose::{Deformation, DeformingMesh};

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

/// What playing takes, of each task: a pose of each entity's own would have to come from far memory, ten kilobytes for forty
/// bones.
#[derive(Debug, Default)]
struct Scratch {
    skeletons: Vec<Played>,
    q: Vec<f32>,
}

/// A skeleton that is played.
#[derive(Debug)]
struct Played {
    asset: AssetId,
    pose: SkeletonPose,
    /// In this frame.
    is_used: bool,
}

impl Scratch {
    /// The pose of a model's skeleton, made when it is first asked for.
    fn pose(&mut self, model: &Model) -> Result<&mut SkeletonPose, SkeletonError> {
        let asset = model.asset().id();
        let found = self.skeletons.iter().position(|one| one.asset == asset);
        let index = match found {
            Some(index) => index,
            None => {
                self.skeletons.push(Played {
                    asset,
                    pose: SkeletonPose::new(model)?,
                    is_used: false,
                });
                self.skeletons.len() - 1
            }
        };
        let played = &mut self.skeletons[index];
        played.is_used = true;
        Ok(&mut played.pose)
    }
}

/// Kept from frame to frame, so that none allocates.
#[derive(Debug, Default)]
pub(crate) struct Scratches(Mutex<Vec<Scratch>>);

impl Scratches {
    /// Drops skeletons that the last frame has not played: they keep their models.
    fn start_frame(&mut self) {
        let all = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        for scratch in all {
            scratch.skeletons.retain(|one| one.is_used);
            for one in &mut scratch.skeletons {
                one.is_used = false;
            }
        }
    }

    fn lend(&self) -> Lent<'_> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        Lent {
            scratch: all.pop().unwrap_or_default(),
            of: self,
        }
    }
}

/// What goes back when a task has ended.
struct Lent<'s> {
    scratch: Scratch,
    of: &'s Scratches,
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        let mut all = self.of.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.push(std::mem::take(&mut self.scratch));
    }
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
    mut scratches: Local<Scratches>,
) {
    scratches.start_frame();
    let scratches = &*scratches;
    let passed = time.map_or(0.0, |time| time.delta_secs_f64());
    players.par_iter_mut().for_each_init(
        || scratches.lend(),
        |lent, (entity, mesh, mut player, mut memory, mut deformation, mut transform, mut faults)| {
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
                let scratch = &mut lent.scratch;
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
    /// Looks at the model, unless it is the last one.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_skeleton_that_is_not_played_any_more_lets_its_model_go() {
        let bytes = std::fs::read("../fixtures/golden/skinned.bdt").unwrap();
        let model = Model::from_bytes(&bytes).unwrap();
        let mut scratches = Scratches::default();
        let kept = |scratches: &Scratches| {
            let all = scratches.0.lock().unwrap();
            all.iter().map(|one| one.skeletons.len()).sum::<usize>()
        };
        for _ in 0..3 {
            scratches.start_frame();
            for _ in 0..2 {
                scratches.lend().scratch.pose(&model).unwrap();
            }
            assert_eq!(kept(&scratches), 1);
        }
        scratches.start_frame();
        assert_eq!(kept(&scratches), 1, "of the frame before");
        scratches.start_frame();
        assert_eq!(kept(&scratches), 0);
    }
}
