//! The modes of a body that an engine for rigid bodies moves.

use bdtree_dynamics::{Damping, Oscillator, StrainLimit, Transition};
use bdtree_runtime::TriangleId;

use super::lasting::Drift;
use super::parry::math::{Real, Vector};
use super::parry::query::PointQueryWithLocation;
use super::points::{wide, with_workspace};
use super::rest::Rest;
use super::shape::DeformingMesh;
use crate::error::ShapeError;
use crate::model::DeformingModel;

/// How stiff contacts are taken for, per mass of the body, 1/s². Contacts of rapier are springs of 60 Hz against fixed bodies
/// and of 30 Hz against others: four of the former are 5.7e5. From 1e5 on chairs on a floor come to rest.
const STIFFNESS: f64 = 3.6e5;

/// How stiff contacts are to modes is known from above only. A mode that forces have pulled the same way for so many seconds, as
/// a load on a soft body does...
const STEADY_S: f64 = 0.1;

/// ...is damped half as much every so many seconds...
const EASE_S: f64 = 0.05;

/// ...until a contact as stiff as [`STIFFNESS`] would answer after so many seconds instead of within the step.
const GIVE_S: f64 = 0.2;

/// Below this share of its way that such a mode makes good, its contacts begin to answer too late, and its damping grows again.
const CALM: f64 = 0.9;

/// What of its way a mode that goes somewhere must make good.
const SMOOTH: f64 = 0.7;

/// How much of the tolerance such a mode may move the mesh by before the collider gets it.
const SMALL: f64 = 0.1;

/// How far a vertex may be off in the collider, in radii of the mesh's bounding sphere.
const TOLERANCE: f64 = 5e-3;

/// How far a body and what it touches may move against each other, where they touch, until contacts are looked for anew: times the
/// radius of the body, or of the smaller of the two, whichever is more. Heaps of chairs take a third of the time that they take with 0
/// (docs/guide/rapier.md). What is small next to the body could pass through a thin part of it unseen.
const CONTACT_DRIFT: Real = 0.02;
const DRIFT_OF_SMALLER: Real = 0.05;

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
    /// The collider gets the mesh at the new q once a vertex may have moved by this since the last time, world units, or by a
    /// tenth of this where a load bends it smoothly. Smaller changes let rapier go on with the contacts that it has. Default
    /// 5e-3 of the radius of its bounding sphere.
    pub tolerance: Option<f64>,
    /// The contacts of the body follow its surface until they may have moved by this against what it touches, world units, or bodies
    /// may have bent by four times that: see [`DeformingMesh::with_lasting_contacts`]. Default 0.02 of the radius of its bounding sphere, or 0.05
    /// of the smaller radius of the two if that is more; 0 to look for contacts whenever it has deformed. rapier itself keeps contacts
    /// of bodies that have moved by up to 5 cm.
    pub contact_drift: Option<f64>,
    /// Modes rest once something holds the body, no point of it is faster than this on average, world units per second, and no
    /// load bends it any further: q stays until the body is hit, pressed harder or let go. Default 0.2, four times the speed
    /// below which rapier's bodies sleep; 0 for never.
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
            contact_drift: None,
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
    /// How far s is from where the force on it would hold it, averaged over [`STEADY_S`].
    to_go: f64,
    /// The rate of s and its absolute value, averaged while the body is slow.
    pub(super) mean_rate: f64,
    mean_speed: f64,
    /// For how long `to_go` has had the same sign while the body is slow, s.
    steady_s: f64,
    /// Where the force would hold s, averaged while the body is slow.
    pub(super) goal: f64,
    /// How much of the damping by contacts it gets.
    pub(super) share: f64,
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
    /// The collider gets the mesh however little it has moved, so that the engine looks for its contacts.
    pub(super) is_stale: bool,
    pub(super) rest: Rest,
}

impl Body {
    /// At rest.
    pub(super) fn new(
        model: &DeformingModel,
        options: &FlexibleOptions,
    ) -> Result<Self, ShapeError> {
        let mesh = DeformingMesh::at_rest(model)?;
        let radius = f64::from(mesh.sphere().radius);
        let mesh = match options.contact_drift {
            None => mesh.with_drift(Drift::OfSmaller {
                least: CONTACT_DRIFT * radius as Real,
                share: DRIFT_OF_SMALLER,
            })?,
            Some(way) if way > 0.0 => mesh.with_lasting_contacts(way as Real)?,
            Some(_) => mesh,
        };
        let modes = match options.is_deformable {
            true => modes(model, options)?,
            false => Vec::new(),
        };
        let mass = mesh.baked_mass_properties();
        Ok(Self {
            state: vec![[0.0; 2]; modes.len()],
            rest: Rest::new(options.rest_speed, modes.len()),
            touches: Vec::new(),
            is_touched: false,
            mass: mass.map_or(0.0, |mass| f64::from(mass.mass())),
            tolerance: options.tolerance.unwrap_or(TOLERANCE * radius),
            modes,
            mesh,
            store: 0.0,
            is_stale: false,
        })
    }

