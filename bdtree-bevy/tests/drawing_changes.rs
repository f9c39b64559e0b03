//! What is drawn follows poses, files and meshes that change.

use bdtree_bevy::{BdtModel, Deformation, DeformingMesh, DrawDeformed, PoseStage};
use bdtree_fixtures::bake;
use bdtree_runtime::Model;
use bevy_app::App;
use bevy_asset::{AssetId, Assets, Handle, RenderAssetUsages};
use bevy_camera::visibility::NoFrustumCulling;
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_mesh::{Mesh, Mesh3d};
use bevy_pbr::MeshMaterial3d;
use bevy_transform::components::Transform;

use crate::common::faults;
use crate::drawing::{Body, ORANGE, add_model, deformed_mesh, scene};
use crate::support::{self, material, picture::Picture};

const EYE: Vec3 = Vec3::new(0.0, 2.0, 3.0);

fn sphere(n: u32) -> Model {
    let mesh = bake::bumpy_sphere(n, 7);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 3))
}

fn body(model: &Model, q: f32) -> Body {
    let mut of_all = vec![0.0; model.asset().mode_count()];
    of_all[1] = q;
    Body {
        model: model.clone(),
        deformation: Deformation {
            q: of_all,
            joints: Vec::new(),
        },
        at: Transform::default(),
    }
}

/// A picture of a mesh that the processor deformed, in place of the entity's.
fn expected(app: &mut App, entity: Entity, mesh: Mesh) -> Picture {
    use bevy_camera::visibility::Visibility;
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let orange = material(app.world_mut(), ORANGE);
    let world = app.world_mut();
    world.entity_mut(entity).insert(Visibility::Hidden);
    let other = world.spawn((Mesh3d(mesh), orange, NoFrustumCulling)).id();
    support::settle(app);
    let picture = support::take(app);
    app.world_mut().despawn(other);
    app.world_mut()
        .entity_mut(entity)
        .insert(Visibility::Inherited);
    picture
}

fn drawn(app: &mut App) -> Picture {
    support::settle(app);
    support::take(app)
}

fn assert_same(a: &Picture, b: &Picture, what: &str) {
    let off = a.differing(b, 3);
    if off > 20 {
        a.save("drawing-changes-found");
        b.save("drawing-changes-expected");
    }
    assert!(off <= 20, "{what}: {off} pixels differ");
}

#[test]
fn poses_and_files_that_change_are_drawn_anew() {
    let mut app = scene(EYE, Vec3::ZERO);
    let (coarse, fine) = (sphere(8), sphere(24));
    let handle = add_model(app.world_mut(), &coarse);
    let orange = material(app.world_mut(), ORANGE);
    let entity = app
        .world_mut()
        .spawn((
            DeformingMesh(handle.clone()),
            body(&coarse, 3.0).deformation,
            orange,
        ))
        .id();
    let first = drawn(&mut app);
    let same = expected(&mut app, entity, deformed_mesh(&body(&coarse, 3.0)));
    assert_same(&first, &same, "a pose");

    app.world_mut().get_mut::<Deformation>(entity).unwrap().q[1] = -3.0;
    let second = drawn(&mut app);
    assert!(second.differing(&first, 3) > 1000);
    let same = expected(&mut app, entity, deformed_mesh(&body(&coarse, -3.0)));
    assert_same(&second, &same, "another pose");

    // Nine times as many vertices: as a file that changed on the disk.
    let id: AssetId<BdtModel> = handle.id();
    let mut models = app.world_mut().resource_mut::<Assets<BdtModel>>();
    models.insert(id, fine.clone().into()).unwrap();
    let third = drawn(&mut app);
    let same = expected(&mut app, entity, deformed_mesh(&body(&fine, -3.0)));
    assert_same(&third, &same, "another file");

    // One mesh for each entity, and none that stays behind.
    let count = |app: &App| app.world().resource::<Assets<Mesh>>().len();
    support::settle(&mut app);
    let before = count(&app);
    app.world_mut().entity_mut(entity).remove::<DeformingMesh>();
    let empty = drawn(&mut app);
    assert!(app.world().get::<Mesh3d>(entity).is_none());
    assert!(empty.differing(&third, 3) > 1000);
    assert_eq!(count(&app), before - 1);
}

