//! Boxes hold what they are around.

use bdtree_bevy::bdtree_runtime::{Model, VertexId};
use bdtree_bevy::{BdtreeSystems, DeformedBounds, DeformedInstance};
use bdtree_fixtures::{bake, poses, skin};
use bevy_app::{PostUpdate, Update};
use bevy_camera::primitives::Aabb;
use bevy_camera::visibility::{DynamicSkinnedMeshBounds, NoAutoAabb};
use bevy_ecs::prelude::*;
use bevy_math::DVec3;
use bevy_transform::components::Transform;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::common::{
    app, ball, bar, deformation, faults, instance, of_corpus, random_joints, random_place, spawn,
};

/// How many poses there are in all, over all models.
const POSES: usize = 1_000_000;
/// Vertices of a pose that are looked at, at most.
const VERTICES: usize = 40;

/// Within ordinary amplitudes, far beyond them, at the limits, or one mode alone.
fn random_q(model: &Model, rng: &mut Pcg64Mcg) -> Vec<f32> {
    let asset = model.asset();
    let limit = |j: usize| asset.modes()[j].q_limit.get();
    match rng.random_range(0..8) {
        0 => {
            let hard = poses::hard_qs(asset);
            hard[rng.random_range(0..hard.len())].clone()
        }
        1 => (0..asset.mode_count())
            .map(|j| limit(j) * if rng.random_bool(0.5) { 1.0 } else { -1.0 })
            .collect(),
        2 => poses::random_q(asset, 30.0, rng),
        _ => poses::random_q(asset, 0.5, rng),
    }
}

/// Fails if a vertex of a body is outside of one of its boxes. Corners of triangles are what is drawn.
fn check(world: &World, entity: Entity, rng: &mut Pcg64Mcg) {
    let body = &world.get::<DeformedInstance>(entity).unwrap().instance;
    let placed = body.snapshot();
    let own = placed
        .placed(bdtree_bevy::bdtree_runtime::Transform::IDENTITY)
        .unwrap();
    let aabb = world.get::<Aabb>(entity).unwrap();
    let bounds = world.get::<DeformedBounds>(entity).unwrap();
    let (min, max) = (aabb.min(), aabb.max());
    let triangles = body.model().asset().triangles();
    let corners = 3 * triangles.len();
    for k in 0..corners.min(VERTICES) {
        let corner = if corners <= VERTICES {
            k
        } else {
            rng.random_range(0..corners)
        };
        let vertex = VertexId(triangles[corner / 3].corners[corner % 3]);
        let x = DVec3::from_array(own.deformed(vertex).unwrap());
        assert!(
            x.cmpge(min.as_dvec3()).all() && x.cmple(max.as_dvec3()).all(),
            "{x} is not within {min} to {max}"
        );
        let x = DVec3::from_array(placed.deformed(vertex).unwrap());
        let (min, max) = (DVec3::from_array(bounds.min), DVec3::from_array(bounds.max));
        assert!(
            x.cmpge(min).all() && x.cmple(max).all(),
            "{x} is not within {min} to {max}"
        );
    }
}

/// Another system moves an instance before the plugin poses it or afterwards, or in a frame in which the plugin does not.
#[test]
fn boxes_follow_instances_that_other_systems_move() {
    fn shift(mut bodies: Query<&mut DeformedInstance>, mut by: Local<f64>) {
        *by += 3.0;
        for mut body in &mut bodies {
            let mut at = body.instance.placement();
            at.translation[0] = *by;
            body.instance.set_placement(at).unwrap();
        }
    }
    for is_between in [true, false] {
        let (mut app, mut rng) = (app(), poses::rng(3));
        if is_between {
            let between = shift
                .after(BdtreeSystems::Pose)
                .before(BdtreeSystems::Bounds);
            app.add_systems(PostUpdate, between);
        } else {
            app.add_systems(Update, shift);
        }
        let entity = spawn(&mut app, &ball(), Transform::default());
        app.update();
        for frame in 0..6 {
            if frame % 2 == 0 {
                let q = &mut deformation(&mut app, entity).q;
                *q = vec![0.1 * frame as f32; 4];
            }
            app.update();
            check(app.world(), entity, &mut rng);
        }
        let moved = instance(&app, entity).placement().translation[0];
        assert!(moved > 15.0, "{moved}");
    }
}

