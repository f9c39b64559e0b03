//! Where poses come from, and what is said of those that cannot be taken.

use bdtree_bevy::bdtree_runtime::{Model, SkeletonPose, joint};
use bdtree_bevy::{
    DeformedInstance, JointOrder, MorphOrder, PoseFaults, PoseFromJoints, PoseFromMorphs, PoseStage,
};
use bevy_app::App;
use bevy_asset::{Assets, Handle};
use bevy_ecs::name::Name;
use bevy_ecs::prelude::*;
use bevy_math::{Affine3A, EulerRot, Quat, Vec3};
use bevy_mesh::morph::{MeshMorphWeights, MorphWeights};
use bevy_mesh::skinning::SkinnedMesh;
use bevy_transform::components::Transform;

use crate::common::{apart, app, ball, bar, deformation, faults, instance, named_ball, spawn};

/// When a component was last changed.
fn changed_at<C: Component>(app: &App, entity: Entity) -> u32 {
    let ticks = app.world().entity(entity).get_change_ticks::<C>();
    ticks.expect("the component").changed.get()
}

#[test]
fn one_refused_pose_is_told_once_and_the_last_one_stays() {
    let mut app = app();
    let entity = spawn(&mut app, &ball(), Transform::default());
    app.update();
    deformation(&mut app, entity).q = vec![0.1; 4];
    app.update();
    deformation(&mut app, entity).q = vec![0.1; 5];
    app.update();
    let why = "q has 5 entries but the asset has 4 modes";
    assert_eq!(faults(&app, entity).get(PoseStage::Deformation), Some(why));
    assert_eq!(instance(&app, entity).q(), [0.1; 4]);
    let told_at = changed_at::<PoseFaults>(&app, entity);
    for _ in 0..5 {
        // Also where somebody says it again.
        deformation(&mut app, entity).q = vec![0.1; 5];
        app.update();
        assert_eq!(changed_at::<PoseFaults>(&app, entity), told_at);
    }
    // It still follows its entity.
    *app.world_mut().get_mut::<Transform>(entity).unwrap() = Transform::from_xyz(1.0, 2.0, 3.0);
    app.update();
    assert_eq!(
        instance(&app, entity).placement().translation,
        [1.0, 2.0, 3.0]
    );
    deformation(&mut app, entity).q.clear();
    app.update();
    assert!(faults(&app, entity).is_empty());
    assert_eq!(instance(&app, entity).q(), [0.0; 4]);
}

#[test]
fn transforms_that_are_no_placement_are_told_once() {
    let mut app = app();
    let entity = spawn(&mut app, &ball(), Transform::default());
    app.update();
    let stretched = Transform::from_scale(Vec3::new(1.0, 1.01, 1.0));
    let mirrored = Transform::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let flat = Transform::from_scale(Vec3::ZERO);
    let nowhere = Transform::from_xyz(f32::NAN, 0.0, 0.0);
    for bad in [stretched, mirrored, flat, nowhere] {
        *app.world_mut().get_mut::<Transform>(entity).unwrap() = bad;
        app.update();
        let why = faults(&app, entity).get(PoseStage::Placement).unwrap();
        assert!(why.contains("scales its axes differently"), "{why}");
        let stays = instance(&app, entity).placement();
        assert_eq!(stays, bdtree_bevy::bdtree_runtime::Transform::IDENTITY);
    }
    let told_at = changed_at::<PoseFaults>(&app, entity);
    for turn in 0..5 {
        let sheared = stretched.with_rotation(Quat::from_rotation_x(turn as f32));
        *app.world_mut().get_mut::<Transform>(entity).unwrap() = sheared;
        app.update();
        assert_eq!(changed_at::<PoseFaults>(&app, entity), told_at);
    }
    // A rotation, a scale and a place.
    let at = Transform {
        translation: Vec3::new(4.0, 5.0, 6.0),
        rotation: Quat::from_euler(EulerRot::XYZ, 0.3, 0.4, 0.5),
        scale: Vec3::splat(2.5),
    };
    *app.world_mut().get_mut::<Transform>(entity).unwrap() = at;
    app.update();
    assert!(faults(&app, entity).is_empty());
    let placed = instance(&app, entity).placement();
    assert!((placed.scale - 2.5).abs() < 1e-6);
    for (a, b) in placed.rotation.iter().zip(at.rotation.to_array()) {
        assert!((a - f64::from(b)).abs() < 1e-6);
    }
}

