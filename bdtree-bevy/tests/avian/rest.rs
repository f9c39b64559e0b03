//! Bodies on meshes that deform.

use avian3d::prelude::*;
use bdtree_bevy::Deformation;
use bdtree_bevy::avian::BdtCollider;
use bdtree_build::input::RawMesh;
use bdtree_fixtures::bake;
use bdtree_runtime::Model;
use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

use super::brute::Surface;
use super::support;

const RADIUS: f32 = 0.25;

fn deck() -> Model {
    let (mesh, basis) = bake::swaying_deck();
    bake::baked(&mesh, &basis)
}

fn ball(app: &mut App, at: Vec3) -> Entity {
    let body = (
        RigidBody::Dynamic,
        Collider::sphere(RADIUS),
        Transform::from_translation(at),
        AngularDamping(2.0),
    );
    app.world_mut().spawn(body).id()
}

fn place(app: &App, entity: Entity) -> Vec3 {
    app.world().get::<Position>(entity).expect("a body").0
}

fn deform(app: &mut App, entity: Entity, q: &[f32]) {
    app.world_mut()
        .get_mut::<Deformation>(entity)
        .expect("a mesh")
        .q = q.to_vec();
}

/// How far a point is from all deformed triangles, in the frame of the mesh.
fn brute_distance(app: &App, mesh: Entity, point: Vec3) -> f32 {
    use super::parry::query::PointQuery;
    let collider = app.world().get::<BdtCollider>(mesh).expect("a collider");
    let surface = Surface::of(collider.mesh().expect("a mesh"));
    let distances = surface.triangles.iter().map(|triangle| {
        triangle
            .project_local_point(point, false)
            .point
            .distance(point)
    });
    distances.fold(f32::INFINITY, f32::min)
}

/// A deck that hangs through, as a body of each kind, standing elsewhere.
#[test]
fn a_ball_rests_where_brute_force_says() {
    for kind in [RigidBody::Static, RigidBody::Kinematic] {
        let mut app = support::app();
        let asset = support::add(&mut app, &deck());
        let origin = Vec3::new(3.0, 1.0, -2.0);
        let q = vec![-1.0, 0.5];
        let deformation = Deformation {
            q,
            ..Deformation::default()
        };
        let more = (kind, deformation, Transform::from_translation(origin));
        let mesh = support::mesh_body(&mut app, asset, more);
        let ball = ball(&mut app, origin + Vec3::new(0.6, 0.6, 0.1));
        support::steps(&mut app, 64 * 8);
        let at = place(&app, ball) - origin;
        let apart = brute_distance(&app, mesh, at);
        assert!((apart - RADIUS).abs() < 5e-3, "{kind:?}: {at}, {apart}");
        assert!(at.x.abs() < 0.15 && at.y < RADIUS - 0.25, "{kind:?}: {at}");
        let speed = app.world().get::<LinearVelocity>(ball).expect("a body");
        assert!(speed.length() < 0.02, "{kind:?}: {speed:?}");
    }
}

/// A deck that bends upwards carries the ball with it, also when the ball sleeps.
#[test]
fn what_deforms_pushes() {
    let mut app = support::app();
    let asset = support::add(&mut app, &deck());
    let deformation = Deformation {
        q: vec![-1.0, 0.0],
        ..Deformation::default()
    };
    let mesh = support::mesh_body(&mut app, asset, (RigidBody::Kinematic, deformation));
    let ball = ball(&mut app, Vec3::new(0.0, 0.1, 0.0));
    support::steps(&mut app, 64 * 4);
    assert!(app.world().get::<Sleeping>(ball).is_some(), "it lies still");
    let low = place(&app, ball);
    // As long as the deck hangs through the ball does not roll away.
    for step in 0..64 {
        let q = -1.0 + 0.8 * (step as f32 / 63.0);
        deform(&mut app, mesh, &[q, 0.0]);
        support::steps(&mut app, 1);
        let apart = brute_distance(&app, mesh, place(&app, ball));
        assert!((apart - RADIUS).abs() < 2e-2, "step {step}: {apart}");
    }
    assert!(app.world().get::<Sleeping>(ball).is_none());
    support::steps(&mut app, 64);
    let high = place(&app, ball);
    assert!((high.y - low.y - 0.24).abs() < 1e-2, "{low}, {high}");
}

