//! When the modes of a body rest.
//!
//! Every new shape makes an engine find contacts anew, whose points are not quite the old ones: bodies that may go on deforming
//! a little shake each other and never sleep.

use super::modes::Body;
use super::parry::math::{Real, Vector};

/// Modes rest once frame and surface have been slow for so many seconds, and those that go somewhere steadily have no vertex
/// farther from where the forces would hold it than half the tolerance...
const REST_AFTER_S: f64 = 0.25;

/// ...or once they have been slow for so many seconds.
const PATIENCE_S: f64 = 2.0;

/// Two bodies that are wedged into each other may bend each other to and fro without end, and keep a heap awake. So modes that
/// another force makes go on within so many seconds are restless: each time halves their patience, and doubles how long they rest
/// at least, whatever presses on the body, from [`REST_AFTER_S`] on...
const SOON_S: f64 = 10.0;

/// ...to so many seconds, which is more than rapier takes to send a heap to sleep, and no longer than a load that changes all the
/// time should wait.
const REST_AT_MOST_S: f64 = 4.0;

/// A frame does not sleep before its modes have gone on to where another force bends them, unless they are more restless than this.
const WAITS: i32 = 2;

/// Contacts of slow bodies are looked for anew every so many seconds: those that follow a surface stay where they were on it, also
/// where it slides over an edge. A beam with a load of 2 kg came to rest 3 mm from its balance without, and 2 mm with. Contacts of
/// those that are restless are not: each time shakes what is wedged.
const RENEW_S: f64 = 0.1;

/// They go on when they are faster than this multiple of that speed, or pressed by this multiple of the average force: neighbors
/// that settle do not wake them, and hits do.
const HIT: f64 = 3.0;

/// A body whose surface has just moved may lose its contacts for so many seconds: it takes steps to fall after what held it.
const GAP_S: f64 = 0.02;

/// What modes do later than in so many seconds does not keep them from resting.
const OUTLOOK_S: f64 = 1.0;

/// They also go on when what presses on them has changed by this share of itself, on average, if that bends them by more than the
/// tolerance. Between bodies wedged into each other it changes by less all the time.
const CHANGE: f64 = 0.3;

/// Forces below this, per mass of the body, are no hits: m/s², of the order of gravity.
const LIGHT: f64 = 20.0;

/// Whether the modes of a body rest.
#[derive(Debug, Clone)]
pub(super) struct Rest {
    /// What counts as slow, world units per second.
    speed: f64,
    /// What presses on the body in this step, also while it rests: the sum of all contacts, N, and its average.
    force: f64,
    mean_force: f64,
    /// For how many seconds nothing has touched the body.
    untouched_s: f64,
    /// The average when modes came to rest, while they rest.
    held_by: Option<f64>,
    /// For how many seconds they have rested, and how often before that they went on too soon ([`SOON_S`]).
    rested_s: f64,
    restless: i32,
    /// For how many seconds frame and surface have been slow while something touched them; counts down while modes rest and
    /// nothing touches them.
    slow_s: f64,
    /// How long ago contacts were looked for anew because the body is slow, s.
    renewed_s: f64,
    /// Linear and angular velocity of the frame, and the rates of s, averaged over about [`REST_AFTER_S`]: what only shakes
    /// does not get anywhere.
    drift: [Vector; 2],
    mean_rates: Vec<f64>,
    /// s averaged while the body is slow, and how long ago it was that, s.
    mean_s: Vec<f64>,
    lag_s: f64,
}

impl Rest {
    pub(super) fn new(speed: f64, mode_count: usize) -> Self {
        Self {
            speed,
            force: 0.0,
            mean_force: 0.0,
            untouched_s: f64::INFINITY,
            held_by: None,
            rested_s: 0.0,
            restless: 0,
            slow_s: 0.0,
            renewed_s: 0.0,
            drift: [Vector::ZERO; 2],
            mean_rates: vec![0.0; mode_count],
            mean_s: vec![0.0; mode_count],
            lag_s: 0.0,
        }
    }

