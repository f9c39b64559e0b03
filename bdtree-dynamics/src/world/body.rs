//! A body's state, and what a step knows of it.

use alloc::vec::Vec;

use bdtree_runtime::{Instance, Transform};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::sleep::Rest;
use super::snapshot::Snapshot;
use super::{BodyId, World, part};
use crate::body_model::BodyModel;
use crate::error::DynamicsError;
use crate::frame::FrameState;

/// What moves a body's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frame {
    /// Forces: the floating frame.
    Free,
    /// Nothing: it stays where it is, and its modes move.
    Held,
    /// The caller, by [`World::drive`]: frame and q.
    Driven,
}

/// Position, orientation and speeds of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyState {
    /// Center of mass (for bodies without mass properties the mesh's origin), world units.
    pub position: [f64; 3],
    /// From the principal axes of inertia (or the mesh's axes) to the world's: x, y, z, w.
    pub orientation: [f64; 4],
    /// World units per second.
    pub velocity: [f64; 3],
    /// Angular momentum about the center of mass, kg · world unit² / s.
    pub angular_momentum: [f64; 3],
}

/// Energies of a world, J where world units are meters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// Of the frames' motion.
    pub kinetic: f64,
    /// Of the modes: motion and deformation.
    pub modal: f64,
    /// In the field of gravity, above the world's origin.
    pub potential: f64,
}

impl Energy {
    /// All of it.
    pub fn mechanical(&self) -> f64 {
        self.kinetic + self.modal + self.potential
    }
}

#[derive(Debug, Clone)]
pub(super) struct Body {
    pub(super) model: usize,
    pub(super) frame: Frame,
    pub(super) state: FrameState,
    /// Of the caller, for the step to come; cleared by it.
    pub(super) force: Vector3<f64>,
    pub(super) torque: Vector3<f64>,
    /// Where its numbers begin in [`Modal`].
    pub(super) start: usize,
    /// At the end of the step without contacts.
    pub(super) end: FrameState,
    /// Of a driven body in a step of several parts: where it is to be after the last one.
    pub(super) goal: (Vector3<f64>, UnitQuaternion<f64>),
    /// In its middle: position at constant speed, rotation, angular velocity.
    pub(super) middle: Vector3<f64>,
    pub(super) rotation: Matrix3<f64>,
    pub(super) spin: Vector3<f64>,
    /// Rotations at the beginning and at the end without contacts.
    pub(super) rotations: [Matrix3<f64>; 2],
    /// Of a driven body: whether the step moves it.
    pub(super) is_under_way: bool,
    /// Half of how its center moves in the step without contacts.
    pub(super) way: Vector3<f64>,
    /// What turning moves any contact sphere by from the middle of the step to either end.
    pub(super) swing: f64,
    /// What modes do, if contacts move them as in the step before.
    pub(super) ripple: f64,
    /// How far contact spheres may be from the snapshot within the step.
    pub(super) far: f64,
    /// What forces do to it within the step: displacement over force, and turn over torque (world).
    pub(super) per_force: f64,
    pub(super) per_torque: Matrix3<f64>,
    /// What contacts do to it within the step: displacement and turn.
    pub(super) moved: Vector3<f64>,
    pub(super) turned: Vector3<f64>,
    pub(super) snapshot: Snapshot,
    pub(super) rest: Rest,
}

/// Numbers of all bodies' modes, those of a body one behind the other, padded.
#[derive(Debug, Clone, Default)]
pub(super) struct Modal {
    /// s and ṡ.
    pub(super) s: Vec<f64>,
    pub(super) rate: Vec<f64>,
    /// Generalised forces of the caller's, for the step to come.
    pub(super) force: Vec<f64>,
    /// q at the beginning, and at the end without contacts.
    pub(super) q: Vec<f64>,
    pub(super) end_q: Vec<f64>,
    /// s and ṡ at the end without contacts.
    pub(super) end_s: Vec<f64>,
    pub(super) end_rate: Vec<f64>,
    /// How fast q changes at the end without contacts, of bodies that are not driven.
    pub(super) end_q_rate: Vec<f64>,
    /// dq/ds in the step.
    pub(super) slope: Vec<f64>,
    /// Displacement of q over force, and what contacts have moved it by.
    pub(super) per_force: Vec<f64>,
    pub(super) moved: Vec<f64>,
    /// s of driven bodies at the end of a step of several parts.
    pub(super) goal: Vec<f64>,
    /// q of snapshots.
    pub(super) snapshot_q: Vec<f64>,
    /// Half of what the step is expected to change q by; then how far q is from its snapshot.
    pub(super) change: Vec<f64>,
    start: usize,
}

