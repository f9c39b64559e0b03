//! Steps that are divided into parts, so that no vertex gets through a wall between one look at it and the next.
//!
//! Bodies whose surfaces meet exactly ([`ContactShape::Regions`](crate::ContactShape)) are compared at the beginning of each part.
//! Within a part no vertex of theirs moves by more than half the thinnest wall of any of them. How fast they are says
//! how many parts there should be; contact forces may make them faster, so that a part after which one would be farther away is
//! looked at again, shorter.

use nalgebra::{UnitQuaternion, Vector3};

use super::body::{Body, Modal};
use super::{Frame, StepReport, World};
use crate::body_model::{BodyModel, ContactShape};
use crate::error::DynamicsError;

/// Most parts that what is left of a step is divided into.
const PARTS_MOST: u32 = 4096;

/// Of half the wall, what bodies without contacts may use: those that are hit are faster.
const SHARE: f64 = 0.75;

impl World {
    /// # Errors
    /// Those of [`World::step`], bodies too fast for their walls.
    pub(super) fn step_in_parts(&mut self) -> Result<StepReport, DynamicsError> {
        self.set_goals();
        let mut left = self.options.step_s;
        let mut report = StepReport::default();
        loop {
            let ratio = self.moves_in(left) / (SHARE * 0.5 * self.wall);
            let mut parts = self.parts(left, 1, ratio)?;
            let mut of_part = loop {
                self.part_s = left / f64::from(parts);
                self.approach_goals(1.0 / f64::from(parts));
                let of_part = self.meet()?;
                let ratio = self.moved_in_part() / (0.5 * self.wall);
                if ratio <= 1.0 {
                    break of_part;
                }
                parts = self.parts(left, parts, 1.1 * ratio)?;
            };
            self.part_with(&mut of_part)?;
            report.add(&of_part);
            if parts == 1 {
                break;
            }
            left -= self.part_s;
        }
        self.part_s = self.options.step_s;
        Ok(report)
    }

    /// `parts` times `ratio`, rounded up.
    fn parts(&self, left: f64, parts: u32, ratio: f64) -> Result<u32, DynamicsError> {
        if !ratio.is_finite() {
            return Err(DynamicsError::NotFinite {
                what: "the speed of a body",
            });
        }
        let more = libm::ceil(f64::from(parts) * ratio).max(1.0);
        if more <= f64::from(PARTS_MOST) {
            return Ok(more as u32);
        }
        Err(DynamicsError::Parts {
            wall: self.wall,
            limit: PARTS_MOST,
            step_max_s: left * f64::from(PARTS_MOST) / more,
        })
    }

    /// What vertices move by at most in so many seconds, without contacts and as fast as they are.
    fn moves_in(&mut self, seconds: f64) -> f64 {
        let gravity = Vector3::from(self.options.gravity).norm();
        self.most_of_regions(|body, model, modal, change| {
            let (from, is_driven) = (&body.state, body.frame == Frame::Driven);
            for (j, (change, mode)) in change.iter_mut().zip(&model.modes).enumerate() {
                let at = body.start + j;
                *change = if is_driven {
                    mode.limit.q(modal.goal[at]) - mode.limit.q(modal.s[at])
                } else {
                    seconds * modal.rate[at]
                };
            }
            match &model.mass {
                Some(mass) if body.frame == Frame::Free => {
                    let pull = body.force.norm() / mass.mass_kg + gravity;
                    let way = seconds * (from.velocity.norm() + 0.5 * seconds * pull);
                    (way, seconds * from.angular_velocity(mass).norm())
                }
                _ if is_driven => {
                    let (position, orientation) = &body.goal;
                    let turn = from.orientation.angle_to(orientation);
                    ((position - from.position).norm(), turn)
                }
                _ => (0.0, 0.0),
            }
        })
    }

