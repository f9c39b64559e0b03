//! The chairs of the example `heap` as soft bodies of rapier's own, and what a step of them takes.
//!
//!     cargo run --release -p bdtree-parry --features rapier,rapier3d/fem --example soft_heap -- 24 4 0.1 fem
//!
//! Arguments: chairs (4), simulated seconds (1), edge of the cells that are cut into tetrahedra in meters (0.1), solver of
//! rapier's (`constraints` or `fem`).
//!
//! A body consists of the lattice cells that the chair reaches. The plastic is thinner than any cell that a step can afford, so
//! cells are as much softer as they have more volume, and weigh as much as the chair together.

#[path = "heap.rs"]
#[allow(dead_code, unreachable_pub)]
mod heap;

use std::time::Instant;

use bdtree_build::basis::elastic::ElasticOptions;
use bdtree_dynamics::Damping;
use bdtree_fixtures::models;
use bdtree_parry::FlexibleOptions;
use rapier3d::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let count: usize = args.next().map_or(Ok(4), |text| text.parse())?;
    let seconds: f32 = args.next().map_or(Ok(1.0), |text| text.parse())?;
    let cell: f32 = args.next().map_or(Ok(0.1), |text| text.parse())?;
    let solver = match args.next().as_deref() {
        None | Some("constraints") => SoftBodySolver::Constraints,
        Some("fem") => SoftBodySolver::Fem,
        Some(other) => return Err(format!("{other}: no solver").into()),
    };
    let chair = soft_chair(cell, solver)?;
    println!(
        "{count} chairs, {solver:?}, cells of {cell} m: {} particles, {} tetrahedra, {:.2} kg, {:.2e} Pa each",
        chair.positions.len(),
        chair.cells.len(),
        chair.particle_mass * chair.positions.len() as f32,
        chair.material.young_modulus,
    );
    let mut world = heap::room(count);
    let bodies: Vec<SoftBodyHandle> = (0..count)
        .map(|k| world.insert_soft_body(placed(&chair, heap::start(k, count))))
        .collect();
    let steps = (seconds * heap::RATE as f32) as usize;
    for second in 0..steps.div_ceil(heap::RATE) {
        let steps = (steps - heap::RATE * second).min(heap::RATE);
        let start = Instant::now();
        for _ in 0..steps {
            world.step();
        }
        let spent = start.elapsed().as_secs_f64();
        println!(
            "{:3} s: {:8.3} ms per step, {}",
            second + 1,
            1e3 * spent / steps as f64,
            state(&world, &bodies)
        );
    }
    Ok(())
}

/// A chair at the origin: cells around its surface, of the material of its bake.
fn soft_chair(
    cell: f32,
    solver: SoftBodySolver,
) -> Result<SoftBodyBuilder, Box<dyn std::error::Error>> {
    let bake = ElasticOptions::default();
    let options = FlexibleOptions::default();
    let mesh = models::mesh("chair").ok_or("no chair")?;
    let vector = |p: [f64; 3]| Vector::from_array(p.map(|x| x as f32));
    let vertices: Vec<Vector> = mesh.positions.iter().map(|p| vector(*p)).collect();
    let made = SoftBodyBuilder::volumetric(&vertices, &mesh.triangles, cell);
    let made = made.ok_or("rapier finds no volume in the chair")?;
    let corner = |v: u32| mesh.positions[v as usize];
    let volume: f64 = mesh
        .triangles
        .iter()
        .map(|t| signed_volume(t.map(corner)))
        .sum();
    let filled: f64 = made
        .cells
        .iter()
        .map(|cell| {
            let [origin, corners @ ..] = cell.map(|v| made.positions[v as usize]);
            signed_volume(corners.map(|p| (p - origin).to_array().map(f64::from))).abs()
        })
        .sum();
    let Damping::Ratio(damping) = options.damping else {
        return Err("a damping ratio".into());
    };
    Ok(made
        .cell_model(SoftBodyCellModel::Corotational)
        .material(SoftBodyMaterial {
            young_modulus: (bake.young_pa * volume / filled) as f32,
            poisson_ratio: bake.poisson as f32,
            elastic_damping_ratio: damping as f32,
            ..SoftBodyMaterial::default()
        })
        .solver(solver)
        .mass((bake.density_kg_m3 * volume) as f32)
        .surface_collider(ColliderBuilder::ball(0.1).friction(options.friction)))
}

/// Of the tetrahedron of a triangle and the origin.
fn signed_volume([a, b, c]: [[f64; 3]; 3]) -> f64 {
    (a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0]))
        / 6.0
}

fn placed(chair: &SoftBodyBuilder, at: Pose) -> SoftBodyBuilder {
    let positions = chair.positions.iter().map(|p| at * *p).collect();
    chair.clone().positions(positions)
}

/// Kinetic energy, sleeping bodies, those that rapier switched off since their numbers were not finite, and the lowest point.
fn state(world: &PhysicsWorld, bodies: &[SoftBodyHandle]) -> String {
    let bodies: Vec<&SoftBody> = bodies
        .iter()
        .map(|body| &world.soft_bodies[*body])
        .collect();
    let count = |is_so: fn(&SoftBody) -> bool| bodies.iter().filter(|body| is_so(body)).count();
    let particles = || bodies.iter().flat_map(|body| body.particles());
    let joules: f64 = particles()
        .map(|p| 0.5 * f64::from(p.mass()) * f64::from(p.velocity().length_squared()))
        .sum();
    let lowest = particles().map(|p| p.position().y).fold(f32::MAX, f32::min);
    format!(
        "{joules:10.3e} J in motion, {} asleep, {} switched off, lowest point at {lowest:.3} m",
        count(SoftBody::is_sleeping),
        count(|body| !body.is_enabled())
    )
}
