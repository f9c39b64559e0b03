//! Pointers hit what brute force over the deformed triangles says.

use bdtree_bevy::{
    DeformingHit, DeformingPickingCamera, DeformingPickingPlugin, DeformingPickingSettings,
    PickVisibility,
};
use bdtree_fixtures::oracle::{self, body::Body};
use bdtree_fixtures::poses;
use bevy_app::App;
use bevy_camera::visibility::RenderLayers;
use bevy_camera::{Camera, visibility::Visibility};
use bevy_ecs::message::Messages;
use bevy_ecs::prelude::*;
use bevy_math::{Dir3, Vec3};
use bevy_picking::Pickable;
use bevy_picking::backend::PointerHits;
use bevy_picking::backend::ray::{RayId, RayMap};
use bevy_picking::pointer::PointerId;
use bevy_shape::Ray3d;
use bevy_transform::components::Transform;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use crate::common::{app, ball, bar, deformation, instance, random_joints, random_place, spawn};

/// Random picks in all.
const PICKS: usize = 100_000;
/// Pointers per frame.
const POINTERS: usize = 1000;

/// A program that picks: rays are what the test puts into the map, as Bevy's `PickingPlugin` would.
fn picking_app() -> App {
    let mut app = app();
    app.init_resource::<RayMap>()
        .add_message::<PointerHits>()
        .add_plugins(DeformingPickingPlugin);
    app.world_mut()
        .resource_mut::<DeformingPickingSettings>()
        .visibility = PickVisibility::Any;
    app
}

/// Adds the ray of a pointer to the frame.
fn point(app: &mut App, camera: Entity, pointer: u64, from: Vec3, towards: Vec3) {
    let ray = Ray3d::new(from, Dir3::new(towards).unwrap());
    let id = RayId::new(camera, PointerId::Touch(pointer));
    app.world_mut().resource_mut::<RayMap>().map.insert(id, ray);
}

/// What the last frame's rays hit, by pointer.
fn hits(app: &mut App) -> Vec<PointerHits> {
    let mut messages = app.world_mut().resource_mut::<Messages<PointerHits>>();
    let mut hits: Vec<_> = messages.drain().collect();
    hits.sort_by_key(|hits| match hits.pointer {
        PointerId::Touch(id) => id,
        _ => u64::MAX,
    });
    app.world_mut().resource_mut::<RayMap>().map.clear();
    hits
}

/// New poses and places of all.
fn move_all(app: &mut App, entities: &[Entity], rng: &mut Pcg64Mcg) -> Vec<(Entity, Body)> {
    for entity in entities {
        let model = instance(app, *entity).model().clone();
        let q = poses::random_q(model.asset(), 0.3, rng);
        let joints = random_joints(&model, rng);
        let mut deformation = deformation(app, *entity);
        (deformation.q, deformation.joints) = (q, joints);
        *app.world_mut().get_mut::<Transform>(*entity).unwrap() = random_place(6.0, rng);
    }
    app.update();
    let body = |entity: &Entity| {
        let pose = instance(app, *entity).snapshot();
        (*entity, oracle::deformed_triangles(&pose))
    };
    entities.iter().map(body).collect()
}

