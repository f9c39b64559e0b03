//! The frames of an asset's animation (SPEC 7.5): q, time, and the rigid motion of each.

use bdtree_format::FrameRecord;

use crate::transform::Transform;
use crate::view::Asset;

/// A pose that the source showed. It plays back as
/// `Pose::new(&asset, frame.q(), frame.transform(), …)`; an instance that is placed elsewhere takes
/// `place.after(frame.transform())?`.
#[derive(Debug, Clone, Copy)]
pub struct AnimationFrame<'a> {
    record: &'a FrameRecord,
    q: &'a [f32],
}

impl<'a> AnimationFrame<'a> {
    /// One number per mode, each within the mode's limit.
    pub fn q(&self) -> &'a [f32] {
        self.q
    }

    /// When the source shows the frame, in seconds from 0; `None` when it does not say.
    pub fn time_s(&self) -> Option<f64> {
        let time = self.record.time_s.get();
        (time != -1.0).then_some(time)
    }

    /// The rigid motion that a writer took out of the frame and that puts the mesh back:
    /// `x = R (origin + p') + t` (mesh units). The identity where none was.
    pub fn transform(&self) -> Transform {
        Transform {
            rotation: self.record.rotation.map(|c| c.get()),
            translation: self.record.translation.map(|c| c.get()),
            scale: 1.0,
        }
    }
}

impl<'a> Asset<'a> {
    /// Number of frames of the animation; 0 when there is none.
    pub fn frame_count(&self) -> usize {
        self.frames.len()
    }

    /// A frame of the animation, counted from 0; `None` when there is no such frame. Its numbers
    /// are the file's: where nobody has verified them, [`crate::Pose::new`] still checks what it
    /// takes.
    pub fn frame(&self, index: usize) -> Option<AnimationFrame<'a>> {
        let m = self.mode_count();
        let start = index.checked_mul(m)?;
        Some(AnimationFrame {
            record: self.frames.get(index)?,
            q: self.frame_q.get(start..start.checked_add(m)?)?,
        })
    }
}
