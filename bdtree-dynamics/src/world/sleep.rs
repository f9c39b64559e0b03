//! Islands of bodies that have come to rest sleep: they are neither moved nor looked at until something pushes them.
//!
//! An island is what touches each other, free body by free body. It falls asleep when all of its bodies have been slower than
//! [`WorldOptions::sleep_speed`](super::WorldOptions::sleep_speed) for half a second, and wakes as a whole when anything
//! that moves pushes one of them, or the caller does. What has been decided in a step is done at the beginning of the
//! next one, so that events of the step stay what they were.

use super::World;
use super::body::{Body, Frame};
use super::contact::Side;
use super::events::Touch;
use super::solve::Warm;
use crate::error::DynamicsError;

/// How long a body must have been slow, seconds.
const QUIET_S: f64 = 0.5;

/// Islands are looked for every so many steps.
const EVERY: u64 = 15;

/// Whether a body sleeps, and what of it is to be done at the next step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Rest {
    /// Steps in a row in which it was slow.
    pub(super) quiet: u32,
    pub(super) is_asleep: bool,
    /// What fell asleep together has the same number.
    pub(super) island: u32,
    pub(super) change: Change,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Change {
    #[default]
    None,
    FallAsleep,
    Wake,
}

impl Body {
    /// Whether the step moves it by itself.
    pub(super) fn moves(&self, has_modes: bool) -> bool {
        match self.frame {
            Frame::Free => !self.rest.is_asleep,
            Frame::Held => has_modes,
            Frame::Driven => self.is_under_way,
        }
    }

    /// Nothing of it is slow any more.
    pub(super) fn disturb(&mut self) {
        self.rest.quiet = 0;
        if self.rest.is_asleep {
            self.rest.change = Change::Wake;
        }
    }
}

impl World {
    /// Number of bodies that sleep.
    pub fn asleep(&self) -> usize {
        self.bodies
            .iter()
            .filter(|body| body.rest.is_asleep)
            .count()
    }

    /// Whether a side of a contact waits for others to push it.
    fn rests(&self, side: u32) -> bool {
        match self.bodies.get(side as usize) {
            Some(body) => body.frame != Frame::Free || body.rest.is_asleep,
            None => true, // a plane
        }
    }

    /// Does what the last step and the caller have decided.
    ///
    /// # Errors
    /// A damaged asset.
    pub(super) fn fall_asleep_and_wake(&mut self) -> Result<(), DynamicsError> {
        if self
            .bodies
            .iter()
            .all(|body| body.rest.change == Change::None)
        {
            return Ok(());
        }
        // Whoever wakes, wakes its island.
        self.waking.clear();
        let wakes = |body: &&Body| body.rest.change == Change::Wake && body.rest.is_asleep;
        let islands = self
            .bodies
            .iter()
            .filter(wakes)
            .map(|body| body.rest.island);
        self.waking.extend(islands);
        self.waking.sort_unstable();
        for index in 0..self.bodies.len() {
            let rest = &mut self.bodies[index].rest;
            let change = core::mem::take(&mut rest.change);
            if rest.is_asleep {
                if self.waking.binary_search(&rest.island).is_ok() {
                    (rest.is_asleep, rest.quiet) = (false, 0);
                }
            } else if change == Change::FallAsleep {
                rest.is_asleep = true;
                self.lie(index);
                self.follow(index)?;
            }
        }
        // Forces and touches of what sleeps wait in lists of their own.
        let mut warm = core::mem::take(&mut self.warm_scratch);
        warm.clear();
        warm.extend(self.sorted_warm());
        let mut kept = core::mem::take(&mut self.warm_asleep);
        let rest = |warm: &Warm| warm.sides.iter().all(|side: &Side| self.rests(side.body));
        exchange(&mut warm, &mut kept, rest);
        self.loosen(&mut warm);
        (self.warm_scratch, self.warm_asleep) = (warm, kept);
        let mut touches = core::mem::take(&mut self.touches);
        let mut kept = core::mem::take(&mut self.touches_asleep);
        let rest = |touch: &Touch| touch.sides.iter().all(|side| self.rests(*side));
        exchange(&mut touches, &mut kept, rest);
        touches.sort_unstable_by_key(|touch| touch.sides);
        (self.touches, self.touches_asleep) = (touches, kept);
        Ok(())
    }

