//! The forces of all contacts: Gauss–Seidel sweeps, contact after contact.
//!
//! Each visit computes how the pair moves under all forces so far, and then the normal force that the contact law wants and
//! the friction that stops the slip, within the cone. Displacements are linear in forces, so a visit costs two products
//! with Ū for each side, and bodies need no other memory than their displacements.

use nalgebra::Vector3;

use super::contact::{Contact, Side, bodies_of, slipping};
use super::{StepReport, World};
use crate::error::DynamicsError;

/// Pairs that do not touch are visited in every so many sweeps.
const OPEN_EVERY: usize = 3;

/// Forces of a contact, for the next step to begin with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Warm {
    pub(super) sides: [Side; 2],
    pub(super) normal: f64,
    pub(super) across: Vector3<f64>,
    /// Overlap at which the spring begins.
    pub(super) late: f64,
}

/// Contacts stand in the order of their bodies, and for two bodies in that of the spheres.
pub(super) fn order([a, b]: &[Side; 2]) -> [u32; 4] {
    [a.body, b.body, a.sphere, b.sphere]
}

impl World {
    /// Both lists are sorted by bodies and spheres.
    pub(super) fn begin_with_forces_of_before(&mut self) {
        let mut old = self.warm.iter().peekable();
        for contact in &mut self.contacts {
            let at = order(&contact.sides);
            while old.next_if(|warm| order(&warm.sides) < at).is_some() {}
            if let Some(warm) = old.next_if(|warm| warm.sides == contact.sides) {
                // Where they have moved apart since, the spring begins at less.
                contact.late = warm.late.min(contact.late);
                let [s, t] = contact.across.map(|across| across.dot(&warm.across));
                contact.force = [warm.normal, s, t];
            }
        }
    }

    pub(super) fn solve(&mut self, report: &mut StepReport) -> Result<(), DynamicsError> {
        let mut contacts = core::mem::take(&mut self.contacts);
        for contact in &contacts {
            if contact.force[0] != 0.0 {
                self.push(contact, contact.force_vector());
            }
        }
        for sweep in 0..self.options.sweeps {
            let (mut sum, mut changed) = (0.0, 0.0);
            for contact in &mut contacts {
                // Pairs that others have not pushed together so far are looked at less often.
                let is_open = contact.force[0] == 0.0 && contact.after <= 0.0;
                if is_open && sweep % OPEN_EVERY != 0 {
                    continue;
                }
                let before = contact.force[0];
                self.visit(contact);
                sum += contact.force[0];
                changed += (contact.force[0] - before).abs();
            }
            report.sweeps += 1;
            if changed <= self.options.accuracy * sum {
                break;
            }
        }
        self.warm.clear();
        for contact in &contacts {
            report.events += u64::from(contact.is_event());
            report.contact_energy += contact.spring.energy(contact.before - contact.late);
            report.late += u64::from(contact.late > 0.0);
            self.check_depth(contact, report)?;
            let [normal, s, t] = contact.force;
            self.warm.push(Warm {
                sides: contact.sides,
                normal,
                across: contact.across[0] * s + contact.across[1] * t,
                late: contact.late,
            });
        }
        self.contacts = contacts;
        Ok(())
    }

    /// # Errors
    /// An overlap of more than the larger radius.
    fn check_depth(&self, contact: &Contact, report: &mut StepReport) -> Result<(), DynamicsError> {
        let radius = |side: Side| match self.bodies.get(side.body as usize) {
            Some(body) => self.models[body.model].spheres.radius(side.sphere as usize),
            None => 0.0,
        };
        let [a, b] = contact.sides;
        let radius = radius(a).max(radius(b));
        report.penetration = report.penetration.max(contact.before);
        report.penetration_rel = report.penetration_rel.max(contact.before / radius);
        let depth = contact.before.max(contact.after);
        if depth <= radius {
            return Ok(());
        }
        Err(DynamicsError::Penetration {
            bodies: bodies_of([a.body, b.body]),
            depth,
            radius,
            step_max_s: self.options.step_s * 0.5 * radius / depth,
        })
    }

    fn visit(&mut self, contact: &mut Contact) {
        let (mut rigid, mut modes) = self.displacement(contact, 0);
        if !contact.is_with_plane() {
            let other = self.displacement(contact, 1);
            rigid -= other.0;
            modes -= other.1;
        }
        let [before, s, t] = contact.force;
        let moved = contact.normal.dot(&(rigid + modes));
        let free = contact.free - moved + contact.response * before;
        let step_s = self.options.step_s;
        let (start, end) = (contact.before - contact.late, free - contact.late);
        let normal = contact.spring.force(start, end, contact.response, step_s);
        contact.after = free - contact.response * normal;
        let slip = slipping(rigid, modes);
        let change = normal - before;
        let [along, other] = &contact.across;
        let x = contact.slip[0] + along.dot(&slip) + contact.leak[0] * change;
        let y = contact.slip[1] + other.dot(&slip) + contact.leak[1] * change;
        let [xx, yy, xy] = contact.hold;
        let mut held = [s - (xx * x + xy * y), t - (xy * x + yy * y)];
        let most = self.options.law.friction * normal;
        let size = libm::sqrt(held[0] * held[0] + held[1] * held[1]);
        if size > most {
            held = held.map(|f| f * (most / size));
        }
        let [ds, dt] = [held[0] - s, held[1] - t];
        contact.force = [normal, held[0], held[1]];
        let by = contact.normal * change + contact.across[0] * ds + contact.across[1] * dt;
        self.push(contact, by);
    }

    /// How forces have moved a side's point so far: by rigid motion and by modes.
    fn displacement(&self, contact: &Contact, side: usize) -> (Vector3<f64>, Vector3<f64>) {
        let body = &self.bodies[contact.sides[side].body as usize];
        let rigid = body.moved + body.turned.cross(&contact.arms[side]);
        let spheres = &self.models[body.model].spheres;
        let stride = spheres.stride();
        if stride == 0 {
            return (rigid, Vector3::zeros());
        }
        let moved = super::part(&self.modal.moved, body.start, stride);
        let own = spheres.displacement(contact.sides[side].sphere as usize, moved);
        (rigid, body.rotation * own)
    }

    /// Adds a force on the first side, and its opposite on the second.
    fn push(&mut self, contact: &Contact, force: Vector3<f64>) {
        self.push_side(contact, 0, force);
        if !contact.is_with_plane() {
            self.push_side(contact, 1, -force);
        }
    }

    fn push_side(&mut self, contact: &Contact, side: usize, force: Vector3<f64>) {
        let body = &mut self.bodies[contact.sides[side].body as usize];
        body.moved += force * body.per_force;
        body.turned += body.per_torque * contact.arms[side].cross(&force);
        let spheres = &self.models[body.model].spheres;
        let stride = spheres.stride();
        if stride == 0 {
            return;
        }
        let own = body.rotation.tr_mul(&force);
        let at = body.start..body.start + stride;
        let (per_force, moved) = (&self.modal.per_force[at.clone()], &mut self.modal.moved[at]);
        spheres.pull(contact.sides[side].sphere as usize, own, per_force, moved);
    }
}
