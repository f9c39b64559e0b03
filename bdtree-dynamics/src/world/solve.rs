//! The forces of all contacts: Gauss–Seidel sweeps, contact after contact.
//!
//! Each visit computes how the pair moves under all forces so far, and then the normal force that the contact law wants and
//! the friction that stops the slip, within the cone. Displacements are linear in forces, so a visit costs two products
//! with Ū for each side, and bodies need no other memory than their displacements.

use nalgebra::Vector3;

use super::contact::{Contact, SLIP, Side, bodies_of};
use super::find::Slot;
use super::groups::{Cluster, Group, Motion};
use super::{StepReport, World};
use crate::body_model::BodyModel;
use crate::error::DynamicsError;
use crate::field::Field;

/// Pairs that do not touch are visited in every so many sweeps.
const OPEN_EVERY: usize = 3;

/// Forces of a contact, for the next step to begin with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Warm {
    pub(super) sides: [Side; 2],
    pub(super) normal: f64,
    pub(super) across: Vector3<f64>,
    /// The contact's normal.
    pub(super) along: Vector3<f64>,
    /// Overlap at which the spring begins.
    pub(super) late: f64,
    /// Of its spring, N/m.
    pub(super) stiffness: f64,
}

/// Contacts stand in the order of their bodies, and for two bodies in that of the spheres.
pub(super) fn order([a, b]: &[Side; 2]) -> [u32; 4] {
    [a.body, b.body, a.sphere, b.sphere]
}

impl Contact {
    /// Begins with the force of the step before, if it is in `old`, which is sorted by spheres, as the contacts are that begin
    /// one after the other; what it began with.
    pub(super) fn begin_with<'w>(&mut self, old: &mut &'w [Warm]) -> Option<&'w Warm> {
        let at = order(&self.sides);
        while let Some((warm, rest)) = old.split_first() {
            if order(&warm.sides) > at {
                return None;
            }
            *old = rest;
            if warm.sides == self.sides {
                // Where they have moved apart since, the spring begins at less.
                self.late = warm.late.min(self.late);
                let [s, t] = self.across.map(|across| across.dot(&warm.across));
                self.force = [warm.normal, s, t];
                return Some(warm);
            }
        }
        None
    }

    /// The same for a sphere, side `sphere` of the two, and a triangle: where it meets another triangle than before, it goes on
    /// with the force of one that it met.
    pub(super) fn begin_with_any(&mut self, old: &[Warm], sphere: usize) {
        let same = |warm: &&Warm| warm.sides == self.sides;
        let of_sphere = |warm: &&Warm| warm.sides[sphere] == self.sides[sphere];
        let found = old.iter().find(same);
        if let Some(warm) = found.or_else(|| old.iter().find(of_sphere)) {
            self.late = warm.late.min(self.late);
            let [s, t] = self.across.map(|across| across.dot(&warm.across));
            self.force = [warm.normal, s, t];
        }
    }

    fn warm(&self) -> Warm {
        let [normal, s, t] = self.force;
        Warm {
            sides: self.sides,
            normal,
            across: self.across[0] * s + self.across[1] * t,
            along: self.normal,
            late: self.late,
            stiffness: self.spring.stiffness,
        }
    }
}

/// What is done with a group.
#[derive(Debug, Clone, Copy)]
enum Turn {
    /// The forces of the step before act.
    Begin,
    /// Each contact is visited.
    Sweep(usize),
}

/// What visits need of the world.
struct Solver<'w> {
    models: &'w [BodyModel],
    step_s: f64,
    friction: f64,
}

/// The clusters of a group.
struct Clusters<'c> {
    first: &'c mut Cluster,
    /// `None` if it is the first one.
    second: Option<&'c mut Cluster>,
}

impl World {
    /// Finds all forces; the number of sweeps.
    pub(super) fn solve(&mut self) -> usize {
        self.fill_clusters();
        let sweeps = self.sweep();
        self.take_from_clusters();
        self.memory
            .warm
            .resize_with(self.groups.all.len(), Default::default);
        for (group, warm) in self.groups.all.iter().zip(&mut self.memory.warm) {
            warm.clear();
            warm.extend(group.contacts.iter().map(Contact::warm));
        }
        sweeps
    }

