//! What is to be seen, as numbers: two equal ones look the same.

use bdtree_render::tightness::Scale;
use bdtree_render::{Camera, Framing, Place, ViewDirection};
use bdtree_runtime::{BoneMatrices, JointMatrix, Transform};

use super::probe::Probe;
use crate::orbit;

/// From where the camera of the beginning looks.
const AZIMUTH_DEG: f32 = 30.0;
const ELEVATION_DEG: f32 = 20.0;

/// Pixels around the probe where it can be taken, however small it is.
const GRAB: f32 = 9.0;

/// Camera, posture and what else is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Reduced coordinates.
    pub q: Vec<f32>,
    /// From the space of each joint to model space; none: bones are at rest.
    pub joints: Vec<JointMatrix>,
    /// Where the mesh stands.
    pub transform: Transform,
    /// Whether the mesh is drawn.
    pub has_mesh: bool,
    /// Whether bones are drawn.
    pub has_bones: bool,
    /// The level whose spheres are drawn.
    pub level: Option<usize>,
    /// The colors of their growth.
    pub scale: Scale,
    /// Opacity of spheres, 0 to 1.
    pub opacity: f32,
    /// Whether there is a probe.
    pub has_probe: bool,
    /// The probe.
    pub probe: Probe,
    /// Whether the spheres in which its query ended are drawn.
    pub has_ends: bool,
    /// Where it is seen from (drawn units); `None`: from where all of it is seen.
    pub camera: Option<Camera>,
}

/// What a drag moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grab {
    /// The camera around its target.
    Orbit,
    /// Camera and target.
    Pan,
    /// The probe, at its distance.
    Probe,
}

impl View {
    /// Where the bones are.
    pub fn bones(&self) -> BoneMatrices<'_> {
        match &self.joints[..] {
            [] => BoneMatrices::Rest,
            joints => BoneMatrices::Joints(joints),
        }
    }

    /// Whether the mesh is the same and in the same place.
    pub fn is_posed_as(&self, other: &Self) -> bool {
        (&self.q, self.transform, &self.joints) == (&other.q, other.transform, &other.joints)
    }

    /// What the camera of the beginning is to see, in a picture of `aspect`; `up` points up there.
    pub fn framing(aspect: f32, up: [f32; 3]) -> Framing {
        let direction = ViewDirection {
            up: up.into(),
            ..ViewDirection::new(AZIMUTH_DEG, ELEVATION_DEG)
        };
        Framing::new(direction, aspect)
    }

    /// What a drag takes that begins at a pixel of a picture of `size`.
    pub fn grab(&self, place: &Place, at: [f32; 2], size: [u32; 2]) -> Grab {
        let center = place.shown(self.probe.center);
        let seen = self.camera.and_then(|camera| {
            let [right, ..] = camera.axes();
            let radius = place.shown_length(self.probe.radius);
            let rim = [0, 1, 2].map(|k| center[k] + radius * right[k]);
            Some([camera.project(center, size)?, camera.project(rim, size)?])
        });
        let apart = |a: [f32; 2], b: [f32; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        match seen {
            Some([center, rim])
                if self.has_probe && apart(center, at) <= apart(center, rim).max(GRAB) =>
            {
                Grab::Probe
            }
            _ => Grab::Orbit,
        }
    }

    /// Moves what is taken by so many pixels of a picture of `size`, right and down.
    pub fn drag(&mut self, place: &Place, grab: Grab, [right, down]: [f32; 2], size: [u32; 2]) {
        let Some(camera) = self.camera else { return };
        match grab {
            Grab::Orbit => self.camera = Some(orbit::turned(camera, [right, down], size[1])),
            Grab::Pan => self.camera = Some(orbit::moved(camera, [right, down], size[1])),
            Grab::Probe => {
                let height = size[1].max(1) as f32;
                let [x, y, forward] = camera.axes();
                let center = place.shown(self.probe.center);
                let depth: f32 = (0..3)
                    .map(|k| (center[k] - camera.eye[k]) * forward[k])
                    .sum();
                let per_pixel = 2.0 * depth * (0.5 * camera.fov_y_rad).tan() / height;
                for k in 0..3 {
                    let by = f64::from(per_pixel * (right * x[k] - down * y[k]));
                    self.probe.center[k] += by * place.size;
                }
            }
        }
    }

    /// Goes nearer by `steps` of the wheel, or away.
    pub fn zoom(&mut self, steps: f32) {
        self.camera = self.camera.map(|camera| orbit::zoomed(camera, steps));
    }
}
