//! Frames of an animation: played back, described, compared, queried.

use serde_json::{Value, json};

use bdtree_build::basis::{BasisError, RigidMotion};

use crate::oracle::{Point, norm, placed, point_distance, sub};
use crate::support::{
    FRAME_Q, Folder, animated, baked, baked_with_error, ball_mesh, basis, positions_of_npy,
};

/// A folder with `moving.bdt` beside the others.
fn moving() -> Folder {
    let folder = Folder::new();
    folder.write("moving.bdt", baked(&ball_mesh(), &animated(&ball_mesh())));
    folder
}

fn motion(frame: usize) -> RigidMotion {
    animated(&ball_mesh())
        .animation
        .expect("an animation")
        .motions[frame]
}

/// The mesh of a frame: fields and motion in f64, straight from what was baked.
fn shown(frame: usize) -> Vec<Point> {
    let (mesh, basis, motion) = (ball_mesh(), basis(&ball_mesh()), motion(frame));
    let vertex = |i: usize| {
        let x: Point = std::array::from_fn(|k| {
            let moved: f64 = (0..3)
                .map(|j| FRAME_Q[frame][j] * basis.field(j)[i][k])
                .sum();
            mesh.positions[i][k] + moved
        });
        placed(x, motion.rotation, motion.translation, 1.0)
    };
    (0..mesh.positions.len()).map(vertex).collect()
}

