//! The viewer on a virtual display: what its window shows, and how it ends.
#![cfg(target_os = "linux")]

mod clips;
mod display;
mod ends;
mod find;
mod hands;
mod input;
mod playground;

use std::path::{Path, PathBuf};

use bdtree_fixtures::golden;
use bdtree_render::Level;
use bdtree_runtime::Transform;
use bdtree_tools::{AssetFile, Posture};
use bdtree_view::app::App;
use display::{Display, Picture, Running};

/// The window of these tests.
const SIZE: [u32; 2] = [1000, 700];
/// Left of it are controls, right of it is the picture.
const EDGE: u32 = bdtree_view::PANEL_WIDTH as u32;
const CONTROLS: [u32; 4] = [0, 0, EDGE, SIZE[1]];
const PICTURE: [u32; 4] = [EDGE + 2, 0, SIZE[0], SIZE[1]];

const PANEL: [u8; 3] = [243, 244, 247];
const BACKGROUND: [u8; 3] = [252, 252, 253];
/// Half of `q_range` of the golden files' first modes, and more.
const FAR: &str = "0.5,0.5,-0.5";

fn file(name: &str) -> PathBuf {
    golden::folder().join(name)
}

/// What `bdtree-view --screenshot` copies.
fn screenshot(display: &Display, file: &Path, options: &[&str]) -> Picture {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("window.png");
    let output = display
        .viewer()
        .arg(file)
        .args(["--size", "1000x700", "--screenshot"])
        .arg(&path)
        .args(options)
        .output()
        .expect("the viewer starts");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{text}");
    let picture = Picture::load(&path);
    assert_eq!(picture.size, SIZE);
    let wrote = format!("wrote {}: 1000 x 700 pixels\n", path.display());
    assert_eq!(String::from_utf8_lossy(&output.stdout), wrote);
    picture
}

/// Blue, as spheres are that have not grown.
fn is_blue([r, g, b]: [u8; 3]) -> bool {
    b > r.saturating_add(25) && b > g.saturating_add(15)
}

/// Yellow to red, as spheres are that have grown by half of what the scale ends with, or more.
fn is_warm([r, _, b]: [u8; 3]) -> bool {
    r > b.saturating_add(60)
}

#[test]
fn the_display_shows_controls_and_the_mesh() {
    let display = Display::start();
    let mut viewer = display.viewer();
    viewer.arg(file("sphere.bdt")).args(["--size", "1000x700"]);
    let mut viewer = Running(viewer.spawn().expect("the viewer starts"));
    let shown = display.wait_for(&mut viewer, |screen| {
        screen.share(CONTROLS, |c| c == PANEL) > 0.5
            && screen.share(PICTURE, |c| c != BACKGROUND && c != [0; 3]) > 0.05
    });
    // Words, sliders and buttons on the panel; a mesh in the middle, nothing around it.
    let is_dark = |c: [u8; 3]| c.iter().all(|x| *x < 120);
    assert!(shown.share(CONTROLS, is_dark) > 0.005, "text");
    let background = shown.share(PICTURE, |c| c == BACKGROUND);
    assert!(
        (0.25..0.9).contains(&background),
        "{background} is background"
    );
    for corner in [
        [EDGE + 9, 9],
        [SIZE[0] - 9, 9],
        [EDGE + 9, SIZE[1] - 9],
        [SIZE[0] - 9, SIZE[1] - 9],
    ] {
        assert_eq!(shown.at(corner[0], corner[1]), BACKGROUND, "{corner:?}");
    }
    let middle = shown.at(u32::midpoint(EDGE, SIZE[0]), SIZE[1] / 2);
    let [r, g, b] = middle.map(i32::from);
    assert!(
        (r - b).abs() < 40 && (r - g).abs() < 30 && r > 60,
        "the mesh is grey: {middle:?}"
    );
    // Beyond the window the display is as it was: black.
    assert_eq!(shown.at(SIZE[0] + 20, 100), [0; 3]);
    // And the copy that the viewer makes of its own is that, frame time aside.
    drop(viewer);
    let copy = screenshot(&display, &file("sphere.bdt"), &[]);
    let differ = copy.difference(&shown, [0, 0, SIZE[0], SIZE[1]]);
    assert!(differ < 0.002, "{differ} of the pixels differ");
}

#[test]
fn q_moves_the_mesh_and_its_sliders() {
    let display = Display::start();
    let rest = screenshot(&display, &file("sphere.bdt"), &[]);
    let far = screenshot(&display, &file("sphere.bdt"), &["--q", FAR]);
    assert!(rest.difference(&far, PICTURE) > 0.02);
    assert!(rest.difference(&far, CONTROLS) > 0.001);
    // A frame shows what its q shows, with its own rigid motion.
    let first = screenshot(&display, &file("animated.bdt"), &["--frame", "0"]);
    let third = screenshot(&display, &file("animated.bdt"), &["--frame", "2"]);
    assert!(first.difference(&third, PICTURE) > 0.005);
}

