//! Bodies whose contacts move q.

use std::collections::{HashMap, HashSet};

use avian3d::collision::collider::ScalableCollider;
use avian3d::dynamics::solver::constraint_graph::ConstraintGraph;
use avian3d::prelude::*;
use bdtree_parry::{FlexibleBody, FlexibleOptions, ShapeError};
use bevy_ecs::prelude::*;
use bevy_log::error;
use bevy_math::{Quat, Vec3};
use bevy_time::Time;

use super::collider::BdtCollider;
use super::follow::DeformingCollider;
use crate::faults::{PoseFaults, PoseStage};
use crate::pose::{Deformation, DeformingMesh};

/// Lets contacts move the modes of a [`DeformingMesh`]: the impulses of avian's solver push them as `Uᵀ f`, and the entity's
/// [`Deformation`] follows. The file needs vibration modes with frequencies and modal masses, and a mass. avian itself sees a
/// rigid body of the mesh's shape. `FlexibleOptions::friction` is not used: give the body avian's `Friction`. Contacts are looked
/// for in every step, as avian does it, unless `FlexibleOptions::contact_drift` says how long they last.
#[derive(Component, Debug, Clone, Default)]
#[require(DeformingCollider)]
pub struct Flexible(pub FlexibleOptions);

/// What it is made with.
fn options(own: &FlexibleOptions) -> FlexibleOptions {
    FlexibleOptions {
        // A box that tips on another one fell off the chair where contacts lasted.
        contact_drift: own.contact_drift.or(Some(0.0)),
        ..own.clone()
    }
}

/// The modes of a [`Flexible`] body, from the step on in which its file is loaded. They start at rest, at the q that the
/// entity has; a program that writes another q to the [`Deformation`] later lets the modes go on from there, at rest.
#[derive(Component, Debug, Clone)]
pub struct FlexibleModes(FlexibleBody);

impl FlexibleModes {
    /// q, one number per mode.
    pub fn q(&self) -> Vec<f32> {
        self.0.q()
    }

    /// Deforms the body: amplitudes and rates (1/s) of its modes.
    ///
    /// # Errors
    /// Another number of modes than the body has, numbers that are not finite or at the strain limit.
    pub fn set_modes(&mut self, amplitudes: &[f64], rates: &[f64]) -> Result<(), ShapeError> {
        self.0.set_modes(amplitudes, rates)
    }

    /// Energy of the modes, joules where a world unit is a meter.
    pub fn energy(&self) -> f64 {
        self.0.modal_energy()
    }

    /// Kinetic energy of the modes.
    pub fn kinetic_energy(&self) -> f64 {
        self.0.modal_kinetic_energy()
    }

    /// Modes at a q, at rest.
    fn at(&mut self, q: &[f32]) -> Result<(), ShapeError> {
        let amplitudes: Vec<f64> = q.iter().map(|q| f64::from(*q)).collect();
        self.0.set_modes(&amplitudes, &vec![0.0; q.len()])
    }
}

/// Makes modes where a body is new or another one, and takes the q that the program wrote.
pub(super) fn make_modes(
    mut commands: Commands,
    mut bodies: Query<(
        Entity,
        Ref<Flexible>,
        Ref<DeformingMesh>,
        Ref<Deformation>,
        Ref<BdtCollider>,
        Option<&mut FlexibleModes>,
        &mut PoseFaults,
    )>,
) {
    for (entity, flexible, mesh, deformation, collider, modes, mut faults) in &mut bodies {
        let Some(shape) = collider.mesh() else {
            continue;
        };
        let is_new = collider.is_added() || flexible.is_changed() || mesh.is_changed();
        let q = &deformation.q;
        let result = match modes {
            Some(mut modes)
                if !is_new && modes.0.mesh().model().scale() == shape.model().scale() =>
            {
                if !deformation.is_changed() {
                    continue;
                }
                if q.is_empty() || *q == modes.q() {
                    Ok(())
                } else {
                    modes.at(q).map_err(|why| why.to_string())
                }
            }
            None if !is_new => continue,
            _ => FlexibleBody::new(shape.model(), &options(&flexible.0))
                .and_then(|body| {
                    let mut modes = FlexibleModes(body);
                    if flexible.0.is_deformable && !q.is_empty() {
                        modes.at(q)?;
                    }
                    commands.entity(entity).try_insert(modes);
                    Ok(())
                })
                .map_err(|why: ShapeError| format!("the body stays rigid: {why}")),
        };
        PoseFaults::tell(&mut faults, entity, PoseStage::Modes, result);
    }
}