#[test]
fn an_instance_goes_with_its_mesh() {
    let mut app = app();
    let entity = spawn(&mut app, &ball(), Transform::default());
    app.update();
    assert!(app.world().get::<DeformedInstance>(entity).is_some());
    app.world_mut()
        .entity_mut(entity)
        .remove::<bdtree_bevy::DeformingMesh>();
    app.update();
    assert!(app.world().get::<DeformedInstance>(entity).is_none());
}

#[test]
fn morph_weights_become_q() {
    let mut app = app();
    let entity = spawn(&mut app, &named_ball(), Transform::default());
    app.world_mut()
        .entity_mut(entity)
        .insert(PoseFromMorphs::default());
    app.update();
    let why = faults(&app, entity).get(PoseStage::Morphs).unwrap();
    assert!(
        why.contains("neither MeshMorphWeights nor MorphWeights"),
        "{why}"
    );

    // In order, of its own.
    let own = MorphWeights::new(vec![0.1, 0.2, 0.3], None).unwrap();
    app.world_mut().entity_mut(entity).insert(own);
    app.update();
    assert!(faults(&app, entity).is_empty());
    assert_eq!(instance(&app, entity).q(), [0.1, 0.2, 0.3]);

    // What stays the same changes nothing.
    let posed_at = changed_at::<DeformedInstance>(&app, entity);
    app.update();
    assert_eq!(changed_at::<DeformedInstance>(&app, entity), posed_at);

    // Of another entity.
    let other = MorphWeights::new(vec![0.4, 0.5, 0.6], None).unwrap();
    let other = app.world_mut().spawn(other).id();
    app.world_mut()
        .entity_mut(entity)
        .insert(MeshMorphWeights::Reference(other));
    app.update();
    assert_eq!(instance(&app, entity).q(), [0.4, 0.5, 0.6]);

    // By name, two of three: the third keeps its q.
    let names = ["blink", "smile"].map(str::to_string).to_vec();
    let weights = vec![0.7, 0.8];
    app.world_mut().entity_mut(entity).insert((
        MeshMorphWeights::Value { weights },
        PoseFromMorphs {
            order: MorphOrder::Named(names),
        },
    ));
    app.update();
    assert!(faults(&app, entity).is_empty());
    assert_eq!(instance(&app, entity).q(), [0.8, 0.5, 0.7]);

    let refusals = [
        (
            MorphOrder::InOrder,
            "the mesh has 2 morph targets, the file has 3 modes",
        ),
        (
            MorphOrder::Named(vec!["smile".into()]),
            "1 names for 2 morph targets",
        ),
        (
            MorphOrder::Named(vec!["smile".into(), "grin".into()]),
            r#"no mode "grin": its modes are ["smile", "frown", "blink"]"#,
        ),
        (MorphOrder::NamesOfMesh, "does not name its morph targets"),
    ];
    for (order, expected) in refusals {
        app.world_mut()
            .entity_mut(entity)
            .insert(PoseFromMorphs { order });
        app.update();
        let why = faults(&app, entity).get(PoseStage::Morphs).unwrap();
        assert!(why.contains(expected), "{why}");
        assert_eq!(instance(&app, entity).q(), [0.8, 0.5, 0.7]);
    }
}

#[test]
fn morph_targets_are_named_by_the_mesh() {
    use bevy_mesh::{Mesh, Mesh3d, PrimitiveTopology};
    let mut app = app();
    app.world_mut().init_resource::<Assets<Mesh>>();
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, Default::default());
    mesh.set_morph_target_names(["frown", "blink", "smile"].map(str::to_string).to_vec());
    let mesh: Handle<Mesh> = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let entity = spawn(&mut app, &named_ball(), Transform::default());
    let weights = vec![0.1, 0.2, 0.3];
    let order = MorphOrder::NamesOfMesh;
    app.world_mut().entity_mut(entity).insert((
        Mesh3d(mesh),
        MeshMorphWeights::Value { weights },
        PoseFromMorphs { order },
    ));
    app.update();
    app.update();
    assert!(
        faults(&app, entity).is_empty(),
        "{:?}",
        faults(&app, entity)
    );
    assert_eq!(instance(&app, entity).q(), [0.3, 0.1, 0.2]);
}