    /// Decides who sleeps and who wakes at the next step.
    pub(super) fn watch(&mut self) {
        let limit = self.options.sleep_speed * self.options.sleep_speed;
        if limit == 0.0 {
            return;
        }
        for body in &mut self.bodies {
            if body.frame != Frame::Free || body.rest.is_asleep {
                continue;
            }
            let model = &self.models[body.model];
            let Some(mass) = &model.mass else { continue };
            let rates = &self.modal.rate[body.start..];
            let modes = model.modes.iter().zip(rates);
            let modes: f64 = modes.map(|(mode, rate)| mode.mass * rate * rate).sum();
            let twice = 2.0 * body.state.kinetic_energy(mass) + modes;
            body.rest.quiet = if twice < limit * mass.mass_kg {
                body.rest.quiet.saturating_add(1)
            } else {
                0
            };
        }
        self.wake_the_pushed();
        if self.steps.is_multiple_of(EVERY) {
            self.find_islands();
        }
    }

    /// What moves and pushes wakes.
    fn wake_the_pushed(&mut self) {
        for touch in &self.touches {
            let [a, b] = touch.sides.map(|side| side as usize);
            if b >= self.bodies.len() {
                continue; // planes do not move
            }
            for (one, other) in [(a, b), (b, a)] {
                let body = &self.bodies[other];
                let has_modes = !self.models[body.model].modes.is_empty();
                if self.bodies[one].rest.is_asleep && body.moves(has_modes) {
                    self.bodies[one].rest.change = Change::Wake;
                }
            }
        }
    }

    /// Unites what touches, and marks islands that have been quiet for long enough.
    fn find_islands(&mut self) {
        let needed = (QUIET_S / self.options.step_s) as u32;
        let count = self.bodies.len();
        self.islands.clear();
        self.islands.extend(0..count as u32);
        for touch in &self.touches {
            let [a, b] = touch.sides.map(|side| side as usize);
            let is_free =
                |k: usize| (self.bodies.get(k)).is_some_and(|body| body.frame == Frame::Free);
            if is_free(a) && is_free(b) {
                let (a, b) = (root(&mut self.islands, a), root(&mut self.islands, b));
                // The lower number leads, whatever the order.
                self.islands[a.max(b)] = a.min(b) as u32;
            }
        }
        self.restless.clear();
        self.restless.resize(count, false);
        for index in 0..count {
            let Body { frame, rest, .. } = &self.bodies[index];
            if *frame == Frame::Free && rest.quiet < needed && !rest.is_asleep {
                let leader = root(&mut self.islands, index);
                self.restless[leader] = true;
            }
        }
        for index in 0..count {
            let leader = root(&mut self.islands, index);
            let Body { frame, rest, .. } = &mut self.bodies[index];
            if *frame == Frame::Free && !rest.is_asleep && !self.restless[leader] {
                rest.change = Change::FallAsleep;
                rest.island = leader as u32;
            }
        }
    }
}

/// The leader of a body's island.
fn root(islands: &mut [u32], index: usize) -> usize {
    let mut at = index;
    while islands[at] as usize != at {
        islands[at] = islands[islands[at] as usize];
        at = islands[at] as usize;
    }
    at
}

/// Moves what rests from the first list to the second, and what does not back.
fn exchange<T: Copy>(
    active: &mut alloc::vec::Vec<T>,
    resting: &mut alloc::vec::Vec<T>,
    rests: impl Fn(&T) -> bool,
) {
    resting.retain(|item| {
        let stays = rests(item);
        if !stays {
            active.push(*item);
        }
        stays
    });
    resting.extend(active.iter().filter(|item| rests(item)).copied());
    active.retain(|item| !rests(item));
}