    /// Counts contacts and measures overlaps.
    ///
    /// # Errors
    /// One that is too deep.
    pub(super) fn tell(&self, report: &mut StepReport) -> Result<(), DynamicsError> {
        for group in &self.groups.all {
            for contact in &group.contacts {
                report.events += u64::from(contact.is_event());
                report.contact_energy += contact.spring.energy(contact.before - contact.late);
                // Springs of regions begin elsewhere for another reason.
                let is_late = contact.late > 0.0 && !contact.is_of_regions();
                report.late += u64::from(is_late);
                self.check_depth(contact, report)?;
            }
        }
        Ok(())
    }

    /// Visits all contacts until their forces settle; the number of sweeps.
    fn sweep(&mut self) -> usize {
        let (sweeps, accuracy) = (self.options.sweeps, self.options.accuracy);
        let solver = Solver {
            models: &self.models,
            step_s: self.part_s,
            friction: self.options.law.friction,
        };
        #[cfg(feature = "threads")]
        if self.workers.len() > 1 && self.groups.clusters.len() > 1 {
            return threads::sweep(
                &solver,
                &mut self.groups,
                self.workers.len(),
                sweeps,
                accuracy,
            );
        }
        let (all, clusters) = (&mut self.groups.all, &mut self.groups.clusters);
        let order = &self.groups.order;
        for index in order {
            solver.turn_of(&mut all[*index as usize], clusters, Turn::Begin);
        }
        for sweep in 0..sweeps {
            let (mut sum, mut changed) = (0.0, 0.0);
            for index in order {
                let group = &mut all[*index as usize];
                solver.turn_of(group, clusters, Turn::Sweep(sweep));
                sum += group.sum;
                changed += group.changed;
            }
            if changed <= accuracy * sum {
                return sweep + 1;
            }
        }
        sweeps
    }

    /// # Errors
    /// An overlap of more than the larger radius, or than the thinner wall; of a sphere and a triangle, which has no inside, of
    /// more than the diameter.
    fn check_depth(&self, contact: &Contact, report: &mut StepReport) -> Result<(), DynamicsError> {
        let [a, b] = contact.sides;
        let is_one_sided = contact.fields == [None; 2] || contact.is_of_regions();
        let limit = if is_one_sided { 1.0 } else { 2.0 } * contact.radius;
        report.penetration = report.penetration.max(contact.before);
        report.penetration_rel = report.penetration_rel.max(contact.before / contact.radius);
        let depth = contact.before.max(contact.after);
        if depth <= limit {
            return Ok(());
        }
        Err(DynamicsError::Penetration {
            bodies: bodies_of([a.body, b.body]),
            depth,
            limit,
            step_max_s: self.options.step_s * 0.5 * limit / depth,
        })
    }
}

