//! Bodies of rapier in Bevy (feature `rapier`).
//!
//! [`RapierPlugin`] steps one world of rapier per fixed step. [`RapierWorld`] holds it: a program adds its rigid bodies and
//! colliders there, with rapier's own builders, and gives the entities that draw them a [`RapierBody`]. A [`RapierFlexible`]
//! makes a [`DeformingMesh`] a body whose contacts move q. After each step places and coordinates are written back.
//!
//! ```
//! # use bdtree_bevy::rapier::{RapierBody, RapierFlexible, RapierPlugin, RapierWorld};
//! # use bdtree_bevy::{BdtModel, BdtreePlugin, DeformingMesh};
//! # use bevy_app::{App, TaskPoolPlugin};
//! # use bevy_asset::{AssetPlugin, Handle};
//! # use bevy_transform::components::Transform;
//! # use rapier3d::prelude::*;
//! # fn build(app: &mut App, chair: Handle<BdtModel>) {
//! app.add_plugins((BdtreePlugin, RapierPlugin::default()));
//!
//! // Bodies of rapier's own builders; the entity follows the body.
//! let mut physics = app.world_mut().resource_mut::<RapierWorld>();
//! let (ball, _) = physics.world.insert(
//!     RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 1.0, 0.0)),
//!     ColliderBuilder::ball(0.1).mass(3.0),
//! );
//! app.world_mut().spawn(RapierBody::from(ball));
//!
//! // A mesh becomes a flexible body at its transform, once its file is loaded.
//! app.world_mut().spawn((
//!     DeformingMesh(chair), // Handle<BdtModel>
//!     RapierFlexible::default(),
//!     Transform::from_xyz(0.0, 0.02, 0.0),
//! ));
//! # }
//! # let mut app = App::new();
//! # app.add_plugins((TaskPoolPlugin::default(), AssetPlugin::default()));
//! # build(&mut app, Handle::default());
//! # assert_eq!(app.world().resource::<RapierWorld>().world.bodies.len(), 1);
//! ```

use bdtree_parry::{FlexibleBodies, FlexibleOptions, MeshDispatcher, ShapeError};
use bevy_app::{App, FixedUpdate, Plugin};
use bevy_asset::Assets;
use bevy_ecs::intern::Interned;
use bevy_ecs::lifecycle::Remove;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use bevy_log::error;
use bevy_time::Time;
use bevy_transform::components::Transform;
use rapier3d::math::Pose;
use rapier3d::prelude::{
    ColliderHandle, NarrowPhase, PhysicsWorld, RigidBodyBuilder, RigidBodyHandle,
};

use crate::asset::BdtModel;
use crate::faults::Kinds;
use crate::pose::{Deformation, DeformingMesh};
use crate::shape::{ShapeModels, forget_models};

/// Steps a [`RapierWorld`]. Add it beside [`BdtreePlugin`](crate::BdtreePlugin).
#[derive(Debug, Clone, Copy)]
pub struct RapierPlugin {
    schedule: Interned<dyn ScheduleLabel>,
}

impl RapierPlugin {
    /// Physics that runs in a schedule. The default is `FixedUpdate`.
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self {
            schedule: schedule.intern(),
        }
    }
}

impl Default for RapierPlugin {
    fn default() -> Self {
        Self::new(FixedUpdate)
    }
}

/// What [`RapierPlugin`] does in a fixed step, in this order.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RapierSystems {
    /// Bodies are made of entities.
    Prepare,
    /// The world takes a step of the schedule's time.
    Step,
    /// Entities take the places and coordinates of their bodies.
    Writeback,
}

impl Plugin for RapierPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<RapierWorld>()
            .init_resource::<ShapeModels>()
            .add_observer(remove_body)
            .configure_sets(
                self.schedule,
                (
                    RapierSystems::Prepare,
                    RapierSystems::Step,
                    RapierSystems::Writeback,
                )
                    .chain(),
            )
            .add_systems(
                self.schedule,
                (
                    (forget_models, make_bodies)
                        .chain()
                        .in_set(RapierSystems::Prepare),
                    step.in_set(RapierSystems::Step),
                    write_back.in_set(RapierSystems::Writeback),
                ),
            );
    }
}

/// rapier's world, whose narrow phase asks bdtree's dispatcher, and the modes of its flexible bodies.
#[derive(Resource)]
pub struct RapierWorld {
    /// Bodies and colliders. A program that replaces the narrow phase gives it a `MeshDispatcher`.
    pub world: PhysicsWorld,
    /// The bodies that entities with a [`RapierFlexible`] became.
    pub flexible: FlexibleBodies,
}

