//! Skins: what is read of them and what is baked.

use bdtree_build::basis::dropped::Keep;
use bdtree_build::input::{Animated, KeyInterpolation, Local, RawSkin, gltf::read_gltf};
use bdtree_build::pipeline::bake;
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Morphs, Motion, Recipe};
use bdtree_build::skin::Weights;
use bdtree_fixtures::models::gltf::{Writer, component};
use bdtree_fixtures::{corpus, models};
use bdtree_runtime::Asset;
use serde_json::{Value, json};

use crate::skin_rows::{baked, checked};
use crate::support::read;

/// A right triangle whose corners two joints move; `change` edits the document before it is packed.
pub(crate) fn corner(change: impl FnOnce(&mut Writer, &mut Value)) -> Vec<u8> {
    let mut file = Writer::default();
    let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let joints = [[0.0, 1.0, 0.0, 0.0]; 3];
    let joints = file.numbers(
        "VEC4",
        component::UNSIGNED_BYTE,
        false,
        joints.as_flattened(),
        4,
    );
    let weights = [
        [1.0, 0.0, 0.0, 0.0],
        [0.5, 0.5, 0.0, 0.0],
        [0.25, 0.5, 0.25, 0.0],
    ];
    let weights = file.numbers("VEC4", component::FLOAT, false, weights.as_flattened(), 4);
    let mut document = json!({
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights},
        }]}],
        "nodes": [
            {"name": "skinned", "mesh": 0, "skin": 0, "translation": [7, 7, 7]},
            {"name": "root", "translation": [0, 0, 2], "children": [2, 3]},
            {"name": "a"},
            {"name": "b", "matrix": [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 1]},
        ],
        "scenes": [{"nodes": [0, 1]}],
        "skins": [{"joints": [3, 2]}],
    });
    change(&mut file, &mut document);
    let Value::Object(document) = document else {
        panic!("an object");
    };
    file.document = document;
    file.glb()
}

fn push(list: &mut Value, element: Value) {
    list.as_array_mut().expect("a list").push(element);
}

fn skin(bytes: &[u8]) -> RawSkin {
    read(bytes).expect("sound").skin.expect("a skin")
}

#[test]
fn a_skin_is_read_as_it_stands() {
    let model = read(&corner(|_, _| {})).expect("sound");
    // The node's own placement does not count.
    assert_eq!(model.mesh.positions[1], [1.0, 0.0, 0.0]);
    assert!(model.mesh.warnings.is_empty(), "{:?}", model.mesh.warnings);
    let skin = model.skin.expect("a skin");
    let names: Vec<&str> = skin
        .skeleton
        .iter()
        .map(|node| node.name.as_str())
        .collect();
    // Joints in the skin's order, parents before them.
    assert_eq!(names, ["root", "b", "a"]);
    assert_eq!(skin.joints, [1, 2]);
    assert_eq!(skin.skeleton[1].parent, Some(0));
    let sheared = [
        [1.0, 0.5, 0.0, 1.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, -1.0, 0.0],
    ];
    assert_eq!(skin.skeleton[1].local, Local::Matrix(sheared));
    // Without matrices they are the identity.
    assert_eq!(skin.bones[1].inverse_bind[2], [0.0, 0.0, 1.0, 0.0]);
    // One joint twice: the sum.
    assert_eq!(skin.influences.of(2), [(0, 0.5), (1, 0.5)]);
    assert_eq!(skin.influences.of(0), [(0, 1.0)]);
}

#[test]
fn a_joint_with_two_matrices_is_two_bones() {
    let bytes = corner(|file, document| {
        let mut other = vec![0.0; 32];
        for k in 0..4 {
            other[5 * k] = 1.0;
            other[16 + 5 * k] = 1.0;
        }
        other[12] = 3.0;
        let other = file.numbers("MAT4", component::FLOAT, false, &other, 16);
        push(
            &mut document["skins"],
            json!({"joints": [2, 3], "inverseBindMatrices": other}),
        );
        push(&mut document["nodes"], json!({"mesh": 0, "skin": 1}));
        document["scenes"][0]["nodes"] = json!([0, 1, 4]);
    });
    let skin = skin(&bytes);
    assert_eq!(skin.joints.len(), 2);
    let joints: Vec<u32> = skin.bones.iter().map(|bone| bone.joint).collect();
    // The second matrix of the second skin is the identity, like the first skin's.
    assert_eq!(joints, [0, 1, 1]);
    assert_eq!(skin.bones[2].inverse_bind[0], [1.0, 0.0, 0.0, 3.0]);
    assert_eq!(skin.influences.of(3), [(2, 1.0)]);
    assert_eq!(skin.influences.of(4), [(0, 0.5), (2, 0.5)]);
}

