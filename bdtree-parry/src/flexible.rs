//! The modes of one body, for engines other than rapier.

use super::modes::{Body, FlexibleOptions};
use super::parry::math::Vector;
use super::points::wide;
use super::shape::DeformingMesh;
use crate::error::ShapeError;
use crate::model::DeformingModel;

/// The modes of a body whose rigid motion an engine computes: what `FlexibleBodies` do under rapier, for programs with another
/// engine. In each step call [`FlexibleBody::begin`], [`FlexibleBody::push`] with the impulses of its contacts, and
/// [`FlexibleBody::advance`]; give the collider the mesh that comes back.
///
/// Modes are damped while they are touched, the less the longer a force pulls them the same way; never gain more energy than
/// contacts have destroyed; and rest once the body is held and slow ([`FlexibleOptions::rest_speed`]) and no load bends it any
/// further.
#[derive(Debug, Clone)]
pub struct FlexibleBody {
    body: Body,
    step_s: f64,
}

impl FlexibleBody {
    /// A body at rest.
    ///
    /// # Errors
    /// A damaged asset; modes without frequencies or modal masses, and a mesh without mass, of a body that shall deform.
    pub fn new(model: &DeformingModel, options: &FlexibleOptions) -> Result<Self, ShapeError> {
        Ok(Self {
            body: Body::new(model, options)?,
            step_s: 0.0,
        })
    }

    /// Begins a step of this many seconds.
    ///
    /// # Errors
    /// A step that is not positive.
    pub fn begin(&mut self, step_s: f64) -> Result<(), ShapeError> {
        let is_new = step_s != self.step_s;
        self.step_s = step_s;
        self.body.begin(step_s, is_new)
    }

    /// The impulse on the body (newton seconds) of a contact at a point of a triangle, both in the shape's frame; without the
    /// triangle ([`DeformingMesh::triangle_of`]) the nearest point of the surface is looked for.
    ///
    /// # Errors
    /// A damaged asset.
    pub fn push(
        &mut self,
        point: Vector,
        triangle: Option<u32>,
        impulse: Vector,
    ) -> Result<(), ShapeError> {
        let force = wide(impulse).map(|x| x / self.step_s);
        if force.iter().all(|x| *x == 0.0) {
            return Ok(());
        }
        self.body
            .press(force.iter().map(|x| x * x).sum::<f64>().sqrt());
        self.body.pushed(point, triangle, force)
    }

    /// Energy that the body's contacts have taken from the motion of frames in the step, joules: this body's share.
    pub fn pay(&mut self, lost_j: f64) {
        self.body.pay(lost_j);
    }

    /// Ends the step, in which the frame came to this linear and angular velocity: modes move. Gives the mesh at the new q once a
    /// vertex may have moved by the tolerance since the last one.
    ///
    /// # Errors
    /// A damaged asset.
    pub fn advance(
        &mut self,
        linear: Vector,
        angular: Vector,
    ) -> Result<Option<DeformingMesh>, ShapeError> {
        if self.body.modes.is_empty() {
            return Ok(None);
        }
        self.body.settle([linear, angular], self.step_s);
        if !self.body.rests() {
            self.body.advance(self.step_s)?;
        }
        let made = self.body.deformed()?;
        if let Some(mesh) = &made {
            self.body.mesh = mesh.clone();
        }
        Ok(made)
    }

    /// Whether forces may still be bending the body to where they hold it: an engine should not let its frame sleep before.
    pub fn is_settling(&self) -> bool {
        self.body.is_settling()
    }

    /// The last mesh that [`FlexibleBody::advance`] gave; at rest before.
    pub fn mesh(&self) -> &DeformingMesh {
        &self.body.mesh
    }

    /// q, one number per mode, up to date.
    pub fn q(&self) -> Vec<f32> {
        self.body.q()
    }

    /// Deforms the body: amplitudes and rates (1/s) of its modes.
    ///
    /// # Errors
    /// Another number of modes than the body has, numbers that are not finite or at the strain limit.
    pub fn set_modes(&mut self, amplitudes: &[f64], rates: &[f64]) -> Result<(), ShapeError> {
        self.body.set_state(amplitudes, rates)
    }

    /// Energy of the modes, joules where a world unit is a meter.
    pub fn modal_energy(&self) -> f64 {
        self.body.energy()
    }

    /// Kinetic energy of the modes.
    pub fn modal_kinetic_energy(&self) -> f64 {
        self.body.kinetic_energy()
    }
}
