//! Every mistake beside the document's values is named with its place: numbers, containers, sizes.

use bdtree_fixtures::models::{self, gltf::Writer, gltf::pack};
use serde_json::json;

use crate::support::{edited, parts, read, rewritten};

#[test]
fn mistakes_in_the_numbers_are_named() {
    let position = "meshes[0].primitives[0].attributes.POSITION";
    let indices = "meshes[0].primitives[0].indices";
    let f = |x: f32| x.to_le_bytes().to_vec();
    let u = |x: u16| x.to_le_bytes().to_vec();
    for (file, problem) in [
        (rewritten(0, 12, &f(f32::NAN)), format!("{position}: vertex 1: [NaN, 0.0, -1.0] is not finite")),
        (rewritten(2, 4, &f(f32::INFINITY)), "meshes[0].primitives[0].targets[0].POSITION: vertex 0: [1.0, inf, 1.0] is not finite".into()),
        (rewritten(1, 2, &u(26)), format!("{indices}: index 1 is 26, but there are 26 vertices")),
        (rewritten(1, 4, &u(65535)), format!("{indices}: index 2 is 65535: glTF 2.0 has no primitive restart")),
        (rewritten(4, 4, &f(-1.0)), "animations[0].samplers[0].input: key 1 at -1 s: times are numbers of at least 0 that ascend".into()),
        (rewritten(4, 8, &f(0.25)), "animations[0].samplers[0].input: key 2 at 0.25 s: times are numbers of at least 0 that ascend".into()),
        (rewritten(4, 4, &f(f32::NAN)), "animations[0].samplers[0].input: key 1 at NaN s: times are numbers of at least 0 that ascend (and 1 more like it)".into()),
        (rewritten(5, 8, &f(f32::NAN)), "animations[0].samplers[0].output: value 2 is NaN".into()),
    ] {
        assert_eq!(read(&file).expect_err(&problem), format!("m: {problem}"));
    }
}

#[test]
fn sparse_indices_ascend_within_their_accessor() {
    let file = |replaced: &[u32]| {
        let mut file = Writer::default();
        let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let replaced: Vec<_> = replaced.iter().map(|i| (*i, [1.0; 3])).collect();
        let moves = file.sparse(3, None, &replaced);
        let primitive =
            json!({"attributes": {"POSITION": positions}, "targets": [{"POSITION": moves}]});
        file.add("meshes", json!({"primitives": [primitive]}));
        file.add("nodes", json!({"mesh": 0}));
        file.add("scenes", json!({"nodes": [0]}));
        read(&file.glb()).map(|model| model.morphs.targets[0].displacements.len())
    };
    let place = "m: meshes[0].primitives[0].targets[0].POSITION: accessors[1].sparse.indices";
    assert_eq!(file(&[0, 2]), Ok(2));
    assert_eq!(
        file(&[0, 3]),
        Err(format!(
            "{place}: index 1 is 3, but accessors[1] has 3 elements"
        ))
    );
    assert_eq!(
        file(&[2, 0]),
        Err(format!("{place}: index 1 is not above the one before it"))
    );
    assert_eq!(
        file(&[1, 1]),
        Err(format!("{place}: index 1 is not above the one before it"))
    );
}

#[test]
fn at_most_a_hundred_problems_are_listed() {
    let mut file = Writer::default();
    let positions = file.vectors(&vec![[f64::NAN, 0.0, 0.0]; 300]);
    file.add(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": positions}}]}),
    );
    file.add("nodes", json!({"mesh": 0}));
    file.add("scenes", json!({"nodes": [0]}));
    let (mut document, binary) = file.parts();
    document["accessors"][0]["min"] = json!([0, 0, 0]);
    document["accessors"][0]["max"] = json!([0, 0, 0]);
    let text = read(&pack(document.to_string().as_bytes(), &binary)).expect_err("NaN");
    assert_eq!(text.lines().count(), 2);
    assert!(text.contains("(and 99 problems like it, at "), "{text}");
    assert!(text.ends_with("\nm: 200 more problems"), "{text}");
}

#[test]
fn broken_fixtures_say_what_is_wrong() {
    for (name, problem) in [
        (
            "bad_gltf_truncated.glb",
            "m: GLB header: length 3576 at byte 8, but the file has 1788 bytes",
        ),
        // Validation by the crate panics here, after it has reported what is wrong.
        (
            "bad_gltf_accessor.glb",
            "m: meshes[0].primitives[0].attributes[\"POSITION\"]: refers to an element that the file does not have",
        ),
        (
            "bad_gltf_index.glb",
            "m: meshes[0].primitives[0].indices: accessors[1]: 4000 elements of 2 bytes, 2 apart from byte 0, end beyond bufferViews[1], which has 288 bytes",
        ),
        (
            "bad_gltf_cycle.glb",
            "m: nodes[0]: reached from scenes[0] and from nodes[2]; a node has one parent",
        ),
        (
            "bad_gltf_required.glb",
            "m: extensionsRequired[0]: KHR_draco_mesh_compression is not supported: export without mesh compression",
        ),
    ] {
        assert_eq!(read(&models::content(name)).expect_err(name), problem);
    }
}