    /// Begins a step.
    pub(super) fn begin(&mut self) {
        self.force = 0.0;
    }

    /// Takes in what presses on a body of this mass; whether that is a hit.
    fn meet(&mut self, step_s: f64, mass: f64) -> bool {
        self.untouched_s = match self.force > 0.0 {
            true => 0.0,
            false => self.untouched_s + step_s,
        };
        let is_hit = self.force > HIT * self.mean_force + LIGHT * mass;
        let share = (step_s / REST_AFTER_S).min(1.0);
        self.mean_force += (self.force - self.mean_force) * share;
        is_hit
    }

    /// Whether something touches the body.
    pub(super) fn is_held(&self) -> bool {
        self.untouched_s <= GAP_S
    }

    /// Whether frame and surface are slow, and something touches the body.
    pub(super) fn is_slow(&self) -> bool {
        self.slow_s > 0.0
    }

    /// How much the new value counts in what is averaged while the body is slow, over at most [`REST_AFTER_S`].
    pub(super) fn weight(&self, step_s: f64) -> f64 {
        (step_s / self.slow_s.clamp(step_s, REST_AFTER_S.max(step_s))).min(1.0)
    }

    /// Modes go on.
    pub(super) fn wake(&mut self) {
        self.slow_s = 0.0;
        self.held_by = None;
    }
}

impl Body {
    /// A contact presses on the body with this force, N.
    pub(super) fn press(&mut self, force: f64) {
        self.rest.force += force;
    }

    /// Whether its modes rest.
    pub(super) fn rests(&self) -> bool {
        self.rest.held_by.is_some()
    }

    /// Whether forces may still be bending it to where they hold it: its frame should not sleep before.
    pub(super) fn is_settling(&self) -> bool {
        let may_rest = !self.modes.is_empty() && self.rest.speed > 0.0;
        let is_waiting = self.rest.restless <= WAITS
            && (self.rest.held_by).is_some_and(|held_by| self.is_pressed_otherwise(held_by));
        may_rest && self.rest.is_held() && (!self.rests() || is_waiting)
    }

    /// Lets modes rest where they are on average, or go on, by how fast the frame, whose linear and angular velocity these are,
    /// and the surface are, and by what presses on the body.
    pub(super) fn settle(&mut self, velocity: [Vector; 2], step_s: f64) {
        self.average(velocity, step_s);
        let is_hit = self.rest.meet(step_s, self.mass);
        if let Some(held_by) = self.rest.held_by {
            self.rest_on(step_s);
            let is_free = is_hit || self.is_let_go(velocity, step_s);
            let least_s = (REST_AFTER_S * 2_f64.powi(self.rest.restless)).min(REST_AT_MOST_S);
            let is_pressed = self.rest.rested_s >= least_s && self.is_pressed_otherwise(held_by);
            if is_hit {
                self.rest.restless = 0;
            } else if is_pressed && !is_free && self.rest.rested_s < SOON_S {
                self.rest.restless += 1;
            }
            if is_free || is_pressed {
                self.rest.wake();
            }
        } else {
            self.come_to_rest(step_s);
        }
        if is_hit {
            for mode in &mut self.modes {
                mode.share = 1.0;
            }
        }
    }

    /// Counts a step in which modes stay where they are, at rest or since the frame sleeps.
    pub(super) fn rest_on(&mut self, step_s: f64) {
        self.rest.rested_s += step_s;
        if self.rest.rested_s >= SOON_S {
            self.rest.restless = 0;
        }
    }

    /// Takes a step into what is averaged.
    fn average(&mut self, velocity: [Vector; 2], step_s: f64) {
        let share = (step_s / REST_AFTER_S).min(1.0);
        let rest = &mut self.rest;
        for (mean, now) in rest.drift.iter_mut().zip(velocity) {
            *mean += (now - *mean) * share as Real;
        }
        for (mean, [_, rate]) in rest.mean_rates.iter_mut().zip(&self.state) {
            *mean += (rate - *mean) * share;
        }
        let weight = rest.weight(step_s);
        rest.lag_s = (rest.lag_s + step_s) * (1.0 - weight);
        for (mean, [s, _]) in rest.mean_s.iter_mut().zip(&self.state) {
            *mean += (s - *mean) * weight;
        }
    }

