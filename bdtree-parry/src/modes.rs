//! The modes of a body that an engine for rigid bodies moves.

use bdtree_dynamics::{Damping, Oscillator, StrainLimit, Transition};

use super::parry::math::{Real, Vector};
use super::points::{wide, with_workspace};
use super::shape::DeformingMesh;
use crate::error::ShapeError;
use crate::model::DeformingModel;

/// How stiff contacts are taken for, per mass of the body, 1/s². Contacts of rapier are springs of 60 Hz against fixed bodies
/// and of 30 Hz against others: four of the former are 5.7e5. From 1e5 on chairs on a floor come to rest.
const STIFFNESS: f64 = 3.6e5;

/// Modes rest once frame and surface have been slow for so many seconds...
const REST_AFTER_S: f64 = 0.25;

/// ...until they are faster than this multiple of that speed, or pressed by this multiple of the average force: neighbors that
/// settle do not wake them, and hits do.
const HIT: f64 = 3.0;

/// Forces below this, per mass of the body, are no hits: m/s², of the order of gravity.
const LIGHT: f64 = 20.0;

/// How far a vertex may be off in the collider, in radii of the mesh's bounding sphere.
const TOLERANCE: f64 = 5e-3;

/// Seconds after which half of what a body has stored is forgotten.
const STORE_HALF_LIFE_S: f64 = 0.25;

/// How much of what contacts destroy modes may take: what rapier's corrections of positions add is not known.
const LENT: f64 = 0.5;

/// How a body deforms.
#[derive(Debug, Clone, PartialEq)]
pub struct FlexibleOptions {
    /// Whether contacts move q; default true. Without, q stays what it is.
    pub is_deformable: bool,
    /// Default a ratio of 0.1 for every mode.
    pub damping: Damping,
    /// Limit of q in multiples of each mode's `q_range`; never above `q_limit`. Default 1.
    pub strain_limit: f64,
    /// The collider gets the mesh at the new q once a vertex may have moved by this since the last time, world units. Smaller
    /// changes let rapier go on with the contacts that it has. Default 5e-3 of the radius of its bounding sphere: rapier itself
    /// keeps contacts of bodies that have moved by up to 5 cm.
    pub tolerance: Option<f64>,
    /// Modes rest once something holds the body and no point of it is faster than this on average, world units per second: q
    /// stays until the body is hit or let go. Default 0.2, four times the speed below which rapier's bodies sleep; 0 for
    /// never.
    pub rest_speed: f64,
    /// Of the collider; default 0.5.
    pub friction: Real,
}

impl Default for FlexibleOptions {
    fn default() -> Self {
        Self {
            is_deformable: true,
            damping: Damping::Ratio(0.1),
            strain_limit: 1.0,
            tolerance: None,
            rest_speed: 0.2,
            friction: 0.5,
        }
    }
}

/// One mode of a body.
#[derive(Debug, Clone)]
pub(super) struct Mode {
    pub(super) oscillator: Oscillator,
    /// Of the last step's length.
    pub(super) transition: Transition,
    /// kg for q in mesh units.
    pub(super) mass: f64,
    pub(super) limit: StrainLimit,
    /// How far q = 1 moves the farthest vertex, world units.
    pub(super) reach: f64,
}

/// A contact of a body, in its frame.
#[derive(Debug, Clone)]
pub(super) struct Touch {
    /// N.
    pub(super) force: f64,
    /// How far a unit of q of each mode moves the point along the direction, world units.
    pub(super) moves: Vec<f64>,
}

#[derive(Debug, Clone)]
pub(super) struct Body {
    /// At the q that the collider has.
    pub(super) mesh: DeformingMesh,
    pub(super) modes: Vec<Mode>,
    /// s and its rate of each mode: q = limit(s).
    pub(super) state: Vec<[f64; 2]>,
    /// The contacts of the step.
    pub(super) touches: Vec<Touch>,
    /// Whether the transitions of modes are those of a step with contacts.
    pub(super) is_touched: bool,
    /// kg.
    pub(super) mass: f64,
    pub(super) tolerance: f64,
    /// Joules that contacts have destroyed and modes have not taken.
    pub(super) store: f64,
    pub(super) rest: Rest,
}

