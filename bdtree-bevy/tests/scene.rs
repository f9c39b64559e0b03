//! The scene of the example `flexible_chair`.

#[path = "../examples/flexible_chair.rs"]
#[allow(dead_code, unreachable_pub)]
mod flexible_chair;

use bdtree_bevy::Deformation;
use bevy_transform::components::Transform;

use crate::chair::chair;

/// Two boxes end up on the seat or on each other there, two beside the chair.
#[test]
fn boxes_rest_on_a_chair_and_beside_it() {
    let mut app = flexible_chair::program();
    let scene = flexible_chair::scene(&mut app, chair());
    for _ in 0..64 * 4 {
        app.update();
    }
    let places: Vec<_> = (scene.boxes.iter())
        .map(|entity| {
            app.world()
                .get::<Transform>(*entity)
                .expect("a box")
                .translation
        })
        .collect();
    let lowest = flexible_chair::HALF - 0.01;
    assert!(places.iter().all(|at| at.y > lowest), "{places:?}");
    assert!(places[0].y > 0.45 && places[1].y > 0.45, "{places:?}");
    assert!(places[2].y < 0.45 && places[3].y < 0.45, "{places:?}");
    let q = &app
        .world()
        .get::<Deformation>(scene.chair)
        .expect("a mesh")
        .q;
    assert!(q.iter().any(|q| q.abs() > 1e-4), "{q:?}");
}
