//! Files are loaded as assets.

use bdtree_bevy::{BdtModel, Deformation, DeformedInstance, DeformingMesh};
use bevy_asset::AssetServer;
use bevy_transform::components::Transform;

use crate::common::{app_in, run_until};

#[test]
fn a_file_becomes_an_instance_at_the_pose_of_its_entity() {
    let folder = std::path::absolute("../fixtures/golden").unwrap();
    let mut app = app_in(&folder);
    let handle = app
        .world()
        .resource::<AssetServer>()
        .load::<BdtModel>("sphere.bdt");
    let entity = app
        .world_mut()
        .spawn((DeformingMesh(handle), Transform::from_xyz(1.0, 2.0, 3.0)))
        .id();
    run_until(&mut app, |world| {
        world.get::<DeformedInstance>(entity).is_some()
    });
    let modes = {
        let instance = &app
            .world()
            .get::<DeformedInstance>(entity)
            .unwrap()
            .instance;
        assert_eq!(instance.placement().translation, [1.0, 2.0, 3.0]);
        instance.q().len()
    };
    let mut q = vec![0.0; modes];
    q[0] = 0.05;
    app.world_mut().get_mut::<Deformation>(entity).unwrap().q = q.clone();
    app.update();
    let instance = &app
        .world()
        .get::<DeformedInstance>(entity)
        .unwrap()
        .instance;
    assert_eq!(instance.q(), q);
}