#[test]
fn meshes_without_a_skin_are_bones_of_their_nodes() {
    let bytes = corner(|_, document| {
        push(
            &mut document["nodes"],
            json!({"name": "hat", "mesh": 0, "translation": [0, 0, 1], "scale": [2, 2, 2]}),
        );
        push(
            &mut document["nodes"],
            json!({"name": "flat", "mesh": 0, "scale": [1, 1, 0]}),
        );
        document["nodes"][2]["children"] = json!([4, 5]);
    });
    let model = read(&bytes).expect("sound");
    let skin = model.skin.expect("a skin");
    let names: Vec<&str> = skin
        .joints
        .iter()
        .map(|&n| skin.skeleton[n as usize].name.as_str())
        .collect();
    assert_eq!(names, ["b", "a", "hat", "flat"]);
    // Where it stands at rest, and what undoes that.
    assert_eq!(model.mesh.positions[4], [2.0, 0.0, 3.0]);
    assert_eq!(
        skin.bones[2].inverse_bind,
        [
            [0.5, 0.0, 0.0, 0.0],
            [0.0, 0.5, 0.0, 0.0],
            [0.0, 0.0, 0.5, -1.5]
        ]
    );
    assert_eq!(skin.influences.of(4), [(2, 1.0)]);
    // What cannot be undone stays in its own coordinates.
    assert_eq!(model.mesh.positions[7], [1.0, 0.0, 0.0]);
    assert_eq!(skin.bones[3].inverse_bind[2], [0.0, 0.0, 1.0, 0.0]);
}

