//! What drags and the wheel do to a camera.

use bdtree_render::Camera;

/// Degrees per drag across the whole height of the picture.
const TURN_DEG: f32 = 240.0;

/// Points of the wheel that count as one step.
pub(crate) const WHEEL: f32 = 40.0;

/// Turned around its target by a drag of so many pixels, right and down, of a picture so many pixels high.
pub(crate) fn turned(camera: Camera, [right, down]: [f32; 2], height: u32) -> Camera {
    let by = TURN_DEG / height.max(1) as f32;
    camera.orbited(-right * by, down * by)
}

/// Moved so that what is at the target follows the drag.
pub(crate) fn moved(camera: Camera, [right, down]: [f32; 2], height: u32) -> Camera {
    let height = height.max(1) as f32;
    camera.moved(-right / height, down / height)
}

/// Nearer by `steps` of the wheel, or farther away.
pub(crate) fn zoomed(camera: Camera, steps: f32) -> Camera {
    let nearer = camera.at_distance(0.9_f32.powf(steps));
    // Beyond that f32 has no digits left.
    match (1e-4..1e4).contains(&nearer.distance()) {
        true => nearer,
        false => camera,
    }
}
