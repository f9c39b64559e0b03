//! Bodies at the end of the step: what they would be without contacts, and what contact forces have changed.

use super::World;
use super::body::Frame;
use crate::error::DynamicsError;
use crate::frame::FrameState;

impl World {
    /// # Errors
    /// Something that is not finite.
    pub(super) fn advance(&mut self) -> Result<(), DynamicsError> {
        let (whole, h) = (self.options.step_s, self.part_s);
        for body in &mut self.bodies {
            if body.rest.is_asleep {
                continue;
            }
            let model = &self.models[body.model];
            body.state = match (body.frame, &model.mass) {
                (Frame::Free, Some(mass)) => {
                    body.end
                        .moved(mass, body.moved, body.turned, &body.rotation, h)
                }
                // What is moved otherwise has no speed of its own.
                _ => FrameState::at(body.end.position, body.end.orientation),
            };
            let state = &body.state;
            let mut sum =
                state.position.sum() + state.velocity.sum() + state.angular_momentum.sum();
            let modal = &mut self.modal;
            for (j, mode) in model.modes.iter().enumerate() {
                let at = body.start + j;
                let (s, rate) = (modal.end_s[at], modal.end_rate[at]);
                // Where the limit lets nothing pass, forces have moved nothing.
                let moved = if modal.slope[at] > 0.0 {
                    modal.moved[at] / modal.slope[at]
                } else {
                    0.0
                };
                modal.s[at] = s + moved;
                let transition = mode.transition_of(h, whole)?;
                modal.rate[at] = rate + moved * (transition.q_v / transition.q_a);
                sum += modal.s[at] + modal.rate[at];
            }
            if !sum.is_finite() {
                return Err(DynamicsError::NotFinite {
                    what: "the state after a step",
                });
            }
        }
        Ok(())
    }
}