#[test]
fn a_hundred_thousand_picks_equal_brute_force() {
    let mut app = picking_app();
    let mut rng = poses::rng(6);
    let camera = Camera {
        order: 3,
        ..Default::default()
    };
    let camera = app.world_mut().spawn(camera).id();
    let models = [ball(), bar()];
    let entities: Vec<_> = (0..24)
        .map(|k| spawn(&mut app, &models[k % 2], Transform::default()))
        .collect();
    // Some block what lies behind them, some are passed over.
    for (k, entity) in entities.iter().enumerate() {
        let pickable = match k % 6 {
            0..3 => continue,
            3 | 4 => Pickable::default(),
            _ => Pickable::IGNORE,
        };
        app.world_mut().entity_mut(*entity).insert(pickable);
    }
    let pickable = |app: &App, entity| app.world().get::<Pickable>(entity).copied();
    app.update();
    let mut hit_count = 0;
    for _ in 0..PICKS / POINTERS {
        let bodies = move_all(&mut app, &entities, &mut rng);
        let rays: Vec<(Vec3, Vec3)> = (0..POINTERS)
            .map(|_| {
                let mut point = |spread: f32| {
                    Vec3::from_array([0; 3].map(|_| rng.random_range(-spread..spread)))
                };
                let from = point(1.0) + 15.0 * Vec3::Z;
                (from, point(7.0) - from)
            })
            .collect();
        for (k, (from, towards)) in rays.iter().enumerate() {
            point(&mut app, camera, k as u64, *from, *towards);
        }
        let used = app.world().resource::<RayMap>().map.clone();
        app.update();
        let mut answers = hits(&mut app).into_iter().peekable();
        for k in 0..POINTERS {
            let pointer = PointerId::Touch(k as u64);
            let ray = used[&RayId::new(camera, pointer)];
            let origin = ray.origin.to_array().map(f64::from);
            let direction = oracle::unit(ray.direction.to_array().map(f64::from));
            let mut expected: Vec<(f64, Entity, u32)> = (bodies.iter())
                .filter(|(entity, _)| pickable(&app, *entity).is_none_or(|p| p.is_hoverable))
                .filter_map(|(entity, body)| {
                    let (id, d) = oracle::ray(body, origin, direction, f64::INFINITY)?;
                    Some((d, *entity, id))
                })
                .collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let blocks = |hit: &(f64, Entity, u32)| {
                pickable(&app, hit.1).is_some_and(|p| p.should_block_lower)
            };
            if let Some(first) = expected.iter().position(blocks) {
                expected.truncate(first + 1);
            }
            let found = answers.next_if(|hits| hits.pointer == pointer);
            let Some(found) = found else {
                assert_eq!(expected, []);
                continue;
            };
            assert_eq!(found.order, 3.0);
            hit_count += 1;
            let told: Vec<_> = (found.picks.iter())
                .map(|(entity, data)| {
                    let extra = data.extra_as::<DeformingHit>().unwrap();
                    assert_eq!(data.camera, camera);
                    assert_eq!(data.depth, extra.distance as f32);
                    (extra.distance, *entity, extra.triangle)
                })
                .collect();
            assert_eq!(told, expected);
            for (entity, data) in &found.picks {
                check_surface(&app, *entity, data, ray.direction.into());
            }
        }
        assert!(answers.next().is_none());
    }
    assert!((PICKS / 5..PICKS).contains(&hit_count), "{hit_count}");
}

/// Point, normal and weights belong to the triangle.
fn check_surface(app: &App, entity: Entity, data: &bevy_picking::backend::HitData, along: Vec3) {
    let extra = data.extra_as::<DeformingHit>().unwrap();
    let pose = instance(app, entity).snapshot();
    let triangle = bdtree_bevy::bdtree_runtime::TriangleId(extra.triangle);
    let corners = pose.asset().triangle(triangle).unwrap();
    let corners = corners.map(|v| bevy_math::DVec3::from_array(pose.deformed(v).unwrap()));
    let weighted: bevy_math::DVec3 = (corners.iter().zip(extra.barycentric))
        .map(|(x, w)| *x * w)
        .sum();
    let size = corners[0].length() + corners[1].distance(corners[0]) + 20.0;
    let point = data.position.unwrap();
    assert!(weighted.distance(point.as_dvec3()) < 1e-6 * size);
    let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let normal = data.normal.unwrap();
    assert!((normal.length() - 1.0).abs() < 1e-5);
    assert!(normal.dot(along) <= 1e-6);
    let cosine = across.normalize().dot(normal.as_dvec3()).abs();
    assert!((cosine - 1.0).abs() < 1e-4, "{cosine}");
}

#[test]
fn layers_markers_visibility_and_cameras_count() {
    let mut app = picking_app();
    let spawn_camera = |app: &mut App, order: isize| {
        let camera = Camera {
            order,
            ..Default::default()
        };
        app.world_mut().spawn(camera).id()
    };
    let (first, second) = (spawn_camera(&mut app, 0), spawn_camera(&mut app, 7));
    app.world_mut()
        .entity_mut(second)
        .insert(RenderLayers::layer(2));
    let entity = spawn(&mut app, &ball(), Transform::default());
    app.update();
    app.update();
    // Who hits the ball, as the orders of their cameras.
    let orders = |app: &mut App| {
        for camera in [first, second] {
            point(app, camera, 0, 9.0 * Vec3::Z, -Vec3::Z);
        }
        app.update();
        let mut orders: Vec<_> = hits(app).iter().map(|hits| hits.order).collect();
        orders.sort_by(f32::total_cmp);
        orders
    };
    assert_eq!(orders(&mut app), [0.0]);
    app.world_mut()
        .entity_mut(entity)
        .insert(RenderLayers::layer(2));
    assert_eq!(orders(&mut app), [7.0]);
    app.world_mut()
        .entity_mut(entity)
        .insert(RenderLayers::from_layers(&[0, 2]));
    assert_eq!(orders(&mut app), [0.0, 7.0]);

    let settings = |app: &mut App, require_markers, visibility| {
        app.insert_resource(DeformingPickingSettings {
            require_markers,
            visibility,
        });
    };
    settings(&mut app, true, PickVisibility::Any);
    assert!(orders(&mut app).is_empty());
    app.world_mut()
        .entity_mut(second)
        .insert(DeformingPickingCamera);
    assert!(orders(&mut app).is_empty());
    app.world_mut()
        .entity_mut(entity)
        .insert(Pickable::default());
    assert_eq!(orders(&mut app), [7.0]);

    // Without Visibility it is not drawn; hidden it is not either.
    settings(&mut app, false, PickVisibility::Visible);
    assert!(orders(&mut app).is_empty());
    app.init_resource::<bevy_asset::Assets<bevy_mesh::Mesh>>()
        .init_resource::<bevy_asset::Assets<bevy_mesh::skinning::SkinnedMeshInverseBindposes>>()
        .add_plugins(bevy_camera::visibility::VisibilityPlugin);
    app.world_mut()
        .entity_mut(entity)
        .insert(Visibility::Visible);
    app.update();
    assert_eq!(orders(&mut app), [0.0, 7.0]);
    settings(&mut app, false, PickVisibility::VisibleInView);
    // No camera has a frustum here that it could be in.
    assert!(orders(&mut app).is_empty());
    settings(&mut app, false, PickVisibility::Visible);
    app.world_mut()
        .entity_mut(entity)
        .insert(Visibility::Hidden);
    app.update();
    assert!(orders(&mut app).is_empty());
}

