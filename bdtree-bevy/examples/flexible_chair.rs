//! A flexible chair among rigid boxes, or that stops a ball, under avian or rapier:
//!
//! ```text
//! cargo run --features avian --example flexible_chair [-- [ball] [CHAIR.bdt]]
//! cargo run --features rapier --example flexible_chair [-- [ball] [CHAIR.bdt]]
//! ```
//!
//! Four boxes fall on a chair and around it, or with the word `ball` a ball on its seat. It prints what happens in four seconds of
//! simulated time and writes a picture, for example `target/bevy/flexible_chair_avian.png` or `…_avian_ball.png`. Without a file
//! it bakes the chair of the fixtures, coarsely and of a soft plastic, so that its legs give way. With both features avian moves
//! the bodies; the word `rapier` among the arguments has rapier do it.

use std::process::ExitCode;
use std::time::Duration;

use bdtree_bevy::bdtree_runtime::Model;
use bdtree_bevy::{BdtModel, BdtreePlugin, Deformation, DeformingMesh};
use bevy_app::App;
use bevy_asset::{Assets, Handle};
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_mesh::{Mesh, Meshable};
use bevy_time::TimeUpdateStrategy;
use bevy_transform::components::Transform;

pub(crate) mod support;

use support::picture::Picture;

/// Half of a box's edge.
pub(crate) const HALF: f32 = 0.08;

/// Angular damping of the ball, 1/s: the seat slopes.
const ROLLS_NOT: f32 = 10.0;

/// Steps of 1/64 s, one a frame.
const STEPS: usize = 64 * 4;

/// Where boxes start: over the seat, beside it, and on each other.
const STARTS: [[f32; 3]; 4] = [
    [0.02, 0.9, 0.0],
    [-0.03, 1.2, 0.04],
    [0.5, 0.4, 0.1],
    [0.48, 0.7, 0.12],
];

/// Where the ball starts: over the seat.
const BALL_START: Vec3 = Vec3::new(0.02, 0.9, 0.0);

/// What falls on the chair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Falling {
    Boxes,
    Ball,
}

/// What differs between engines of rigid bodies.
pub(crate) trait Engine {
    fn name(&self) -> &'static str;

    /// Adds the engine's plugins.
    fn add(&self, app: &mut App);

    /// The half-space below y = 0, as a large box.
    fn ground(&self, world: &mut World);

    fn chair(&self, world: &mut World, mesh: Handle<BdtModel>, at: Transform) -> Entity;

    /// A cube of 2 kg with edges of twice [`HALF`].
    fn cube(&self, world: &mut World, at: Transform) -> Entity;

    /// A ball of 3 kg with a radius of [`HALF`], which does not roll for long.
    fn ball(&self, world: &mut World, at: Transform) -> Entity;
}

/// The scene's bodies.
pub(crate) struct Scene {
    /// Has a `DeformingMesh`.
    pub(crate) chair: Entity,
    /// Boxes, or a ball.
    pub(crate) fallen: Vec<Entity>,
}

// Not run where tests include this file as a module.
#[allow(dead_code)]
pub(crate) fn main() -> ExitCode {
    support::show_errors();
    match start() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("flexible_chair: {why}");
            ExitCode::FAILURE
        }
    }
}

#[allow(dead_code)]
fn start() -> Result<(), Box<dyn std::error::Error>> {
    let mut file = None;
    let mut falling = Falling::Boxes;
    let mut engines = engines();
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            name @ ("avian" | "rapier") => engines.retain(|engine| engine.name() == name),
            "ball" => falling = Falling::Ball,
            path => file = Some(Model::read(path)?),
        }
    }
    let Some(engine) = engines.first() else {
        return Err("no such engine: add --features avian or --features rapier".into());
    };
    let file = file.unwrap_or_else(chair);
    println!("under {}", engine.name());
    let mut tell = |line: &str| println!("{line}");
    let (_, _, picture) = run(&file, &**engine, falling, &mut tell);
    println!("{}", picture.save(&name(&**engine, falling)).display());
    Ok(())
}

/// What its picture is called.
pub(crate) fn name(engine: &dyn Engine, falling: Falling) -> String {
    let what = if falling == Falling::Ball {
        "_ball"
    } else {
        ""
    };
    format!("flexible_chair_{}{what}", engine.name())
}

