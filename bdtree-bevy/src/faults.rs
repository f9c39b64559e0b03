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
    /// The `Mesh3d` that is drawn.
    Drawing,
    /// The collider under avian.
    Collider,
    /// The modes that contacts move under avian.
    Modes,
}

/// Number of [`PoseStage`]s.
const STAGES: usize = PoseStage::Modes as usize + 1;

/// What is wrong with the pose of an entity, as long as it is: the mesh keeps its last sound pose meanwhile.
///
/// Each fault is logged when it comes. One that comes every frame, with other numbers perhaps, is logged once until it is
/// mended; its words here are those of the last frame.
#[derive(Component, Debug, Clone, Default)]
pub struct PoseFaults {
    of: [Option<Fault>; STAGES],
}

#[derive(Debug, Clone, Default)]
struct Fault {
    words: String,
    logged: Kinds,
}

impl PoseFaults {
    /// The fault of a stage, in words; `None` where there is none.
    pub fn get(&self, stage: PoseStage) -> Option<&str> {
        let fault = self.of[stage as usize].as_ref();
        fault.map(|fault| fault.words.as_str())
    }

    /// True if nothing is wrong.
    pub fn is_empty(&self) -> bool {
        self.of.iter().all(Option::is_none)
    }

    /// Keeps what a stage says, and logs it where it is of a new kind. Does not count as a change where it says the same.
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
                let words = why.to_string();
                if kept == Some(&words) {
                    return;
                }
                let fault = faults.of[stage as usize].get_or_insert_default();
                if fault.logged.is_new(&words) {
                    error!("{entity}: {words}");
                }
                fault.words = words;
            }
        }
    }
}

/// Kinds of faults that were logged: those are of one kind whose words differ in numbers alone.
#[derive(Debug, Clone, Default)]
pub(crate) struct Kinds(Vec<String>);

impl Kinds {
    /// Whether a fault is the first of its kind; the next one is not.
    pub(crate) fn is_new(&mut self, words: &str) -> bool {
        let is_of_number = |c: &char| c.is_ascii_digit() || matches!(c, '.' | '-');
        let kind: String = words.chars().filter(|c| !is_of_number(c)).collect();
        let is_new = !self.0.contains(&kind);
        if is_new {
            self.0.push(kind);
        }
        is_new
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;
    use std::sync::{Arc, Mutex};

    use bdtree_runtime::PoseError;
    use bevy_log::tracing_subscriber::fmt;
    use bevy_log::tracing_subscriber::util::SubscriberInitExt;

    use super::*;

    /// What this thread logs.
    #[derive(Clone, Default)]
    struct Log(Arc<Mutex<Vec<u8>>>);

    impl Write for Log {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_fault_of_every_frame_is_logged_once_until_it_is_mended() {
        let log = Log::default();
        let writer = log.clone();
        let _guard = fmt()
            .with_ansi(false)
            .with_writer(move || writer.clone())
            .set_default();
        let lines = || {
            let mut bytes = log.0.lock().unwrap();
            String::from_utf8(std::mem::take(&mut *bytes))
                .unwrap()
                .lines()
                .count()
        };

        let mut world = World::new();
        let entity = world.spawn(PoseFaults::default()).id();
        let mut tell = |said: Result<(), PoseError>| {
            let mut faults = world.get_mut::<PoseFaults>(entity).unwrap();
            PoseFaults::tell(&mut faults, entity, PoseStage::Deformation, said);
            faults.get(PoseStage::Deformation).map(str::to_string)
        };
        let over = |frame: usize| PoseError::OverLimit {
            mode: frame % 3,
            found: if frame.is_multiple_of(2) { -7.5 } else { 1e30 } + frame as f32,
            limit: 2.0,
        };
        let count = |found| PoseError::ModeCount { expected: 3, found };
        for frame in 0..100 {
            // What it says is of this frame.
            assert_eq!(tell(Err(over(frame))), Some(over(frame).to_string()));
        }
        assert_eq!(lines(), 1);
        // Two kinds by turns.
        for frame in 0..100 {
            assert_eq!(tell(Err(count(frame))), Some(count(frame).to_string()));
            tell(Err(over(frame)));
        }
        assert_eq!(lines(), 1);
        // Mended, and come back.
        assert_eq!(tell(Ok(())), None);
        assert_eq!(lines(), 0);
        tell(Err(over(1)));
        tell(Err(count(1)));
        tell(Err(over(2)));
        assert_eq!(lines(), 2);
    }
}