/// Stripes along the vertices' ids.
fn striped(mesh: Mesh) -> Mesh {
    let color = |i: usize| match i / 24 % 2 {
        0 => [0.1, 0.2, 0.9, 1.0],
        _ => [1.0, 1.0, 0.9, 1.0_f32],
    };
    let colors: Vec<_> = (0..mesh.count_vertices()).map(color).collect();
    mesh.with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors)
}

#[test]
fn a_mesh_of_the_program_keeps_its_colors() {
    let mut app = scene(EYE, Vec3::ZERO);
    let model = sphere(24);
    let handle = add_model(app.world_mut(), &model);
    let white = material(app.world_mut(), Color::WHITE);
    let template = striped(deformed_mesh(&body(&model, 0.0)));
    let template: Handle<Mesh> = app.world_mut().resource_mut::<Assets<Mesh>>().add(template);
    let bodies: Vec<Entity> = [-1.0, 1.0]
        .map(|x| {
            let deformation = body(&model, 3.0 * x).deformation;
            app.world_mut()
                .spawn((
                    DeformingMesh(handle.clone()),
                    Mesh3d(template.clone()),
                    deformation,
                    Transform::from_xyz(x, 0.0, 0.0),
                    white.clone(),
                ))
                .id()
        })
        .to_vec();
    let found = drawn(&mut app);
    found.save("drawing-stripes");
    for entity in bodies {
        app.world_mut().despawn(entity);
    }
    for x in [-1.0, 1.0] {
        let mesh = striped(deformed_mesh(&body(&model, 3.0 * x)));
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
        app.world_mut().spawn((
            Mesh3d(mesh),
            Transform::from_xyz(x, 0.0, 0.0),
            MeshMaterial3d(white.0.clone()),
            NoFrustumCulling,
        ));
    }
    assert_same(&found, &drawn(&mut app), "stripes");
}

#[test]
fn a_mesh_of_the_program_that_does_not_fit_is_told_of_and_drawn_as_it_is() {
    let mut app = scene(EYE, Vec3::ZERO);
    let model = sphere(8);
    let handle = add_model(app.world_mut(), &model);
    let orange = material(app.world_mut(), ORANGE);
    let fits = || deformed_mesh(&body(&model, 0.0));
    let other = deformed_mesh(&body(&sphere(9), 0.0));
    let mut bare = fits();
    bare.remove_attribute(Mesh::ATTRIBUTE_NORMAL);
    let mut gone = fits();
    gone.asset_usage = RenderAssetUsages::RENDER_WORLD;
    let cases = [
        (other, "the Mesh3d has 146 vertices and the .bdt file 114"),
        (bare, "the Mesh3d has no Vertex_Normal as Float32x3"),
        (gone, "the Mesh3d is in the render world alone"),
    ];
    for (mesh, words) in cases {
        let given = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
        // Drawn before it is known that it deforms, as while a file is loaded.
        let entity = app
            .world_mut()
            .spawn((Mesh3d(given.clone()), orange.clone()))
            .id();
        app.update();
        let deforming = (DeformingMesh(handle.clone()), body(&model, 3.0).deformation);
        app.world_mut().entity_mut(entity).insert(deforming);
        app.update();
        let told = faults(&app, entity).get(PoseStage::Drawing).unwrap();
        assert!(told.starts_with(words), "{told}");
        assert_eq!(app.world().get::<Mesh3d>(entity).unwrap().0, given);

        // One that fits mends it.
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(fits());
        app.world_mut().entity_mut(entity).insert(Mesh3d(mesh));
        app.update();
        assert!(faults(&app, entity).is_empty());
        assert_ne!(app.world().get::<Mesh3d>(entity).unwrap().0, given);
        app.world_mut().despawn(entity);
    }
}

#[test]
fn meshes_are_drawn_that_have_a_material_or_ask_for_it() {
    let mut app = scene(EYE, Vec3::ZERO);
    let handle = add_model(app.world_mut(), &sphere(8));
    let orange = material(app.world_mut(), ORANGE);
    let world = app.world_mut();
    let plain = world.spawn(DeformingMesh(handle.clone())).id();
    let asks = world
        .spawn((DeformingMesh(handle.clone()), DrawDeformed))
        .id();
    let has_one = world.spawn((DeformingMesh(handle), orange)).id();
    app.update();
    let is_drawn = |entity| app.world().get::<Mesh3d>(entity).is_some();
    assert_eq!([plain, asks, has_one].map(is_drawn), [false, true, true]);
}