#[test]
fn a_pointer_in_a_viewport_hits_what_is_drawn_there() {
    use bevy_app::PreUpdate;
    use bevy_camera::{
        CameraProjection, PerspectiveProjection, RenderTarget, RenderTargetInfo, Viewport,
    };
    use bevy_math::UVec2;
    use bevy_picking::PickingSystems;
    use bevy_picking::pointer::{Location, PointerLocation, PointerMap};
    use bevy_window::PrimaryWindow;

    let mut app = picking_app();
    let backend = RayMap::repopulate.before(PickingSystems::Backend);
    app.init_resource::<PointerMap>()
        .add_systems(PreUpdate, backend);
    let window = app.world_mut().spawn(PrimaryWindow).id();
    // Half of a window of 800 × 600 logical pixels, which are two physical ones each way.
    let (from, size) = (UVec2::new(800, 0), UVec2::new(800, 1200));
    let mut camera = Camera {
        viewport: Some(Viewport {
            physical_position: from,
            physical_size: size,
            ..Default::default()
        }),
        ..Default::default()
    };
    let projection = PerspectiveProjection {
        aspect_ratio: size.x as f32 / size.y as f32,
        ..Default::default()
    };
    camera.computed.clip_from_view = projection.get_clip_from_view();
    camera.computed.target_info = Some(RenderTargetInfo {
        physical_size: UVec2::new(1600, 1200),
        scale_factor: 2.0,
    });
    let eye = Transform::from_xyz(1.0, 2.0, 5.0).looking_at(Vec3::ZERO, Vec3::Y);
    app.world_mut().spawn((camera.clone(), eye));
    let entity = spawn(&mut app, &ball(), Transform::default());
    deformation(&mut app, entity).q = vec![0.9, -0.7, 0.8, 0.5];
    app.update();
    let target = RenderTarget::default().normalize(Some(window)).unwrap();
    let mut pick = |position| {
        let location = PointerLocation::new(Location {
            target: target.clone(),
            position,
        });
        let pointer = app.world_mut().spawn((PointerId::Mouse, location)).id();
        app.update();
        app.world_mut().despawn(pointer);
        let (found, body) = (hits(&mut app), instance(&app, entity));
        let data = found.first().map(|hits| hits.picks[0].1.clone());
        (data, oracle::deformed_triangles(&body.snapshot()))
    };
    let view = bevy_transform::components::GlobalTransform::from(eye);
    let mut hit_count = 0;
    for k in 0..30 {
        let pixel = bevy_math::Vec2::new(410.0 + 13.0 * k as f32, 40.0 + 17.0 * k as f32);
        let (data, body) = pick(pixel);
        let ray = camera.viewport_to_world(&view, pixel).unwrap();
        let origin = ray.origin.to_array().map(f64::from);
        let direction = oracle::unit(ray.direction.to_array().map(f64::from));
        let expected = oracle::ray(&body, origin, direction, f64::INFINITY);
        let found = data.as_ref().map(|data| {
            let extra = data.extra_as::<DeformingHit>().unwrap();
            (extra.triangle, extra.distance)
        });
        assert_eq!(found, expected);
        if let Some(point) = data.and_then(|data| data.position) {
            let drawn = camera.world_to_viewport(&view, point).unwrap();
            assert!(drawn.distance(pixel) < 0.01, "{drawn} is not {pixel}");
            hit_count += 1;
        }
    }
    assert!((5..30).contains(&hit_count), "{hit_count}");
    // What lies left of the viewport is another camera's.
    assert!(pick(bevy_math::Vec2::new(390.0, 300.0)).0.is_none());
}