/// The bar as an entity at a place, with entities for its three joints.
fn jointed(
    app: &mut App,
    model: &Model,
    order: JointOrder,
    names: [&str; 3],
) -> (Entity, [Entity; 3]) {
    let place = Transform {
        translation: Vec3::new(10.0, -20.0, 30.0),
        rotation: Quat::from_euler(EulerRot::XYZ, 0.3, 0.4, 0.5),
        scale: Vec3::splat(1.5),
    };
    let joints = names.map(|name| {
        let name = Name::new(name.to_string());
        app.world_mut().spawn((name, Transform::default())).id()
    });
    let entity = spawn(app, model, place);
    app.world_mut().entity_mut(entity).insert((
        PoseFromJoints { order },
        SkinnedMesh {
            joints: joints.to_vec(),
            ..Default::default()
        },
    ));
    (entity, joints)
}

#[test]
fn joints_of_a_skinned_mesh_move_bones() {
    let model = bar();
    let mut pose = SkeletonPose::new(&model).unwrap();
    pose.play(0, 0.4).unwrap();
    let joints = pose.joints().to_vec();
    for (order, names, places) in [
        (JointOrder::InOrder, ["a", "b", "c"], [0, 1, 2]),
        (JointOrder::ByName, ["tip", "root", "elbow"], [2, 0, 1]),
    ] {
        let mut app = app();
        let (entity, entities) = jointed(&mut app, &model, order, names);
        app.update();
        // Where the joints stand in the world when they stand so in the model.
        let world = app
            .world()
            .get::<bevy_transform::components::GlobalTransform>(entity)
            .unwrap()
            .affine();
        for (joint, own) in entities.iter().zip(places) {
            let columns = joint::to_columns(&joints[own]).map(|c| c.map(|x| x as f32));
            let matrix = bevy_math::Mat4::from_cols_array_2d(&columns);
            let matrix = world * Affine3A::from_mat4(matrix);
            app.world_mut()
                .entity_mut(*joint)
                .insert(Transform::from_matrix(matrix.into()));
        }
        app.update();
        assert!(
            faults(&app, entity).is_empty(),
            "{:?}",
            faults(&app, entity)
        );
        let mut expected = bdtree_bevy::bdtree_runtime::Instance::new(&model).unwrap();
        expected
            .set_placement(instance(&app, entity).placement())
            .unwrap();
        expected.set_joints(&joints).unwrap();
        let error = apart(instance(&app, entity), &expected);
        // Coordinates of up to 40 in f32, through four products.
        assert!(error < 1e-4, "{error}");
        // At rest it would be elsewhere.
        expected
            .set_joints(SkeletonPose::new(&model).unwrap().joints())
            .unwrap();
        assert!(apart(instance(&app, entity), &expected) > 0.1);
    }
}

#[test]
fn joints_that_do_not_fit_are_told() {
    let mut app = app();
    let model = bar();
    let (entity, joints) = jointed(
        &mut app,
        &model,
        JointOrder::ByName,
        ["root", "knee", "tip"],
    );
    app.update();
    let why = faults(&app, entity).get(PoseStage::Joints).unwrap();
    assert!(why.contains(r#"is named "elbow""#), "{why}");
    app.world_mut()
        .entity_mut(entity)
        .insert(PoseFromJoints::default());
    app.world_mut()
        .entity_mut(joints[1])
        .remove::<(Transform, bevy_transform::components::GlobalTransform)>();
    app.update();
    let why = faults(&app, entity).get(PoseStage::Joints).unwrap();
    assert!(why.contains("joint 1 of the SkinnedMesh"), "{why}");
    app.world_mut()
        .get_mut::<SkinnedMesh>(entity)
        .unwrap()
        .joints
        .pop();
    app.update();
    let why = faults(&app, entity).get(PoseStage::Joints).unwrap();
    assert!(why.contains("has 2 joints, the file has 3"), "{why}");

    let plain = spawn(&mut app, &ball(), Transform::default());
    app.world_mut()
        .entity_mut(plain)
        .insert((PoseFromJoints::default(), SkinnedMesh::default()));
    app.update();
    let why = faults(&app, plain).get(PoseStage::Joints).unwrap();
    assert!(why.contains("the file has no skin"), "{why}");
}