/// The chair of the fixtures, baked coarsely, of a soft plastic: its legs give way under two boxes.
pub(crate) fn chair() -> Model {
    let options = bdtree_build::basis::elastic::ElasticOptions {
        mode_count: 6,
        resolution: Some(30),
        young_pa: 2e8,
        ..Default::default()
    };
    bdtree_fixtures::bake::elastic_of("chair", &options)
}

/// The engines that are compiled in.
fn engines() -> Vec<Box<dyn Engine>> {
    vec![
        #[cfg(feature = "avian")]
        Box::new(avian::Avian),
        #[cfg(feature = "rapier")]
        Box::new(rapier::Rapier),
    ]
}

/// The program and its picture after all steps; `tell` is given a line per second.
pub(crate) fn run(
    file: &Model,
    engine: &dyn Engine,
    falling: Falling,
    tell: &mut dyn FnMut(&str),
) -> (App, Scene, Picture) {
    let mut app = support::app(480, 360, &support::models::folder());
    app.add_plugins(BdtreePlugin);
    engine.add(&mut app);
    let step = Duration::from_secs(1) / 64;
    app.insert_resource(TimeUpdateStrategy::ManualDuration(step));
    support::start(&mut app);
    let scene = build(app.world_mut(), file, engine, falling);
    for second in 0..=STEPS / 64 {
        if second > 0 {
            support::run_undrawn(&mut app, 64);
        }
        let seen = state(&app, &scene);
        tell(&format!("{second} s: {seen}"));
    }
    // Shaders may take any number of frames to be ready: the picture is of this moment all the same.
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO));
    support::settle(&mut app);
    let picture = support::take(&mut app);
    (app, scene, picture)
}

/// A chair on the ground, which is the plane y = 0, what falls above it, light and a camera.
fn build(world: &mut World, file: &Model, engine: &dyn Engine, falling: Falling) -> Scene {
    let eye = Vec3::new(1.3, 0.9, 1.7);
    support::camera(world, eye, Vec3::new(0.15, 0.35, 0.0));
    support::sun(world, Vec3::new(1.0, 3.0, 1.5));
    let plane = bevy_shape::Plane3d::default().mesh().size(20.0, 20.0);
    let ground = support::solid(world, plane, Color::srgb(0.6, 0.62, 0.6));
    world.spawn(ground);
    engine.ground(world);
    let mut models = world.resource_mut::<Assets<BdtModel>>();
    let mesh = models.add(BdtModel::from(file.clone()));
    let chair = engine.chair(world, mesh, Transform::from_xyz(0.0, 0.01, 0.0));
    let wood = support::material(world, WOOD);
    world.entity_mut(chair).insert(wood);
    let fallen = match falling {
        Falling::Ball => {
            let body = engine.ball(world, Transform::from_translation(BALL_START));
            let look = support::solid(world, ball(), BLUE);
            world.entity_mut(body).insert(look);
            vec![body]
        }
        Falling::Boxes => {
            let each = (0..).zip(STARTS).map(|(k, at)| {
                let turn = Quat::from_rotation_y(0.4 * k as f32);
                let at = Transform::from_translation(Vec3::from_array(at)).with_rotation(turn);
                let body = engine.cube(world, at);
                let look = support::solid(world, cube(), BLUE);
                world.entity_mut(body).insert(look);
                body
            });
            each.collect()
        }
    };
    Scene { chair, fallen }
}

pub(crate) const WOOD: Color = Color::srgb(0.75, 0.5, 0.3);
pub(crate) const BLUE: Color = Color::srgb(0.15, 0.35, 0.8);

/// What a box looks like.
pub(crate) fn cube() -> Mesh {
    let edge = 2.0 * HALF;
    bevy_shape::Cuboid::new(edge, edge, edge).into()
}

/// What the ball looks like.
pub(crate) fn ball() -> Mesh {
    bevy_shape::Sphere::new(HALF).into()
}

