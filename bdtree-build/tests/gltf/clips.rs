//! Weights over time.

use std::path::Path;

use super::twin::{File, Sampler};
use bdtree_build::input::{RawClip, gltf};
use bdtree_fixtures::models::{self, gltf::Writer, gltf::component};
use serde_json::json;

use crate::support::{edited, read};

fn clip(name: Option<&str>) -> Result<RawClip, String> {
    let bytes = models::content("morph_nodes.glb");
    let model = gltf::parse(&bytes, "m", Path::new(""), name).map_err(|e| e.to_string())?;
    Ok(model.morphs.clip.expect("a clip"))
}

#[test]
fn keys_become_frames_and_steps_jump() {
    let clip = clip(None).expect("sound");
    assert_eq!(clip.name, "talk");
    assert_eq!(clip.times_s, [0.0, 0.5, 1.0, 1.0, 2.0]);
    // Left: linear from key to key; right: one step at 1 s.
    let third = 1.0 / 3.0;
    let expected = [
        [0.0, 0.0, 0.0, 1.0],
        [1.0, -0.5, 0.0, 1.0],
        [1.0 - 0.75 * third, -0.5 + 2.0 * third, 0.0, 1.0],
        [1.0 - 0.75 * third, -0.5 + 2.0 * third, 0.75, 0.0],
        [0.25, 1.5, 0.75, 0.0],
    ];
    for (found, wanted) in clip.weights.iter().zip(expected.as_flattened()) {
        assert!((found - wanted).abs() <= 1e-15, "{found} {wanted}");
    }
    // Keys exactly as the file has them.
    assert_eq!(clip.weights[4..6], [1.0, -0.5]);
    assert_eq!(clip.weights[16..20], [0.25, 1.5, 0.75, 0.0]);
}

/// The weight of target `k` of a sampler at time `t`, straight from appendix C of glTF 2.0.
fn spline(sampler: &Sampler, width: usize, k: usize, t: f64) -> f64 {
    let key = sampler.times.iter().rposition(|x| *x <= t).unwrap_or(0);
    let value = |key: usize, which: usize| sampler.values[(3 * key + which) * width + k];
    let Some(next) = sampler.times.get(key + 1) else {
        return value(key, 1);
    };
    let td = next - sampler.times[key];
    let s = (t - sampler.times[key]) / td;
    let [s2, s3] = [s.powi(2), s.powi(3)];
    (2.0 * s3 - 3.0 * s2 + 1.0) * value(key, 1)
        + td * (s3 - 2.0 * s2 + s) * value(key, 2)
        + (-2.0 * s3 + 3.0 * s2) * value(key + 1, 1)
        + td * (s3 - s2) * value(key + 1, 0)
}