/// Whether the modes of a body rest.
#[derive(Debug, Clone)]
pub(super) struct Rest {
    /// What counts as slow, world units per second.
    speed: f64,
    /// What presses on the body in this step, also while it rests: the sum of all contacts, N, and its average.
    force: f64,
    mean_force: f64,
    /// For how many seconds frame and surface have been slow while something touched them, at most twice [`REST_AFTER_S`].
    pub(super) slow_s: f64,
    /// Linear and angular velocity of the frame, and the body's `state`, averaged over about [`REST_AFTER_S`]: what only
    /// shakes does not get anywhere.
    drift: [Vector; 2],
    mean_state: Vec<[f64; 2]>,
}

impl Body {
    /// At rest.
    pub(super) fn new(
        model: &DeformingModel,
        options: &FlexibleOptions,
    ) -> Result<Self, ShapeError> {
        let mesh = DeformingMesh::at_rest(model)?;
        let modes = match options.is_deformable {
            true => modes(model, options)?,
            false => Vec::new(),
        };
        let mass = mesh.baked_mass_properties();
        let radius = f64::from(mesh.sphere().radius);
        Ok(Self {
            state: vec![[0.0; 2]; modes.len()],
            rest: Rest {
                speed: options.rest_speed,
                force: 0.0,
                mean_force: 0.0,
                slow_s: 0.0,
                drift: [Vector::ZERO; 2],
                mean_state: vec![[0.0; 2]; modes.len()],
            },
            touches: Vec::new(),
            is_touched: false,
            mass: mass.map_or(0.0, |mass| f64::from(mass.mass())),
            tolerance: options.tolerance.unwrap_or(TOLERANCE * radius),
            modes,
            mesh,
            store: 0.0,
        })
    }

    /// Begins a step, of another length than the last one where it is new.
    pub(super) fn begin(&mut self, step_s: f64, is_new: bool) -> Result<(), ShapeError> {
        self.touches.clear();
        self.rest.force = 0.0;
        self.store *= 0.5_f64.powf(step_s / STORE_HALF_LIFE_S);
        if is_new || self.is_touched {
            self.is_touched = false;
            for mode in &mut self.modes {
                mode.transition = transition(&mode.oscillator, step_s)?;
            }
        }
        Ok(())
    }

    /// Energy that contacts have destroyed, joules.
    pub(super) fn pay(&mut self, lost: f64) {
        self.store += LENT * lost.max(0.0);
    }

    /// Deforms it: amplitudes and rates (1/s).
    pub(super) fn set_state(
        &mut self,
        amplitudes: &[f64],
        rates: &[f64],
    ) -> Result<(), ShapeError> {
        let refused = |text: String| ShapeError::Dynamics(text);
        let expected = self.modes.len();
        for (what, found) in [("amplitudes", amplitudes.len()), ("rates", rates.len())] {
            if found != expected {
                return Err(refused(format!("{found} {what} for {expected} modes")));
            }
        }
        let mut state = Vec::with_capacity(expected);
        let each = self.modes.iter().zip(amplitudes).zip(rates);
        for (k, ((mode, q), rate)) in each.enumerate() {
            let limit = mode.limit.0;
            let Some(s) = mode.limit.s(*q).filter(|s| s.is_finite()) else {
                return Err(refused(format!(
                    "mode {k}: |q| of {q} is not below {limit}"
                )));
            };
            if !rate.is_finite() {
                return Err(refused(format!("mode {k}: a rate of {rate}")));
            }
            state.push([s, rate / mode.limit.slope(s)]);
        }
        self.state = state;
        self.rest.slow_s = 0.0;
        Ok(())
    }

    /// Adds `Uᵀ f` of a force (N, the mesh's frame) near a point of the surface.
    pub(super) fn pushed(&mut self, point: Vector, force: [f64; 3]) -> Result<(), ShapeError> {
        if self.modes.is_empty() {
            return Ok(());
        }
        let pose = self.mesh.pose();
        let found = with_workspace(|workspace| {
            pose.query(workspace)
                .project_point(wide(point), f64::INFINITY)
        })?;
        let Some(found) = found else {
            return Ok(());
        };
        let size = force.iter().map(|x| x * x).sum::<f64>().sqrt();
        let direction = force.map(|x| x / size);
        let mut moves = vec![0.0; self.modes.len()];
        pose.add_generalized_force(found.triangle, found.barycentric, direction, &mut moves)?;
        self.touches.push(Touch { force: size, moves });
        Ok(())
    }