impl Default for RapierWorld {
    fn default() -> Self {
        let mut world = PhysicsWorld::new();
        world.narrow_phase = NarrowPhase::with_query_dispatcher(MeshDispatcher::new());
        Self {
            world,
            flexible: FlexibleBodies::new(),
        }
    }
}

/// The body of rapier that moves this entity. Goes from the world with the component.
#[derive(Component, Debug, Clone, Copy)]
#[require(Transform)]
pub struct RapierBody {
    /// In [`RapierWorld::world`].
    pub body: RigidBodyHandle,
    /// The collider whose modes the [`Deformation`] follows, if the body is flexible.
    pub flexible: Option<ColliderHandle>,
}

impl From<RigidBodyHandle> for RapierBody {
    fn from(body: RigidBodyHandle) -> Self {
        Self {
            body,
            flexible: None,
        }
    }
}

/// Makes a [`DeformingMesh`] a dynamic body at the entity's `Transform`, once its file is loaded: it then has a [`RapierBody`].
/// The scale of the entity has to be the same along all axes when the body is made.
#[derive(Component, Debug, Clone, Default)]
#[require(DeformingMesh)]
pub struct RapierFlexible(pub FlexibleOptions);

/// A body of each entity that has none, whose file is loaded. What the file refuses is reported once.
fn make_bodies(
    mut commands: Commands,
    assets: Res<Assets<BdtModel>>,
    mut models: ResMut<ShapeModels>,
    mut world: ResMut<RapierWorld>,
    new: Query<(Entity, &RapierFlexible, &DeformingMesh, &Transform), Without<RapierBody>>,
    mut refused: Local<Vec<Entity>>,
) {
    refused.retain(|entity| new.contains(*entity));
    for (entity, flexible, mesh, transform) in &new {
        if refused.contains(&entity) {
            continue;
        }
        let scale = f64::from(transform.scale.x);
        let Some(model) = models.get(&assets, mesh.0.id(), scale) else {
            continue;
        };
        let at = Pose::from_parts(transform.translation, transform.rotation);
        let RapierWorld {
            world,
            flexible: all,
        } = &mut *world;
        let made = model.and_then(|model| {
            let frame = RigidBodyBuilder::dynamic().pose(at);
            all.insert(
                &model,
                &flexible.0,
                frame,
                &mut world.bodies,
                &mut world.colliders,
            )
        });
        match made {
            Ok((body, collider)) => {
                commands.entity(entity).try_insert(RapierBody {
                    body,
                    flexible: Some(collider),
                });
            }
            Err(why) => {
                error!("{entity}: {why}");
                refused.push(entity);
            }
        }
    }
}

fn remove_body(
    trigger: On<Remove<RapierBody>>,
    bodies: Query<&RapierBody>,
    mut world: ResMut<RapierWorld>,
) {
    if let Ok(body) = bodies.get(trigger.entity) {
        let RapierWorld { world, flexible } = &mut *world;
        if let Some(collider) = body.flexible {
            flexible.remove(collider);
        }
        world.remove_body(body.body);
    }
}

fn step(mut world: ResMut<RapierWorld>, time: Res<Time>, mut told: Local<Kinds>) {
    let RapierWorld { world, flexible } = &mut *world;
    let step_s = time.delta_secs();
    if step_s > 0.0 {
        world.integration_parameters.dt = step_s;
        let result: Result<(), ShapeError> = flexible.step(world);
        match result {
            Ok(()) => *told = Kinds::default(),
            Err(why) => {
                let words = why.to_string();
                if told.is_new(&words) {
                    error!("flexible bodies: {words}");
                }
            }
        }
    }
}

fn write_back(
    world: Res<RapierWorld>,
    mut entities: Query<(&RapierBody, &mut Transform, Option<&mut Deformation>)>,
) {
    for (own, mut transform, deformation) in &mut entities {
        let Some(body) = world.world.bodies.get(own.body) else {
            continue;
        };
        let at = body.position();
        if transform.translation != at.translation || transform.rotation != at.rotation {
            transform.translation = at.translation;
            transform.rotation = at.rotation;
        }
        let q = own.flexible.and_then(|collider| world.flexible.q(collider));
        if let (Some(q), Some(mut deformation)) = (q, deformation)
            && deformation.q != q
        {
            deformation.q = q;
        }
    }
}
