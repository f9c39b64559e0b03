//! Mouse and keyboard on controls and picture, without a window.

use bdtree_fixtures::{bake, golden};
use bdtree_render::Camera;
use bdtree_tools::{AssetFile, Posture};
use egui::{Key, Modifiers, PointerButton, Pos2, Vec2, pos2, vec2};

use super::*;
use crate::person::Person;

const WIDE: Vec2 = vec2(1000.0, 700.0);
const SMALL: Vec2 = vec2(640.0, 480.0);

fn with_person(file: &AssetFile, size: Vec2, test: impl FnOnce(Person<App<'_>>)) {
    let asset = file.checked_asset(true).expect("sound");
    let posture = Posture::of_q(vec![0.0; asset.mode_count()]);
    let app = App::new(file, posture).expect("a state");
    test(Person::new(app, size));
}

fn golden_file(name: &str) -> AssetFile {
    AssetFile::read(&golden::folder().join(name)).expect("a golden file")
}

impl Person<App<'_>> {
    /// The middle of the slider below a mode's name, its number, and its "Zero".
    #[track_caller]
    fn slider(&self, name: &str) -> [Pos2; 3] {
        let name = self.find(name);
        let below = |pos: &Pos2| pos.y > name.y && pos.y < name.y + 24.0;
        let rows = self.texts.iter().map(|(text, area)| (text, area.center()));
        let row: Vec<_> = rows.filter(|(_, pos)| below(pos)).collect();
        let zero = row
            .iter()
            .find(|(text, _)| *text == "Zero")
            .expect("a button")
            .1;
        let is_number = |pos: &Pos2| {
            pos.x > zero.x - 90.0 && pos.x < zero.x - 20.0 && (pos.y - zero.y).abs() < 6.0
        };
        let number = row
            .iter()
            .find(|(_, pos)| is_number(pos))
            .expect("a number")
            .1;
        // From the panel's margin to the field with the number.
        let middle = f32::midpoint(12.0, number.x - 37.0);
        [pos2(middle, number.y), number, zero]
    }

    fn camera(&self) -> Camera {
        self.app.view.camera.expect("a camera")
    }
}

const FAR: Vec2 = vec2(400.0, 0.0);

#[test]
fn sliders_go_to_range_and_limit_and_back_to_zero() {
    let file = golden_file("animated.bdt");
    with_person(&file, WIDE, |mut person| {
        let ends = person.app.asset().modes()[0];
        person.find("range ±0.5000  ·  limit ±512");
        let name = "field 0";
        let [slider, ..] = person.slider(name);
        person.app.playback.clock.is_playing = true;
        person.drag(PointerButton::Primary, slider, FAR);
        assert_eq!(person.app.view.q[0], ends.q_range.get());
        assert_eq!(person.app.view.q[1], 0.0);
        assert!(!person.app.playback.clock.is_playing, "q is set by hand");
        person.drag(PointerButton::Primary, slider, -FAR);
        assert_eq!(person.app.view.q[0], -ends.q_range.get());
        person.click_on("limit");
        person.drag(PointerButton::Primary, slider, FAR);
        assert_eq!(person.app.view.q[0], ends.q_limit.get());
        let [.., zero] = person.slider(name);
        person.click(zero);
        assert_eq!(person.app.view.q, [0.0, 0.0]);
        person.app.view.q = vec![0.1, 0.2];
        person.click_on("Zero all");
        assert_eq!(person.app.view.q, [0.0, 0.0]);
    });
}

/// A body of forty modes.
fn forty_modes() -> AssetFile {
    let mesh = bake::bumpy_sphere(8, 1);
    let basis = bake::smooth_basis(&mesh, 40, 1);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("forty.bdt");
    std::fs::write(&path, bake::baked(&mesh, &basis).asset().bytes()).expect("written");
    AssetFile::read(&path).expect("a file")
}

