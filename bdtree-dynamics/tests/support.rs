//! Bodies and worlds of tests.

use std::sync::OnceLock;

use bdtree_build::input::RawMesh;
use bdtree_dynamics::{
    BodyOptions, ContactLaw, Frame, MassProperties, ModelId, Plane, World, WorldOptions,
};
use bdtree_fixtures::bake;
use bdtree_runtime::{Model, Transform};

/// Radius of [`ball`].
pub(crate) const RADIUS: f64 = 0.5;

/// An asset whose only contact sphere has radius 0.5 around the origin: one triangle.
pub(crate) fn ball_model() -> Model {
    let mesh = ball_mesh();
    bake::baked(&mesh, &bake::rigid(&mesh))
}

/// A ball as [`ball_model`], whose only mode moves it by q along x and has no frequency, as those of animations.
pub(crate) fn sliding_ball() -> Model {
    let mesh = ball_mesh();
    let field = vec![[1.0, 0.0, 0.0]; mesh.positions.len()];
    bake::baked(&mesh, &bake::basis_of(&[field]))
}

fn ball_mesh() -> RawMesh {
    let (s, h) = (RADIUS, RADIUS * 0.75_f64.sqrt());
    RawMesh {
        name: "ball".to_string(),
        positions: vec![[s, 0.0, 0.0], [-0.5 * s, h, 0.0], [-0.5 * s, -h, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..RawMesh::default()
    }
}

/// Adds a ball as [`ball_model`], with the mass of a homogeneous one.
pub(crate) fn ball(world: &mut World, mass_kg: f64) -> ModelId {
    let options = BodyOptions {
        mass: Some(MassProperties::ball(mass_kg, RADIUS, [0.0; 3])),
        ..BodyOptions::default()
    };
    world.add_model(&ball_model(), &options).expect("a ball")
}

/// The beam, 1 m long and 5 cm thick, free, with six modes; baked once.
pub(crate) fn beam() -> &'static Model {
    static BEAM: OnceLock<Model> = OnceLock::new();
    BEAM.get_or_init(|| bake::elastic("beam", 6, 40, &[]))
}

/// A world of this step and law, without gravity.
pub(crate) fn weightless(step_s: f64, law: ContactLaw) -> World {
    World::new(WorldOptions {
        step_s,
        gravity: [0.0; 3],
        law,
        sleep_speed: 0.0,
        ..WorldOptions::default()
    })
    .expect("a world")
}

/// The ground at height 0.
pub(crate) const GROUND: Plane = Plane {
    normal: [0.0, 1.0, 0.0],
    offset: 0.0,
};

/// At a place, not turned.
pub(crate) fn at(translation: [f64; 3]) -> Transform {
    Transform {
        translation,
        ..Transform::IDENTITY
    }
}

/// A heap in the making: beams one above the other, turned against each other, on the ground.
pub(crate) fn falling_beams(count: usize, threads: usize) -> World {
    let options = WorldOptions {
        threads,
        ..WorldOptions::default()
    };
    falling(count, options, &BodyOptions::default())
}

/// The same, that never sleeps.
pub(crate) fn restless_beams(count: usize) -> World {
    let options = WorldOptions {
        sleep_speed: 0.0,
        ..WorldOptions::default()
    };
    falling(count, options, &BodyOptions::default())
}

/// The same in a world and of beams with these options.
pub(crate) fn falling(count: usize, options: WorldOptions, of: &BodyOptions) -> World {
    let mut world = World::new(options).expect("a world");
    // Some sixty contact spheres: with the usual level a beam lies on a hundred.
    let of = BodyOptions {
        level: Some(1),
        ..of.clone()
    };
    let model = world.add_model(beam(), &of).expect("a beam");
    world.add_plane(GROUND).expect("a plane");
    for k in 0..count {
        let angle = 0.7 * k as f64;
        let (sin, cos) = (0.5 * angle).sin_cos();
        let turned = Transform {
            rotation: [0.0, sin, 0.0, cos],
            translation: [
                -0.5 * angle.cos(),
                0.15 + 0.12 * k as f64,
                0.5 * angle.sin(),
            ],
            scale: 1.0,
        };
        world.add_body(model, Frame::Free, turned).expect("a body");
    }
    world
}

/// Momentum and angular momentum of a world, to 1e-9.
pub(crate) fn same_momenta(before: [[f64; 3]; 2], after: [[f64; 3]; 2]) {
    for (before, after) in before.iter().flatten().zip(after.iter().flatten()) {
        assert!((before - after).abs() < 1e-9, "{before} {after}");
    }
}

/// A closed box of twelve triangles around the origin.
pub(crate) fn box_mesh(sides: [f64; 3]) -> RawMesh {
    let corner = |k: usize| {
        let side = |axis: usize| if k >> axis & 1 == 0 { -0.5 } else { 0.5 } * sides[axis];
        [side(0), side(1), side(2)]
    };
    RawMesh {
        name: "box".to_string(),
        positions: (0..8).map(corner).collect(),
        triangles: vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ],
        ..RawMesh::default()
    }
}