/// A body at the start of the step.
#[derive(Debug, Clone, Copy, Default)]
struct Motion {
    linear: Vec3,
    angular: Vec3,
    /// The center of mass in the world.
    center: Vec3,
}

impl Motion {
    fn at(&self, point: Vec3) -> Vec3 {
        self.linear + self.angular.cross(point - self.center)
    }
}

/// Of one manifold's points.
#[derive(Debug, Clone, Default)]
struct Impulses {
    /// On the second body, newton seconds, the sum over substeps.
    sums: Vec<Vec3>,
    /// The last substep's part along the normal.
    last: Vec<f32>,
}

/// What the contacts of flexible bodies do in a step.
#[derive(Resource, Debug, Default)]
pub(super) struct Pushes {
    contacts: HashSet<u32>,
    before: HashMap<Entity, Motion>,
    /// Where flexible colliders stand.
    places: HashMap<Entity, (Vec3, Quat)>,
    impulses: HashMap<(u32, usize), Impulses>,
}

type Moving<'a> = (
    Entity,
    &'a Position,
    &'a Rotation,
    &'a ComputedCenterOfMass,
    &'a LinearVelocity,
    &'a AngularVelocity,
    Option<&'a GravityScale>,
    &'a RigidBody,
);

/// Before the solver: which contacts matter, and how bodies move.
pub(super) fn begin_step(
    mut pushes: ResMut<Pushes>,
    contacts: Res<ContactGraph>,
    flexible: Query<(Entity, &Position, &Rotation), With<FlexibleModes>>,
    bodies: Query<Moving<'static>>,
    gravity: Res<Gravity>,
    time: Res<Time>,
) {
    let pushes = &mut *pushes;
    pushes.contacts.clear();
    pushes.before.clear();
    pushes.impulses.clear();
    pushes.places = (flexible.iter())
        .map(|(entity, position, rotation)| (entity, (position.0, rotation.0)))
        .collect();
    if pushes.places.is_empty() {
        return;
    }
    for pair in contacts.iter_active_touching() {
        let sides = [pair.collider1, pair.collider2];
        if sides.iter().any(|side| pushes.places.contains_key(side)) {
            pushes.contacts.insert(pair.contact_id.0);
        }
    }
    for (entity, position, rotation, com, linear, angular, scale, body) in &bodies {
        let falls = match body {
            RigidBody::Dynamic => {
                gravity.0 * (scale.map_or(1.0, |scale| scale.0) * time.delta_secs())
            }
            _ => Vec3::ZERO,
        };
        let motion = Motion {
            linear: linear.0 + falls,
            angular: angular.0,
            center: position.0 + rotation.0 * com.0,
        };
        pushes.before.insert(entity, motion);
    }
}

/// After each substep: avian keeps the impulses of the last one alone.
pub(super) fn gather(mut pushes: ResMut<Pushes>, constraints: Res<ConstraintGraph>) {
    let pushes = &mut *pushes;
    if pushes.contacts.is_empty() {
        return;
    }
    let all = constraints.colors.iter();
    for constraint in all.flat_map(|color| &color.contact_constraints) {
        if !pushes.contacts.contains(&constraint.contact_id.0) {
            continue;
        }
        let key = (constraint.contact_id.0, constraint.manifold_index);
        let own = pushes.impulses.entry(key).or_default();
        own.sums.resize(constraint.points.len(), Vec3::ZERO);
        own.last.resize(constraint.points.len(), 0.0);
        let [one, two] = constraint.tangent_directions();
        for (k, point) in constraint.points.iter().enumerate() {
            let along = point.normal_part.impulse;
            let across = point.tangent_part.as_ref().map(|part| part.impulse);
            let across = across.unwrap_or_default();
            own.last[k] = along;
            own.sums[k] += constraint.normal * along + one * across.x + two * across.y;
        }
    }
}