#[test]
fn every_control_is_reached_in_a_small_window() {
    let file = forty_modes();
    with_person(&file, SMALL, |mut person| {
        let [width, height] = person.picture;
        assert!(
            width >= 360 && height == 480,
            "{width} x {height} pixels of picture"
        );
        let name = |person: &Person<App<'_>>, mode: usize| {
            let info = &person.app.info.mode_info[mode];
            info.name.clone().unwrap_or_else(|| format!("q[{mode}]"))
        };
        let [first, last] = [0, 39].map(|mode| name(&person, mode));
        let [slider, ..] = person.slider(&first);
        assert_eq!([&last, "Show all"].map(|text| person.sees(text)), [None; 2]);
        person.wheel(slider, -5000.0);
        let [slider, ..] = person.slider(&last);
        assert_eq!(person.sees(&first), None);
        person.drag(PointerButton::Primary, slider, FAR);
        let q = &person.app.view.q;
        assert_eq!(q[39], person.app.asset().modes()[39].q_range.get());
        assert!(q[..39].iter().all(|q| *q == 0.0));
        // The wheel went on to the sections below.
        person.click_on("mesh");
        assert!(!person.app.view.has_mesh);
        person.find("Show all");
        for (text, area) in &person.texts {
            assert!(
                area.right() <= SMALL.x - width as f32,
                "{text} reaches into the picture"
            );
        }
    });
}

/// Above it the picture, as wide as the window and with a good part of its height; no text of it is cut off.
#[test]
fn in_a_narrow_window_the_controls_are_below_the_picture() {
    let files = [forty_modes(), golden_file("animated.bdt")];
    for (file, width) in files
        .iter()
        .flat_map(|f| [300.0, 400.0, 480.0].map(|w| (f, w)))
    {
        with_person(file, vec2(width, 640.0), |mut person| {
            let [wide, high] = person.picture.map(|n| n as f32);
            assert!(wide == width && high >= 300.0, "{wide} x {high} pixels");
            let slider = person.find("range").y;
            assert!(slider > high, "{slider} in a picture {high} high");
            let (camera, middle) = (person.camera(), person.middle());
            person.drag(PointerButton::Primary, middle, vec2(40.0, 0.0));
            assert_ne!(person.camera(), camera);
            person.app.view.level = Some(0);
            person.app.view.has_probe = true;
            let mut sees_probe = false;
            for _ in 0..40 {
                assert_eq!(person.cut, [""; 0], "{width}");
                sees_probe |= person.sees("where the query ended").is_some();
                if person.sees("Show all").is_some() {
                    break;
                }
                person.wheel(pos2(0.5 * width, high + 120.0), -60.0);
            }
            assert!(sees_probe, "{width}");
            person.click_on("Show all");
        });
    }
}

#[test]
fn in_a_window_of_the_usual_size_all_controls_are_seen() {
    let file = forty_modes();
    with_person(&file, vec2(1280.0, 800.0), |mut person| {
        person.app.view.has_probe = true;
        person.wait();
        person.find("nodes visited");
        person.find("drag: turn  ·  right or shift drag: move  ·  wheel: zoom");
    });
}

#[test]
fn nothing_is_cut_off_beside_the_picture() {
    let file = forty_modes();
    for width in [560.0, 640.0, 1000.0] {
        with_person(&file, vec2(width, 480.0), |person| {
            person.find("limit");
            assert_eq!(person.cut, [""; 0], "{width}");
            assert!(person.picture[0] as f32 >= 0.5 * width, "{width}");
        });
    }
}

