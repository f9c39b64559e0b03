//! Bodies of rapier whose contacts move q.
//!
//! rapier moves the frames. After each of its steps the impulses of its contacts push the modes: `Uᵀ f` at the point of
//! contact, through the weights of the triangle's corners, is the force on q, and each mode is an oscillator that is
//! integrated exactly. The collider then gets the mesh at the new q.
//!
//! rapier finds contact forces for rigid bodies: it does not know that a mode gives way, and sees it one step later.
//!
//! * A contact whose depth a mode changes would push back too late and too hard. So modes are damped while they are touched, as
//!   if the force already followed the mode within the step ([`STIFFNESS`]). Where modes rest, that changes nothing; they
//!   take longer to get there.
//! * Modes rest once frame and surface are slow and something touches them, as rapier's bodies sleep: q stays, until something
//!   hits the body. What is left of their way to equilibrium is not gone.
//! * So that a contact cannot bring more energy into modes than it took from the motion of frames, each body has a store: what
//!   contacts of rapier destroy is paid in, what modes take is paid from it, and forces on modes are scaled down where it
//!   does not suffice.

use std::collections::HashMap;

use bdtree_dynamics::Damping;

use super::modes::{Body, modes, transition};
use super::parry::math::{Pose, Real, Vector};
use super::parry::shape::SharedShape;
use super::points::wide;
use super::rapier::dynamics::{RigidBody, RigidBodyHandle, RigidBodySet};
use super::rapier::geometry::{
    ColliderBuilder, ColliderHandle, ColliderSet, ContactManifold, ContactPair, NarrowPhase,
};
use super::rapier::pipeline::PhysicsWorld;
use super::shape::DeformingMesh;
use crate::error::ShapeError;
use crate::model::DeformingModel;

/// Seconds after which half of what a body has stored is forgotten.
const STORE_HALF_LIFE_S: f64 = 0.25;

/// How much of what contacts destroy modes may take: what rapier's corrections of positions add is not known.
const LENT: f64 = 0.5;

/// How far a vertex may be off in the collider, in radii of the mesh's bounding sphere.
const TOLERANCE: f64 = 5e-3;

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
            friction: 0.5,
        }
    }
}

/// Velocities of a frame before the step.
#[derive(Debug, Clone, Copy, Default)]
struct Velocity {
    linear: Vector,
    angular: Vector,
    /// Center of mass.
    center: Vector,
}

impl Velocity {
    fn of(body: &RigidBody) -> Self {
        Self {
            linear: body.linvel(),
            angular: body.angvel(),
            center: body.center_of_mass(),
        }
    }

    fn at(&self, point: Vector) -> Vector {
        self.linear + self.angular.cross(point - self.center)
    }
}

/// All bodies of a world that deform. Worlds need a [`MeshDispatcher`](super::MeshDispatcher) in their narrow phase.
#[derive(Debug, Clone, Default)]
pub struct FlexibleBodies {
    bodies: HashMap<ColliderHandle, Body>,
    before: HashMap<RigidBodyHandle, Velocity>,
    step_s: f64,
}

impl FlexibleBodies {
    /// No bodies.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a body: a frame, and a collider that is the model at rest with the mass of its bake.
    ///
    /// # Errors
    /// A damaged asset; modes without frequencies or modal masses, and a mesh without mass, of a body that shall deform.
    pub fn insert(
        &mut self,
        model: &DeformingModel,
        options: &FlexibleOptions,
        frame: impl Into<RigidBody>,
        frames: &mut RigidBodySet,
        colliders: &mut ColliderSet,
    ) -> Result<(RigidBodyHandle, ColliderHandle), ShapeError> {
        let mesh = DeformingMesh::at_rest(model)?;
        let modes = if options.is_deformable {
            modes(model, options)?
        } else {
            Vec::new()
        };
        let collider = ColliderBuilder::new(SharedShape::new(mesh.clone()));
        let (collider, mass) = match mesh.baked_mass_properties() {
            Some(mass) => (collider.mass_properties(mass), f64::from(mass.mass())),
            None => (collider, 0.0),
        };
        let frame = frames.insert(frame);
        let collider = collider.friction(options.friction);
        let handle = colliders.insert_with_parent(collider, frame, frames);
        let radius = f64::from(mesh.sphere().radius);
        let body = Body {
            frame,
            state: vec![[0.0; 2]; modes.len()],
            mean_state: vec![[0.0; 2]; modes.len()],
            touches: Vec::new(),
            is_held: false,
            is_touched: false,
            mass,
            tolerance: options.tolerance.unwrap_or(TOLERANCE * radius),
            modes,
            mesh,
            store: 0.0,
            slow_s: 0.0,
            drift: [Vector::ZERO; 2],
        };
        self.bodies.insert(handle, body);
        Ok((frame, handle))
    }

