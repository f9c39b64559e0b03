//! What a thread plays clips in.

use bdtree_runtime::{AssetId, Model, SkeletonError, SkeletonPose};

/// Memory that a thread plays all its entities in, one after the other. With a pose for each entity, a thousand entities would have
/// to fetch ten kilobytes each from outside the caches.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    poses: Vec<Played>,
    /// Of an animation.
    pub(super) q: Vec<f32>,
}

/// The pose of a skeleton that is played.
#[derive(Debug)]
struct Played {
    asset: AssetId,
    pose: SkeletonPose,
    /// Frames since it was last asked for.
    idle: u32,
}

/// Frames that a pose is kept for unused: it keeps its model in memory.
const IDLE_MAX: u32 = 60;

impl Scratch {
    /// Drops poses that have not been played for long.
    pub(super) fn start_frame(&mut self) {
        self.poses.retain_mut(|one| {
            one.idle += 1;
            one.idle <= IDLE_MAX
        });
    }

    /// A pose of the model's skeleton.
    pub(super) fn pose(&mut self, model: &Model) -> Result<&mut SkeletonPose, SkeletonError> {
        let asset = model.asset().id();
        let index = match self.poses.iter().position(|one| one.asset == asset) {
            Some(index) => index,
            None => {
                self.poses.push(Played {
                    asset,
                    pose: SkeletonPose::new(model)?,
                    idle: 0,
                });
                self.poses.len() - 1
            }
        };
        let played = &mut self.poses[index];
        played.idle = 0;
        Ok(&mut played.pose)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_are_used_again_and_let_their_models_go() {
        let bytes = std::fs::read("../fixtures/golden/skinned.bdt").unwrap();
        // The same file, loaded twice.
        let models = [&bytes, &bytes].map(|bytes| Model::from_bytes(bytes).unwrap());
        let mut scratch = Scratch::default();
        for model in [&models[0], &models[1], &models[0]] {
            scratch.pose(model).unwrap();
        }
        assert_eq!(scratch.poses.len(), 2);
        for _ in 0..IDLE_MAX {
            scratch.start_frame();
            scratch.pose(&models[1]).unwrap();
            assert_eq!(scratch.poses.len(), 2);
        }
        scratch.start_frame();
        assert_eq!(scratch.poses.len(), 1);
        assert_eq!(scratch.poses[0].asset, models[1].asset().id());
    }
}
