//! Which bodies began to touch, still touch, or have parted.

use alloc::vec::Vec;

use nalgebra::Vector3;

use super::World;
use super::contact::bodies_of;

/// Two bodies, or a body and a plane, in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// The bodies; the second is `None` for a plane.
    pub bodies: [Option<usize>; 2],
    /// What has happened.
    pub phase: Phase,
    /// What the step's contact forces have added to the first body's momentum, N s; 0 once they have parted.
    pub impulse: [f64; 3],
}

/// What has happened to two bodies since the step before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// They push each other, which they did not before.
    Began,
    /// They push each other as before.
    Touching,
    /// They do not push each other any more.
    Ended,
}

/// Two sides that push each other, as contacts number them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touch {
    pub(super) sides: [u32; 2],
    pub(super) impulse: Vector3<f64>,
}

impl World {
    /// Adds the contacts of the step, or of a part of it, which are sorted by their bodies.
    pub(super) fn sum_up_touches(&mut self) {
        let mut touches = core::mem::take(&mut self.touches);
        let known = touches.len();
        for contact in self.sorted_contacts() {
            let force = contact.force_vector();
            if contact.force[0] == 0.0 {
                continue;
            }
            let sides = contact.sides.map(|side| side.body);
            let impulse = force * self.part_s;
            match touches[known..].last_mut() {
                Some(last) if last.sides == sides => last.impulse += impulse,
                _ => touches.push(Touch { sides, impulse }),
            }
        }
        if known > 0 {
            touches.sort_unstable_by_key(|touch| touch.sides);
            touches.dedup_by(|second, first| {
                let is_same = first.sides == second.sides;
                if is_same {
                    first.impulse += second.impulse;
                }
                is_same
            });
        }
        self.touches = touches;
    }

    /// What has happened to pairs of bodies in the last step, sorted by bodies; planes come last. Pairs that sleep are not
    /// among them, and have not ended.
    pub fn events(&self) -> Events<'_> {
        Events {
            now: &self.touches,
            before: &self.touches_before,
        }
    }
}

/// An iterator over [`World::events`].
#[derive(Debug, Clone)]
pub struct Events<'w> {
    now: &'w [Touch],
    before: &'w [Touch],
}

impl Iterator for Events<'_> {
    type Item = Event;

    fn next(&mut self) -> Option<Event> {
        let (now, before) = (self.now.first(), self.before.first());
        let (touch, phase) = match (now, before) {
            (Some(now), Some(before)) if now.sides == before.sides => (now, Phase::Touching),
            (Some(now), Some(before)) if now.sides > before.sides => (before, Phase::Ended),
            (Some(now), _) => (now, Phase::Began),
            (None, Some(before)) => (before, Phase::Ended),
            (None, None) => return None,
        };
        if phase != Phase::Ended {
            self.now = self.now.get(1..).unwrap_or_default();
        }
        if phase != Phase::Began {
            self.before = self.before.get(1..).unwrap_or_default();
        }
        let impulse = match phase {
            Phase::Ended => [0.0; 3],
            _ => touch.impulse.into(),
        };
        Some(Event {
            bodies: bodies_of(touch.sides),
            phase,
            impulse,
        })
    }
}

/// Lists of this step and of the one before.
pub(super) type Touches = Vec<Touch>;