    /// Forgets a body; rapier's frame and collider stay.
    pub fn remove(&mut self, collider: ColliderHandle) -> bool {
        self.bodies.remove(&collider).is_some()
    }

    /// One step of a world and of all modes.
    ///
    /// # Errors
    /// Those of [`FlexibleBodies::after_step`].
    pub fn step(&mut self, world: &mut PhysicsWorld) -> Result<(), ShapeError> {
        let step_s = world.integration_parameters.dt;
        self.before_step(&world.bodies, world.gravity * step_s);
        world.step();
        self.after_step(
            &world.narrow_phase,
            &world.bodies,
            &mut world.colliders,
            step_s,
        )
    }

    /// Call before rapier's step, for programs that run its pipeline themselves: remembers velocities. `falls` is what gravity
    /// adds to them in the step.
    pub fn before_step(&mut self, frames: &RigidBodySet, falls: Vector) {
        self.before.clear();
        for (handle, frame) in frames.iter() {
            let mut velocity = Velocity::of(frame);
            if frame.is_dynamic() {
                velocity.linear += falls * frame.gravity_scale();
            }
            self.before.insert(handle, velocity);
        }
    }

    /// Call after rapier's step of `step_s` seconds: contacts push modes, and colliders get the meshes at the new q. Bodies
    /// that sleep stay as they are.
    ///
    /// # Errors
    /// A step that is not positive; a damaged asset.
    pub fn after_step(
        &mut self,
        contacts: &NarrowPhase,
        frames: &RigidBodySet,
        colliders: &mut ColliderSet,
        step_s: Real,
    ) -> Result<(), ShapeError> {
        let step_s = f64::from(step_s);
        let is_new_step = step_s != self.step_s;
        self.step_s = step_s;
        for body in self.bodies.values_mut() {
            body.touches.clear();
            body.is_held = false;
            if is_new_step || body.is_touched {
                body.is_touched = false;
                for mode in &mut body.modes {
                    mode.transition = transition(&mode.oscillator, step_s)?;
                }
            }
        }
        for pair in contacts.contact_pairs() {
            self.push(pair, frames, colliders, step_s)?;
        }
        let forgets = 0.5_f64.powf(step_s / STORE_HALF_LIFE_S);
        for (handle, body) in &mut self.bodies {
            body.store *= forgets;
            let Some(frame) = frames.get(body.frame) else {
                continue;
            };
            if frame.is_sleeping() {
                body.stop();
            }
            if frame.is_sleeping() || body.modes.is_empty() {
                continue;
            }
            body.settle(frame, step_s);
            if !body.rests() {
                body.advance(step_s)?;
            }
            if let Some(mesh) = body.deformed()? {
                let Some(collider) = colliders.get_mut(*handle) else {
                    continue;
                };
                collider.set_shape(SharedShape::new(mesh.clone()));
                body.mesh = mesh;
            }
        }
        Ok(())
    }