impl Modal {
    pub(super) fn add(&mut self, stride: usize) {
        self.start = self.s.len();
        let len = self.start + stride;
        for all in self.all() {
            all.resize(len, 0.0);
        }
    }

    /// Where the last body's numbers begin.
    pub(super) fn start(&self) -> usize {
        self.start
    }

    fn all(&mut self) -> [&mut Vec<f64>; 14] {
        [
            &mut self.s,
            &mut self.rate,
            &mut self.force,
            &mut self.q,
            &mut self.end_q,
            &mut self.end_s,
            &mut self.end_rate,
            &mut self.end_q_rate,
            &mut self.slope,
            &mut self.per_force,
            &mut self.moved,
            &mut self.goal,
            &mut self.snapshot_q,
            &mut self.change,
        ]
    }
}

impl Body {
    pub(super) fn new(model: usize, frame: Frame, state: FrameState, start: usize) -> Self {
        let zero = Vector3::zeros();
        Self {
            model,
            frame,
            state,
            force: zero,
            torque: zero,
            start,
            end: state,
            goal: (state.position, state.orientation),
            middle: state.position,
            rotation: Matrix3::identity(),
            spin: zero,
            rotations: [Matrix3::identity(); 2],
            is_under_way: false,
            way: zero,
            swing: 0.0,
            ripple: 0.0,
            far: 0.0,
            per_force: 0.0,
            per_torque: Matrix3::zeros(),
            moved: zero,
            turned: zero,
            snapshot: Snapshot::none(),
            rest: Rest::default(),
        }
    }
}

impl Body {
    /// Whether forces move any of its modes in the step.
    pub(super) fn per_mode_moves(&self, per_force: &[f64], stride: usize) -> bool {
        part(per_force, self.start, stride)
            .iter()
            .any(|of| *of != 0.0)
    }
}

impl World {
    fn at(&self, body: BodyId) -> Result<&Body, DynamicsError> {
        let BodyId(index) = body;
        self.bodies.get(index).ok_or(unknown(index))
    }

    fn at_mut(&mut self, body: BodyId) -> Result<&mut Body, DynamicsError> {
        let BodyId(index) = body;
        self.bodies.get_mut(index).ok_or(unknown(index))
    }

    /// Position, orientation and speeds of a body.
    ///
    /// # Errors
    /// A body that the world does not have.
    pub fn state(&self, body: BodyId) -> Result<BodyState, DynamicsError> {
        let body = self.at(body)?;
        Ok(BodyState {
            position: body.state.position.into(),
            orientation: body.state.orientation.coords.into(),
            velocity: body.state.velocity.into(),
            angular_momentum: body.state.angular_momentum.into(),
        })
    }

    /// Sets velocity (world units per second) and angular velocity (rad/s, world axes) of a free body.
    ///
    /// # Errors
    /// A body that the world does not have, numbers that are not finite.
    pub fn set_velocity(
        &mut self,
        body: BodyId,
        velocity: [f64; 3],
        angular_velocity: [f64; 3],
    ) -> Result<(), DynamicsError> {
        let (v, spin) = (
            finite(velocity, "velocity")?,
            finite(angular_velocity, "angular velocity")?,
        );
        let BodyId(index) = body;
        let of = self.bodies.get_mut(index).ok_or(unknown(index))?;
        if let Some(mass) = &self.models[of.model].mass {
            of.state.velocity = v;
            of.state.angular_momentum = of.state.momentum_of(mass, spin);
            of.disturb();
        }
        Ok(())
    }

