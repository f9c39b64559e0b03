//! What is wrong with a skin: one message for each kind, with its JSON path and vertex.

use bdtree_build::pipeline::bake;
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Motion, Recipe};
use bdtree_build::skin::Weights;
use bdtree_fixtures::models::gltf::{Writer, component};
use serde_json::{Value, json};

use crate::skins::corner;
use crate::support::read;

/// The problems of the changed file.
fn told(change: impl FnOnce(&mut Writer, &mut Value)) -> String {
    read(&corner(change)).map(|_| ()).expect_err("a problem")
}

/// The file with other weights.
fn weighted(weights: [[f64; 4]; 3]) -> Vec<u8> {
    corner(|file, document| {
        let weights = file.numbers("VEC4", component::FLOAT, false, weights.as_flattened(), 4);
        document["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    })
}

#[test]
fn mistakes_are_told_with_their_place() {
    let attributes = "/meshes/0/primitives/0/attributes";
    let edit = |pointer: String, value: Value| {
        move |_: &mut Writer, document: &mut Value| {
            let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
            let parent = document.pointer_mut(parent).expect("there");
            match parent {
                Value::Object(fields) if value.is_null() => {
                    fields.remove(key);
                }
                _ => parent[key] = value,
            }
        }
    };
    let cases = [
        (
            format!("{attributes}/JOINTS_0"),
            Value::Null,
            "m: meshes[0].primitives[0].attributes: has WEIGHTS_0 but no JOINTS_0",
        ),
        (
            format!("{attributes}/WEIGHTS_0"),
            Value::Null,
            "m: meshes[0].primitives[0].attributes: has JOINTS_0 but no WEIGHTS_0",
        ),
        (
            format!("{attributes}/WEIGHTS_0"),
            json!(1),
            "componentType 5121 (UNSIGNED_BYTE) is not FLOAT or normalized",
        ),
        (
            format!("{attributes}/JOINTS_0"),
            json!(0),
            "accessors[0] is not of type VEC4",
        ),
        (
            "/nodes/0/skin".into(),
            json!(4),
            "m: skins[4]: there is no such element",
        ),
        (
            "/skins".into(),
            json!([{"joints": []}]),
            "m: skins[0].joints: has no joints",
        ),
        (
            "/skins".into(),
            json!([{"joints": [2, 9]}]),
            "m: skins[0].joints[1]: there is no nodes[9]",
        ),
        (
            "/skins".into(),
            json!([{"joints": [2]}]),
            "m: meshes[0].primitives[0].attributes: vertex 1: joint 1, but skins[0] has 1 joints (and 1 more like it)",
        ),
        (
            "/skins".into(),
            json!([{"joints": [2, 3], "inverseBindMatrices": 0}]),
            "skins[0].inverseBindMatrices: accessors[0] is not of type MAT4",
        ),
        (
            "/skins".into(),
            json!([{"joints": "all"}]),
            "m: skins[0]: invalid type",
        ),
    ];
    for (pointer, value, expected) in cases {
        let text = told(edit(pointer.clone(), value));
        assert!(text.contains(expected), "{pointer}: {text}");
        assert_eq!(text.lines().count(), 1, "{text}");
    }
}

#[test]
fn joints_outside_of_the_scene_may_not_go_round() {
    let text = told(|_, document| {
        document["scenes"][0]["nodes"] = json!([0]);
        document["nodes"][2]["children"] = json!([1]);
    });
    assert!(text.contains("is a node below itself"), "{text}");
    let text = told(|_, document| {
        document["scenes"][0]["nodes"] = json!([0]);
        document["nodes"][3]["children"] = json!([2]);
    });
    assert!(text.contains("a node has one parent"), "{text}");
}

#[test]
fn weights_that_are_none_are_told_once_for_all_vertices() {
    let text = read(&weighted([[-0.5, 1.0, 0.0, 0.0]; 3]))
        .map(|_| ())
        .expect_err("a problem");
    assert_eq!(
        text,
        "m: meshes[0].primitives[0].attributes: vertex 0: weight -0.5 of joint 0 is not a number of at least 0 \
         (and 2 more like it)"
    );
    let text = read(&weighted([[f64::NAN, 1.0, 0.0, 0.0]; 3]))
        .map(|_| ())
        .expect_err("a problem");
    assert!(text.contains("weight NaN"), "{text}");
    let baked = |weights: [[f64; 4]; 3], how: Weights| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.glb");
        std::fs::write(&path, weighted(weights)).expect("written");
        let mut recipe = Recipe::of_surface(path, Motion::Rigid);
        recipe.settings.weights = how;
        bake(&recipe, &Silent).map_err(|e| e.to_string())
    };
    let none = [[1.0, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]];
    let text = baked(none, Weights::Normalise).expect_err("zeros");
    assert!(
        text.contains("a.glb: meshes[0].primitives[0].attributes, vertex 1: all weights are zero"),
        "{text}"
    );
    assert!(text.ends_with("(and 1 vertex like it)"), "{text}");
    // A vertex that nothing carries.
    crate::skin_rows::checked(&baked(none, Weights::AsStored).expect("bakes"));
    crate::skin_rows::checked(&baked([[0.0; 4]; 3], Weights::AsStored).expect("bakes"));
    let text = baked([[1.5, 1.0, 0.0, 0.0]; 3], Weights::AsStored).expect_err("too much");
    assert!(
        text.contains("vertex 0: the sum of its weights is beyond 2"),
        "{text}"
    );
    baked([[1.5, 1.0, 0.0, 0.0]; 3], Weights::Normalise).expect("bakes");
}

#[test]
fn keys_that_are_none_are_refused() {
    let told = |times: &[f64], turns: &[f64], interpolation: &str, twice: bool| {
        read(&corner(|file, document| {
            let times = file.scalars(times);
            let turns = file.numbers("VEC4", component::FLOAT, false, turns, 4);
            let channel = json!({"sampler": 0, "target": {"node": 2, "path": "rotation"}});
            document["animations"] = json!([{
                "samplers": [{"input": times, "output": turns, "interpolation": interpolation}],
                "channels": if twice { json!([channel, channel]) } else { json!([channel]) },
            }]);
        }))
    };
    let still = [0.0, 0.0, 0.0, 1.0];
    let two = [still, still].concat();
    assert!(told(&[0.0, 1.0], &two, "LINEAR", false).is_ok());
    for (times, turns, interpolation, twice, expected) in [
        (
            &[0.0, 1.0][..],
            still.to_vec(),
            "LINEAR",
            false,
            "samplers[0].output: 4 numbers for 2 keys of 4",
        ),
        (
            &[0.0, 1.0],
            two.clone(),
            "CUBICSPLINE",
            false,
            "8 numbers for 2 keys of 12",
        ),
        (
            &[1.0, 0.0],
            two.clone(),
            "LINEAR",
            false,
            "samplers[0].input: key 1 at 0 s",
        ),
        (
            &[0.0, 1.0],
            vec![0.0; 8],
            "STEP",
            false,
            "the rotation of key 0 is zero",
        ),
        (
            &[0.0, 1.0],
            [&[f64::NAN; 4], &still[..]].concat(),
            "STEP",
            false,
            "number 0 is NaN",
        ),
        (
            &[0.0, 1.0],
            two.clone(),
            "LINEAR",
            true,
            "channels[1]: moves what another channel",
        ),
    ] {
        let text = told(times, &turns, interpolation, twice)
            .map(|_| ())
            .expect_err(expected);
        assert!(text.contains(expected), "{expected}: {text}");
    }
    // A jump: the key before it moves to the number below.
    let four = [still; 4].concat();
    let skin = told(&[0.0, 1.0, 1.0, 2.0], &four, "LINEAR", false)
        .expect("sound")
        .skin
        .expect("a skin");
    let times = &skin.clips[0].channels[0].times_s;
    assert_eq!(times.as_slice(), [0.0, 1.0_f32.next_down(), 1.0, 2.0]);
}
