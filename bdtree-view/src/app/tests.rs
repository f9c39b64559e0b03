//! The state without a window.

use std::collections::BTreeSet;

use bdtree_fixtures::{bake, golden};
use bdtree_render::{Box3, Camera};
use bdtree_runtime::{TriangleId, narrow};

use super::*;

fn with_file(name: &str, test: impl FnOnce(App<'_>)) {
    let file = AssetFile::read(&golden::folder().join(name)).expect("a golden file");
    let asset = file.checked_asset(true).expect("sound");
    let posture = Posture::of_q(vec![0.0; asset.mode_count()]);
    test(App::new(&file, posture).expect("a state"));
}

#[test]
fn a_probe_finds_what_testing_every_triangle_finds() {
    with_file("sphere.bdt", |mut app| {
        app.view.q = vec![0.4, -0.3, 0.2];
        app.view.has_probe = true;
        app.view.probe = Probe {
            center: [0.7, 0.6, 0.1],
            radius: 0.45,
        };
        assert!(app.refresh());
        let answer = app
            .answer
            .as_ref()
            .expect("asked")
            .as_ref()
            .expect("answered");

        let mut memory = vec![0.0; app.asset().pose_len()];
        let View { q, transform, .. } = &app.view;
        let pose = app.asset().pose(q, *transform, &mut memory).unwrap();
        let Probe { center, radius } = app.view.probe;
        let mut expected = BTreeSet::new();
        let mut depth = f64::NEG_INFINITY;
        for id in 0..app.asset().triangle_count() as u32 {
            let corners = pose.deformed_triangle(TriangleId(id)).unwrap();
            let closest = narrow::closest_point(center, &corners);
            if closest.distance <= radius {
                expected.insert(id);
                depth = depth.max(radius - closest.distance);
            }
        }
        assert!(expected.len() > 3, "the probe is in the mesh");
        let found: BTreeSet<u32> = answer.contacts.iter().map(|c| c.triangle.0).collect();
        assert_eq!(found, expected);
        assert_eq!(found.len(), answer.contacts.len(), "each once");
        assert!((answer.depth().unwrap() - depth).abs() < 1e-12);
        assert!((1..=app.asset().node_count() as u64).contains(&answer.nodes_visited));
        // What was found hangs below a sphere in which the query ended.
        for contact in &answer.contacts {
            let is_in = |s: &NodeSphere| {
                let apart = (0..3)
                    .map(|k| (contact.point[k] - s.center[k]).powi(2))
                    .sum::<f64>();
                apart.sqrt() <= s.radius
            };
            assert!(answer.ends.iter().any(is_in), "{contact:?}");
        }
    });
}

#[test]
fn a_probe_that_is_refused_says_why() {
    with_file("sphere.bdt", |mut app| {
        app.view.has_probe = true;
        app.view.probe.center[1] = 1e40;
        app.refresh();
        let refused = app.answer.as_ref().expect("asked").as_ref().unwrap_err();
        assert!(refused.contains("center"), "{refused}");
        app.view.has_probe = false;
        assert!(app.refresh());
        assert!(app.answer.is_none());
    });
}

#[test]
fn moments_are_frames_and_what_lies_between() {
    with_file("animated.bdt", |mut app| {
        let count = app.asset().frame_count();
        assert!(count > 2);
        for index in 0..count {
            app.playback.go_to(index);
            app.show_moment();
            let frame = app.asset().frame(index).unwrap();
            assert_eq!(app.view.q, frame.q());
            assert_eq!(
                app.view.transform.translation,
                frame.transform().translation
            );
        }
        let frames = [0, 1].map(|i| app.asset().frame(i).unwrap());
        let [from, to] = frames.map(|frame| frame.time_s().unwrap());
        app.playback.go_to(0);
        app.playback.clock.is_playing = true;
        app.advance(0.25 * (to - from));
        for (k, q) in app.view.q.iter().enumerate() {
            let expected = 0.75 * frames[0].q()[k] + 0.25 * frames[1].q()[k];
            assert!((q - expected).abs() < 1e-6, "{q} {expected}");
        }
        app.zero();
        assert!(app.view.q.iter().all(|q| *q == 0.0) && !app.playback.clock.is_playing);
    });
}

#[test]
fn sliders_go_to_the_range_or_the_limit() {
    with_file("animated.bdt", |mut app| {
        assert_eq!([0, 1, 2].map(|j| app.slider_end(j)), [0.5, 0.5, 0.0]);
        app.reach = Reach::Limit;
        assert_eq!([0, 1].map(|j| app.slider_end(j)), [512.0, 2048.0]);
    });
}

#[test]
fn growth_is_none_at_rest_and_found_anew_when_q_changes() {
    with_file("sphere.bdt", |mut app| {
        app.view.level = Some(1);
        assert!(app.refresh());
        assert!(!app.refresh(), "nothing has changed");
        let rest = app.spheres.clone().expect("spheres");
        assert_eq!(rest.spheres.len(), 55);
        let [mean, max] = rest.mean_and_max.unwrap();
        assert!(mean >= 1.0 && max < 1.0 + 1e-4, "{mean} {max}");
        app.fit(1.5).unwrap();
        assert!(!app.refresh(), "a camera changes nothing");
        app.view.q = vec![0.5; 3];
        assert!(app.refresh());
        let [_, max] = app.spheres.clone().expect("spheres").mean_and_max.unwrap();
        assert!(max > 1.05, "{max}");
        let scale = app.view.scale;
        assert_ne!(scale.colour(max), scale.colour(1.0));
        app.view.level = None;
        assert!(app.refresh());
        assert!(app.spheres.clone().expect("none").spheres.is_empty());
    });
}

#[test]
fn the_mouse_moves_what_it_holds_as_far_as_it_goes() {
    let size = [900, 600];
    with_file("sphere.bdt", |mut app| {
        app.fit(1.5).unwrap();
        let place = app.place;
        let seen = |app: &App<'_>| {
            let center = place.shown(app.view.probe.center);
            app.view.camera.unwrap().project(center, size).unwrap()
        };
        let before = seen(&app);
        assert_eq!(
            app.view.grab(&place, before, size),
            Grab::Orbit,
            "there is no probe"
        );
        app.view.has_probe = true;
        assert_eq!(app.view.grab(&place, before, size), Grab::Probe);
        assert_eq!(app.view.grab(&place, [5.0, 595.0], size), Grab::Orbit);
        app.view.drag(&place, Grab::Probe, [40.0, -25.0], size);
        let after = seen(&app);
        assert!(
            (after[0] - before[0] - 40.0).abs() < 0.1,
            "{before:?} {after:?}"
        );
        assert!(
            (after[1] - before[1] + 25.0).abs() < 0.1,
            "{before:?} {after:?}"
        );

        let camera = app.view.camera.unwrap();
        app.view.drag(&place, Grab::Pan, [30.0, 12.0], size);
        let moved = seen(&app);
        // Nearer or farther than the target it moves more or less.
        assert!(
            (moved[0] - after[0] - 30.0).abs() < 6.0 && (moved[1] - after[1] - 12.0).abs() < 3.0
        );
        app.view.drag(&place, Grab::Orbit, [100.0, 0.0], size);
        let turned = app.view.camera.unwrap();
        assert!((turned.distance() - camera.distance()).abs() < 1e-4);
        assert_ne!(turned.eye, camera.eye);
        app.view.zoom(3.0);
        let nearer = app.view.camera.unwrap().distance() / turned.distance();
        assert!((nearer - 0.729).abs() < 1e-3, "{nearer}");
        for _ in 0..1000 {
            app.view.zoom(-10.0);
        }
        assert!(
            app.view.camera.unwrap().distance() < 1e5,
            "there is an end to it"
        );
    });
}

