//! The poses that trees are asked at, each for as many steps as its body stays near it.
//!
//! Which contact spheres may touch is asked of trees at *snapshots* of bodies, with an *allowance*: how far contact spheres
//! may get from where they are in the snapshot until a new one is needed. The answer for two bodies holds until one of them
//! needs a new snapshot, as a list of near neighbors does in molecular dynamics (Verlet 1967). It depends on the two
//! snapshots alone, so that a world that goes on from saved snapshots finds the same. Bodies of the shape
//! [`ContactShape::Regions`] take one in each part of a step.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::{Frame, World, half_way, part};
use crate::body_model::{BodyModel, ContactShape};
use crate::error::DynamicsError;
use crate::level_spheres::LevelSpheres;
use crate::rotation::rotation;

/// Contact spheres may move within a step by as much as falling and turning move them without contacts and this many times as
/// much: contacts elsewhere may push them on. What modes move is taken once.
const FAR: f64 = 2.0;

/// What rounding to f32 changes a number by, relative to it.
const F32: f64 = 6e-8;

/// The part of an allowance beyond the step, in steps of the present speed.
const STEPS: f64 = 8.0;

/// Its limits, in mean radii of contact spheres. Bodies too fast for a few steps within the larger one have none.
const LEAST: f64 = 0.1;
const MOST: f64 = 0.5;
const FEW_STEPS: f64 = 2.0;

/// How far ahead of a body its snapshot is, as a share of what it may move by.
const LEAD: f64 = 0.75;

/// A snapshot is taken before it must be, in one step of `TURN`, if the allowance would be `MUCH` smaller.
const TURN: u64 = 16;
const MUCH: f64 = 1.5;

/// Motion of modes that need not be known better than by the length of q, in mean radii.
const LITTLE: f64 = 0.03;

/// Where trees were asked for a body, ahead of where it was then; q is [`Modal::snapshot_q`](super::body::Modal).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Snapshot {
    pub(super) position: Vector3<f64>,
    pub(super) orientation: UnitQuaternion<f64>,
    /// How far contact spheres may get from there, world units. Negative: there is no snapshot yet.
    pub(super) allowance: f64,
    /// Whether it holds for this step alone, since the body is too fast: answers for it are not kept.
    pub(super) is_brief: bool,
    /// Whether it is of this step: what trees said before does not hold any more.
    pub(super) is_new: bool,
}

impl Snapshot {
    /// That of a body that has not been looked at.
    pub(super) fn none() -> Self {
        Self {
            position: Vector3::zeros(),
            orientation: UnitQuaternion::identity(),
            allowance: -1.0,
            is_brief: false,
            is_new: false,
        }
    }
}

/// A body's contact spheres at its snapshot.
pub(super) struct AtSnapshot<'w> {
    spheres: &'w LevelSpheres,
    position: Vector3<f64>,
    turn: Matrix3<f64>,
    q: &'w [f64],
}

impl AtSnapshot<'_> {
    pub(super) fn center(&self, sphere: usize) -> Vector3<f64> {
        self.position + self.turn * self.spheres.center(sphere, self.q)
    }
}

