//! Programs without a window, and models for them.

use std::time::{Duration, Instant};

use bdtree_bevy::bdtree_runtime::{Instance, Model, SkeletonPose, VertexId, joint};
use bdtree_bevy::{
    BdtModel, BdtreePlugin, Deformation, DeformedInstance, DeformingMesh, PoseFaults,
};
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Elastic, Morphs, Motion, Recipe};
use bdtree_fixtures::{bake, corpus, poses, skin};
use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets};
use bevy_ecs::prelude::*;
use bevy_math::{Affine3A, Mat3, Mat4, Quat, Vec3};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// A program without a window whose files lie in a folder; they are watched, as in every program with Bevy's
/// `file_watcher`.
pub(crate) fn app_in(folder: &std::path::Path) -> App {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        AssetPlugin {
            file_path: folder.display().to_string(),
            ..Default::default()
        },
        TransformPlugin,
        BdtreePlugin,
    ));
    app
}

/// The same without files.
pub(crate) fn app() -> App {
    let mut app = App::new();
    let asset_plugin = AssetPlugin {
        watch_for_changes_override: Some(false),
        ..Default::default()
    };
    app.add_plugins((
        TaskPoolPlugin::default(),
        asset_plugin,
        TransformPlugin,
        BdtreePlugin,
    ));
    app
}

/// Runs frames until something is so, for 30 s at most.
pub(crate) fn run_until(app: &mut App, mut done: impl FnMut(&mut World) -> bool) {
    let start = Instant::now();
    while !done(app.world_mut()) {
        assert!(start.elapsed() < Duration::from_secs(30), "nothing in 30 s");
        app.update();
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// An entity with a model, at a place. Its instance is there after the next frame.
pub(crate) fn spawn(app: &mut App, model: &Model, at: Transform) -> Entity {
    let mut models = app.world_mut().resource_mut::<Assets<BdtModel>>();
    let handle = models.add(BdtModel::from(model.clone()));
    app.world_mut().spawn((DeformingMesh(handle), at)).id()
}

/// The instance of an entity.
pub(crate) fn instance(app: &App, entity: Entity) -> &Instance {
    let kept = app.world().get::<DeformedInstance>(entity);
    &kept.expect("an instance").instance
}

/// Changes the deformation of an entity.
pub(crate) fn deformation(app: &mut App, entity: Entity) -> Mut<'_, Deformation> {
    let deformation = app.world_mut().get_mut::<Deformation>(entity);
    deformation.expect("a deformation")
}

/// What is wrong with an entity.
pub(crate) fn faults(app: &App, entity: Entity) -> &PoseFaults {
    app.world().get::<PoseFaults>(entity).expect("faults")
}

/// A ball with four smooth fields, of 98 triangles.
pub(crate) fn ball() -> Model {
    let mesh = bake::bumpy_sphere(7, 3);
    bake::baked(&mesh, &bake::smooth_basis(&mesh, 4, 5))
}

/// A ball with three named fields.
pub(crate) fn named_ball() -> Model {
    let mesh = bake::bumpy_sphere(7, 3);
    let mut basis = bake::smooth_basis(&mesh, 3, 5);
    for (mode, name) in basis.modes.iter_mut().zip(["smile", "frown", "blink"]) {
        mode.name = Some(name.to_string());
    }
    bake::baked(&mesh, &basis)
}

/// The bar with three joints (`root`, `elbow`, `tip`), one mode (`lift`) and two clips (`bend`, `stretch`).
pub(crate) fn bar() -> Model {
    Model::from_bytes(&skin::skinned_bar()).expect("a bar")
}

/// The model of a file of the corpus: its morph targets and its skin; `None` without a corpus.
pub(crate) fn of_corpus(test: &str, file: &str) -> Option<Model> {
    let path = corpus::path(test, file)?;
    let motion = Motion::MorphsElseSkin(Morphs::default(), Elastic::default());
    let baked = bdtree_build::bake(&Recipe::of_surface(path, motion), &Silent).expect("a bake");
    Some(Model::from_bytes(&baked.bytes).expect("an asset"))
}

/// Joints of a model near rest: each turned, stretched, sheared and moved.
pub(crate) fn random_joints(model: &Model, rng: &mut Pcg64Mcg) -> Vec<Affine3A> {
    let Ok(pose) = SkeletonPose::new(model) else {
        return Vec::new();
    };
    let mut number = |share: f64| rng.random_range(-share..share) as f32;
    let rest = pose.joints().iter();
    rest.map(|joint| {
        let columns = joint::to_columns(joint).map(|c| c.map(|x| x as f32));
        let mut matrix = Mat4::from_cols_array_2d(&columns);
        let turn = Quat::from_scaled_axis(Vec3::new(number(2.0), number(2.0), number(2.0)));
        let mut bent = Mat3::from_quat(turn);
        for column in [&mut bent.x_axis, &mut bent.y_axis, &mut bent.z_axis] {
            *column += Vec3::new(number(0.3), number(0.3), number(0.3));
        }
        matrix *= Mat4::from_mat3(bent);
        let size = matrix.x_axis.length();
        matrix.w_axis += Vec3::new(number(0.5), number(0.5), number(0.5)).extend(0.0) * size;
        Affine3A::from_mat4(matrix)
    })
    .collect()
}

/// A rotation, a scale and a place.
pub(crate) fn random_place(spread: f64, rng: &mut Pcg64Mcg) -> Transform {
    let at = poses::random_transform(spread, rng);
    Transform {
        translation: Vec3::from_array(at.translation.map(|x| x as f32)),
        rotation: Quat::from_array(at.rotation.map(|x| x as f32)).normalize(),
        scale: Vec3::splat(at.scale as f32),
    }
}

/// The difference between where two instances put the same vertices, at most.
pub(crate) fn apart(a: &Instance, b: &Instance) -> f64 {
    let (a, b) = (a.snapshot(), b.snapshot());
    (0..a.asset().vertex_count() as u32)
        .map(|i| {
            let (p, q) = (
                a.deformed(VertexId(i)).unwrap(),
                b.deformed(VertexId(i)).unwrap(),
            );
            (0..3).map(|k| (p[k] - q[k]).abs()).fold(0.0, f64::max)
        })
        .fold(0.0, f64::max)
}