#[test]
fn splines_are_followed_within_a_thousandth() {
    let clip = clip(Some("blink")).expect("sound");
    let file = File::open(&models::path("morph_nodes.glb"));
    let samplers = file.samplers(1, &file.scene());
    let [sampler] = samplers.as_slice() else {
        panic!("{samplers:?}");
    };
    assert!(clip.times_s.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(clip.times_s.len() < 100, "{}", clip.times_s.len());
    for (key, t) in sampler.times.iter().enumerate() {
        let frame = clip
            .times_s
            .iter()
            .position(|x| x == t)
            .expect("a frame per key");
        let row = &clip.weights[4 * frame..4 * frame + 4];
        assert_eq!(row[..2], sampler.values[6 * key + 2..6 * key + 4]);
        // The other node keeps its own weights.
        assert_eq!(row[2..], [0.0, 0.5]);
    }
    let mut worst = 0.0_f64;
    for i in 0..=4000 {
        let t = 2.0 * f64::from(i) / 4000.0;
        let next = clip
            .times_s
            .partition_point(|x| *x <= t)
            .clamp(1, clip.times_s.len() - 1);
        let (from, to) = (clip.times_s[next - 1], clip.times_s[next]);
        let u = (t - from) / (to - from);
        for k in 0..2 {
            let linear =
                clip.weights[4 * (next - 1) + k] * (1.0 - u) + clip.weights[4 * next + k] * u;
            worst = worst.max((linear - spline(sampler, 2, k, t)).abs());
        }
    }
    assert!(worst < 1e-3 && worst > 1e-4, "{worst}");
}

#[test]
fn clips_are_chosen_by_name() {
    assert_eq!(clip(Some("talk")), clip(None));
    assert_eq!(
        clip(Some("walk")),
        Err("m: animations: no animation called \"walk\" moves weights; these do: \"talk\", \"blink\"".into())
    );
    let none = gltf::parse(
        &models::content("strips_fans.glb"),
        "m",
        Path::new(""),
        Some("walk"),
    );
    assert_eq!(
        none.expect_err("no clip").to_string(),
        "m: animations: no animation called \"walk\" moves weights; none does"
    );
    let unnamed = edited(&[("/animations/0/name", json!(null))]);
    let model = gltf::parse(&unnamed, "m", Path::new(""), Some("animation 0")).expect("sound");
    assert_eq!(model.morphs.clip.expect("a clip").name, "animation 0");
}

/// A triangle with one target and one animation of weights.
fn animated(
    times: &[f64],
    output: impl FnOnce(&mut Writer) -> usize,
    interpolation: &str,
) -> Vec<u8> {
    let mut file = Writer::default();
    let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let primitive =
        json!({"attributes": {"POSITION": positions}, "targets": [{"POSITION": positions}]});
    file.add("meshes", json!({"primitives": [primitive]}));
    file.add("nodes", json!({"mesh": 0}));
    file.add("scenes", json!({"nodes": [0]}));
    let (input, output) = (file.scalars(times), output(&mut file));
    file.add(
        "animations",
        json!({
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
        }),
    );
    file.glb()
}

#[test]
fn keys_at_one_time_jump() {
    let file = animated(
        &[1.0, 2.0, 2.0, 3.0],
        |f| f.scalars(&[0.0, 1.0, 0.5, 0.0]),
        "LINEAR",
    );
    let model = read(&file).expect("sound");
    let clip = model.morphs.clip.expect("a clip");
    assert_eq!(clip.times_s, [1.0, 2.0, 2.0, 3.0]);
    assert_eq!(clip.weights, [0.0, 1.0, 0.5, 0.0]);
    let warning =
        "m: animations[0].samplers[0].input: 1 keys have the time of the key before them: jumps";
    assert_eq!(model.mesh.warnings, [warning]);
}

#[test]
fn integer_weights_are_shares_of_their_largest() {
    let output = |kind: u32, bytes: Vec<u8>| {
        move |file: &mut Writer| {
            let view = file.view(bytes);
            file.accessor(json!({
                "bufferView": view, "componentType": kind, "normalized": true, "count": 3,
                "type": "SCALAR",
            }))
        }
    };
    for (kind, bytes, expected) in [
        (component::BYTE, vec![0, 127, 0x80], [0.0, 1.0, -1.0]),
        (component::UNSIGNED_BYTE, vec![0, 255, 51], [0.0, 1.0, 0.2]),
        (
            component::SHORT,
            vec![0, 0, 0xff, 0x7f, 0, 0x80],
            [0.0, 1.0, -1.0],
        ),
        (
            component::UNSIGNED_SHORT,
            vec![0, 0, 0xff, 0xff, 0x33, 0x33],
            [0.0, 1.0, 0.2],
        ),
    ] {
        let file = animated(&[0.0, 1.0, 2.0], output(kind, bytes), "LINEAR");
        let clip = read(&file).expect("sound").morphs.clip.expect("a clip");
        assert_eq!(clip.weights, expected, "{kind}");
    }
}

#[test]
fn splines_that_bend_too_fast_are_said_so() {
    let file = animated(
        &[0.0, 1.0],
        |f| f.scalars(&[0.0, 0.0, 1e6, 0.0, 1.0, 0.0]),
        "CUBICSPLINE",
    );
    let model = read(&file).expect("sound");
    let clip = model.morphs.clip.expect("a clip");
    assert_eq!(clip.times_s.len(), 257);
    let [warning] = model.mesh.warnings.as_slice() else {
        panic!("{:?}", model.mesh.warnings);
    };
    let start = "m: animations[0]: bends so fast that weights between frames are off by up to ";
    let off: f64 = warning
        .strip_prefix(start)
        .expect(warning)
        .parse()
        .expect("a number");
    // |p''| ≤ 4e6: 4e6 / (8 · 256²).
    assert!((off - 4e6 / 8.0 / 65536.0).abs() < 1e-3 * off, "{off}");
}