impl Solver<'_> {
    fn turn_of(&self, group: &mut Group, clusters: &mut [Cluster], turn: Turn) {
        let [i, j] = group.clusters;
        if i == j {
            let clusters = Clusters {
                first: &mut clusters[i],
                second: None,
            };
            self.turn(group, clusters, turn);
        } else if let Ok([first, second]) = clusters.get_disjoint_mut([i, j]) {
            let clusters = Clusters {
                first,
                second: Some(second),
            };
            self.turn(group, clusters, turn);
        }
    }

    fn turn(&self, group: &mut Group, mut clusters: Clusters<'_>, turn: Turn) {
        let (mut sum, mut changed) = (0.0, 0.0);
        let fields = &group.fields;
        for contact in &mut group.contacts {
            let before = contact.force[0];
            match turn {
                Turn::Begin => {
                    if before != 0.0 {
                        self.push(&mut clusters, contact, fields, contact.force_vector());
                    }
                }
                Turn::Sweep(sweep) => {
                    // Pairs that others have not pushed together so far are looked at less often.
                    let is_open = before == 0.0 && contact.after <= 0.0;
                    if is_open && sweep % OPEN_EVERY != 0 {
                        continue;
                    }
                    self.visit(&mut clusters, contact, fields);
                    sum += contact.force[0];
                    changed += (contact.force[0] - before).abs();
                }
            }
        }
        (group.sum, group.changed) = (sum, changed);
    }

    fn visit(&self, clusters: &mut Clusters<'_>, contact: &mut Contact, fields: &[f64]) {
        let (mut way, mut slip) = self.displacement(clusters, contact, fields, 0);
        if !contact.is_with_plane() {
            let other = self.displacement(clusters, contact, fields, 1);
            way -= other.0;
            slip -= other.1;
        }
        let [before, s, t] = contact.force;
        let moved = contact.normal.dot(&way);
        let free = contact.free - moved + contact.response * before;
        let (start, end) = (contact.before - contact.late, free - contact.late);
        let normal = (contact.spring).force(start, end, contact.response, self.step_s);
        contact.after = free - contact.response * normal;
        let change = normal - before;
        let [along, other] = &contact.across;
        let x = contact.slip[0] + along.dot(&slip) + contact.leak[0] * change;
        let y = contact.slip[1] + other.dot(&slip) + contact.leak[1] * change;
        let [xx, yy, xy] = contact.hold;
        let mut held = [s - (xx * x + xy * y), t - (xy * x + yy * y)];
        let most = self.friction * normal;
        let size = libm::sqrt(held[0] * held[0] + held[1] * held[1]);
        if size > most {
            // It slides: friction is against the slip, not against what would stop it, which is along `hold` times the slip.
            let ease = 0.5 * (xx + yy) - libm::hypot(0.5 * (xx - yy), xy);
            held = [s - ease * x, t - ease * y];
            let size = libm::hypot(held[0], held[1]);
            if size > most {
                held = held.map(|f| f * (most / size));
            }
        }
        let [ds, dt] = [held[0] - s, held[1] - t];
        if change == 0.0 && ds == 0.0 && dt == 0.0 {
            return;
        }
        contact.force = [normal, held[0], held[1]];
        let by = contact.normal * change + contact.across[0] * ds + contact.across[1] * dt;
        self.push(clusters, contact, fields, by);
    }

    /// How forces have moved a side's point so far, and its slip.
    #[inline(always)] // with what surrounds it, since it is most of a visit
    fn displacement(
        &self,
        clusters: &mut Clusters<'_>,
        contact: &Contact,
        fields: &[f64],
        side: usize,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (motion, _, moved) = clusters.at(contact.slots[side]);
        let rigid = motion.moved + motion.turned.cross(&contact.arms[side]);
        let field = self.field(motion, contact, fields, side);
        let stride = field.stride();
        if stride == 0 {
            return (rigid, rigid * SLIP);
        }
        let own = field.displacement(&moved[motion.start..motion.start + stride]);
        let modes = motion.rotation * own;
        let share = self.models[motion.model].modal_slip();
        (rigid + modes, rigid * SLIP + modes * share)
    }

    /// Adds a force on the first side, and its opposite on the second.
    fn push(
        &self,
        clusters: &mut Clusters<'_>,
        contact: &Contact,
        fields: &[f64],
        force: Vector3<f64>,
    ) {
        self.push_side(clusters, contact, fields, 0, force);
        if !contact.is_with_plane() {
            self.push_side(clusters, contact, fields, 1, -force);
        }
    }

    #[inline(always)] // as above
    fn push_side(
        &self,
        clusters: &mut Clusters<'_>,
        contact: &Contact,
        fields: &[f64],
        side: usize,
        force: Vector3<f64>,
    ) {
        let (motion, per_force, moved) = clusters.at(contact.slots[side]);
        motion.moved += force * motion.per_force;
        motion.turned += motion.per_torque * contact.arms[side].cross(&force);
        let field = self.field(motion, contact, fields, side);
        let stride = field.stride();
        if stride == 0 {
            return;
        }
        let own = motion.rotation.tr_mul(&force);
        let at = motion.start..motion.start + stride;
        let (per_force, moved) = (&per_force[at.clone()], &mut moved[at]);
        field.pull(own, per_force, moved);
    }

    /// How modes move a side.
    #[inline]
    fn field<'f>(
        &'f self,
        motion: &Motion,
        contact: &Contact,
        fields: &'f [f64],
        side: usize,
    ) -> Field<'f> {
        let spheres = &self.models[motion.model].spheres;
        match contact.fields[side] {
            // Nothing, for a body whose modes no force moves.
            Some(at) => {
                let len = 3 * spheres.stride();
                Field(
                    fields
                        .get(at as usize..at as usize + len)
                        .unwrap_or_default(),
                )
            }
            None => spheres.field(contact.sides[side].sphere as usize),
        }
    }
}

