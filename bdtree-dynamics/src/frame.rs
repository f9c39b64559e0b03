//! The floating frame of a body: rigid motion of its center of mass and principal axes.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::rotation::{rotation, turn_freely};

/// Position, orientation and speeds of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameState {
    /// Center of mass, world units.
    pub position: Vector3<f64>,
    /// From the principal axes of inertia to the world's.
    pub orientation: UnitQuaternion<f64>,
    /// World units per second.
    pub velocity: Vector3<f64>,
    /// Angular momentum about the center of mass, kg · world unit² / s, world axes.
    pub angular_momentum: Vector3<f64>,
}

/// Mass and principal moments of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameMass {
    /// kg.
    pub mass_kg: f64,
    /// kg · world unit².
    pub moments: Vector3<f64>,
}

impl FrameState {
    /// At rest.
    pub fn at(position: Vector3<f64>, orientation: UnitQuaternion<f64>) -> Self {
        Self {
            position,
            orientation,
            velocity: Vector3::zeros(),
            angular_momentum: Vector3::zeros(),
        }
    }

    /// The state after `step_s` seconds of a constant force (N) and torque (N · world unit, world axes). Position and both
    /// momenta are exact; orientation is of second order ([`turn_freely`]), the torque acting on it as on a body at rest.
    pub fn after(
        &self,
        mass: &FrameMass,
        force: Vector3<f64>,
        torque: Vector3<f64>,
        step_s: f64,
    ) -> Self {
        let acceleration = force / mass.mass_kg;
        // Half of what the torque adds to the momentum turns the body within the step.
        let turning = self.angular_momentum + torque * (0.5 * step_s);
        Self {
            position: self.position
                + self.velocity * step_s
                + acceleration * (0.5 * step_s * step_s),
            orientation: turn_freely(self.orientation, mass.moments, turning, step_s),
            velocity: self.velocity + acceleration * step_s,
            angular_momentum: self.angular_momentum + torque * step_s,
        }
    }

    /// The state at the end of a step if forces of that step, which it does not know yet, have moved it by `moved` and
    /// turned it by `turned` (radians, world axes); `axes` are the principal axes that the turn was computed with.
    pub fn moved(
        &self,
        mass: &FrameMass,
        moved: Vector3<f64>,
        turned: Vector3<f64>,
        axes: &Matrix3<f64>,
        step_s: f64,
    ) -> Self {
        // A constant force adds 2/h times what it displaces to the velocity; so does a torque.
        let per_step = 2.0 / step_s;
        let own = axes.tr_mul(&turned).component_mul(&mass.moments);
        Self {
            position: self.position + moved,
            orientation: rotation(turned) * self.orientation,
            velocity: self.velocity + moved * per_step,
            angular_momentum: self.angular_momentum + axes * own * per_step,
        }
    }

    /// Ω = I⁻¹ L, rad/s, world axes.
    pub fn angular_velocity(&self, mass: &FrameMass) -> Vector3<f64> {
        let own = self
            .orientation
            .inverse_transform_vector(&self.angular_momentum);
        self.orientation * own.component_div(&mass.moments)
    }

    /// L = I Ω for an angular velocity (rad/s, world axes).
    pub fn momentum_of(&self, mass: &FrameMass, spin: Vector3<f64>) -> Vector3<f64> {
        let own = self.orientation.inverse_transform_vector(&spin);
        self.orientation * own.component_mul(&mass.moments)
    }

    /// ½ m v² + ½ Ω·L.
    pub fn kinetic_energy(&self, mass: &FrameMass) -> f64 {
        let spin = self.angular_velocity(mass).dot(&self.angular_momentum);
        0.5 * (mass.mass_kg * self.velocity.norm_squared() + spin)
    }
}