    /// Ω of a body, rad/s, world axes.
    ///
    /// # Errors
    /// A body that the world does not have.
    pub fn angular_velocity(&self, body: BodyId) -> Result<[f64; 3], DynamicsError> {
        let body = self.at(body)?;
        let spin = (self.models[body.model].mass).map(|mass| body.state.angular_velocity(&mass));
        Ok(spin.unwrap_or_default().into())
    }

    /// A force (N) at the center of mass and a torque (N · world unit), world axes, for the next step; several add up.
    ///
    /// # Errors
    /// A body that the world does not have, numbers that are not finite.
    pub fn add_force(
        &mut self,
        body: BodyId,
        force: [f64; 3],
        torque: [f64; 3],
    ) -> Result<(), DynamicsError> {
        let (force, torque) = (finite(force, "force")?, finite(torque, "torque")?);
        let body = self.at_mut(body)?;
        body.force += force;
        body.torque += torque;
        body.disturb();
        Ok(())
    }

    /// Generalised forces on q for the next step, one per mode (`Uᵀ f` with U in world units:
    /// [`Pose::add_generalized_force`](bdtree_runtime::Pose::add_generalized_force)); several add up.
    ///
    /// # Errors
    /// A body that the world does not have, another number of forces than it has modes, forces that are not finite.
    pub fn add_modal_force(&mut self, body: BodyId, force: &[f64]) -> Result<(), DynamicsError> {
        let start = self.modal_start(body, force.len())?;
        if !force.iter().all(|f| f.is_finite()) {
            return Err(DynamicsError::NotFinite {
                what: "modal force",
            });
        }
        for (sum, force) in self.modal.force[start..].iter_mut().zip(force) {
            *sum += force;
        }
        self.at_mut(body)?.disturb();
        Ok(())
    }

    /// Impulses on q, one per mode: their rates change at once.
    ///
    /// # Errors
    /// As for [`World::add_modal_force`].
    pub fn add_modal_impulse(
        &mut self,
        body: BodyId,
        impulse: &[f64],
    ) -> Result<(), DynamicsError> {
        let start = self.modal_start(body, impulse.len())?;
        if !impulse.iter().all(|p| p.is_finite()) {
            return Err(DynamicsError::NotFinite {
                what: "modal impulse",
            });
        }
        let model = &self.models[self.bodies[body.0].model];
        for (j, (mode, impulse)) in model.modes.iter().zip(impulse).enumerate() {
            let slope = mode.limit.slope(self.modal.s[start + j]);
            self.modal.rate[start + j] += slope * impulse / mode.mass;
        }
        self.at_mut(body)?.disturb();
        Ok(())
    }

    fn modal_start(&self, body: BodyId, found: usize) -> Result<usize, DynamicsError> {
        let body = self.at(body)?;
        let expected = self.models[body.model].modes.len();
        if expected != found {
            return Err(DynamicsError::ModeCount { expected, found });
        }
        Ok(body.start)
    }

    /// Sets q and its rates (per second), one number per mode that moves.
    ///
    /// # Errors
    /// A body that the world does not have, another number of values, values that are not finite, a q that is not below
    /// the strain limit.
    pub fn set_modes(
        &mut self,
        body: BodyId,
        q: &[f64],
        rate: &[f64],
    ) -> Result<(), DynamicsError> {
        let start = self.modal_start(body, q.len())?;
        self.modal_start(body, rate.len())?;
        let modes = &self.models[self.bodies[body.0].model].modes;
        for (mode, (of, &q)) in modes.iter().zip(q).enumerate() {
            let limit = of.limit.0;
            if of.limit.s(q).is_none() {
                return Err(DynamicsError::Limit { mode, q, limit });
            }
        }
        if !rate.iter().all(|x| x.is_finite()) {
            return Err(DynamicsError::NotFinite { what: "rate of q" });
        }
        for (j, (of, (&q, &rate))) in modes.iter().zip(q.iter().zip(rate)).enumerate() {
            let s = of.limit.s(q).unwrap_or(q);
            self.modal.s[start + j] = s;
            self.modal.rate[start + j] = rate / of.limit.slope(s);
        }
        self.at_mut(body)?.disturb();
        Ok(())
    }