impl Clusters<'_> {
    /// A body, and its cluster's numbers for modes.
    #[inline]
    fn at(&mut self, slot: Slot) -> (&mut Motion, &[f64], &mut [f64]) {
        let (is_second, slot) = slot.split();
        let cluster = match &mut self.second {
            Some(second) if is_second => second,
            _ => &mut *self.first,
        };
        (
            &mut cluster.motions[slot],
            &cluster.per_force,
            &mut cluster.moved,
        )
    }
}

#[cfg(feature = "threads")]
mod threads {
    //! Sweeps of several threads: a round's groups are taken one by one, and nobody goes on to the next round before all are
    //! done.

    use alloc::vec::Vec;
    use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

    use super::super::groups::Groups;
    use super::super::workers::{Barrier, Lock};
    use super::{Clusters, Solver, Turn};

    pub(super) fn sweep(
        solver: &Solver<'_>,
        groups: &mut Groups,
        threads: usize,
        sweeps: usize,
        accuracy: f64,
    ) -> usize {
        let clusters: Vec<_> = groups.clusters.iter_mut().map(Lock::new).collect();
        let all: Vec<_> = groups.all.iter_mut().map(Lock::new).collect();
        let (order, ends) = (&groups.order, &groups.ends);
        let barrier = Barrier::new(threads);
        let next = AtomicUsize::new(0);
        let (is_done, done) = (AtomicBool::new(sweeps == 0), AtomicUsize::new(sweeps));
        let round = |start: usize, end: usize, turn: Turn| {
            loop {
                let at = start + next.fetch_add(1, Ordering::Relaxed);
                if at >= end {
                    return;
                }
                all[order[at] as usize].with(|group| {
                    let [i, j] = group.clusters;
                    clusters[i].with(|first| {
                        if i == j {
                            let second = None;
                            solver.turn(group, Clusters { first, second }, turn);
                            return;
                        }
                        clusters[j].with(|second| {
                            let second = Some(&mut **second);
                            solver.turn(group, Clusters { first, second }, turn);
                        });
                    });
                });
            }
        };
        let settled = |sweep: usize| {
            let (mut sum, mut changed) = (0.0, 0.0);
            for index in order {
                all[*index as usize].with(|group| {
                    sum += group.sum;
                    changed += group.changed;
                });
            }
            if changed <= accuracy * sum {
                done.store(sweep + 1, Ordering::Relaxed);
                is_done.store(true, Ordering::Release);
            }
        };
        let run = || {
            let turns = core::iter::once(Turn::Begin).chain((0..sweeps).map(Turn::Sweep));
            for turn in turns {
                let mut start = 0;
                for end in ends {
                    round(start, *end, turn);
                    start = *end;
                    barrier.wait(|| {
                        next.store(0, Ordering::Relaxed);
                        if let Turn::Sweep(sweep) = turn
                            && *end == order.len()
                        {
                            settled(sweep);
                        }
                    });
                }
                if ends.is_empty() || is_done.load(Ordering::Acquire) {
                    return;
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 1..threads {
                scope.spawn(run);
            }
            run();
        });
        if ends.is_empty() {
            return sweeps.min(1);
        }
        done.load(Ordering::Relaxed)
    }
}
