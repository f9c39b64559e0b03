//! Clips and animations of the file itself play as the runtime does.

use std::time::Duration;

use bdtree_bevy::bdtree_runtime::{Instance, Model, SkeletonPose};
use bdtree_bevy::{ClipPlayer, ClipRef, PoseStage};
use bdtree_fixtures::{bake, skin};
use bevy_app::App;
use bevy_time::Time;
use bevy_transform::components::Transform;

use crate::common::{apart, app, bar, deformation, faults, instance, spawn};

/// Lets time pass and runs a frame.
fn pass(app: &mut App, seconds: f64) {
    let mut time = app.world_mut().get_resource_or_init::<Time>();
    time.advance_by(Duration::from_secs_f64(seconds));
    app.update();
}

#[test]
fn clips_of_the_skeleton_are_played() {
    let mut app = app();
    let model = bar();
    let entity = spawn(&mut app, &model, Transform::default());
    app.world_mut().entity_mut(entity).insert(ClipPlayer {
        clip: ClipRef::Name("bend".to_string()),
        speed: 2.0,
        ..Default::default()
    });
    let mut expected = Instance::new(&model).unwrap();
    let mut pose = SkeletonPose::new(&model).unwrap();
    // The clip lasts one second: times 0, 0.5, 1.0 and, begun anew, 0.5.
    pass(&mut app, 0.0);
    for time in [0.5, 1.0, 0.5] {
        pass(&mut app, 0.25);
        pose.play(0, time).unwrap();
        expected.set_q(pose.q()).unwrap();
        expected.set_joints(pose.joints()).unwrap();
        assert!(apart(instance(&app, entity), &expected) < 1e-5);
        assert_eq!(instance(&app, entity).q(), pose.q());
    }
    // Once through, and it holds its end.
    app.world_mut().entity_mut(entity).insert(ClipPlayer {
        clip: ClipRef::Index(1),
        is_looping: false,
        ..Default::default()
    });
    pass(&mut app, 100.0);
    let player = app.world().get::<ClipPlayer>(entity).unwrap();
    assert_eq!(player.time_s, 2.0);
    for (clip, expected) in [
        (
            ClipRef::Name("dance".into()),
            r#"no clip "dance": its clips are ["bend", "stretch"]"#,
        ),
        (ClipRef::Index(2), "clip"),
        (ClipRef::Frames, "the asset has no animation"),
    ] {
        let player = ClipPlayer {
            clip,
            ..Default::default()
        };
        app.world_mut().entity_mut(entity).insert(player);
        pass(&mut app, 0.1);
        let why = faults(&app, entity).get(PoseStage::Clip).unwrap();
        assert!(why.contains(expected), "{why}");
    }
}

/// A thread plays all its entities in the same memory, whatever their skeletons.
#[test]
fn entities_of_several_skeletons_play_side_by_side() {
    let mut other = skin::bar_skin();
    other.clips.swap(0, 1);
    let other = skin::with_skin(&skin::bar(), &other);
    let models = [bar(), Model::from_bytes(&other).expect("another bar")];
    let mut app = app();
    let entities: Vec<_> = (0..60)
        .map(|k| {
            let entity = spawn(&mut app, &models[k % 2], Transform::default());
            app.world_mut().entity_mut(entity).insert(ClipPlayer {
                clip: ClipRef::Index(0),
                time_s: 0.01 * k as f64,
                ..Default::default()
            });
            entity
        })
        .collect();
    let mut poses = models
        .each_ref()
        .map(|model| SkeletonPose::new(model).unwrap());
    pass(&mut app, 0.0);
    for step in 1..4 {
        pass(&mut app, 0.1);
        for (k, entity) in entities.iter().enumerate() {
            let player = app.world().get::<ClipPlayer>(*entity).unwrap();
            let time = player.time_s;
            assert!((time - (0.01 * k as f64 + 0.1 * f64::from(step))).abs() < 1e-6);
            let pose = &mut poses[k % 2];
            pose.play(0, time).unwrap();
            let mut expected = Instance::new(&models[k % 2]).unwrap();
            expected.set_q(pose.q()).unwrap();
            expected.set_joints(pose.joints()).unwrap();
            assert!(apart(instance(&app, *entity), &expected) < 1e-5, "{k}");
        }
    }
    assert_ne!(poses[0].joints(), poses[1].joints());
}

/// Also of different numbers of modes, forwards and back.
#[test]
fn entities_of_several_animations_play_side_by_side() {
    let models = [2, 6, 3].map(|modes| {
        let mesh = bake::bumpy_sphere(7, 3);
        let basis = bake::with_frames(bake::smooth_basis(&mesh, modes, 5), 6, 0.3, 8);
        bake::baked(&mesh, &basis)
    });
    let mut app = app();
    let entities: Vec<_> = (0..30)
        .map(|k| {
            let entity = spawn(&mut app, &models[k % 3], Transform::default());
            app.world_mut().entity_mut(entity).insert(ClipPlayer {
                clip: ClipRef::Frames,
                time_s: 0.003 * k as f64,
                ..Default::default()
            });
            entity
        })
        .collect();
    pass(&mut app, 0.0);
    pass(&mut app, 0.01);
    for (k, entity) in entities.iter().enumerate() {
        let asset = models[k % 3].asset();
        let time = app.world().get::<ClipPlayer>(*entity).unwrap().time_s;
        let mut expected = vec![0.0; asset.mode_count()];
        asset.sample(time, &mut expected).unwrap();
        assert!(expected.iter().any(|q| *q != 0.0));
        assert_eq!(deformation(&mut app, *entity).q, expected, "{k}");
    }
}

#[test]
fn compressed_animations_are_played_with_their_motion() {
    let mut app = app();
    let mesh = bake::bumpy_sphere(7, 3);
    let basis = bake::with_frames(bake::smooth_basis(&mesh, 4, 5), 6, 0.3, 8);
    let model = bake::baked(&mesh, &basis);
    let entity = spawn(&mut app, &model, Transform::default());
    app.world_mut().entity_mut(entity).insert(ClipPlayer {
        clip: ClipRef::Frames,
        ..Default::default()
    });
    pass(&mut app, 0.0);
    pass(&mut app, 0.09);
    assert!(
        faults(&app, entity).is_empty(),
        "{:?}",
        faults(&app, entity)
    );
    let mut expected = Instance::new(&model).unwrap();
    let mut q = vec![0.0; 4];
    let motion = model.asset().sample(0.09, &mut q).unwrap();
    expected.set_pose(&q, motion).unwrap();
    // The Transform is f32.
    assert!(apart(instance(&app, entity), &expected) < 1e-5);
    // It is not where it would be without its motion.
    expected
        .set_pose(&q, bdtree_bevy::bdtree_runtime::Transform::IDENTITY)
        .unwrap();
    assert!(apart(instance(&app, entity), &expected) > 1e-2);
}
