//! Where bodies would be at the end of the step without contacts, and what forces would do to them.

use nalgebra::{Matrix3, Vector3};

use super::body::Frame;
use super::{World, half_way};
use crate::body_model::ContactShape;
use crate::error::DynamicsError;

impl World {
    pub(super) fn predict(&mut self) -> Result<(), DynamicsError> {
        for index in 0..self.bodies.len() {
            if self.bodies[index].rest.is_asleep {
                continue; // as `lie` has left it
            }
            self.predict_frame(index);
            self.predict_modes(index)?;
            self.follow(index)?;
        }
        Ok(())
    }

    fn predict_frame(&mut self, index: usize) {
        let h = self.part_s;
        let body = &mut self.bodies[index];
        let model = &self.models[body.model];
        (body.moved, body.turned) = (Vector3::zeros(), Vector3::zeros());
        let (force, torque) = (body.force, body.torque);
        let (Frame::Free, Some(mass)) = (body.frame, &model.mass) else {
            if body.frame == Frame::Held {
                body.end = body.state;
            }
            if body.frame == Frame::Driven {
                let (from, to) = (&body.state, &body.end);
                let own = body.start..body.start + model.spheres.stride();
                let modal = &self.modal;
                body.is_under_way = from.position != to.position
                    || from.orientation != to.orientation
                    || modal.s[own.clone()] != modal.end_s[own];
            }
            // A driven body's end is what the caller has set.
            let turn = body.end.orientation * body.state.orientation.inverse();
            body.spin = turn.scaled_axis() / h;
            body.end.velocity = (body.end.position - body.state.position) / h;
            body.middle = (body.state.position + body.end.position) * 0.5;
            let half = half_way(&body.state.orientation, &body.end.orientation);
            body.rotation = half.to_rotation_matrix().into_inner();
            (body.per_force, body.per_torque) = (0.0, Matrix3::zeros());
            return;
        };
        let weight = Vector3::from(self.options.gravity) * mass.mass_kg;
        body.end = body.state.after(mass, weight + force, torque, h);
        // Where forces are constant, what momentum changes by is their lever about this point.
        body.middle = body.state.position + body.state.velocity * (0.5 * h);
        let half = half_way(&body.state.orientation, &body.end.orientation);
        let axes = half.to_rotation_matrix().into_inner();
        let inverse = Matrix3::from_diagonal(&mass.moments.map(|moment| 1.0 / moment));
        let inverse = axes * inverse * axes.transpose();
        body.rotation = axes;
        body.spin = inverse * body.state.angular_momentum;
        body.per_force = 0.5 * h * h / mass.mass_kg;
        body.per_torque = inverse * (0.5 * h * h);
    }

    /// For a body that falls asleep: it ends where it begins, and nothing moves it.
    pub(super) fn lie(&mut self, index: usize) {
        let body = &mut self.bodies[index];
        body.state.velocity = Vector3::zeros();
        body.state.angular_momentum = Vector3::zeros();
        (body.end, body.middle) = (body.state, body.state.position);
        (body.way, body.spin) = (Vector3::zeros(), Vector3::zeros());
        (body.swing, body.ripple) = (0.0, 0.0);
        body.rotation = body.state.orientation.to_rotation_matrix().into_inner();
        body.rotations = [body.rotation; 2];
        (body.per_force, body.per_torque) = (0.0, Matrix3::zeros());
        (body.moved, body.turned) = (Vector3::zeros(), Vector3::zeros());
        let model = &self.models[body.model];
        let modal = &mut self.modal;
        for (j, mode) in model.modes.iter().enumerate() {
            let at = body.start + j;
            let s = modal.s[at];
            (modal.rate[at], modal.end_rate[at], modal.end_s[at]) = (0.0, 0.0, s);
            modal.end_q_rate[at] = 0.0;
            (modal.q[at], modal.end_q[at]) = (mode.limit.q(s), mode.limit.q(s));
            (modal.per_force[at], modal.moved[at]) = (0.0, 0.0);
        }
    }