#[test]
fn a_mesh_below_an_animated_node_is_a_bone_and_others_are_as_ever() {
    let still = |file: &mut Writer, document: &mut Value| {
        document.as_object_mut().expect("an object").remove("skins");
        document["nodes"][0] = json!({"name": "still", "translation": [7, 7, 7]});
        document["nodes"][2]["mesh"] = json!(0);
        let times = file.scalars(&[0.0, 1.0]);
        let moves = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0]]);
        document["animations"] = json!([{
            "samplers": [{"input": times, "output": moves}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        }]);
    };
    let model = read(&corner(still)).expect("sound");
    assert!(model.skin.is_none());
    let model = read(&corner(|file, document| {
        still(file, document);
        document["animations"][0]["channels"][0]["target"]["node"] = json!(1);
    }))
    .expect("sound");
    let skin = model.skin.expect("a skin");
    assert_eq!((skin.joints.len(), skin.skeleton.len()), (1, 2));
    assert_eq!(skin.clips.len(), 1);
    assert_eq!(skin.clips[0].channels[0].animated, Animated::Translation(0));
    // A node with a matrix cannot move.
    let model = read(&corner(|file, document| {
        still(file, document);
        document["nodes"][1] =
            json!({"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 2, 1], "children": [2, 3]});
        document["animations"][0]["channels"][0]["target"]["node"] = json!(1);
    }));
    assert!(model.expect("sound").skin.is_none());
}

#[test]
fn clips_have_the_keys_of_the_file() {
    let skin = read_gltf(&models::path("skinned_tube.glb"), None)
        .expect("sound")
        .skin
        .expect("a skin");
    let names: Vec<&str> = skin.clips.iter().map(|clip| clip.name.as_str()).collect();
    assert_eq!(names, ["wave", "slide", "animation 2"]);
    let wave = &skin.clips[0].channels;
    assert_eq!(wave[0].times_s, [0.0, 0.5, 1.5]);
    assert_eq!(wave[0].interpolation, KeyInterpolation::Linear);
    // Whole numbers are shares of 32767.
    assert_eq!(wave[1].values[3], 1.0);
    // The mesh's default weight, which the clip does not move.
    assert_eq!(wave[2].animated, Animated::Fields { first: 0, count: 1 });
    assert_eq!(
        (&wave[2].times_s[..], &wave[2].values[..]),
        (&[0.0_f32][..], &[0.25_f32][..])
    );
    let slide = &skin.clips[1].channels;
    assert_eq!(slide[0].interpolation, KeyInterpolation::Cubic);
    assert_eq!(slide[0].values[6..9], [0.0, 2.0, 0.0]);
    assert_eq!(slide[1].animated, Animated::Fields { first: 0, count: 1 });
    assert_eq!(slide[1].values.len(), 9);
    assert_eq!(
        skin.clips[2].channels[0].interpolation,
        KeyInterpolation::Step
    );
}

#[test]
fn fixtures_bake_and_hold_their_bounds() {
    let tube = baked(&models::path("skinned_tube.gltf"));
    let report = &tube.report;
    let counts = (
        report.joints,
        report.bones,
        report.influences_max,
        report.clips,
    );
    assert_eq!(counts, (Some(4), Some(4), Some(4), Some(3)));
    assert_eq!((report.modes, report.frames), (1, None));
    let model = checked(&tube);
    assert_eq!(model.asset().bone_count(), 4);
    let twelve = baked(&models::path("skinned_12.glb"));
    let report = &twelve.report;
    assert_eq!(
        (report.joints, report.influences_max, report.clips),
        (Some(12), Some(12), Some(0))
    );
    checked(&twelve);
}

/// Bytes do not depend on threads.
#[test]
fn weights_as_stored_and_threads() {
    let path = models::path("skinned_12.glb");
    let mut recipe = Recipe::of_surface(path, Motion::Rigid);
    recipe.settings.weights = Weights::AsStored;
    let one = bake(&recipe, &Silent).expect("bakes");
    let model = checked(&one);
    assert!(model.asset().skin_record().expect("a skin").weight_defect > 0.1);
    recipe.settings.threads = 3;
    assert_eq!(one.bytes, bake(&recipe, &Silent).expect("bakes").bytes);
    recipe.settings.weights = Weights::Normalise;
    let model = checked(&bake(&recipe, &Silent).expect("bakes"));
    assert!(model.asset().skin_record().expect("a skin").weight_defect < 1e-7);
}

#[test]
fn clips_follow_the_targets_that_are_kept() {
    let bytes = corner(|file, document| {
        let fields: Vec<usize> = (1..4)
            .map(|k| file.vectors(&[[f64::from(k), 0.0, 0.0]; 3]))
            .collect();
        let targets: Vec<Value> = fields.iter().map(|f| json!({"POSITION": f})).collect();
        document["meshes"][0]["primitives"][0]["targets"] = json!(targets);
        let times = file.scalars(&[0.0, 1.0]);
        let weights = file.scalars(&[0.0, 0.25, 0.5, 1.0, 1.25, -3.0]);
        document["animations"] = json!([{
            "samplers": [{"input": times, "output": weights}],
            "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
        }]);
    });
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.glb");
    std::fs::write(&path, bytes).expect("written");
    let keep = |keep: Keep| {
        let morphs = Morphs {
            keep,
            ..Morphs::default()
        };
        let baked =
            bake(&Recipe::of_surface(&path, Motion::Morphs(morphs)), &Silent).expect("bakes");
        (baked.report.modes, baked.report.clips)
    };
    assert_eq!(keep(Keep::All), (3, Some(1)));
    assert_eq!(keep(Keep::First(2)), (2, Some(1)));
    // Nothing is left to move.
    assert_eq!(keep(Keep::First(0)), (0, Some(0)));
}

#[test]
fn the_character_for_measuring_is_as_large_as_it_says() {
    let model = read(&models::gltf::character(250, 40)).expect("sound");
    assert_eq!(model.mesh.triangles.len(), 100_000);
    let skin = model.skin.expect("a skin");
    assert_eq!(
        (skin.bones.len(), skin.joints.len(), skin.skeleton.len()),
        (60, 60, 60)
    );
    assert_eq!(skin.clips[0].channels.len(), 60);
    assert!((0..skin.influences.vertex_count()).all(|i| skin.influences.of(i).len() == 4));
}

#[test]
fn characters_bake_with_their_bones() {
    let test = "gltf_characters_bake_with_their_bones";
    let Some(folder) = corpus::path(test, "characters") else {
        return;
    };
    for (name, joints, clips, modes) in [
        ("RiggedSimple.glb", 4, 1, 0),
        ("Fox.glb", 24, 3, 0),
        ("CesiumMan.glb", 19, 1, 0),
        ("RobotExpressive.glb", 58, 14, 9),
    ] {
        let made = baked(&folder.join(name));
        let report = &made.report;
        println!(
            "{name}: {:?} {:?} {:?}",
            report.joints, report.bones, report.influences_max
        );
        println!("{name}: {:?}", report.warnings);
        assert_eq!(report.joints, Some(joints), "{name}");
        assert_eq!((report.clips, report.modes), (Some(clips), modes), "{name}");
        Asset::open(checked(&made).asset().bytes()).expect("opens");
    }
}