#[test]
fn all_of_the_mesh_is_seen() {
    with_file("animated.bdt", |mut app| {
        app.view.q = vec![0.5, -0.5];
        app.fit(0.8).unwrap();
        let camera = app.view.camera.unwrap();
        let at_q = positions(app.file, &app.body.pose()).unwrap();
        let mut seen = Box3::EMPTY;
        for p in at_q {
            let [x, y] = camera.project(app.place.shown(p), [800, 1000]).unwrap();
            seen = seen.with([x, y, 0.0]);
        }
        assert!(
            seen.low[0] > 0.0 && seen.low[1] > 0.0 && seen.high[0] < 800.0 && seen.high[1] < 1000.0
        );
        assert!(seen.high[0] - seen.low[0] > 760.0 || seen.high[1] - seen.low[1] > 950.0);
        // And what else is drawn: a probe far away, a level's spheres.
        app.view.has_probe = true;
        app.view.probe.center = [9.0, 0.0, 0.0];
        app.fit(0.8).unwrap();
        let probe = app.place.shown(app.view.probe.center);
        let [x, _] = app
            .view
            .camera
            .unwrap()
            .project(probe, [800, 1000])
            .unwrap();
        assert!((0.0..800.0).contains(&x), "{x}");
        app.view.has_probe = false;
        app.view.level = Some(0);
        app.fit(0.8).unwrap();
        assert!(app.view.camera.unwrap().distance() > 1.05 * camera.distance());
    });
}

#[test]
fn the_spheres_in_which_the_query_ended_are_seen() {
    with_file("sphere.bdt", |mut app| {
        app.view.has_probe = true;
        app.view.probe.center = [0.7, 0.6, 0.1];
        app.fit(1.5).unwrap();
        app.refresh();
        let camera = app.view.camera.unwrap();
        let ends = &app.answer.as_ref().unwrap().as_ref().unwrap().ends;
        assert!(ends.len() > 5);
        for sphere in ends {
            let center = app.place.shown(sphere.center);
            let radius = app.place.shown_length(sphere.radius);
            let [right, up, _] = camera.axes();
            for axis in [right, -right, up, -up] {
                let rim = [0, 1, 2].map(|k| center[k] + radius * axis[k]);
                let [x, y] = camera.project(rim, [900, 600]).unwrap();
                assert!((0.0..900.0).contains(&x) && (0.0..600.0).contains(&y));
            }
        }
        app.view.has_ends = false;
        app.fit(1.5).unwrap();
        assert!(app.view.camera.unwrap().distance() < camera.distance());
    });
}

