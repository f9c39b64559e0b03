//! What gizmos show.

use bdtree_bevy::{
    Deformation, DeformedGizmos, DeformedInstance, DeformingMesh, ShowBox, ShowSpheres,
};
use bdtree_fixtures::bake;
use bdtree_runtime::{Ray, Workspace};
use bevy_app::{App, Update};
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_gizmos::gizmos::Gizmos;
use bevy_math::Vec3;

use crate::drawing::{ORANGE, add_model, scene};
use crate::support::{self, material, picture::Picture};

const RED: Color = Color::srgb(1.0, 0.0, 0.0);
const GREEN: Color = Color::srgb(0.0, 0.8, 0.0);
const BLUE: Color = Color::srgb(0.0, 0.0, 1.0);

/// Whether the system below runs.
#[derive(Resource)]
struct Shot;

/// A ray from above, and what it hits.
fn shoot(mut bodies: Query<&mut DeformedInstance>, mut gizmos: Gizmos) {
    let mut workspace = Workspace::new();
    for mut body in &mut bodies {
        let ray = Ray::new([0.85, 5.0, 0.0], [0.0, -1.0, 0.0]);
        let hit = body.instance.query(&mut workspace).cast_ray(&ray).unwrap();
        let pose = body.instance.pose();
        gizmos.ray_hit(&pose, &hit.unwrap(), 0.8, RED).unwrap();
    }
}

/// Pixels in which one channel is far above the others.
fn of_color(picture: &Picture, channel: usize) -> usize {
    let is_it = |p: &&[u8; 3]| {
        let others = (0..3)
            .filter(|k| *k != channel)
            .map(|k| p[k])
            .max()
            .unwrap();
        p[channel] > 120 && u16::from(p[channel]) > 2 * u16::from(others)
    };
    picture.pixels.iter().filter(is_it).count()
}

fn pictures() -> (App, Entity) {
    let mut app = scene(Vec3::new(0.0, 3.0, 3.0), Vec3::ZERO);
    app.add_systems(Update, shoot.run_if(resource_exists::<Shot>));
    let model = bake::elastic("torus", 6, 8, &[]);
    let handle = add_model(app.world_mut(), &model);
    let orange = material(app.world_mut(), ORANGE);
    let mut q = vec![0.0; 6];
    q[0] = 0.3;
    let deformation = Deformation {
        q,
        joints: Vec::new(),
    };
    let entity = app
        .world_mut()
        .spawn((DeformingMesh(handle), orange, deformation))
        .id();
    support::settle(&mut app);
    (app, entity)
}

#[test]
fn spheres_boxes_and_hits_are_drawn() {
    let (mut app, entity) = pictures();
    let plain = support::take(&mut app);
    assert_eq!([0, 1, 2].map(|k| of_color(&plain, k)), [0; 3]);

    let spheres = ShowSpheres {
        level: 0,
        color: Some(BLUE),
    };
    let boxed = ShowBox { color: Some(GREEN) };
    app.world_mut().entity_mut(entity).insert((spheres, boxed));
    app.insert_resource(Shot);
    support::settle(&mut app);
    let shown = support::take(&mut app);
    shown.save("gizmos");
    let counts = [0, 1, 2].map(|k| of_color(&shown, k));
    assert!(counts.iter().all(|count| *count > 20), "{counts:?}");

    app.world_mut()
        .entity_mut(entity)
        .remove::<(ShowSpheres, ShowBox)>();
    app.world_mut().remove_resource::<Shot>();
    support::settle(&mut app);
    assert_eq!(support::take(&mut app).differing(&plain, 0), 0);
}
