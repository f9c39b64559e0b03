//! Chairs that fall on a heap under avian: the heap of `bdtree-parry`'s example `heap`.

use std::time::{Duration, Instant};

use avian3d::prelude::*;
use bdtree_bevy::avian::{BdtreePhysicsPlugins, DeformingCollider, Flexible, FlexibleModes};
use bdtree_bevy::bdtree_runtime::Model;
use bdtree_bevy::{BdtModel, BdtreePlugin, DeformingMesh};
use bdtree_fixtures::{bake, heap};
use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets};
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;

/// Steps per second, as under rapier.
const RATE: u32 = 240;

/// Arguments: chairs (4), simulated seconds (4).
pub(crate) fn measure(arguments: &[String]) {
    let number = |k: usize, default: u32| {
        let text = arguments.get(k);
        text.map_or(default, |text| text.parse().expect("a number"))
    };
    let (count, seconds) = (number(0, 4) as usize, number(1, 4));
    let model = bake::elastic("chair", 6, 30, &[]);
    for is_flexible in [true, false] {
        let how = if is_flexible { "flexible" } else { "q = 0" };
        println!("{count} chairs under avian, {how}");
        let (mut app, chairs) = heap_of(&model, count, is_flexible);
        for second in 1..=seconds {
            let start = Instant::now();
            for _ in 0..RATE {
                app.update();
            }
            let spent = 1e3 * start.elapsed().as_secs_f64() / f64::from(RATE);
            println!(
                "{second:3} s: {spent:8.3} ms per step, {}",
                state(&app, &chairs)
            );
        }
    }
}

/// A program that takes a step in every update, and its chairs.
fn heap_of(model: &Model, count: usize, is_flexible: bool) -> (App, Vec<Entity>) {
    let mut app = App::new();
    let step = Duration::from_secs(1) / RATE;
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        TransformPlugin,
        AssetPlugin {
            watch_for_changes_override: Some(false),
            ..Default::default()
        },
        BdtreePlugin,
        BdtreePhysicsPlugins::default(),
    ))
    .insert_resource(Time::<Fixed>::from_duration(step))
    .insert_resource(TimeUpdateStrategy::ManualDuration(step));
    app.finish();
    app.cleanup();
    let mut models = app.world_mut().resource_mut::<Assets<BdtModel>>();
    let mesh = models.add(BdtModel::from(model.clone()));
    let world = app.world_mut();
    world.spawn((
        RigidBody::Static,
        Collider::cuboid(40.0, 1.0, 40.0),
        Transform::from_xyz(0.0, -0.5, 0.0),
    ));
    let half = heap::half_width(count);
    for (x, z) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
        let thick = |along: f32| if along == 0.0 { 2.0 * half + 2.0 } else { 1.0 };
        world.spawn((
            RigidBody::Static,
            Collider::cuboid(thick(x), 200.0, thick(z)),
            Transform::from_xyz(x * (half + 0.5), 100.0, z * (half + 0.5)),
        ));
    }
    let chairs = (0..count).map(|k| {
        let [at, turn] = heap::start(k, count).map(Vec3::from_array);
        let place = Transform::from_translation(at).with_rotation(Quat::from_scaled_axis(turn));
        let body = (DeformingMesh(mesh.clone()), RigidBody::Dynamic, place);
        let mut chair = world.spawn((body, Friction::new(0.5)));
        if is_flexible {
            chair.insert(Flexible::default());
        } else {
            chair.insert(DeformingCollider);
        }
        chair.id()
    });
    let chairs = chairs.collect();
    (app, chairs)
}

/// The fastest chair, the energy of modes, how many sleep, and the lowest and the farthest chair.
fn state(app: &App, chairs: &[Entity]) -> String {
    let world = app.world();
    let mut fastest = 0.0_f32;
    let mut joules = 0.0;
    let (mut lowest, mut farthest) = (f32::INFINITY, 0.0_f32);
    for chair in chairs {
        let speed = world
            .get::<LinearVelocity>(*chair)
            .map_or(0.0, |v| v.length());
        fastest = fastest.max(speed);
        joules += (world.get::<FlexibleModes>(*chair)).map_or(0.0, FlexibleModes::kinetic_energy);
        let at = world.get::<Position>(*chair).map_or(Vec3::ZERO, |at| at.0);
        lowest = lowest.min(at.y);
        farthest = farthest.max(at.x.abs().max(at.z.abs()));
    }
    let asleep = chairs
        .iter()
        .filter(|chair| world.get::<Sleeping>(**chair).is_some());
    format!(
        "fastest at {fastest:.3} m/s, {joules:.2e} J in modes, {} asleep, lowest at {lowest:.2} m, farthest at {farthest:.2} m",
        asleep.count()
    )
}