/// From wherever it begins: else what plays leaves the picture.
#[test]
fn all_that_can_be_played_is_seen() {
    let is_seen = |app: &App<'_>, camera: Camera| {
        let is_in = |p: [f64; 3]| {
            let seen = camera.project(app.place.shown(p), [900, 600]);
            seen.is_some_and(|[x, y]| (0.0..900.0).contains(&x) && (0.0..600.0).contains(&y))
        };
        positions(app.file, &app.body.pose()).unwrap().all(is_in)
    };
    let mesh = bake::bumpy_sphere(8, 1);
    let basis = bake::with_frames(bake::smooth_basis(&mesh, 2, 1), 5, 0.5, 1);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("moves.bdt");
    std::fs::write(&path, bake::baked(&mesh, &basis).asset().bytes()).expect("written");
    with_file(path.to_str().expect("UTF-8"), |mut app| {
        app.fit(1.5).unwrap();
        let camera = app.view.camera.unwrap();
        for index in 0..app.asset().frame_count() {
            app.playback.go_to(index);
            app.show_moment();
            app.refresh();
            assert!(is_seen(&app, camera), "{index}");
            app.fit(1.5).unwrap();
            let apart = app.view.camera.unwrap().eye.distance(camera.eye);
            assert!(apart < 1e-4, "{index}: {apart}");
        }
    });
    with_file("skinned.bdt", |mut app| {
        app.begin_clip(0, 0.0, true);
        app.show_clip();
        app.fit(1.5).unwrap();
        let camera = app.view.camera.unwrap();
        for _ in 0..20 {
            app.advance(0.05 * app.clips.duration_s());
            app.refresh();
            assert!(is_seen(&app, camera), "{}", app.clips.clock.time_s);
        }
    });
    // One that flies far away is seen where it is.
    with_file("animated.bdt", |mut app| {
        for index in [0, 2] {
            app.playback.go_to(index);
            app.show_moment();
            app.fit(1.5).unwrap();
            assert!(app.view.camera.unwrap().distance() < 20.0, "{index}");
            assert!(is_seen(&app, app.view.camera.unwrap()), "{index}");
        }
    });
}

#[test]
fn the_up_axis_is_up() {
    with_file("sphere.bdt", |mut app| {
        app.up = [0.0, 0.0, 1.0];
        app.fit(1.5).unwrap();
        let camera = app.view.camera.unwrap();
        let seen = |p: [f64; 3]| camera.project(app.place.shown(p), [900, 600]).unwrap();
        let [low, high] = [seen([0.0, 0.0, -1.0]), seen([0.0, 0.0, 1.0])];
        assert!((low[0] - high[0]).abs() < 1.0 && low[1] > high[1] + 100.0);
    });
}

/// Where q is set by hand, no frame is named.
#[test]
fn a_frame_is_shown_until_q_is_set() {
    with_file("animated.bdt", |mut app| {
        app.playback.go_to(2);
        app.show_moment();
        assert!(app.shows_moment());
        app.view.q[0] += 0.01;
        assert!(!app.shows_moment());
        app.show_moment();
        app.zero();
        assert!(!app.shows_moment());
    });
}

#[test]
fn a_clip_begins_where_it_is_told() {
    with_file("skinned.bdt", |mut app| {
        let duration = app.clips.names[0].duration_s;
        for (asked, time, is_playing) in [
            (0.75, 0.75, true),
            (-1.0, 0.0, false),
            (1e9, duration, false),
        ] {
            app.begin_clip(0, asked, is_playing);
            assert_eq!(app.clips.chosen, Some(0));
            assert_eq!(app.clips.clock.time_s, time);
            assert_eq!(app.is_playing(), is_playing);
        }
    });
}

#[test]
fn given_joints_stay_until_the_skeleton_rests() {
    with_file("skinned.bdt", |mut app| {
        let given = vec![bdtree_runtime::joint::IDENTITY; app.asset().joint_count()];
        assert!(!app.has_given_joints());
        app.view.joints.clone_from(&given);
        assert!(app.has_given_joints());
        app.zero();
        assert!(app.view.joints.is_empty());
        app.view.joints = given;
        app.clips.choose(None);
        app.show_clip();
        assert!(!app.has_given_joints());
        // A clip goes on carrying the mesh.
        app.begin_clip(0, 0.5, false);
        app.show_clip();
        app.zero();
        assert!(!app.view.joints.is_empty() && !app.has_given_joints());
    });
}