/// After the solver: contacts push modes, and colliders get the meshes at the new q. Bodies do not sleep before their modes rest,
/// and those that sleep stay as they are.
pub(super) fn end_step(
    mut pushes: ResMut<Pushes>,
    contacts: Res<ContactGraph>,
    constraints: Res<ConstraintGraph>,
    bodies: Query<Moving<'static>>,
    asleep: Query<(), With<Sleeping>>,
    mut timers: Query<&mut SleepTimer>,
    mut flexible: Query<(
        Entity,
        &mut FlexibleModes,
        &mut Deformation,
        &mut BdtCollider,
        Option<&ColliderOf>,
    )>,
    time: Res<Time>,
) {
    let step_s = f64::from(time.delta_secs());
    for (entity, mut modes, ..) in &mut flexible {
        if let Err(why) = modes.0.begin(step_s) {
            error!("{entity}: {why}");
        }
    }
    let pushes = &mut *pushes;
    // Of each pair what its contacts have destroyed.
    let mut lost = HashMap::new();
    let all = constraints.colors.iter();
    for constraint in all.flat_map(|color| &color.contact_constraints) {
        let key = (constraint.contact_id.0, constraint.manifold_index);
        let (Some(own), Some((_, pair))) = (
            pushes.impulses.get(&key),
            contacts.get_by_id(constraint.contact_id),
        ) else {
            continue;
        };
        let sides = [(pair.collider1, pair.body1), (pair.collider2, pair.body2)];
        let before = sides.map(|(_, body)| body.and_then(|body| pushes.before.get(&body)));
        let before = before.map(|motion| motion.copied().unwrap_or_default());
        let after = sides.map(|(_, body)| {
            let found = body.and_then(|body| bodies.get(body).ok());
            found.map_or((Vec3::ZERO, Vec3::ZERO), |found| (found.4.0, found.5.0))
        });
        let lost = lost.entry(constraint.contact_id.0).or_insert((sides, 0.0));
        for (k, point) in constraint.points.iter().enumerate() {
            // What restitution added after the last substep.
            let rest = point.normal_part.impulse - own.last[k];
            let impulse = own.sums[k] + constraint.normal * rest;
            let anchors = [point.anchor1, point.anchor2];
            let at = before[0].center + anchors[0];
            let now = [0, 1].map(|k| after[k].0 + after[k].1.cross(anchors[k]));
            let approach = before[1].at(at) - before[0].at(at) + now[1] - now[0];
            lost.1 -= 0.5 * f64::from(impulse.dot(approach));
            for ((side, _), sign) in sides.into_iter().zip([-1.0_f32, 1.0]) {
                let (Ok((entity, mut modes, ..)), Some((place, turn))) =
                    (flexible.get_mut(side), pushes.places.get(&side))
                else {
                    continue;
                };
                let back = turn.inverse();
                let (own, push) = (back * (at - *place), back * (impulse * sign));
                // Constraints do not name features.
                if let Err(why) = modes.0.push(own, None, push) {
                    error!("{entity}: {why}");
                }
            }
        }
    }
    for (sides, lost) in lost.into_values() {
        let own = sides.map(|(side, _)| side);
        let count = own.iter().filter(|side| flexible.contains(**side)).count();
        for side in own {
            if let Ok((_, mut modes, ..)) = flexible.get_mut(side) {
                modes.0.pay(lost / count as f64);
            }
        }
    }
    for (entity, mut modes, mut deformation, mut collider, of) in &mut flexible {
        if of.is_some_and(|of| asleep.contains(of.body)) {
            continue;
        }
        let body = of.and_then(|of| bodies.get(of.body).ok());
        let (linear, angular) = body.map_or((Vec3::ZERO, Vec3::ZERO), |body| (body.4.0, body.5.0));
        match modes.0.advance(linear, angular) {
            Ok(Some(mesh)) => {
                let scale = collider.scale();
                let pose = Deformation {
                    q: mesh.q().to_vec(),
                    ..Deformation::default()
                };
                *collider = BdtCollider::deforming(mesh, 1.0, scale, Some(pose));
            }
            Ok(None) => {}
            Err(why) => error!("{entity}: {why}"),
        }
        if modes.0.is_settling()
            && let Some(of) = of
            && let Ok(mut timer) = timers.get_mut(of.body)
        {
            timer.0 = 0.0;
        }
        let q = modes.q();
        if deformation.q != q {
            deformation.q = q;
        }
    }
}