    /// Writes q of a body, one number per mode that moves, to `out`.
    ///
    /// # Errors
    /// A body that the world does not have, another number of values.
    pub fn q(&self, body: BodyId, out: &mut [f64]) -> Result<(), DynamicsError> {
        let start = self.modal_start(body, out.len())?;
        let modes = &self.models[self.bodies[body.0].model].modes;
        for (j, (of, out)) in modes.iter().zip(out).enumerate() {
            *out = of.limit.q(self.modal.s[start + j]);
        }
        Ok(())
    }

    /// Writes how fast q of a body changes (per second), one number per mode that moves, to `out`.
    ///
    /// # Errors
    /// Those of [`World::q`].
    pub fn q_rate(&self, body: BodyId, out: &mut [f64]) -> Result<(), DynamicsError> {
        let start = self.modal_start(body, out.len())?;
        let modes = &self.models[self.bodies[body.0].model].modes;
        for (j, (of, out)) in modes.iter().zip(out).enumerate() {
            let slope = of.limit.slope(self.modal.s[start + j]);
            *out = slope * self.modal.rate[start + j];
        }
        Ok(())
    }

    /// Where a body's mesh is.
    ///
    /// # Errors
    /// A body that the world does not have.
    pub fn placement(&self, body: BodyId) -> Result<Transform, DynamicsError> {
        let body = self.at(body)?;
        Ok(self.models[body.model].placement(body.state.position, body.state.orientation))
    }

    /// The instances, posed as bodies are now after [`World::pose_instances`]; steps leave them where they ask their trees.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The model of a body.
    ///
    /// # Errors
    /// A body that the world does not have.
    pub fn model_of(&self, body: BodyId) -> Result<&BodyModel, DynamicsError> {
        Ok(&self.models[self.at(body)?.model])
    }

    /// Energies of all bodies as they are now. Contacts' energy is in the report of the step that begins here.
    pub fn energy(&self) -> Energy {
        let mut sum = Energy::default();
        let gravity = Vector3::from(self.options.gravity);
        for body in &self.bodies {
            let model = &self.models[body.model];
            if let (Frame::Free, Some(mass)) = (body.frame, &model.mass) {
                sum.kinetic += body.state.kinetic_energy(mass);
                sum.potential -= mass.mass_kg * gravity.dot(&body.state.position);
            }
            if body.frame == Frame::Driven {
                continue;
            }
            let stride = model.spheres.stride();
            let s = part(&self.modal.s, body.start, stride);
            let rate = part(&self.modal.rate, body.start, stride);
            for ((mode, s), rate) in model.modes.iter().zip(s).zip(rate) {
                let omega = mode.oscillator.omega_rad_s * s;
                sum.modal += 0.5 * mode.mass * (rate * rate + omega * omega);
            }
        }
        sum
    }

    /// Momentum and angular momentum about the world's origin of all free bodies.
    pub fn momenta(&self) -> [[f64; 3]; 2] {
        let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
        for body in &self.bodies {
            if let (Frame::Free, Some(mass)) = (body.frame, &self.models[body.model].mass) {
                let p = body.state.velocity * mass.mass_kg;
                linear += p;
                angular += body.state.angular_momentum + body.state.position.cross(&p);
            }
        }
        [linear.into(), angular.into()]
    }
}

fn unknown(index: usize) -> DynamicsError {
    DynamicsError::Unknown {
        what: "body",
        index,
    }
}

fn finite(x: [f64; 3], what: &'static str) -> Result<Vector3<f64>, DynamicsError> {
    if x.iter().all(|x| x.is_finite()) {
        Ok(x.into())
    } else {
        Err(DynamicsError::NotFinite { what })
    }
}
