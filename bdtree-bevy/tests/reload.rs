//! Files that change while the program runs.

use std::fs;

use bdtree_bevy::{BdtModel, Deformation, DeformedInstance, DeformingMesh, PoseStage};
use bdtree_fixtures::bake;
use bevy_asset::AssetServer;

use crate::common::{app_in, faults, instance, named_ball, run_until};

#[test]
fn a_changed_file_makes_a_new_instance_and_a_broken_one_leaves_the_old() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.bdt");
    let (old, new) = (bake::elastic("icosphere", 4, 6, &[]), named_ball());
    fs::write(&path, old.asset().bytes()).unwrap();
    let mut app = app_in(folder.path());
    let handle = app
        .world()
        .resource::<AssetServer>()
        .load::<BdtModel>("ball.bdt");
    let deformation = Deformation {
        q: vec![0.01; old.asset().mode_count()],
        ..Default::default()
    };
    let entity = app
        .world_mut()
        .spawn((DeformingMesh(handle), deformation))
        .id();
    run_until(&mut app, |world| {
        world.get::<DeformedInstance>(entity).is_some()
    });
    assert!(faults(&app, entity).is_empty());
    app.world_mut()
        .get_mut::<DeformedInstance>(entity)
        .unwrap()
        .instance
        .user_data = 7;

    // No file of ours: what was there stays, however many frames pass.
    fs::write(&path, b"not a mesh").unwrap();
    for _ in 0..300 {
        app.update();
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let bytes = instance(&app, entity).model().asset().bytes();
    assert_eq!(bytes, old.asset().bytes());
    assert_eq!(instance(&app, entity).q(), [0.01; 4]);

    // Another mesh of three modes, which refuses four numbers: it is there at rest, and says so.
    fs::write(&path, new.asset().bytes()).unwrap();
    run_until(&mut app, |world| {
        let kept = world.get::<DeformedInstance>(entity).unwrap();
        kept.instance.model().asset().bytes() == new.asset().bytes()
    });
    assert_eq!(instance(&app, entity).q(), [0.0; 3]);
    assert_eq!(instance(&app, entity).user_data, 7);
    assert_eq!(
        faults(&app, entity).get(PoseStage::Deformation),
        Some("q has 4 entries but the asset has 3 modes")
    );
    app.world_mut().get_mut::<Deformation>(entity).unwrap().q = vec![0.5; 3];
    app.update();
    assert_eq!(instance(&app, entity).q(), [0.5; 3]);
    assert!(faults(&app, entity).is_empty());
}
