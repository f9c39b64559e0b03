//! Bodies of rapier whose contacts move q.
//!
//! rapier moves the frames. After each of its steps the impulses of its contacts push the modes: `Uᵀ f` at the point of
//! contact, through the weights of the triangle's corners, is the force on q, and each mode is an oscillator that is
//! integrated exactly. The collider then gets the mesh at the new q.
//!
//! rapier finds contact forces for rigid bodies: it does not know that a mode gives way, and sees it one step later.
//!
//! * A contact whose depth a mode changes would push back too late and too hard. So modes are damped while they are touched, as
//!   if the force already followed the mode within the step ([`STIFFNESS`]).
//! * A lasting load bends a body as far as its stiffness says all the same: modes that forces go on pulling the same way are
//!   damped less and less.
//! * Modes rest once frame and surface are slow, something touches them and no load bends them any further, as rapier's bodies
//!   sleep: q stays, until something hits the body, presses on it a third more or less, or lets go of it.
//! * So that a contact cannot bring more energy into modes than it took from the motion of frames, each body has a store: what
//!   contacts of rapier destroy is paid in, what modes take is paid from it, and forces on modes are scaled down where it
//!   does not suffice.

use std::collections::HashMap;

use super::modes::{Body, FlexibleOptions};
use super::parry::math::{Pose, Real, Vector};
use super::parry::shape::SharedShape;
use super::points::wide;
use super::rapier::dynamics::{RigidBody, RigidBodyHandle, RigidBodySet};
use super::rapier::geometry::{
    ColliderBuilder, ColliderHandle, ColliderSet, ContactPair, NarrowPhase,
};
use super::rapier::pipeline::PhysicsWorld;
use super::shape::DeformingMesh;
use crate::error::ShapeError;
use crate::model::DeformingModel;

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
    frame_of: HashMap<ColliderHandle, RigidBodyHandle>,
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
        let body = Body::new(model, options)?;
        let collider = ColliderBuilder::new(SharedShape::new(body.mesh.clone()));
        let collider = match body.mesh.baked_mass_properties() {
            Some(mass) => collider.mass_properties(mass),
            None => collider,
        };
        let frame = frames.insert(frame);
        let collider = collider.friction(options.friction);
        let handle = colliders.insert_with_parent(collider, frame, frames);
        self.bodies.insert(handle, body);
        self.frame_of.insert(handle, frame);
        Ok((frame, handle))
    }

    /// Forgets a body; rapier's frame and collider stay.
    pub fn remove(&mut self, collider: ColliderHandle) -> bool {
        self.frame_of.remove(&collider);
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
            &mut world.bodies,
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

    /// Call after rapier's step of `step_s` seconds: contacts push modes, and colliders get the meshes at the new q. Frames do not
    /// sleep before their modes rest, and bodies that sleep stay as they are.
    ///
    /// # Errors
    /// A step that is not positive; a damaged asset.
    pub fn after_step(
        &mut self,
        contacts: &NarrowPhase,
        frames: &mut RigidBodySet,
        colliders: &mut ColliderSet,
        step_s: Real,
    ) -> Result<(), ShapeError> {
        let step_s = f64::from(step_s);
        let is_new_step = step_s != self.step_s;
        self.step_s = step_s;
        for body in self.bodies.values_mut() {
            body.begin(step_s, is_new_step)?;
        }
        // All forces first: a hit wakes modes in time for its own impulse.
        for pair in contacts.contact_pairs() {
            self.press(pair, step_s);
        }
        let frames_of = &self.frame_of;
        for (handle, body) in &mut self.bodies {
            match awake(frames_of, frames, handle) {
                Some(frame) => {
                    body.settle([frame.linvel(), frame.angvel()], step_s);
                }
                None => body.stop(step_s),
            }
            // rapier may find a frame slow long before its modes are where a load bends them.
            if body.is_settling()
                && let Some(frame) = frames_of.get(handle)
                && let Some(frame) = frames.get_mut(*frame)
                && !frame.is_sleeping()
            {
                frame.activation_mut().time_since_can_sleep = 0.0;
            }
        }
        for pair in contacts.contact_pairs() {
            self.push(pair, frames, colliders, step_s)?;
        }
        for (handle, body) in &mut self.bodies {
            if body.modes.is_empty() || awake(&self.frame_of, frames, handle).is_none() {
                continue;
            }
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

    /// How hard the contacts of a pair press on both.
    fn press(&mut self, pair: &ContactPair, step_s: f64) {
        let manifolds = pair.solver_manifolds();
        let points = manifolds.iter().flat_map(|manifold| &manifold.points);
        let impulse: f64 = points.map(|point| f64::from(point.data.impulse)).sum();
        for side in [pair.collider1, pair.collider2] {
            if let Some(body) = self.bodies.get_mut(&side) {
                body.press(impulse / step_s);
            }
        }
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
        // What sleeps or rests takes no forces.
        let moved = sides.map(|side| {
            awake(&self.frame_of, frames, &side).is_some()
                && self.bodies.get(&side).is_some_and(|body| !body.rests())
        });
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
                    let triangle = body.mesh.triangle_of([point.fid1, point.fid2][side]);
                    let force = wide(own).map(|x| x / step_s);
                    body.pushed(own_points[side], triangle, force)?;
                }
            }
        }
        let sharers = moved.iter().filter(|is_moved| **is_moved).count() as f64;
        for side in 0..2 {
            if let Some(body) = self.bodies.get_mut(&sides[side]).filter(|_| moved[side]) {
                body.pay(lost / sharers);
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
        let Some(body) = self.bodies.get_mut(&collider) else {
            let text = format!("no body has the collider {collider:?}");
            return Err(ShapeError::Dynamics(text));
        };
        body.set_state(amplitudes, rates)
    }

    /// Energy of a body's modes, joules where a world unit is a meter.
    pub fn modal_energy(&self, collider: ColliderHandle) -> Option<f64> {
        self.bodies.get(&collider).map(Body::energy)
    }

    /// Kinetic energy of a body's modes.
    pub fn modal_kinetic_energy(&self, collider: ColliderHandle) -> Option<f64> {
        self.bodies.get(&collider).map(Body::kinetic_energy)
    }
}

impl Body {
    /// No mode moves in this step.
    fn stop(&mut self, step_s: f64) {
        self.rest_on(step_s);
        for [_, rate] in &mut self.state {
            *rate = 0.0;
        }
    }
}

/// The frame of a collider's body, unless it sleeps.
fn awake<'f>(
    frame_of: &HashMap<ColliderHandle, RigidBodyHandle>,
    frames: &'f RigidBodySet,
    collider: &ColliderHandle,
) -> Option<&'f RigidBody> {
    let frame = frames.get(*frame_of.get(collider)?);
    frame.filter(|frame| !frame.is_sleeping())
}

fn whole(pose: Option<&Pose>) -> Pose {
    pose.copied().unwrap_or(Pose::IDENTITY)
}