    /// Whether nothing holds a body whose modes rest any more, or it is fast.
    fn is_let_go(&mut self, velocity: [Vector; 2], step_s: f64) -> bool {
        // What lets go of the body may only have lost it for a step.
        let held_s = match self.rest.is_held() {
            true => step_s,
            false => -step_s,
        };
        self.rest.slow_s = (self.rest.slow_s + held_s).min(REST_AFTER_S);
        let is_fast = self.speed(velocity, &self.rates()) >= HIT * self.rest.speed;
        is_fast || self.rest.slow_s <= 0.0
    }

    /// Whether what presses on a body whose modes rest, held by this force, has become another force, which bends it by more than
    /// the tolerance.
    fn is_pressed_otherwise(&self, held_by: f64) -> bool {
        let more = self.rest.mean_force / held_by - 1.0;
        more.abs() > CHANGE && self.bends_by(more) > self.tolerance
    }

    /// Lets modes rest once they have been slow for long enough.
    fn come_to_rest(&mut self, step_s: f64) {
        let is_slow = self.speed(self.rest.drift, &self.rest.mean_rates) < self.rest.speed;
        if !(is_slow && self.rest.is_held()) {
            self.rest.slow_s = 0.0;
            return;
        }
        self.rest.slow_s += step_s;
        self.rest.renewed_s += step_s;
        if self.rest.renewed_s >= RENEW_S && self.rest.restless == 0 {
            self.rest.renewed_s = 0.0;
            self.is_stale |= self.mesh.forget_contacts();
        }
        let patience_s = (PATIENCE_S * 0.5_f64.powi(self.rest.restless)).max(REST_AFTER_S);
        let is_there = self.rest.slow_s >= REST_AFTER_S && self.to_go() <= 0.5 * self.tolerance;
        if !(is_there || self.rest.slow_s >= patience_s) {
            return;
        }
        let each = self.state.iter_mut().zip(&self.rest.mean_s);
        for ((state, mean), mode) in each.zip(&self.modes) {
            *state = [mean + mode.mean_rate * self.rest.lag_s, 0.0];
        }
        self.rest.held_by = Some(self.rest.mean_force);
        self.rest.rested_s = 0.0;
        self.rest.slow_s = REST_AFTER_S;
    }

    /// How far a vertex may still be on its way to where the forces would hold it, world units: no farther than it goes in
    /// [`OUTLOOK_S`] as fast as it has been on average.
    fn to_go(&self) -> f64 {
        let each = self.modes.iter().zip(&self.rest.mean_s);
        each.filter(|(mode, _)| mode.is_steady())
            .map(|(mode, s)| {
                let soon = mode.limit.slope(*s) * mode.mean_rate.abs() * mode.reach * OUTLOOK_S;
                let now = s + mode.mean_rate * self.rest.lag_s;
                mode.way(mode.goal, now).min(soon)
            })
            .sum()
    }

    /// No vertex moves farther where all forces on the body grow by this share of themselves.
    fn bends_by(&self, more: f64) -> f64 {
        let each = self.modes.iter().zip(&self.state);
        let bent: f64 = each
            .map(|(mode, [s, _])| mode.limit.q(*s).abs() * mode.reach)
            .sum();
        bent * more.abs()
    }

    /// No point of the body is faster than this.
    fn speed(&self, [linear, angular]: [Vector; 2], rates: &[f64]) -> f64 {
        let turning = angular.length() * self.mesh.sphere().radius;
        let modes = self.modes.iter().zip(&self.state).zip(rates);
        let surface =
            modes.map(|((mode, [s, _]), rate)| (mode.limit.slope(*s) * rate).abs() * mode.reach);
        f64::from(linear.length() + turning) + surface.sum::<f64>()
    }

    fn rates(&self) -> Vec<f64> {
        self.state.iter().map(|[_, rate]| *rate).collect()
    }
}