    /// A contact presses on the body with this force, N.
    pub(super) fn press(&mut self, force: f64) {
        self.rest.force += force;
    }

    /// Whether its modes rest.
    pub(super) fn rests(&self) -> bool {
        self.rest.slow_s >= REST_AFTER_S
    }

    /// Lets modes rest where they are on average, or go on, by how fast the frame, whose linear and angular velocity these are,
    /// and the surface are. Every new shape makes an engine find contacts anew, whose points are not quite the old ones: bodies
    /// that may go on deforming a little shake each other and never sleep.
    pub(super) fn settle(&mut self, velocity: [Vector; 2], step_s: f64) {
        let share = (step_s / REST_AFTER_S).min(1.0);
        let rest = &mut self.rest;
        for (mean, now) in rest.drift.iter_mut().zip(velocity) {
            *mean += (now - *mean) * share as Real;
        }
        for (mean, now) in rest.mean_state.iter_mut().zip(&self.state) {
            for (mean, now) in mean.iter_mut().zip(now) {
                *mean += (now - *mean) * share;
            }
        }
        let is_held = rest.force > 0.0;
        let is_pressed = rest.force > HIT * rest.mean_force + LIGHT * self.mass;
        rest.mean_force += (rest.force - rest.mean_force) * share;
        if self.rests() {
            // A hit shows at once; what lets go of the body may only have lost it for a step.
            if is_pressed || self.speed(velocity, &self.state) >= HIT * self.rest.speed {
                self.rest.slow_s = 0.0;
            } else if is_held {
                self.rest.slow_s = (self.rest.slow_s + step_s).min(2.0 * REST_AFTER_S);
            } else {
                self.rest.slow_s -= step_s;
            }
        } else if is_held && self.speed(self.rest.drift, &self.rest.mean_state) < self.rest.speed {
            self.rest.slow_s += step_s;
            if self.rests() {
                self.state.copy_from_slice(&self.rest.mean_state);
                self.stop();
            }
        } else {
            self.rest.slow_s = 0.0;
        }
    }

    /// No point of the body is faster than this.
    fn speed(&self, [linear, angular]: [Vector; 2], state: &[[f64; 2]]) -> f64 {
        let turning = angular.length() * self.mesh.sphere().radius;
        let modes = self.modes.iter().zip(state);
        let surface =
            modes.map(|(mode, [s, rate])| (mode.limit.slope(*s) * rate).abs() * mode.reach);
        f64::from(linear.length() + turning) + surface.sum::<f64>()
    }

    /// No mode moves any more.
    pub(super) fn stop(&mut self) {
        for [_, rate] in &mut self.state {
            *rate = 0.0;
        }
    }

    /// One step of all modes under the forces, scaled down so that they bring no more energy than the store has.
    pub(super) fn advance(&mut self, step_s: f64) -> Result<(), ShapeError> {
        self.dampen(step_s)?;
        let mut forces = vec![0.0; self.modes.len()];
        for touch in &self.touches {
            for (force, moves) in forces.iter_mut().zip(&touch.moves) {
                *force += touch.force * moves;
            }
        }
        // Work of the forces times x is x (free + x forced).
        let (mut free, mut forced) = (0.0, 0.0);
        for ((mode, state), force) in self.modes.iter().zip(&self.state).zip(&mut forces) {
            *force *= mode.limit.slope(state[0]);
            let moved = mode.transition.apply(*state, 0.0)[0] - state[0];
            free += *force * moved;
            forced += *force * *force * mode.transition.q_a / mode.mass;
        }
        let work = free + forced;
        let share = if work <= self.store || forced <= 0.0 {
            1.0
        } else {
            let root = (free * free + 4.0 * forced * self.store).max(0.0).sqrt();
            ((root - free) / (2.0 * forced)).clamp(0.0, 1.0)
        };
        self.store = (self.store - share * (free + share * forced)).clamp(0.0, self.store);
        for ((mode, state), force) in self.modes.iter().zip(&mut self.state).zip(&forces) {
            *state = mode.transition.apply(*state, share * force / mode.mass);
        }
        Ok(())
    }