#[test]
fn the_mouse_turns_moves_and_zooms_the_camera() {
    let file = golden_file("sphere.bdt");
    with_person(&file, WIDE, |mut person| {
        let first = person.camera();
        let at = person.middle() + vec2(120.0, 80.0);
        person.drag(PointerButton::Primary, at, vec2(90.0, 30.0));
        let turned = person.camera();
        assert_eq!(turned.target, first.target);
        assert!((turned.distance() - first.distance()).abs() < 1e-4);
        assert!(turned.eye.distance(first.eye) > 0.3);

        person.drag(PointerButton::Secondary, at, vec2(0.0, 70.0));
        let moved = person.camera();
        let by = moved.target - turned.target;
        assert!(
            (moved.eye - turned.eye).distance(by) < 1e-4,
            "eye and target go together"
        );
        // A tenth of the height down: the picture follows the pointer.
        let height = 2.0 * turned.distance() * (0.5 * turned.fov_y_rad).tan();
        assert!((by.dot(turned.axes()[1]) - 0.1 * height).abs() < 0.01 * height);
        person.modifiers = Modifiers::SHIFT;
        person.drag(PointerButton::Primary, at, vec2(0.0, -70.0));
        person.modifiers = Modifiers::NONE;
        assert!(
            person.camera().target.distance(turned.target) < 1e-3,
            "shift moves, too"
        );

        person.wheel(at, 200.0);
        let near = person.camera();
        assert!(near.distance() < 0.8 * turned.distance());
        person.wheel(at, -400.0);
        assert!(person.camera().distance() > near.distance());
        // Over the controls the wheel does not zoom.
        let before = person.camera();
        person.wheel(pos2(100.0, 300.0), 200.0);
        assert_eq!(person.camera(), before);

        let title = person.find("Modes (3)");
        person.wheel(title, -5000.0);
        person.click_on("Show all");
        assert_eq!(person.camera(), first);
    });
}

#[test]
fn without_modes_there_are_no_sliders() {
    for (name, has_modes) in [("tetrahedron.bdt", false), ("sphere.bdt", true)] {
        with_person(&golden_file(name), WIDE, |person| {
            person.find("Spheres");
            for text in ["Zero all", "sliders go to"] {
                assert_eq!(person.sees(text).is_some(), has_modes, "{name}: {text}");
            }
            assert_eq!(person.sees("Modes (0)"), None);
        });
    }
}

#[test]
fn the_space_bar_plays_and_halts() {
    let file = golden_file("animated.bdt");
    with_person(&file, WIDE, |mut person| {
        for plays in [true, false, true] {
            person.key(Key::Space);
            assert_eq!(person.app.playback.clock.is_playing, plays);
        }
        person.find("Pause");
        person.click_on("Pause");
        assert!(!person.app.playback.clock.is_playing);
        // In a field with a number it is a character.
        let [_, number, _] = person.slider("field 0");
        person.click(number);
        person.key(Key::Space);
        assert!(!person.app.playback.clock.is_playing);
    });
    let file = golden_file("sphere.bdt");
    with_person(&file, WIDE, |mut person| {
        person.key(Key::Space);
        assert!(
            !person.app.playback.clock.is_playing,
            "there is no animation"
        );
    });
}

#[test]
fn what_the_query_met_does_not_look_like_the_level() {
    use bdtree_render::tightness::Scale;
    let colours = |app: &App<'_>| {
        let shapes = crate::shapes::Shapes::of(app);
        shapes.spheres.iter().map(|s| s.colour).collect::<Vec<_>>()
    };
    let file = golden_file("sphere.bdt");
    with_person(&file, WIDE, |mut person| {
        person.app.view.has_probe = true;
        person.app.view.probe.center = [0.7, 0.6, 0.1];
        person.wait();
        let met = colours(&person.app);
        let [r, g, b, _] = crate::shapes::ENDS;
        assert!(
            met.iter().any(|[x, y, z, _]| [*x, *y, *z] == [r, g, b]),
            "{met:?}"
        );
        // Far from every color of either scale.
        for scale in [Scale::Paper, Scale::Viridis] {
            for k in 0..=100 {
                let of_level = scale.colour(1.0 + 0.0044 * f64::from(k));
                let apart = (0..3).map(|i| i32::from(of_level[i].abs_diff([r, g, b][i])));
                assert!(apart.sum::<i32>() > 150, "{scale:?} {k}: {of_level:?}");
            }
        }
        // The scale is chosen in the panel, and colors the level.
        person.app.view.has_probe = false;
        person.app.view.level = Some(0);
        person.click_on("viridis");
        assert_eq!(person.app.view.scale, Scale::Viridis);
        let level = colours(&person.app);
        assert!(
            level.iter().all(|[r, g, b, _]| [*r, *g, *b] == [68, 1, 84]),
            "{level:?}"
        );
    });
}