    /// What the contacts of a pair do to the modes of both, and the energy that they have destroyed.
    fn push(
        &mut self,
        pair: &ContactPair,
        frames: &RigidBodySet,
        colliders: &ColliderSet,
        step_s: f64,
    ) -> Result<(), ShapeError> {
        let sides = [pair.collider1, pair.collider2];
        let presses = |manifold: &ContactManifold| {
            let mut impulses = manifold.points.iter().map(|point| point.data.impulse);
            impulses.any(|impulse| impulse != 0.0)
        };
        if !pair.solver_manifolds().iter().any(presses) {
            return Ok(());
        }
        for side in &sides {
            if let Some(body) = self.bodies.get_mut(side) {
                body.is_held = true;
            }
        }
        // What sleeps or rests takes no forces.
        let is_moved = |side: &ColliderHandle| {
            self.bodies.get(side).is_some_and(|body| {
                let frame = frames.get(body.frame);
                frame.is_some_and(|frame| !frame.is_sleeping()) && !body.rests()
            })
        };
        let moved = sides.map(|side| is_moved(&side));
        if moved == [false; 2] {
            return Ok(());
        }
        let [Some(one), Some(two)] = sides.map(|side| colliders.get(side)) else {
            return Ok(());
        };
        let velocities = [one, two].map(|collider| {
            let handle = collider.parent();
            let now = handle
                .and_then(|handle| frames.get(handle))
                .map(Velocity::of);
            let before = handle.and_then(|handle| self.before.get(&handle).copied());
            [before.unwrap_or_default(), now.unwrap_or_default()]
        });
        let mut lost = 0.0;
        for manifold in pair.solver_manifolds() {
            for point in &manifold.points {
                let data = &point.data;
                if data.impulse == 0.0 {
                    continue;
                }
                // On the second body; rapier's friction is that on the first.
                let rubs = data.warmstart_tangent_world.normalize_or_zero();
                let size = data.tangent_impulse.norm();
                let impulse = manifold.data.normal * data.impulse - rubs * size;
                let own_points = [
                    whole(manifold.subshape_pos1()) * point.local_p1,
                    whole(manifold.subshape_pos2()) * point.local_p2,
                ];
                let at = *one.position() * own_points[0];
                // Half of the speed of approach before and after.
                let apart = |k: usize| velocities[1][k].at(at) - velocities[0][k].at(at);
                lost -= 0.5 * f64::from(impulse.dot(apart(0) + apart(1)));
                for (side, collider, sign) in [(0, one, -1.0), (1, two, 1.0)] {
                    let Some(body) = self.bodies.get_mut(&sides[side]).filter(|_| moved[side])
                    else {
                        continue;
                    };
                    let own = collider.position().rotation.inverse() * impulse * sign;
                    body.pushed(own_points[side], wide(own).map(|x| x / step_s))?;
                }
            }
        }
        let sharers = moved.iter().filter(|is_moved| **is_moved).count() as f64;
        for side in 0..2 {
            if let Some(body) = self.bodies.get_mut(&sides[side]).filter(|_| moved[side]) {
                body.store += LENT * lost.max(0.0) / sharers;
            }
        }
        Ok(())
    }

    /// The mesh that the collider has.
    pub fn mesh(&self, collider: ColliderHandle) -> Option<&DeformingMesh> {
        self.bodies.get(&collider).map(|body| &body.mesh)
    }

    /// q of a body, one number per mode, up to date within its tolerance or nearer.
    pub fn q(&self, collider: ColliderHandle) -> Option<Vec<f32>> {
        self.bodies.get(&collider).map(Body::q)
    }

    /// Deforms a body: amplitudes and rates (1/s) of its modes. The collider gets them with the next step.
    ///
    /// # Errors
    /// A collider of no body here, another number of modes than the body has, numbers that are not finite or at the strain limit.
    pub fn set_modes(
        &mut self,
        collider: ColliderHandle,
        amplitudes: &[f64],
        rates: &[f64],
    ) -> Result<(), ShapeError> {
        let refused = |text: String| ShapeError::Dynamics(text);
        let Some(body) = self.bodies.get_mut(&collider) else {
            return Err(refused(format!("no body has the collider {collider:?}")));
        };
        let expected = body.modes.len();
        for (what, found) in [("amplitudes", amplitudes.len()), ("rates", rates.len())] {
            if found != expected {
                return Err(refused(format!("{found} {what} for {expected} modes")));
            }
        }
        let mut state = Vec::with_capacity(expected);
        let each = body.modes.iter().zip(amplitudes).zip(rates);
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
        body.state = state;
        body.slow_s = 0.0;
        Ok(())
    }

    /// Energy of a body's modes, joules where a world unit is a meter.
    pub fn modal_energy(&self, collider: ColliderHandle) -> Option<f64> {
        self.bodies.get(&collider).map(Body::energy)
    }

    /// Kinetic energy of a body's modes.
    pub fn modal_kinetic_energy(&self, collider: ColliderHandle) -> Option<f64> {
        let body = self.bodies.get(&collider)?;
        let each = body.modes.iter().zip(&body.state);
        Some(
            each.map(|(mode, state)| 0.5 * mode.mass * state[1] * state[1])
                .sum(),
        )
    }
}

fn whole(pose: Option<&Pose>) -> Pose {
    pose.copied().unwrap_or(Pose::IDENTITY)
}