/// Two blocks that a morph target moves towards each other: 0.6 apart at q = 0, 0.2 at q = 1.
fn jaws() -> Model {
    let mut mesh = RawMesh {
        name: "jaws".into(),
        ..RawMesh::default()
    };
    let mut field = Vec::new();
    for side in [-1.0, 1.0] {
        let first = mesh.positions.len() as u32;
        for corner in 0..8 {
            let sign = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            mesh.positions
                .push([0.4 * side + 0.1 * sign(0), 0.3 * sign(1), 0.3 * sign(2)]);
            field.push([-0.2 * side, 0.0, 0.0]);
        }
        // Corners by their bits x, y, z; outwards.
        for [a, b, c, d] in [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ] {
            mesh.triangles.push([first + a, first + b, first + c]);
            mesh.triangles.push([first + a, first + c, first + d]);
        }
    }
    bake::baked(&mesh, &bake::basis_of(&[field]))
}

/// A ball is pushed to the middle, held without ground, and let go.
#[test]
fn morph_targets_squeeze_a_ball() {
    let mut app = support::app();
    let asset = support::add(&mut app, &jaws());
    let mesh = support::mesh_body(&mut app, asset, (RigidBody::Kinematic, Friction::new(1.0)));
    let floor = (
        RigidBody::Static,
        Collider::cuboid(4.0, 1.0, 4.0),
        Transform::from_xyz(0.0, -0.625, 0.0),
    );
    let floor = app.world_mut().spawn(floor).id();
    let radius = 0.101;
    let ball = (
        RigidBody::Dynamic,
        Collider::sphere(radius),
        Friction::new(1.0),
        Transform::from_xyz(0.15, -0.02, 0.0),
    );
    let ball = app.world_mut().spawn(ball).id();
    support::steps(&mut app, 32);
    for step in 1..=64 {
        deform(&mut app, mesh, &[step as f32 / 64.0]);
        support::steps(&mut app, 1);
    }
    assert!(place(&app, ball).x.abs() < 5e-3, "{}", place(&app, ball));
    app.world_mut().entity_mut(floor).despawn();
    support::steps(&mut app, 128);
    let held = place(&app, ball);
    assert!(held.x.abs() < 5e-3 && held.y > -0.1, "held at {held}");
    let sides: Vec<f32> = (support::contacts(&app, ball, mesh).iter())
        .map(|point| (point.point.x - held.x).signum())
        .collect();
    assert!(sides.contains(&1.0) && sides.contains(&-1.0), "{sides:?}");
    deform(&mut app, mesh, &[0.0]);
    support::steps(&mut app, 64);
    assert!(place(&app, ball).y < -1.0, "it falls");
}

/// A fast body needs avian's speculative contacts; then a mesh stops it.
#[test]
fn a_fast_ball_is_stopped() {
    let mut app = support::app();
    let asset = support::add(&mut app, &deck());
    support::mesh_body(&mut app, asset, RigidBody::Static);
    let body = (
        RigidBody::Dynamic,
        Collider::sphere(0.05),
        SpeculativeCcd::MAX,
        LinearVelocity(Vec3::NEG_Y * 80.0),
        Transform::from_xyz(0.1, 2.0, 0.1),
    );
    let ball = app.world_mut().spawn(body).id();
    support::steps(&mut app, 64);
    let at = place(&app, ball);
    assert!(at.y > 0.0, "{at}");
}

/// A file that changes, and a scale: the collider follows.
#[test]
fn colliders_follow_files_and_scales() {
    use bdtree_bevy::BdtModel;
    use bevy_asset::Assets;
    let mut app = support::app();
    let asset = support::add(&mut app, &deck());
    let mesh = support::mesh_body(&mut app, asset.clone(), RigidBody::Static);
    support::steps(&mut app, 2);
    let size = |app: &App| {
        let aabb = app.world().get::<ColliderAabb>(mesh).expect("a collider");
        aabb.size().x
    };
    // Boxes hold more than the mesh.
    let whole = size(&app);
    assert!((8.0..9.0).contains(&whole), "{whole}");
    let scaled = Transform::from_scale(Vec3::splat(0.5));
    app.world_mut().entity_mut(mesh).insert(scaled);
    support::steps(&mut app, 2);
    assert!((size(&app) - 0.5 * whole).abs() < 0.1, "{}", size(&app));
    // Not one that meshes can have: the last one stays.
    let uneven = Transform::from_scale(Vec3::new(0.5, 1.0, 0.5));
    app.world_mut().entity_mut(mesh).insert(uneven);
    support::steps(&mut app, 2);
    assert!((size(&app) - 0.5 * whole).abs() < 0.1, "{}", size(&app));
    app.world_mut().entity_mut(mesh).insert(scaled);
    let mut assets = app.world_mut().resource_mut::<Assets<BdtModel>>();
    assets
        .insert(asset.id(), BdtModel::from(jaws()))
        .expect("an asset");
    support::steps(&mut app, 3);
    assert!(size(&app) < 1.0, "{}", size(&app));
}

