//! Why the mesh of an entity is not as its components say.

use std::fmt::Display;

use bevy_ecs::prelude::*;
use bevy_log::error;

/// What a [`PoseFaults`] speaks of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PoseStage {
    /// A [`ClipPlayer`](crate::ClipPlayer).
    Clip,
    /// A [`PoseFromMorphs`](crate::PoseFromMorphs).
    Morphs,
    /// A [`PoseFromJoints`](crate::PoseFromJoints).
    Joints,
    /// The entity's `GlobalTransform`.
    Placement,
    /// The [`Deformation`](crate::Deformation).
    Deformation,
    /// The box around the mesh.
    Bounds,
}

/// Number of [`PoseStage`]s.
const STAGES: usize = PoseStage::Bounds as usize + 1;

/// What is wrong with the pose of an entity, as long as it is: the mesh keeps its last sound pose meanwhile. Each fault is
/// also logged once, when it comes or its words change.
#[derive(Component, Debug, Clone, Default)]
pub struct PoseFaults {
    of: [Option<String>; STAGES],
}

impl PoseFaults {
    /// The fault of a stage, in words; `None` where there is none.
    pub fn get(&self, stage: PoseStage) -> Option<&str> {
        self.of[stage as usize].as_deref()
    }

    /// True if nothing is wrong.
    pub fn is_empty(&self) -> bool {
        self.of.iter().all(Option::is_none)
    }

    /// Keeps what a stage says, and logs it where it is new. Does not count as a change otherwise.
    pub(crate) fn tell<E: Display>(
        faults: &mut Mut<'_, Self>,
        entity: Entity,
        stage: PoseStage,
        said: Result<(), E>,
    ) {
        let kept = faults.get(stage);
        match said {
            Ok(()) if kept.is_none() => {}
            Ok(()) => faults.of[stage as usize] = None,
            Err(why) => {
                let why = why.to_string();
                if kept != Some(&why) {
                    error!("{entity}: {why}");
                    faults.of[stage as usize] = Some(why);
                }
            }
        }
    }
}