    /// Damps modes by what contacts would do within the step.
    fn dampen(&mut self, step_s: f64) -> Result<(), ShapeError> {
        let pressure: f64 = self.touches.iter().map(|touch| touch.force).sum();
        if !(pressure > 0.0) {
            return Ok(());
        }
        self.is_touched = true;
        // How far each mode moves the contacts, of unit modal mass, weighted by force: a bound for the rows of their matrix.
        let mut rows = vec![0.0; self.modes.len()];
        for touch in &self.touches {
            let own = |k: usize| touch.moves[k].abs() / self.modes[k].mass.sqrt();
            let all: f64 = (0..rows.len()).map(own).sum();
            for (k, row) in rows.iter_mut().enumerate() {
                *row += touch.force / pressure * own(k) * all;
            }
        }
        // A force that follows the mode at this stiffness within a step is that of a damper of stiffness times step.
        let decay = 0.5 * STIFFNESS * self.mass * step_s;
        for (mode, row) in self.modes.iter_mut().zip(&rows) {
            let oscillator = Oscillator {
                decay_per_s: mode.oscillator.decay_per_s + decay * row,
                ..mode.oscillator
            };
            mode.transition = transition(&oscillator, step_s)?;
        }
        Ok(())
    }

    pub(super) fn q(&self) -> Vec<f32> {
        if self.modes.is_empty() {
            return self.mesh.q().to_vec();
        }
        let each = self.modes.iter().zip(&self.state);
        each.map(|(mode, state)| mode.limit.q(state[0]) as f32)
            .collect()
    }

    /// The mesh at the new q, if a vertex may have moved by more than the tolerance.
    pub(super) fn deformed(&self) -> Result<Option<DeformingMesh>, ShapeError> {
        let q = self.q();
        let changes = q.iter().zip(self.mesh.q()).zip(&self.modes);
        let moved: f64 = changes
            .map(|((new, old), mode)| f64::from((new - old).abs()) * mode.reach)
            .sum();
        if moved <= self.tolerance {
            return Ok(None);
        }
        self.mesh.with_q(&q).map(Some)
    }

    pub(super) fn energy(&self) -> f64 {
        let each = self.modes.iter().zip(&self.state);
        each.map(|(mode, [s, rate])| {
            let swing = mode.oscillator.omega_rad_s * s;
            0.5 * mode.mass * (rate * rate + swing * swing)
        })
        .sum()
    }

    pub(super) fn kinetic_energy(&self) -> f64 {
        let each = self.modes.iter().zip(&self.state);
        each.map(|(mode, state)| 0.5 * mode.mass * state[1] * state[1])
            .sum()
    }
}

fn transition(oscillator: &Oscillator, step_s: f64) -> Result<Transition, ShapeError> {
    let made = oscillator.transition(step_s);
    made.map_err(|error| ShapeError::Dynamics(error.to_string()))
}

/// The oscillators of a model's modes.
fn modes(model: &DeformingModel, options: &FlexibleOptions) -> Result<Vec<Mode>, ShapeError> {
    let asset = model.model().asset();
    if asset.mass_properties().is_none() {
        let text = "the asset has no mass: its mesh is not closed, or it was baked without";
        return Err(ShapeError::Dynamics(text.to_string()));
    }
    let world_per_stored = asset.unit() * model.scale();
    let made = asset.modes().iter().enumerate().map(|(k, record)| {
        let (omega_rad_s, kg) = (record.omega_rad_s.get(), record.modal_mass_kg.get());
        if !(omega_rad_s > 0.0 && kg > 0.0) {
            let text = format!("mode {k} has no frequency or modal mass: no contact can move it");
            return Err(ShapeError::Dynamics(text));
        }
        let oscillator = options.damping.oscillator(omega_rad_s);
        Ok(Mode {
            transition: transition(&oscillator, 1.0 / 60.0)?,
            oscillator,
            mass: kg * model.scale() * model.scale(),
            limit: StrainLimit::of_mode(record, options.strain_limit),
            reach: f64::from(record.field_norm_max.get()) * world_per_stored,
        })
    });
    made.collect()
}