/// Heights of what falls and the largest coordinate of the chair.
fn state(app: &App, scene: &Scene) -> String {
    let height = |entity: &Entity| {
        let at = app.world().get::<Transform>(*entity);
        format!("{:.3}", at.map_or(f32::NAN, |at| at.translation.y))
    };
    let heights: Vec<String> = scene.fallen.iter().map(height).collect();
    let q = app.world().get::<Deformation>(scene.chair);
    let largest = q.map_or(0.0, |pose| pose.q.iter().fold(0.0, |m, q| q.abs().max(m)));
    let heights = heights.join(", ");
    format!("at {heights} m, largest |q| {largest:.5}")
}

#[cfg(feature = "avian")]
pub(crate) mod avian {
    use super::*;
    use avian3d::prelude::*;
    use bdtree_bevy::avian::{BdtreePhysicsPlugins, Flexible};

    pub(crate) struct Avian;

    impl Engine for Avian {
        fn name(&self) -> &'static str {
            "avian"
        }

        fn add(&self, app: &mut App) {
            app.add_plugins(BdtreePhysicsPlugins::default());
        }

        fn ground(&self, world: &mut World) {
            world.spawn((
                RigidBody::Static,
                Collider::cuboid(10.0, 1.0, 10.0),
                Transform::from_xyz(0.0, -0.5, 0.0),
            ));
        }

        fn chair(&self, world: &mut World, mesh: Handle<BdtModel>, at: Transform) -> Entity {
            let chair = world.spawn((
                DeformingMesh(mesh),
                Flexible::default(),
                RigidBody::Dynamic,
                Friction::new(0.5),
                at,
            ));
            chair.id()
        }

        fn cube(&self, world: &mut World, at: Transform) -> Entity {
            let edge = 2.0 * HALF;
            let cube = world.spawn((
                RigidBody::Dynamic,
                Collider::cuboid(edge, edge, edge),
                Mass(2.0),
                Friction::new(0.5),
                at,
            ));
            cube.id()
        }

        fn ball(&self, world: &mut World, at: Transform) -> Entity {
            let ball = world.spawn((
                RigidBody::Dynamic,
                Collider::sphere(HALF),
                Mass(3.0),
                Friction::new(0.8),
                AngularDamping(ROLLS_NOT),
                at,
            ));
            ball.id()
        }
    }
}

#[cfg(feature = "rapier")]
pub(crate) mod rapier {
    use super::*;
    use bdtree_bevy::rapier::{RapierBody, RapierFlexible, RapierPlugin, RapierWorld};
    use rapier3d::prelude::*;

    pub(crate) struct Rapier;

    impl Engine for Rapier {
        fn name(&self) -> &'static str {
            "rapier"
        }

        fn add(&self, app: &mut App) {
            app.add_plugins(RapierPlugin::default());
        }

        fn ground(&self, world: &mut World) {
            let ground = ColliderBuilder::cuboid(5.0, 0.5, 5.0);
            let at = Vector::new(0.0, -0.5, 0.0);
            let mut physics = world.resource_mut::<RapierWorld>();
            physics.world.insert_collider(ground.translation(at), None);
        }

        fn chair(&self, world: &mut World, mesh: Handle<BdtModel>, at: Transform) -> Entity {
            let chair = (DeformingMesh(mesh), RapierFlexible::default(), at);
            world.spawn(chair).id()
        }

        fn cube(&self, world: &mut World, at: Transform) -> Entity {
            let pose = rapier3d::math::Pose::from_parts(at.translation, at.rotation);
            let mut physics = world.resource_mut::<RapierWorld>();
            let (body, _) = physics.world.insert(
                RigidBodyBuilder::dynamic().pose(pose),
                ColliderBuilder::cuboid(HALF, HALF, HALF)
                    .mass(2.0)
                    .friction(0.5),
            );
            world.spawn((RapierBody::from(body), at)).id()
        }

        fn ball(&self, world: &mut World, at: Transform) -> Entity {
            let mut physics = world.resource_mut::<RapierWorld>();
            let (body, _) = physics.world.insert(
                RigidBodyBuilder::dynamic()
                    .translation(at.translation)
                    .angular_damping(ROLLS_NOT),
                ColliderBuilder::ball(HALF).mass(3.0).friction(0.8),
            );
            world.spawn((RapierBody::from(body), at)).id()
        }
    }
}