/// A sphere in a picture: middle and radius in pixels.
type Disc = ([f32; 2], f32);

/// A window's picture of spheres and where they are in it.
fn spheres(display: &Display, q: &[f32], options: &[&str]) -> (Picture, Vec<Disc>) {
    let path = file("sphere.bdt");
    let mut all = vec!["--spheres", "0"];
    all.extend(options);
    let picture = screenshot(display, &path, &all);
    let file = AssetFile::read(&path).expect("a golden file");
    let asset = file.checked_asset(true).expect("sound");
    let posture = Posture::of_q(q.to_vec());
    let mut app = App::new(&file, posture).expect("a state");
    app.view.level = Some(0);
    let size = [SIZE[0] - EDGE, SIZE[1]];
    app.fit(size[0] as f32 / size[1] as f32).expect("a camera");
    let camera = app.view.camera.expect("a camera");
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset.pose(q, Transform::IDENTITY, &mut memory);
    let pose = pose.expect("a pose");
    let level = Level::of(&pose, 0).expect("spheres");
    let seen = level.spheres.iter().map(|sphere| {
        let center = app.place.shown(sphere.center);
        let [x, y] = camera.project(center, size).expect("in front");
        let away = (0..3)
            .map(|k| (center[k] - camera.eye[k]).powi(2))
            .sum::<f32>()
            .sqrt();
        let radius = app.place.shown_length(sphere.radius);
        let slope = radius / (away * away - radius * radius).sqrt();
        let pixels = 0.5 * size[1] as f32 / (0.5 * camera.fov_y_rad).tan() * slope;
        ([x + EDGE as f32, y], pixels)
    });
    (picture, seen.collect())
}

#[test]
fn spheres_are_where_they_must_be_and_coloured_by_growth() {
    let display = Display::start();
    let (rest, seen) = spheres(&display, &[0.0; 3], &[]);
    assert_eq!(seen.len(), 7);
    // Perspective makes discs ellipses, and a little more: within 0.9 of the radius there is colour, beyond
    // 1.15 of all there is none.
    let (mut within, mut beyond) = (0, 0);
    for y in (0..SIZE[1]).step_by(3) {
        for x in (EDGE + 4..SIZE[0]).step_by(3) {
            let of = seen
                .iter()
                .map(|([a, b], r)| (a - x as f32).hypot(b - y as f32) / r);
            let nearest = of.fold(f32::INFINITY, f32::min);
            let pixel = rest.at(x, y);
            if nearest < 0.9 {
                within += 1;
                assert_ne!(pixel, BACKGROUND, "in a sphere at {x}, {y}");
            } else if nearest > 1.15 {
                beyond += 1;
                assert_eq!(pixel, BACKGROUND, "outside all spheres at {x}, {y}");
            }
        }
    }
    assert!(within > 1000 && beyond > 1000, "{within} {beyond}");
    assert!(rest.share(PICTURE, is_blue) > 0.2, "dark blue: no growth");
    assert!(rest.share(PICTURE, is_warm) < 0.001);
    let (far, _) = spheres(&display, &[0.5, 0.5, -0.5], &["--q", FAR]);
    assert!(
        far.share(PICTURE, is_warm) > 0.02,
        "{}",
        far.share(PICTURE, is_warm)
    );
}

#[test]
fn a_probe_is_seen_and_what_it_found() {
    let display = Display::start();
    let without = screenshot(&display, &file("sphere.bdt"), &[]);
    let with = screenshot(
        &display,
        &file("sphere.bdt"),
        &["--probe", "0.6,0.4,0.8,0.3"],
    );
    assert!(with.difference(&without, PICTURE) > 0.01);
    assert!(with.difference(&without, CONTROLS) > 0.002, "its numbers");
    // Contacts are red dots.
    let is_red = |[r, g, b]: [u8; 3]| r > 150 && g < 90 && b < 110;
    assert!(with.share(PICTURE, is_red) > 0.0001);
    assert!(without.share(PICTURE, is_red) == 0.0);
}

#[test]
fn an_animation_plays_and_stillness_costs_nothing() {
    let display = Display::start();
    let start = |options: &[&str]| {
        let mut viewer = display.viewer();
        viewer
            .arg(file("animated.bdt"))
            .args(["--size", "1000x700"])
            .args(options);
        Running(viewer.spawn().expect("the viewer starts"))
    };
    let is_shown = |screen: &Picture| {
        screen.share(CONTROLS, |c| c == PANEL) > 0.5
            && screen.share(PICTURE, |c| c != BACKGROUND && c != [0; 3]) > 0.05
    };
    let mut playing = start(&["--play"]);
    let mut last = display.wait_for(&mut playing, is_shown);
    for _ in 0..3 {
        let moved = |screen: &Picture| screen.difference(&last, PICTURE) > 0.001;
        last = display.wait_for(&mut playing, moved);
    }
    drop(playing);
    let mut still = start(&["--frame", "1"]);
    display.wait_for(&mut still, is_shown);
    still.wait_for_rest();
}
