//! Drops a ball on a chair that deforms, under rapier.
//!
//!     cargo run --release -p bdtree-parry --features rapier --example ball_on_chair -- target/chair.bdt
//!
//! Without a file it bakes the chair of the fixtures, coarsely.

use bdtree_parry::{DeformingModel, FlexibleBodies, FlexibleOptions, MeshDispatcher};
use bdtree_runtime::Model;
use rapier3d::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = match std::env::args().nth(1) {
        Some(path) => Model::read(path)?,
        None => bdtree_fixtures::bake::elastic("chair", 6, 30, &[]),
    };
    let height = drop_on_chair(&file)?;
    println!("after 4 s the ball lies at {height:.3} m");
    Ok(())
}

/// Drops a ball of 3 kg on the seat; its height after 4 s.
pub fn drop_on_chair(file: &Model) -> Result<f32, Box<dyn std::error::Error>> {
    let mut world = PhysicsWorld::new();
    // Before anything is in the world: rapier asks this dispatcher for all contacts, casts and distances.
    world.narrow_phase = NarrowPhase::with_query_dispatcher(MeshDispatcher::new());
    world.insert_collider(
        ColliderBuilder::cuboid(5.0, 0.5, 5.0).translation(Vector::new(0.0, -0.5, 0.0)),
        None,
    );

    let mut flexible = FlexibleBodies::new();
    let chair = DeformingModel::new(file, 1.0)?; // world units per mesh unit
    let (_, collider) = flexible.insert(
        &chair,
        &FlexibleOptions::default(),
        RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.02, 0.0)),
        &mut world.bodies,
        &mut world.colliders,
    )?;
    let (ball, _) = world.insert(
        RigidBodyBuilder::dynamic()
            .translation(Vector::new(0.0, 1.0, 0.0))
            .angular_damping(2.0),
        ColliderBuilder::ball(0.1).mass(3.0).friction(0.8),
    );

    for step in 1..=240 {
        flexible.step(&mut world)?; // instead of world.step()
        if step % 40 == 0 {
            let height = world.bodies[ball].translation().y;
            let q = flexible.q(collider).unwrap_or_default();
            let largest = q.iter().fold(0.0_f32, |m, q| m.max(q.abs()));
            println!("{step:3} steps: ball at {height:.3} m, largest |q| {largest:.5}");
        }
    }
    Ok(world.bodies[ball].translation().y)
}