/// avian's own colliders: what the program changes or removes goes with ours.
#[test]
fn colliders_of_avian_are_taken_over() {
    let mut app = support::app();
    let body = (
        RigidBody::Static,
        Collider::sphere(1.0),
        Transform::default(),
    );
    let entity = app.world_mut().spawn(body).id();
    support::steps(&mut app, 1);
    let size = |app: &App| {
        let aabb = app.world().get::<ColliderAabb>(entity).expect("a collider");
        aabb.size().x
    };
    assert!((size(&app) - 2.0).abs() < 0.1, "{}", size(&app));
    *app.world_mut()
        .get_mut::<Collider>(entity)
        .expect("a collider") = Collider::sphere(2.0);
    support::steps(&mut app, 2);
    assert!((size(&app) - 4.0).abs() < 0.1, "{}", size(&app));
    (app.world_mut()
        .get_mut::<Transform>(entity)
        .expect("a place"))
    .scale = Vec3::splat(0.5);
    support::steps(&mut app, 2);
    assert!((size(&app) - 2.0).abs() < 0.1, "{}", size(&app));
    let own = app.world().get::<Collider>(entity).expect("a collider");
    assert_eq!(own.scale(), Vec3::splat(0.5));
    app.world_mut().entity_mut(entity).remove::<Collider>();
    support::steps(&mut app, 2);
    assert!(app.world().get::<BdtCollider>(entity).is_none());
}

/// A deck that rises and stops throws what lies on it as fast as it rose; one that is bent back does not hold it.
#[test]
fn what_deforms_throws() {
    let mut app = support::app();
    let asset = support::add(&mut app, &deck());
    let deformation = Deformation {
        q: vec![-1.0, 0.0],
        ..Deformation::default()
    };
    let mesh = support::mesh_body(&mut app, asset, (RigidBody::Kinematic, deformation));
    let ball = ball(&mut app, Vec3::new(0.0, 0.1, 0.0));
    support::steps(&mut app, 64 * 2);
    let speed = 2.0;
    for step in 1..=12 {
        let risen = speed * support::STEP_S * step as f32;
        deform(&mut app, mesh, &[-1.0 + risen / 0.3, 0.0]);
        support::steps(&mut app, 1);
    }
    let found = app.world().get::<LinearVelocity>(ball).expect("a body").0.y;
    assert!((found - speed).abs() < 0.1, "{found}");
    let start = place(&app, ball).y;
    let mut highest = start;
    for _ in 0..20 {
        support::steps(&mut app, 1);
        highest = highest.max(place(&app, ball).y);
    }
    let expected = speed * speed / (2.0 * 9.81);
    assert!(
        (highest - start - expected).abs() < 0.03,
        "{}",
        highest - start
    );
}

/// A surface that moves along itself takes what lies on it along.
#[test]
fn what_slides_carries() {
    let mut app = support::app();
    let asset = support::add(&mut app, &deck());
    let deformation = Deformation {
        q: vec![-1.0, 0.0],
        ..Deformation::default()
    };
    let mesh = support::mesh_body(&mut app, asset, (RigidBody::Kinematic, deformation));
    let body = (
        RigidBody::Dynamic,
        Collider::cuboid(0.2, 0.1, 0.2),
        Transform::from_xyz(0.0, -0.2, 0.0),
    );
    let cube = app.world_mut().spawn(body).id();
    support::steps(&mut app, 64);
    let start = place(&app, cube).z;
    for step in 1..=64 {
        // The middle moves across by 0.3 m.
        deform(&mut app, mesh, &[-1.0, step as f32 / 64.0]);
        support::steps(&mut app, 1);
    }
    let carried = place(&app, cube).z - start;
    assert!((carried - 0.3).abs() < 0.05, "{carried}");
    support::steps(&mut app, 64);
    let after = place(&app, cube).z - start;
    assert!((after - carried).abs() < 0.02, "{after} after {carried}");
}
