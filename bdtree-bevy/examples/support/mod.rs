//! A program without a window: Bevy's renderer draws into an image, and pictures of it are taken. Shared by examples and
//! tests.

// Not every program uses all of it.
#![allow(dead_code, unreachable_pub)]

pub mod models;
pub mod picture;

use std::path::Path;
use std::time::{Duration, Instant};

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets, Handle};
use bevy_camera::{Camera, Camera3d, CameraPlugin, ClearColorConfig, RenderTarget};
use bevy_color::Color;
use bevy_core_pipeline::CorePipelinePlugin;
use bevy_diagnostic::FrameCountPlugin;
use bevy_ecs::prelude::*;
use bevy_gizmos::GizmoPlugin;
use bevy_gizmos_render::GizmoRenderPlugin;
use bevy_image::{Image, ImagePlugin};
use bevy_light::{DirectionalLight, GlobalAmbientLight, LightPlugin};
use bevy_math::Vec3;
use bevy_mesh::{Mesh, Mesh3d, MeshPlugin};
use bevy_pbr::{MeshMaterial3d, PbrPlugin, StandardMaterial};
use bevy_render::render_resource::{PipelineCache, TextureFormat};
use bevy_render::view::Tonemapping;
use bevy_render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy_render::{RenderApp, RenderPlugin};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;
use bevy_window::{ExitCondition, WindowPlugin};

use picture::Picture;

/// What is waited for at most: a frame on a processor alone, beside other programs, may take seconds.
const PATIENCE: Duration = Duration::from_secs(120);

/// The image that cameras of [`camera`] draw into.
#[derive(Resource, Clone)]
pub struct Canvas(pub Handle<Image>);

/// A picture that has come back.
#[derive(Resource)]
struct Taken(Picture);

/// A program with Bevy's plugins for drawing at their defaults, an image of so many pixels to draw into, files from a
/// folder, and frames of 1/60 s.
pub fn app(width: u32, height: u32, files: &Path) -> App {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        FrameCountPlugin,
        TimePlugin,
        TransformPlugin,
        WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..Default::default()
        },
        AssetPlugin {
            file_path: files.display().to_string(),
            ..Default::default()
        },
        RenderPlugin {
            synchronous_pipeline_compilation: true,
            ..Default::default()
        },
        ImagePlugin::default(),
        MeshPlugin,
        CameraPlugin,
        LightPlugin,
        CorePipelinePlugin,
        PbrPlugin::default(),
    ));
    app.add_plugins((GizmoPlugin, GizmoRenderPlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(
        Duration::from_secs(1) / 60,
    ));
    app.insert_resource(GlobalAmbientLight {
        brightness: 300.0,
        ..Default::default()
    });
    let image = Image::new_target_texture(width, height, TextureFormat::Rgba8UnormSrgb, None);
    let image = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    app.insert_resource(Canvas(image));
    app
}

/// Shows on stderr what goes wrong, as Bevy's `DefaultPlugins` do.
pub fn show_errors() {
    bevy_log::tracing_subscriber::fmt()
        .with_max_level(bevy_log::Level::ERROR)
        .with_writer(std::io::stderr)
        .without_time()
        .init();
}

/// Finishes the plugins, as `App::run` does.
pub fn start(app: &mut App) {
    while app.plugins_state() == bevy_app::PluginsState::Adding {
        std::thread::sleep(Duration::from_millis(1));
    }
    app.finish();
    app.cleanup();
}

/// A camera that draws into the canvas.
pub fn camera(world: &mut World, eye: Vec3, at: Vec3) -> Entity {
    let canvas = world.resource::<Canvas>().0.clone();
    world
        .spawn((
            Camera3d::default(),
            Camera {
                clear_color: ClearColorConfig::Custom(Color::srgb(0.93, 0.94, 0.96)),
                ..Default::default()
            },
            RenderTarget::from(canvas),
            // Bevy's default needs a table that is not there without its feature.
            Tonemapping::Reinhard,
            Transform::from_translation(eye).looking_at(at, Vec3::Y),
        ))
        .id()
}

/// A mesh of Bevy's in one color.
pub fn solid(
    world: &mut World,
    mesh: impl Into<Mesh>,
    color: Color,
) -> (Mesh3d, MeshMaterial3d<StandardMaterial>) {
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh.into());
    (Mesh3d(mesh), material(world, color))
}

/// A material of one color, the same on both sides.
pub fn material(world: &mut World, color: Color) -> MeshMaterial3d<StandardMaterial> {
    let material = StandardMaterial {
        base_color: color,
        perceptual_roughness: 0.6,
        double_sided: true,
        cull_mode: None,
        ..Default::default()
    };
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    MeshMaterial3d(materials.add(material))
}

/// A light like the sun that casts shadows.
pub fn sun(world: &mut World, from: Vec3) -> Entity {
    world
        .spawn((
            DirectionalLight {
                illuminance: 7000.0,
                shadow_maps_enabled: true,
                ..Default::default()
            },
            Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y),
        ))
        .id()
}

/// Runs frames until something is so.
///
/// # Panics
/// When it takes too long.
pub fn run_until(app: &mut App, mut done: impl FnMut(&mut App) -> bool) {
    let start = Instant::now();
    while !done(app) {
        assert!(start.elapsed() < PATIENCE, "nothing in {PATIENCE:?}");
        app.update();
    }
}

/// Runs frames until no shader is waited for, and three more.
pub fn settle(app: &mut App) {
    let mut calm = 0;
    run_until(app, |app| {
        let render = app.sub_app(RenderApp).world();
        let pipelines = render.get_resource::<PipelineCache>();
        let is_calm = pipelines.is_some_and(|cache| {
            cache.pipelines().next().is_some() && cache.waiting_pipelines().next().is_none()
        });
        calm = if is_calm { calm + 1 } else { 0 };
        calm > 3
    });
}

/// Runs so many frames of which no picture is wanted: cameras rest, so that nothing is drawn.
pub fn run_undrawn(app: &mut App, frames: usize) {
    set_cameras(app, false);
    for _ in 0..frames {
        app.update();
    }
    set_cameras(app, true);
}

fn set_cameras(app: &mut App, is_active: bool) {
    let world = app.world_mut();
    for mut camera in world.query::<&mut Camera>().iter_mut(world) {
        camera.is_active = is_active;
    }
}

/// A picture of the next frame.
pub fn take(app: &mut App) -> Picture {
    take_and(app, |_| {})
}

/// A picture of the next frame, behind which `look` sees the world as it was drawn.
pub fn take_and(app: &mut App, look: impl FnOnce(&App)) -> Picture {
    app.world_mut().remove_resource::<Taken>();
    let canvas = app.world().resource::<Canvas>().0.clone();
    app.world_mut().spawn(Screenshot::image(canvas)).observe(
        |captured: On<ScreenshotCaptured>, mut commands: Commands| {
            commands.insert_resource(Taken(Picture::of(&captured.image)));
        },
    );
    app.update();
    look(app);
    // Frames that pass until it is there are of no picture.
    set_cameras(app, false);
    run_until(app, |app| app.world().contains_resource::<Taken>());
    set_cameras(app, true);
    app.world_mut().remove_resource::<Taken>().unwrap().0
}