#[test]
fn no_vertex_is_outside_the_box_in_a_million_poses() {
    const TEST: &str = "no_vertex_is_outside_the_box_in_a_million_poses";
    let far = bake::elastic("far", 3, 6, &[]);
    let mut models = vec![
        ball(),
        bar(),
        Model::from_bytes(&skin::skinned_tree()).unwrap(),
        bake::elastic("rod", 6, 8, &[]),
        far,
    ];
    models.extend(
        [
            "characters/AnimatedMorphCube/AnimatedMorphCube.gltf",
            "characters/RiggedSimple.glb",
            "characters/CesiumMan.glb",
            "characters/RobotExpressive.glb",
        ]
        .iter()
        .filter_map(|file| of_corpus(TEST, file)),
    );
    let mut app = app();
    let mut rng = poses::rng(11);
    let mut bodies = Vec::new();
    for k in 0..1000 {
        let model = &models[k % models.len()];
        bodies.push((spawn(&mut app, model, Transform::default()), model));
    }
    app.update();
    for _ in 0..POSES / bodies.len() {
        for (entity, model) in &bodies {
            let mut deformation = deformation(&mut app, *entity);
            deformation.q = random_q(model, &mut rng);
            // Moves of bones are the dearer ones to make up.
            if rng.random_bool(0.3) {
                deformation.joints = random_joints(model, &mut rng);
            }
            let spread = if rng.random_bool(0.1) { 1e6 } else { 3.0 };
            let place = random_place(spread, &mut rng);
            *app.world_mut().get_mut::<Transform>(*entity).unwrap() = place;
        }
        app.update();
        for (entity, _) in &bodies {
            check(app.world(), *entity, &mut rng);
        }
    }
    for (entity, _) in &bodies {
        assert!(
            faults(&app, *entity).is_empty(),
            "{:?}",
            faults(&app, *entity)
        );
    }
}

#[test]
fn boxes_follow_the_pose_and_are_not_much_too_large() {
    let mut app = app();
    let entity = spawn(&mut app, &bar(), Transform::from_xyz(5.0, 0.0, 0.0));
    app.update();
    let loose = |app: &bevy_app::App| {
        let exact = instance(app, entity).snapshot().exact_aabb().unwrap();
        let bounds = app.world().get::<DeformedBounds>(entity).unwrap();
        (0..3)
            .map(|k| (bounds.max[k] - bounds.min[k]) / (exact.max[k] - exact.min[k]))
            .fold(0.0, f64::max)
    };
    assert!((1.0..2.0).contains(&loose(&app)), "{}", loose(&app));
    let before = *app.world().get::<Aabb>(entity).unwrap();
    deformation(&mut app, entity).q = vec![3.0];
    app.update();
    assert_ne!(*app.world().get::<Aabb>(entity).unwrap(), before);
    // The bones' boxes hold what the mode may do to any of their vertices.
    assert!((1.0..3.0).contains(&loose(&app)), "{}", loose(&app));
    // The entity's own space does not move with it.
    let before = *app.world().get::<Aabb>(entity).unwrap();
    app.world_mut()
        .get_mut::<Transform>(entity)
        .unwrap()
        .translation
        .y = 9.0;
    app.update();
    assert_eq!(*app.world().get::<Aabb>(entity).unwrap(), before);
}

#[test]
fn other_systems_keep_their_hands_off() {
    use bevy_asset::Assets;
    use bevy_camera::visibility::VisibilityPlugin;
    use bevy_mesh::{Mesh, Mesh3d, PrimitiveTopology};
    let mut app = app();
    app.init_resource::<Assets<Mesh>>()
        .init_resource::<Assets<bevy_mesh::skinning::SkinnedMeshInverseBindposes>>()
        .add_plugins(VisibilityPlugin);
    // A tiny triangle, as whose box Bevy's systems would write.
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, Default::default());
    let corners = vec![[0.0, 0.0, 0.0], [1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0]];
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, corners);
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let entity = spawn(&mut app, &ball(), Transform::default());
    app.world_mut()
        .entity_mut(entity)
        .insert((Mesh3d(mesh), DynamicSkinnedMeshBounds));
    for frame in 0..4 {
        app.update();
        let aabb = app.world().get::<Aabb>(entity).unwrap();
        assert!(aabb.half_extents.min_element() > 0.5, "{frame}: {aabb:?}");
        let entity = app.world().entity(entity);
        assert!(!entity.contains::<DynamicSkinnedMeshBounds>());
        assert!(entity.contains::<NoAutoAabb>());
    }
    app.world_mut()
        .entity_mut(entity)
        .remove::<bdtree_bevy::DeformingMesh>();
    app.update();
    assert!(!app.world().entity(entity).contains::<DeformedBounds>());
    // And Bevy's is back.
    app.update();
    let aabb = app.world().get::<Aabb>(entity).unwrap();
    assert!(aabb.half_extents.max_element() < 1e-2, "{aabb:?}");
}