#[test]
fn containers_are_checked() {
    for (bytes, problem) in [
        (&b""[..], "m: the file is empty"),
        (
            b"glTF\x02\0",
            "m: GLB header: truncated: 12 bytes make a header",
        ),
        (
            b"glTF\x01\0\0\0\x14\0\0\0aaaabbbb",
            "m: GLB header: version 1 at byte 4; 2 is read",
        ),
        (
            b"glTF\x02\0\0\0\x04\0\0\0aaaabbbb",
            "m: GLB header: length 4 at byte 8, but the file has 20 bytes",
        ),
        (
            b"glTF\x02\0\0\0\x14\0\0\0\x09\0\0\0JSON",
            "m: GLB chunks: JSON chunk length exceeds that of slice",
        ),
        (
            b"glTF\x02\0\0\0\x14\0\0\0\0\0\0\0BIN\0",
            "m: GLB chunks: was not expecting BIN\\0 chunk",
        ),
        (b"[1, 2]", "m: JSON: is not an object"),
        (
            b"{\"asset\":\n tru",
            "m: JSON: EOF while parsing a value at line 2 column 4",
        ),
    ] {
        assert_eq!(read(bytes).expect_err(problem), problem);
    }
    let (document, _) = parts();
    let text = read(document.to_string().as_bytes()).expect_err("no buffer");
    assert_eq!(
        text,
        "m: buffers[0]: has no uri, and the file has no binary chunk"
    );
}

/// Oddities that do not stop a bake.
#[test]
fn what_is_odd_but_kept_is_said() {
    for (edits, warning) in [
        (
            ("/nodes/0/rotation", json!([0, 3, 3, 0])),
            "m: nodes[0]: rotation of length 4.242640687119285 brought to length 1",
        ),
        (
            ("/nodes/2/scale", json!([3, 3, 3])),
            "m: nodes[2]: matrix is used; translation, rotation and scale beside it are not",
        ),
        (
            ("/nodes/2/matrix/15", json!(1.000001)),
            "m: nodes[2]: matrix: its last row is taken as 0, 0, 0, 1, which it nearly is",
        ),
        (
            ("/extensionsUsed", json!(["EXT_mesh_gpu_instancing"])),
            "m: extensionsUsed: EXT_mesh_gpu_instancing is ignored",
        ),
        (
            (
                "/animations/1/channels/0/target",
                json!({"path": "pointer"}),
            ),
            "m: animations[1]: ignored 1 channel without a node",
        ),
        (
            ("/animations/0/channels/1/target/node", json!(0)),
            "m: animations: ignored 1 channel for weights of nodes without morph targets",
        ),
    ] {
        let model = read(&edited(&[edits])).expect(warning);
        assert!(
            model.mesh.warnings.iter().any(|w| w == warning),
            "{warning}: {:?}",
            model.mesh.warnings
        );
        assert_eq!(model.mesh.positions.len(), 52);
    }
    // What a mesh looks like is not read: mistakes there stop nothing.
    let file = edited(&[
        (
            "/materials/0",
            json!({"name": "red", "normalTexture": {"scale": "wide"}}),
        ),
        ("/textures", json!("none")),
        ("/cameras", json!([{}])),
        ("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(77)),
        (
            "/extensionsRequired",
            json!(["KHR_texture_basisu", "KHR_materials_unlit"]),
        ),
    ]);
    assert_eq!(
        read(&file).expect("sound").mesh,
        read(&edited(&[])).expect("sound").mesh
    );
}

#[test]
fn a_short_file_cannot_ask_for_much() {
    // A thousand nodes of a mesh of a thousand primitives of the same ten thousand vertices.
    let mut file = Writer::default();
    let positions = file.vectors(&vec![[0.0; 3]; 9999]);
    let primitive = json!({"attributes": {"POSITION": positions}});
    file.add("meshes", json!({"primitives": vec![primitive; 1000]}));
    file.document
        .insert("nodes".into(), json!(vec![json!({"mesh": 0}); 1000]));
    file.add("scenes", json!({"nodes": (0..1000).collect::<Vec<_>>()}));
    let text = read(&file.glb()).expect_err("large");
    let expected = "m: 9999000000 vertices with every node's mesh written out; at most 134217728 are read\n\
                    m: 9999000000 triangles with every node's mesh written out; at most 134217728 are read";
    assert_eq!(text, expected);
    // Many targets that are one accessor, and many that are none.
    for (target, count, start) in [
        (
            json!({"POSITION": positions}),
            20_000,
            "m: 199980000 displacements of morph targets with",
        ),
        (json!({}), 70_000, "m: 70000 morph targets with"),
    ] {
        let primitive =
            json!({"attributes": {"POSITION": positions}, "targets": vec![target; count]});
        file.document
            .insert("meshes".into(), json!([{"primitives": [primitive]}]));
        file.document.insert("nodes".into(), json!([{"mesh": 0}]));
        file.document
            .insert("scenes".into(), json!([{"nodes": [0]}]));
        let text = read(&file.glb()).expect_err("large");
        assert!(text.starts_with(start), "{text}");
    }
}
