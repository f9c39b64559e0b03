//! Contacts between deforming meshes begin and end.

use std::collections::BTreeSet;

use bdtree_bevy::{ContactStarted, ContactStopped, DeformingCollider, TouchingPairs};
use bdtree_fixtures::{oracle, poses};
use bevy_app::App;
use bevy_ecs::message::{Message, Messages};
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use rand::RngExt;

use crate::common::{app, ball, bar, deformation, instance, random_joints, random_place, spawn};

/// What was written since the last time.
fn taken<M: Message>(app: &mut App) -> Vec<M> {
    let mut messages = app.world_mut().resource_mut::<Messages<M>>();
    messages.drain().collect()
}

fn moved(app: &mut App, entity: Entity, to: Vec3) {
    app.world_mut()
        .get_mut::<Transform>(entity)
        .unwrap()
        .translation = to;
    app.update();
}

#[test]
fn a_contact_begins_and_ends_once() {
    let mut app = app();
    let model = ball();
    let [a, b] = [0.0, 5.0].map(|x| spawn(&mut app, &model, Transform::from_xyz(x, 0.0, 0.0)));
    for entity in [a, b] {
        app.world_mut()
            .entity_mut(entity)
            .insert(DeformingCollider::default());
    }
    let entities = [a.min(b), a.max(b)];
    app.update();
    assert_eq!(taken::<ContactStarted>(&mut app), []);
    moved(&mut app, b, Vec3::new(1.5, 0.0, 0.0));
    assert_eq!(
        taken::<ContactStarted>(&mut app),
        [ContactStarted { entities }]
    );
    assert!(app.world().resource::<TouchingPairs>().contains(b, a));
    app.update();
    moved(&mut app, b, Vec3::new(1.4, 0.0, 0.0));
    assert_eq!(taken::<ContactStarted>(&mut app), []);
    assert_eq!(taken::<ContactStopped>(&mut app), []);
    moved(&mut app, b, Vec3::new(5.0, 0.0, 0.0));
    assert_eq!(
        taken::<ContactStopped>(&mut app),
        [ContactStopped { entities }]
    );

    // Within the sum of the margins.
    for entity in [a, b] {
        let margin = 1.6;
        app.world_mut()
            .entity_mut(entity)
            .insert(DeformingCollider {
                margin,
                ..Default::default()
            });
    }
    app.update();
    assert_eq!(taken::<ContactStarted>(&mut app).len(), 1);

    // Groups that do not meet.
    app.world_mut().entity_mut(a).insert(DeformingCollider {
        group: 2,
        margin: 1.6,
        ..Default::default()
    });
    app.world_mut()
        .get_mut::<DeformingCollider>(b)
        .unwrap()
        .mask = 1;
    app.update();
    assert_eq!(taken::<ContactStopped>(&mut app).len(), 1);
    assert_eq!(instance(&app, a).collision_group, 2);
    assert_eq!(instance(&app, b).collision_mask, 1);

    // An entity that goes ends its contacts.
    app.world_mut()
        .get_mut::<DeformingCollider>(b)
        .unwrap()
        .mask = 2;
    app.update();
    assert_eq!(taken::<ContactStarted>(&mut app).len(), 1);
    app.world_mut().despawn(a);
    app.update();
    assert_eq!(
        taken::<ContactStopped>(&mut app),
        [ContactStopped { entities }]
    );
    assert_eq!(app.world().resource::<TouchingPairs>().iter().count(), 0);
}

#[test]
fn pairs_that_touch_equal_brute_force_while_a_crowd_moves() {
    let mut app = app();
    let mut rng = poses::rng(4);
    let models = [ball(), bar()];
    let entities: Vec<_> = (0..40)
        .map(|k| {
            let place = random_place(6.0, &mut rng);
            let entity = spawn(&mut app, &models[k % 2], place);
            app.world_mut()
                .entity_mut(entity)
                .insert(DeformingCollider::default());
            entity
        })
        .collect();
    let mut now = BTreeSet::new();
    let (mut started_count, mut stopped_count) = (0, 0);
    for _ in 0..12 {
        // Some move, some deform, the others stay.
        for (k, entity) in entities.iter().enumerate() {
            if rng.random_bool(0.2) {
                let place = random_place(6.0, &mut rng);
                *app.world_mut().get_mut::<Transform>(*entity).unwrap() = place;
            } else if rng.random_bool(0.3) {
                let model = &models[k % 2];
                let q = poses::random_q(model.asset(), 0.3, &mut rng);
                let joints = random_joints(model, &mut rng);
                let mut deformation = deformation(&mut app, *entity);
                (deformation.q, deformation.joints) = (q, joints);
            }
        }
        app.update();
        let bodies: Vec<_> = (entities.iter())
            .map(|entity| oracle::deformed_triangles(&instance(&app, *entity).snapshot()))
            .collect();
        let mut expected = BTreeSet::new();
        for i in 0..bodies.len() {
            for j in 0..i {
                if !oracle::pair(&bodies[i], &bodies[j], 0.0).is_empty() {
                    let (a, b) = (entities[i], entities[j]);
                    expected.insert([a.min(b), a.max(b)]);
                }
            }
        }
        let found: BTreeSet<_> = app.world().resource::<TouchingPairs>().iter().collect();
        assert_eq!(found, expected);
        let started: Vec<_> = taken::<ContactStarted>(&mut app)
            .iter()
            .map(|m| m.entities)
            .collect();
        let stopped: Vec<_> = taken::<ContactStopped>(&mut app)
            .iter()
            .map(|m| m.entities)
            .collect();
        assert!(started.iter().eq(expected.difference(&now)));
        assert!(stopped.iter().eq(now.difference(&expected)));
        started_count += started.len();
        stopped_count += stopped.len();
        now = expected;
    }
    assert!(started_count > 50 && stopped_count > 30);
}