fn deformed(folder: &Folder, frame: usize) -> Vec<Point> {
    let frame = frame.to_string();
    let ran = folder.run(&["deform", "moving.bdt", "--frame", &frame, "-o", "frame.npy"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    positions_of_npy(&folder.read("frame.npy"))
}

#[test]
fn deform_puts_the_rigid_motion_back() {
    let folder = moving();
    for frame in 0..3 {
        let found = deformed(&folder, frame);
        assert_eq!(found.len(), ball_mesh().positions.len());
        for (x, y) in found.iter().zip(shown(frame)) {
            // f32 of positions and fields of a few units.
            assert!(norm(sub(*x, y)) < 2e-6, "frame {frame}: {x:?} {y:?}");
        }
        // The same as q and the motion by hand, in f64.
        let q = FRAME_Q[frame].map(|q| q.to_string()).join(",");
        let motion = motion(frame);
        for (x, p) in found.iter().zip(folder.deformed("moving.bdt", &q)) {
            let y = placed(p, motion.rotation, motion.translation, 1.0);
            assert!(norm(sub(*x, y)) < 1e-13, "frame {frame}: {x:?} {y:?}");
        }
    }
    let obj = folder.run(&["deform", "moving.bdt", "--frame", "2"]);
    assert_eq!((obj.code, obj.err.as_str()), (0, ""));
    let lines = obj.out.lines().filter(|l| l.starts_with("v "));
    assert_eq!(lines.count(), ball_mesh().positions.len());
}

#[test]
fn frames_that_do_not_exist_are_refused() {
    let folder = moving();
    for (arguments, text) in [
        (
            ["moving.bdt", "--frame", "3"],
            "--frame: 3 is out of range: asset moving.bdt has 3 frames, numbered from 0\n",
        ),
        (
            ["moving.bdt", "--frame", "18446744073709551615"],
            "--frame: 18446744073709551615 is out of range: asset moving.bdt has 3 frames, \
             numbered from 0\n",
        ),
        (
            ["a.bdt", "--frame", "0"],
            "--frame: asset a.bdt has no animation\n",
        ),
    ] {
        let ran = folder.run(&[&["deform"], &arguments[..]].concat());
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{arguments:?}");
        assert_eq!(ran.err, text);
    }
    for frame in ["-1", "0.5", "last", "18446744073709551616"] {
        let ran = folder.run(&["deform", "moving.bdt", "--frame", frame]);
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{frame}");
    }
}

#[test]
fn info_describes_the_animation_and_the_error() {
    let folder = moving();
    let error = BasisError {
        max_rel: 0.0125,
        rms_rel: 0.002,
        frame: Some(2),
        vertex: 17,
    };
    let (mesh, basis) = (ball_mesh(), animated(&ball_mesh()));
    folder.write("error.bdt", baked_with_error(&mesh, &basis, Some(error)));
    let info = folder.json(&["info", "error.bdt", "--json"]);
    assert_eq!(info["frames"], 3);
    assert_eq!(info["duration_s"], 2.0);
    assert_eq!(info["highest_frequency_hz"], 12.5 / std::f64::consts::TAU);
    assert_eq!(
        info["basis_error_rel"],
        json!({"max": 0.0125, "rms": 0.002, "frame": 2, "vertex": 17})
    );
    assert_eq!(info["mode_info"][2]["default_q"], 0.75);
    assert_eq!(info["mode_info"][1]["default_q"], Value::Null);
    let ran = folder.run(&["info", "error.bdt"]);
    for text in [
        "animation    3 frames, 2 s\n",
        "basis error  at most 1.25 % of the diagonal (vertex 17 in frame 2), rms 0.2 %\n",
        "basis ends   at 1.98",
        "default q",
    ] {
        assert!(ran.out.contains(text), "{text}: {}", ran.out);
    }

    let mut untimed = basis.clone();
    untimed.animation.as_mut().expect("an animation").times_s = None;
    let fixed = BasisError {
        frame: None,
        ..error
    };
    folder.write(
        "untimed.bdt",
        baked_with_error(&mesh, &untimed, Some(fixed)),
    );
    let info = folder.json(&["info", "untimed.bdt", "--json"]);
    assert_eq!(
        (&info["frames"], &info["duration_s"]),
        (&json!(3), &Value::Null)
    );
    assert_eq!(info["basis_error_rel"]["frame"], Value::Null);
    let ran = folder.run(&["info", "untimed.bdt"]);
    for text in [
        "3 frames, times unknown\n",
        "at most 1.25 % of the diagonal (vertex 17), rms",
    ] {
        assert!(ran.out.contains(text), "{text}: {}", ran.out);
    }

    let info = folder.json(&["info", "rigid.bdt", "--json"]);
    for field in [
        "frames",
        "duration_s",
        "highest_frequency_hz",
        "basis_error_rel",
    ] {
        assert_eq!(info.get(field), Some(&Value::Null), "{field}");
    }
}

#[test]
fn diff_compares_frames() {
    let folder = moving();
    let (mesh, basis) = (ball_mesh(), animated(&ball_mesh()));
    let changed = |change: &dyn Fn(&mut bdtree_build::basis::Animation)| {
        let mut basis = basis.clone();
        change(basis.animation.as_mut().expect("an animation"));
        folder.write("b.bdt", baked(&mesh, &basis));
        |tolerance: &str| folder.run(&["diff", "moving.bdt", "b.bdt", "--tolerance-rel", tolerance])
    };
    for (change, text) in [
        (
            &(|a: &mut bdtree_build::basis::Animation| a.q[4] *= 1.0 + 1e-5)
                as &dyn Fn(&mut bdtree_build::basis::Animation),
            "section FRMQ: q of mode 1: 1 of 3 differ",
        ),
        (
            &|a| a.times_s.as_mut().expect("times")[1] += 1e-5,
            "section FRMS: times: 1 of 3 differ",
        ),
        (
            &|a| a.motions[1].rotation[1] = 1e-5,
            "section FRMS: rotations: 1 of 12 differ",
        ),
        (
            &|a| a.motions[0].translation[2] = 1e-5,
            "section FRMS: translations: 1 of 9 differ",
        ),
    ] {
        let diff = changed(change);
        let ran = diff("0");
        assert_eq!((ran.code, ran.err.as_str()), (1, ""), "{text}: {}", ran.out);
        assert!(ran.out.starts_with(text), "{text}: {}", ran.out);
        assert!(ran.out.contains("    frame "), "{}", ran.out);
        let ran = diff("1e-4");
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{text}: {}", ran.out);
    }
    for (change, text) in [
        (
            &(|a: &mut bdtree_build::basis::Animation| a.times_s = None)
                as &dyn Fn(&mut bdtree_build::basis::Animation),
            "section FRMS: times: known or not, frame 0 differs: 0.5 and unknown\n",
        ),
        (
            &|a| {
                a.frame_count = 2;
                a.q.truncate(6);
                a.motions.truncate(2);
                a.times_s.as_mut().expect("times").truncate(2);
            },
            "section FRMS: number of frames differs: 3 and 2\n",
        ),
    ] {
        let ran = changed(change)("10");
        assert_eq!(ran.code, 1, "{text}: {}", ran.out);
        assert!(ran.out.contains(text), "{text}: {}", ran.out);
    }
    let ran = folder.run(&["diff", "moving.bdt", "a.bdt"]);
    assert_eq!(ran.code, 1);
    assert!(ran.out.contains("section table "), "{}", ran.out);
}

#[test]
fn diff_compares_errors() {
    let folder = Folder::new();
    let (mesh, basis) = (ball_mesh(), basis(&ball_mesh()));
    let error = |max_rel, vertex| {
        Some(BasisError {
            max_rel,
            rms_rel: 0.5,
            frame: None,
            vertex,
        })
    };
    folder.write("a.bdt", baked_with_error(&mesh, &basis, error(1.0, 3)));
    for (other, tolerance, code, text) in [
        (
            error(1.0, 4),
            "0",
            1,
            "basis_error_rel: frame and vertex differ: vertex 3 and vertex 4",
        ),
        (
            error(1.0, 4),
            "1e-9",
            0,
            "place of the largest error of the basis (does not count): vertex 3 and vertex 4",
        ),
        (error(1.25, 3), "0.1", 1, "basis_error_rel: 1 of 2 differ"),
        (error(1.25, 3), "0.3", 0, "same: "),
        // Of the diagonal: two errors that are rounding are the same.
        (error(1.0 + 2e-6, 3), "1e-5", 0, "same: "),
        (None, "0.3", 1, "basis_error_rel differs: 1 and unknown"),
    ] {
        folder.write("b.bdt", baked_with_error(&mesh, &basis, other));
        let ran = folder.run(&["diff", "a.bdt", "b.bdt", "--tolerance-rel", tolerance]);
        assert_eq!((ran.code, ran.err.as_str()), (code, ""), "{}", ran.out);
        assert!(ran.out.contains(text), "{text}: {}", ran.out);
    }
}

/// What a scene's instance of a frame is asked equals brute force over the frame's mesh, placed.
#[test]
fn scenes_show_frames() {
    let folder = moving();
    let at = ([0.1, -0.2, 0.3, 0.9273618495495704], [-4.0, 3.0, 2.0], 1.5);
    for frame in 0..3 {
        let vertices: Vec<Point> = deformed(&folder, frame)
            .into_iter()
            .map(|x| placed(x, at.0, at.1, at.2))
            .collect();
        let triangles: Vec<_> = ball_mesh()
            .triangles
            .iter()
            .map(|t| t.map(|i| vertices[i as usize]))
            .collect();
        let point = [
            vertices[40][0] + 0.3,
            vertices[40][1],
            vertices[40][2] - 0.2,
        ];
        let scene = json!({
            "instances": [{"name": "a", "asset": "moving.bdt", "frame": frame,
                           "rotation": at.0, "translation": at.1, "scale": at.2}],
            "queries": [{"closest": {"instance": "a", "point": point}},
                        {"ball": {"instance": "a", "center": point, "radius": 0.7}}]});
        let lines = folder.query(&scene, &[]);
        let distances: Vec<f64> = triangles.iter().map(|t| point_distance(t, point)).collect();
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let found = lines[0]["distance"].as_f64().expect("a distance");
        assert!((found - nearest).abs() < 1e-10, "{found} {nearest}");
        let ids: Vec<usize> = serde_json::from_value(lines[1]["triangles"].clone()).expect("ids");
        assert!(!ids.is_empty());
        for (id, distance) in distances.iter().enumerate() {
            if (distance - 0.7).abs() > 1e-10 {
                assert_eq!(ids.contains(&id), *distance < 0.7, "{id}: {distance}");
            }
        }
    }
}

#[test]
fn scenes_with_bad_frames_are_refused() {
    let folder = moving();
    for (instance, expected) in [
        (
            json!({"frame": 1, "q": [0, 0, 0]}),
            "frame: an instance has either q or a frame",
        ),
        (
            json!({"frame": 1, "clip": "wave", "time": 0.5}),
            "frame: an instance has either a frame or a clip",
        ),
        (
            json!({"frame": 1, "joints": []}),
            "frame: an instance has either a frame or joints",
        ),
        (
            json!({"frame": 1, "time": 0.5}),
            "time: a time is that of a clip, which is missing",
        ),
        (
            json!({"frame": 3}),
            "frame: 3 is out of range: asset moving.bdt has 3 frames, numbered from 0",
        ),
        (json!({"frame": -1}), "frame: not a whole number from 0 on"),
        (json!({"frame": 0.5}), "frame: not a whole number from 0 on"),
        (
            json!({"frame": 1e300}),
            "frame: not a whole number from 0 on",
        ),
        (
            json!({"frame": "1"}),
            "frame: expected a number, found a string",
        ),
        (
            json!({"frame": 0, "asset": "a.bdt"}),
            "frame: asset a.bdt has no animation",
        ),
        (
            // The frame's translation of about 3, times 2^60, and the rest: beyond 2^80 together.
            json!({"frame": 2, "scale": 1e18, "translation": [1.2089258196146292e24, 0, 0]}),
            "frame: translation is not finite or beyond 2^80",
        ),
    ] {
        let mut whole = json!({"name": "a", "asset": "moving.bdt"});
        for (key, value) in instance.as_object().expect("an object") {
            whole[key] = value.clone();
        }
        let scene = json!({"instances": [whole], "queries": []});
        folder.write("scene.json", scene.to_string());
        let ran = folder.run(&["query", "scene.json"]);
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{instance}");
        assert_eq!(ran.err, format!("scene.json: instances[0].{expected}\n"));
    }
}

/// Frames under a checksum that fits, which nobody verified.
#[test]
fn broken_frames_are_an_error_not_a_panic() {
    let folder = moving();
    let info = folder.json(&["info", "moving.bdt", "--json"]);
    let sound = folder.read("moving.bdt");
    let scene =
        json!({"instances": [{"name": "a", "asset": "bad.bdt", "frame": 1}], "queries": []});
    folder.write("scene.json", scene.to_string());
    for kind in ["FRMS", "FRMQ"] {
        let sections = info["sections"].as_array().expect("sections");
        let section = sections.iter().find(|s| s["kind"] == kind).expect("it");
        let number = |field: &str| section[field].as_u64().expect("a number") as usize;
        let mut bytes = sound.clone();
        bytes[number("offset")..number("offset") + number("bytes")].fill(0x7e);
        folder.write("bad.bdt", bytes);
        let ran = folder.run(&["query", "scene.json", "--no-verify"]);
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{kind}");
        assert!(
            ran.err.starts_with("scene.json: instances[0].frame: "),
            "{}",
            ran.err
        );
        let ran = folder.run(&["deform", "bad.bdt", "--frame", "1", "--no-verify"]);
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{kind}");
        assert!(ran.err.starts_with("--frame: "), "{}", ran.err);
        assert_eq!(folder.run(&["info", "bad.bdt", "--json"]).code, 0);
        assert_eq!(folder.run(&["diff", "moving.bdt", "bad.bdt"]).code, 2);
        let ran = folder.run(&["verify", "bad.bdt"]);
        assert_eq!(ran.code, 1);
        assert!(
            ran.err.contains(&format!("section {kind} at byte ")),
            "{}",
            ran.err
        );
    }
}