    /// Begins a step, of another length than the last one where it is new.
    pub(super) fn begin(&mut self, step_s: f64, is_new: bool) -> Result<(), ShapeError> {
        self.touches.clear();
        self.rest.begin();
        self.store *= 0.5_f64.powf(step_s / STORE_HALF_LIFE_S);
        if is_new {
            self.release(step_s)?;
        }
        Ok(())
    }

    /// Modes are those of a body that nothing touches.
    fn release(&mut self, step_s: f64) -> Result<(), ShapeError> {
        self.is_touched = false;
        for mode in &mut self.modes {
            mode.share = 1.0;
            mode.transition = transition(&mode.oscillator, step_s)?;
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
        self.rest.wake();
        Ok(())
    }

    /// Adds `Uᵀ f` of a force (N, the mesh's frame) at a point of a triangle, or near a point of the surface.
    pub(super) fn pushed(
        &mut self,
        point: Vector,
        triangle: Option<u32>,
        force: [f64; 3],
    ) -> Result<(), ShapeError> {
        if self.modes.is_empty() {
            return Ok(());
        }
        let Some((triangle, barycentric)) = self.surface_at(point, triangle)? else {
            return Ok(());
        };
        let size = force.iter().map(|x| x * x).sum::<f64>().sqrt();
        let direction = force.map(|x| x / size);
        let mut moves = vec![0.0; self.modes.len()];
        let pose = self.mesh.pose();
        pose.add_generalized_force(triangle, barycentric, direction, &mut moves)?;
        self.touches.push(Touch { force: size, moves });
        Ok(())
    }

    /// The point of a triangle that is nearest to a point, or that of the whole surface.
    fn surface_at(
        &self,
        point: Vector,
        triangle: Option<u32>,
    ) -> Result<Option<(TriangleId, [f64; 3])>, ShapeError> {
        if let Some(id) = triangle
            && let Some(corners) = self.mesh.triangle(id)
        {
            let (_, location) = corners.project_local_point_and_get_location(point, false);
            if let Some(weights) = location.barycentric_coordinates() {
                return Ok(Some((TriangleId(id), weights.map(f64::from))));
            }
        }
        let pose = self.mesh.pose();
        let found = with_workspace(|workspace| {
            pose.query(workspace)
                .project_point(wide(point), f64::INFINITY)
        })?;
        Ok(found.map(|found| (found.triangle, found.barycentric)))
    }

    /// One step of all modes under the forces, scaled down so that modes gain no more energy than the store has.
    pub(super) fn advance(&mut self, step_s: f64) -> Result<(), ShapeError> {
        // Of each mode, per modal mass.
        let mut pulls = vec![0.0; self.modes.len()];
        for touch in &self.touches {
            for (pull, moves) in pulls.iter_mut().zip(&touch.moves) {
                *pull += touch.force * moves;
            }
        }
        for ((mode, [s, _]), pull) in self.modes.iter().zip(&self.state).zip(&mut pulls) {
            *pull *= mode.limit.slope(*s) / mode.mass;
        }
        self.ease(&pulls, step_s);
        self.dampen(step_s)?;
        if self.touches.is_empty() && self.rest.is_slow() {
            return Ok(());
        }
        // With forces times x, modes gain a + x (b + x c).
        let (mut a, mut b, mut c) = (0.0, 0.0, 0.0);
        for ((mode, state), pull) in self.modes.iter().zip(&self.state).zip(&pulls) {
            let free = mode.transition.apply(*state, 0.0);
            let forced = mode.transition.apply([0.0; 2], *pull);
            a += mode.energy(free, free) - mode.energy(*state, *state);
            b += 2.0 * mode.energy(free, forced);
            c += mode.energy(forced, forced);
        }
        let spare = self.store - a;
        let share = if b + c <= spare || c <= 0.0 {
            1.0
        } else {
            let root = (b * b + 4.0 * c * spare).max(0.0).sqrt();
            ((root - b) / (2.0 * c)).clamp(0.0, 1.0)
        };
        let gained = a + share * (b + share * c);
        self.store = (self.store - gained).clamp(0.0, self.store);
        for ((mode, state), pull) in self.modes.iter_mut().zip(&mut self.state).zip(&pulls) {
            *state = mode.transition.apply(*state, share * pull);
            if share < 1.0 {
                mode.share = 1.0;
            }
        }
        Ok(())
    }

    /// Finds how far modes are from where the forces would hold them, and which are damped less because these forces last.
    fn ease(&mut self, pulls: &[f64], step_s: f64) {
        let least = (step_s / GIVE_S).min(1.0);
        let share = (step_s / STEADY_S).min(1.0);
        let weight = self.rest.weight(step_s);
        let is_slow = self.rest.is_slow();
        for ((mode, [s, rate]), pull) in self.modes.iter_mut().zip(&self.state).zip(pulls) {
            mode.mean_rate += (rate - mode.mean_rate) * weight;
            mode.mean_speed += (rate.abs() - mode.mean_speed) * weight;
            let omega = mode.oscillator.omega_rad_s;
            let goal = pull / (omega * omega);
            let before = mode.to_go;
            mode.to_go += (goal - s - before) * share;
            mode.goal += (goal - mode.goal) * weight;
            mode.steady_s = match mode.to_go * before >= 0.0 && is_slow {
                true => mode.steady_s + step_s,
                false => 0.0,
            };
            let factor = 0.5_f64.powf(step_s / EASE_S);
            if !mode.is_steady() {
                mode.share = 1.0;
            } else if !mode.is_smooth(CALM) {
                mode.share = (mode.share / factor).min(1.0);
            } else if !self.touches.is_empty() {
                mode.share = (mode.share * factor).max(least);
            }
        }
    }

    /// Damps modes by what contacts would do within the step.
    fn dampen(&mut self, step_s: f64) -> Result<(), ShapeError> {
        let pressure: f64 = self.touches.iter().map(|touch| touch.force).sum();
        if !(pressure > 0.0) {
            return match self.is_touched && !self.rest.is_held() {
                true => self.release(step_s),
                false => Ok(()),
            };
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
                decay_per_s: mode.oscillator.decay_per_s + mode.share * decay * row,
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
    pub(super) fn deformed(&mut self) -> Result<Option<DeformingMesh>, ShapeError> {
        let q = self.q();
        let changes = q.iter().zip(self.mesh.q()).zip(&self.modes);
        let moved: f64 = changes
            .map(|((new, old), mode)| f64::from((new - old).abs()) * mode.reach)
            .sum();
        // What gives way smoothly keeps its contacts: a step of the whole tolerance would drop it from what holds it.
        let is_steady = self.modes.iter().any(Mode::is_steady);
        let is_small = moved <= self.tolerance * if is_steady { SMALL } else { 1.0 };
        // What has moved is given as well, and needs no second time.
        if !std::mem::take(&mut self.is_stale) && is_small {
            return Ok(None);
        }
        self.mesh.with_q(&q).map(Some)
    }

    pub(super) fn energy(&self) -> f64 {
        let each = self.modes.iter().zip(&self.state);
        each.map(|(mode, state)| mode.energy(*state, *state)).sum()
    }

    pub(super) fn kinetic_energy(&self) -> f64 {
        let each = self.modes.iter().zip(&self.state);
        each.map(|(mode, state)| 0.5 * mode.mass * state[1] * state[1])
            .sum()
    }
}

impl Mode {
    /// Whether the force has pulled it the same way long enough to go on doing so, and it goes there instead of shaking.
    pub(super) fn is_steady(&self) -> bool {
        self.steady_s >= STEADY_S && self.is_smooth(SMOOTH)
    }

    /// Whether it makes good this share of its way.
    fn is_smooth(&self, share: f64) -> bool {
        self.mean_rate.abs() > share * self.mean_speed
    }

    /// How far the farthest vertex moves from one s to another, world units.
    pub(super) fn way(&self, from: f64, to: f64) -> f64 {
        (self.limit.q(to) - self.limit.q(from)).abs() * self.reach
    }

    /// The energy of a state, for twice the same one; for two, half of what their sum has beyond theirs.
    fn energy(&self, one: [f64; 2], two: [f64; 2]) -> f64 {
        let omega = self.oscillator.omega_rad_s;
        0.5 * self.mass * (one[1] * two[1] + omega * one[0] * (omega * two[0]))
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
            to_go: 0.0,
            steady_s: 0.0,
            mean_rate: 0.0,
            mean_speed: 0.0,
            goal: 0.0,
            share: 1.0,
        })
    });
    made.collect()
}
