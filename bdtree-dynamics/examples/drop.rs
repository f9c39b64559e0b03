//! Drops a body on the ground and prints what it touches.
//!
//!     cargo run --release -p bdtree-dynamics --example drop -- target/chair.bdt
//!
//! Without a file it drops a ball that does not deform.

use bdtree_dynamics::{BodyOptions, Frame, Phase, Plane, World, WorldOptions};
use bdtree_runtime::{Model, Transform, include_bdt};

fn main() {
    if let Err(error) = drop_it() {
        eprintln!("drop: {error}");
        std::process::exit(1);
    }
}

fn drop_it() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1);
    let model = match &file {
        Some(file) => Model::read(file)?,
        None => Model::from_static(include_bdt!("../../fixtures/golden/sphere.bdt"))?,
    };
    let mut world = World::new(WorldOptions::default())?;
    let options = BodyOptions {
        is_deformable: file.is_some(),
        ..BodyOptions::default()
    };
    let kind = world.add_model(&model, &options)?;
    world.add_plane(Plane {
        normal: [0.0, 1.0, 0.0],
        offset: 0.0,
    })?;
    let tilted = Transform {
        rotation: [0.0, 0.0, 0.3_f64.sin(), 0.3_f64.cos()],
        translation: [0.0, 2.0, 0.0],
        scale: 1.0,
    };
    let body = world.add_body(kind, Frame::Free, tilted)?;
    let mut q = vec![0.0; world.model(kind)?.mode_count()];
    for _ in 0..300 {
        world.step()?;
        for event in world.events().filter(|event| event.phase == Phase::Began) {
            world.q(body, &mut q)?;
            let largest = q.iter().fold(0.0_f64, |m, q| m.max(q.abs()));
            let [x, y, z] = event.impulse;
            println!(
                "step {}: touches the ground, impulse {x:.3} {y:.3} {z:.3} N s, largest |q| {largest:.4}",
                world.steps()
            );
        }
    }
    let energy = world.energy();
    println!("after 2 s: {:.3} J in motion", energy.kinetic);
    Ok(())
}