    /// What vertices move by at most in the part, contacts included.
    fn moved_in_part(&mut self) -> f64 {
        self.most_of_regions(|body, model, modal, change| {
            for (j, (change, mode)) in change.iter_mut().zip(&model.modes).enumerate() {
                let at = body.start + j;
                let moved = match modal.slope[at] {
                    slope if slope > 0.0 => modal.moved[at] / slope,
                    _ => 0.0,
                };
                *change = mode.limit.q(modal.end_s[at] + moved) - modal.q[at];
            }
            let (from, end) = (&body.state, &body.end);
            let way = end.position - from.position + body.moved;
            let turn = from.orientation.angle_to(&end.orientation) + body.turned.norm();
            (way.norm(), turn)
        })
    }

    /// The most that vertices of a body move by. `of` says how far its frame goes and by which angle it turns, and writes down
    /// how q changes.
    fn most_of_regions(
        &mut self,
        of: impl Fn(&Body, &BodyModel, &Modal, &mut [f64]) -> (f64, f64),
    ) -> f64 {
        let mut most = 0.0_f64;
        let mut changes = core::mem::take(&mut self.modal.change);
        for body in &self.bodies {
            let model = &self.models[body.model];
            if body.rest.is_asleep || model.contact != ContactShape::Regions {
                continue;
            }
            let change = &mut changes[body.start..body.start + model.spheres.stride()];
            let (way, turn) = of(body, model, &self.modal, change);
            let squares =
                (model.modes.iter().zip(&*change).enumerate()).map(|(j, (mode, change))| {
                    let q = mode.limit.q(self.modal.s[body.start + j]).abs() + change.abs();
                    q * q
                });
            let lever = model.extent() + model.moved_within(libm::sqrt(squares.sum()));
            let moved = way + turn * lever + model.moved(change, 0.0);
            // What is not a number stays.
            most = if most.is_nan() || moved <= most {
                most
            } else {
                moved
            };
        }
        self.modal.change = changes;
        most
    }

    /// Keeps where driven bodies are to be at the end of the step.
    fn set_goals(&mut self) {
        for body in &mut self.bodies {
            if body.frame == Frame::Driven {
                body.goal = (body.end.position, body.end.orientation);
                let stride = self.models[body.model].spheres.stride();
                let own = body.start..body.start + stride;
                let modal = &mut self.modal;
                modal.goal[own.clone()].copy_from_slice(&modal.end_s[own]);
            }
        }
    }

    /// Lets driven bodies go so much of their way in the part.
    fn approach_goals(&mut self, share: f64) {
        for body in &mut self.bodies {
            if body.frame != Frame::Driven {
                continue;
            }
            let (position, orientation) = body.goal;
            let stride = self.models[body.model].spheres.stride();
            let modal = &mut self.modal;
            for at in body.start..body.start + stride {
                modal.end_s[at] = towards(modal.s[at], modal.goal[at], share);
            }
            let from = &body.state;
            body.end.position =
                (from.position).zip_map(&position, |from, to| towards(from, to, share));
            body.end.orientation = turned(&from.orientation, &orientation, share);
        }
    }
}

/// A share of the way; all of it to the bit.
fn towards(from: f64, to: f64, share: f64) -> f64 {
    if share < 1.0 {
        from + (to - from) * share
    } else {
        to
    }
}

/// The same for orientations, the shorter way round.
fn turned(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>, share: f64) -> UnitQuaternion<f64> {
    if !(share < 1.0) {
        return *to;
    }
    let near = if from.coords.dot(&to.coords) < 0.0 {
        UnitQuaternion::new_unchecked(-to.into_inner())
    } else {
        *to
    };
    from.nlerp(&near, share)
}

impl StepReport {
    /// Adds a part of the step.
    fn add(&mut self, part: &Self) {
        let before = core::mem::replace(self, *part);
        self.nodes_visited += before.nodes_visited;
        self.nodes_updated += before.nodes_updated;
        self.sweeps += before.sweeps;
        self.parts += before.parts;
        self.penetration = self.penetration.max(before.penetration);
        self.penetration_rel = self.penetration_rel.max(before.penetration_rel);
        if before.parts > 0 {
            self.contact_energy = before.contact_energy;
        }
    }
}