impl World {
    pub(super) fn at_snapshot(&self, index: usize) -> AtSnapshot<'_> {
        let body = &self.bodies[index];
        let spheres = &self.models[body.model].spheres;
        AtSnapshot {
            spheres,
            position: body.snapshot.position,
            turn: (body.snapshot.orientation)
                .to_rotation_matrix()
                .into_inner(),
            q: part(&self.modal.snapshot_q, body.start, spheres.stride()),
        }
    }

    /// Says how far contact spheres may be from the middle of the step within it, and takes a snapshot there if that is too
    /// far from the last one.
    pub(super) fn follow(&mut self, index: usize) -> Result<(), DynamicsError> {
        let body = &mut self.bodies[index];
        let model = &self.models[body.model];
        let spheres = &model.spheres;
        let own = body.start..body.start + spheres.stride();
        let modal = &mut self.modal;
        let (q, end_q) = (&modal.q[own.clone()], &modal.end_q[own.clone()]);
        let (change, kept) = (&mut modal.change[own.clone()], &mut modal.snapshot_q[own]);
        let mut size = 0.0;
        for (change, q) in change.iter().zip(q) {
            let end = q + 2.0 * change;
            size += f64::max(q * q, end * end);
        }
        let mut size = libm::sqrt(size);
        let half = half_way(&body.state.orientation, &body.end.orientation);
        let both = [body.state.orientation, body.end.orientation];
        body.rotations = both.map(|turn| turn.to_rotation_matrix().into_inner());
        body.way = (body.end.position - body.state.position) * 0.5;
        let middle = body.state.position + body.way;
        // Rounding q to f32 changes it too.
        let rounded = model.moved_within(F32 * size) + model.redundant_move;
        let extent = model.extent() + model.moved_within(size);
        // What a contact sphere's radius is to motion.
        let radius = match model.surface {
            Some(_) => self.finest.min(spheres.radius_mean),
            None => spheres.radius_mean,
        };
        body.swing = chord(&half, &body.end.orientation) * extent;
        let waves = model.moved(change, LITTLE * radius);
        body.ripple = (waves + rounded) * (1.0 + 1e-9);
        let falls = body.way.norm() + body.swing;
        let needed = (FAR * falls + body.ripple) * (1.0 + 1e-9);
        if model.contact == ContactShape::Regions {
            // Regions are those at the beginning of the step.
            body.far = (falls + body.ripple + needed) * (1.0 + 1e-9);
            body.snapshot = Snapshot {
                position: body.state.position,
                orientation: body.state.orientation,
                allowance: body.far,
                is_brief: true,
                is_new: true,
            };
            kept.copy_from_slice(q);
            return self.pose_at_snapshot(index);
        }
        // Farther from the snapshot than the allowance?
        let snapshot = &mut body.snapshot;
        let mut kept_size = 0.0;
        for (change, (q, kept)) in change.iter_mut().zip(q.iter().zip(&*kept)) {
            *change += q - kept;
            kept_size += kept * kept;
        }
        size = size.max(libm::sqrt(kept_size));
        let extent = model.extent() + model.moved_within(size);
        let mut off =
            (middle - snapshot.position).norm() + chord(&snapshot.orientation, &half) * extent;
        let left = snapshot.allowance * (1.0 - 1e-9) - needed - off;
        off += model.moved(change, left);
        body.far = off * (1.0 + 1e-9) + needed;
        let is_enough = body.far <= snapshot.allowance;
        // Now and then a body that has come to rest gets a smaller one, so that lists get shorter.
        // What sleeps keeps it, since a world that goes on does not look.
        let is_turn = !body.rest.is_asleep && (self.steps + index as u64).is_multiple_of(TURN);
        if is_enough && !(is_turn && snapshot.allowance > MUCH * (needed + LEAST * radius)) {
            return Ok(());
        }
        // As it moves, not as it would without contacts that hold it.
        let per_step = 2.0 * waves
            + if body.frame == Frame::Driven {
                2.0 * falls
            } else {
                self.part_s * (body.state.velocity.norm() + body.spin.norm() * extent)
            };
        let margin = if FEW_STEPS * per_step > MOST * radius {
            0.0
        } else {
            (STEPS * per_step).clamp(LEAST * radius, MOST * radius)
        };
        if is_enough && snapshot.allowance <= MUCH * (needed + margin) {
            return Ok(());
        }
        // Ahead of the body, so that it comes to its snapshot and then leaves it: that lasts longer than leaving it at once. Modes
        // turn round too soon for that, but for those that are told how to move.
        let lead = if margin > 0.0 {
            f64::min(LEAD * margin / per_step, STEPS)
        } else {
            0.0
        };
        let is_driven = body.frame == Frame::Driven;
        let way = if is_driven {
            body.way * 2.0
        } else {
            body.state.velocity * self.part_s
        };
        let position = middle + way * lead;
        let orientation = rotation(body.spin * (self.part_s * lead)) * half;
        let mut kept_size = 0.0;
        let ends = q.iter().zip(end_q);
        for ((kept, change), (from, to)) in kept.iter_mut().zip(change.iter_mut()).zip(ends) {
            let ahead = if is_driven { (to - from) * lead } else { 0.0 };
            *kept += *change + ahead;
            *change = ahead;
            kept_size += *kept * *kept;
        }
        size = size.max(libm::sqrt(kept_size));
        let extent = model.extent() + model.moved_within(size);
        let off = (position - middle).norm()
            + chord(&orientation, &half) * extent
            + model.moved(change, 0.0);
        body.far = (off + needed) * (1.0 + 1e-9);
        *snapshot = Snapshot {
            position,
            orientation,
            allowance: f64::max(needed + margin, body.far),
            is_brief: margin == 0.0,
            is_new: true,
        };
        self.pose_at_snapshot(index)
    }

    /// Poses the instance at the snapshot.
    pub(super) fn pose_at_snapshot(&mut self, index: usize) -> Result<(), DynamicsError> {
        let body = &self.bodies[index];
        let model = &self.models[body.model];
        let mut q = [0.0_f32; super::MODES_MAX];
        let q = &mut q[..model.model.asset().mode_count()];
        let kept = &self.modal.snapshot_q[body.start..];
        for (q, kept) in q.iter_mut().zip(&kept[..model.modes.len()]) {
            *q = *kept as f32;
        }
        redundant(model, q);
        let instance = &mut self.instances[index];
        let at = model.placement(body.snapshot.position, body.snapshot.orientation);
        instance.set_pose(q, at)?;
        let pose = instance.pose();
        let mut sphere = pose.bounding_sphere()?;
        sphere.radius += model.spheres.reach() + body.snapshot.allowance;
        sphere.radius *= 1.0 + 1e-9;
        self.spheres[index] = sphere;
        self.caches[index].get_mut().start(&pose);
        Ok(())
    }

    /// Poses all instances at their snapshots again.
    pub(super) fn return_to_snapshots(&mut self) -> Result<(), DynamicsError> {
        for index in 0..self.bodies.len() {
            if self.bodies[index].snapshot.allowance >= 0.0 {
                self.pose_at_snapshot(index)?;
            }
        }
        Ok(())
    }
}

/// Sets what costs bounds as much as deformation and changes nothing.
fn redundant(model: &BodyModel, q: &mut [f32]) {
    for (q, redundant) in q.iter_mut().zip(&model.redundant_q) {
        *q = *redundant;
    }
}

/// Between where a rotation takes a point at distance 1 and where another one does, at most.
fn chord(from: &UnitQuaternion<f64>, to: &UnitQuaternion<f64>) -> f64 {
    2.0 * from.rotation_to(to).imag().norm() * (1.0 + 1e-9)
}