    fn predict_modes(&mut self, index: usize) -> Result<(), DynamicsError> {
        let (whole_s, part_s) = (self.options.step_s, self.part_s);
        let body = &self.bodies[index];
        let model = &self.models[body.model];
        let modal = &mut self.modal;
        let gravity = Vector3::from(self.options.gravity);
        let gravity = match body.frame {
            Frame::Held => body.state.orientation.inverse_transform_vector(&gravity),
            // A free body falls as a whole; a driven one moves as it is told.
            Frame::Free | Frame::Driven => Vector3::zeros(),
        };
        for (j, mode) in model.modes.iter().enumerate() {
            let at = body.start + j;
            // Without contacts, what is bent would spring back within one step. Regions are looked for in parts of a step, each as
            // long as this motion allows: it may not depend on what contacts did in a part of another length.
            let held = if model.contact == ContactShape::Regions {
                0.0
            } else {
                modal.moved[at]
            };
            modal.moved[at] = 0.0;
            let force = modal.force[at] + mode.momentum.dot(&gravity);
            if body.frame == Frame::Driven {
                modal.q[at] = mode.limit.q(modal.s[at]);
                modal.end_q[at] = mode.limit.q(modal.end_s[at]);
                (modal.slope[at], modal.per_force[at]) = (1.0, 0.0);
                modal.change[at] = 0.5 * (modal.end_q[at] - modal.q[at]);
                continue;
            }
            let slope = mode.limit.slope(modal.s[at]);
            let transition = mode.transition_of(part_s, whole_s)?;
            let [s, rate] =
                transition.apply([modal.s[at], modal.rate[at]], slope * force / mode.mass);
            (modal.end_s[at], modal.end_rate[at]) = (s, rate);
            modal.q[at] = mode.limit.q(modal.s[at]);
            modal.end_q[at] = mode.limit.q(s);
            modal.change[at] = 0.5 * (modal.end_q[at] + held - modal.q[at]);
            let end_slope = mode.limit.slope(s);
            modal.end_q_rate[at] = end_slope * rate;
            let slope = 0.5 * (slope + end_slope);
            modal.slope[at] = slope;
            modal.per_force[at] = slope * slope * transition.q_a / mode.mass;
        }
        Ok(())
    }

    /// Forces of the caller's act for one step.
    pub(super) fn forget_forces(&mut self) {
        for body in &mut self.bodies {
            (body.force, body.torque) = (Vector3::zeros(), Vector3::zeros());
        }
        self.modal.force.fill(0.0);
    }

    /// Says where a driven body's mesh is, and what q is, at the end of the next step.
    ///
    /// # Errors
    /// A body that the world does not have or that is not driven, another number of values than modes, a q that is not
    /// below the strain limit.
    pub fn drive(
        &mut self,
        body: super::BodyId,
        q: &[f64],
        at: impl Into<bdtree_runtime::Transform>,
    ) -> Result<(), DynamicsError> {
        let at = at.into();
        let super::BodyId(index) = body;
        let Some(of) = self
            .bodies
            .get_mut(index)
            .filter(|of| of.frame == Frame::Driven)
        else {
            return Err(DynamicsError::Unknown {
                what: "driven body",
                index,
            });
        };
        let model = &self.models[of.model];
        let (expected, found) = (model.modes.len(), q.len());
        if expected != found {
            return Err(DynamicsError::ModeCount { expected, found });
        }
        for (mode, (record, &q)) in model.modes.iter().zip(q).enumerate() {
            let limit = record.limit.0;
            let s = record
                .limit
                .s(q)
                .ok_or(DynamicsError::Limit { mode, q, limit })?;
            self.modal.end_s[of.start + mode] = s;
        }
        (of.end.position, of.end.orientation) = model.frame(&at);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rotation::rotation;

    /// A rotation and the chord of its angle.
    #[test]
    fn chords_bound_what_turning_moves() {
        let turned = rotation(Vector3::new(0.3, -0.2, 0.5));
        let chord = 2.0 * turned.imag().norm();
        let p = Vector3::new(1.0, 2.0, -0.5);
        assert!((turned * p - p).norm() <= chord * p.norm());
    }
}
