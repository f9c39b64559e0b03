//! What is read of sound files.

use super::twin::File;
use bdtree_build::input::gltf::read_gltf;
use bdtree_build::input::{GroupKind, RawGroup, read_mesh};
use bdtree_fixtures::models::{self, gltf::Writer, gltf::component};
use serde_json::json;

use crate::support::{edited, read};

/// `a` and `b` differ by less than roundings of numbers of about 10.
fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|k| (a[k] - b[k]).abs() <= 1e-14)
}

#[test]
fn nodes_place_meshes_and_their_targets() {
    let path = models::path("morph_nodes.glb");
    let model = read_gltf(&path, None).expect("sound");
    let twin = File::open(&path).scene();
    assert_eq!(model.mesh.name, "morph_nodes.glb");
    assert_eq!(model.mesh.triangles, twin.triangles);
    assert_eq!(model.mesh.positions.len(), 52);
    for (a, b) in model.mesh.positions.iter().zip(&twin.positions) {
        assert!(close(*a, *b), "{a:?} {b:?}");
    }
    let names: Vec<_> = model
        .morphs
        .targets
        .iter()
        .filter_map(|t| t.name.clone())
        .collect();
    assert_eq!(
        names,
        ["left/taper", "left/pull", "right/taper", "right/pull"]
    );
    // The second node has weights of its own, the first those of the mesh.
    let weights: Vec<f64> = model
        .morphs
        .targets
        .iter()
        .map(|t| t.default_weight)
        .collect();
    assert_eq!(weights, [0.25, 0.0, 0.0, 0.5]);
    for (j, target) in model.morphs.targets.iter().enumerate() {
        let mut dense = vec![[0.0; 3]; 52];
        for &(i, u) in &target.displacements {
            assert_ne!(u, [0.0; 3], "target {j}");
            dense[i as usize] = u;
        }
        assert!(
            dense
                .iter()
                .zip(&twin.fields[j])
                .all(|(a, b)| close(*a, *b)),
            "target {j}"
        );
    }
    // The corner (1, 1, 1) of the mirrored cube: scaled by 2, y and z swapped, x turned.
    let (_, u) = model.morphs.targets[3].displacements[0];
    assert!(close(u, [1.0, 0.25, 0.5]), "{u:?}");

    let group = |kind, name: &str, first_triangle, triangle_count| RawGroup {
        kind,
        name: name.into(),
        first_triangle,
        triangle_count,
    };
    let primitive = "meshes[0].primitives[0]";
    let expected = [
        group(GroupKind::Object, "left", 0, 48),
        group(GroupKind::Group, primitive, 0, 48),
        group(GroupKind::Material, "red", 0, 48),
        group(GroupKind::Object, "right", 48, 48),
        group(GroupKind::Group, primitive, 48, 48),
        group(GroupKind::Material, "red", 48, 48),
    ];
    assert_eq!(model.mesh.groups, expected);
    // Warnings go into the file, which names no folders.
    let place = "morph_nodes.glb";
    let expected = [
        format!(
            "{place}: animations: ignored 1 channel of 1 animation that moves nodes, not weights"
        ),
        format!(
            "{place}: 2 animations move weights; \"talk\", the first, is stored. Choose another with --clip NAME: \
             \"blink\""
        ),
    ];
    assert_eq!(model.mesh.warnings, expected);
    assert_eq!(read_mesh(&path).expect("sound"), model.mesh);
}

#[test]
fn text_and_binary_say_the_same() {
    let [mut text, mut binary] = ["morph_nodes.gltf", "morph_nodes.glb"].map(|name| {
        let bytes = models::content(name);
        read(&bytes).expect("sound")
    });
    assert_eq!(text, binary);
    for name in ["morph_nodes.gltf", "morph_nodes.glb"] {
        let mesh = read_mesh(&models::path(name)).expect("sound");
        assert_ne!(mesh.hash, [0; 32]);
    }
    // A byte order mark is no JSON.
    let marked = [
        b"\xef\xbb\xbf",
        models::content("morph_nodes.gltf").as_slice(),
    ]
    .concat();
    text = read(&marked).expect("sound");
    assert_eq!(
        text.mesh.warnings.remove(0),
        "m: ignored the byte order mark, which JSON does not have"
    );
    // Bytes after the end are no part of a GLB file.
    let longer = [models::content("morph_nodes.glb"), vec![7; 9]].concat();
    binary = read(&longer).expect("sound");
    assert_eq!(
        binary.mesh.warnings.remove(0),
        "m: GLB header: ignored 9 bytes after its end"
    );
    assert_eq!(text, binary);
}

#[test]
fn strips_and_fans_become_triangles() {
    let model = read(&models::content("strips_fans.glb")).expect("sound");
    let expected = [
        [0, 1, 2],
        [1, 3, 2],
        [2, 3, 4],
        // The strip 0 2 1 3 of the same five vertices again.
        [5, 7, 6],
        [7, 8, 6],
        // Fans end in their first corner.
        [11, 12, 10],
        [12, 13, 10],
        [15, 16, 14],
        [16, 17, 14],
        [18, 19, 20],
        [21, 22, 23],
        [21, 23, 23],
    ];
    assert_eq!(model.mesh.triangles, expected);
    assert_eq!(model.mesh.positions.len(), 24);
    assert!(model.morphs.targets.is_empty() && model.morphs.clip.is_none());
    let expected = [
        "m: meshes[0].primitives[6]: triangle 11 repeats a corner (kept)",
        "m: ignored primitives that are not triangles: 1 of points, 1 of lines",
    ];
    assert_eq!(model.mesh.warnings, expected);
    // Fans face like their polygon, strips all one way: towards +z.
    for corners in &model.mesh.triangles[..11] {
        let [a, b, c] = corners.map(|i| model.mesh.positions[i as usize]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let id = model.mesh.triangles.iter().position(|t| t == corners);
        let faces_up = !matches!(id, Some(0..=2));
        assert_eq!(area > 0.0, faces_up, "{id:?}");
    }
}

#[test]
fn without_a_scene_every_mesh_stands_for_itself() {
    let file = edited(&[("/scenes", json!(null)), ("/scene", json!(null))]);
    let model = read(&file).expect("sound");
    assert_eq!(model.mesh.positions.len(), 26);
    assert!(
        model
            .mesh
            .positions
            .iter()
            .flatten()
            .all(|x| x.abs() <= 1.0)
    );
    assert_eq!(model.morphs.targets.len(), 2);
    assert_eq!(model.morphs.targets[0].name.as_deref(), Some("taper"));
    assert_eq!(model.morphs.targets[0].default_weight, 0.25);
    assert!(model.morphs.clip.is_none());
    assert_eq!(
        model.mesh.warnings[0],
        "m: no scene: every mesh is read in its own coordinates, no node is"
    );
    // The default scene is the named one, else the first.
    let two = json!([{"nodes": [0]}, {"nodes": [1]}]);
    let first = read(&edited(&[
        ("/scenes", two.clone()),
        ("/scene", json!(null)),
    ]))
    .expect("sound");
    let second = read(&edited(&[("/scenes", two), ("/scene", json!(1))])).expect("sound");
    assert_eq!(
        (first.mesh.positions.len(), second.mesh.positions.len()),
        (52, 26)
    );
    // glTF 2.0 lets a scene have no nodes.
    let empty = edited(&[("/scenes/0", json!({}))]);
    assert_eq!(read(&empty).expect_err("empty"), "m: no triangles");
}

#[test]
fn integer_positions_are_read_where_their_extension_is_named() {
    let mut file = Writer::default();
    let view = file.view([0, 0, 0, 127, 0, 0, 0, 0x81, 0]);
    let positions = file.accessor(json!({
        "bufferView": view, "componentType": component::BYTE, "normalized": true, "count": 3,
        "type": "VEC3", "min": [0, -127, 0], "max": [127, 0, 0],
    }));
    let view = file.view(
        [1_u16, 2, 3, 4, 5, 6, 7, 8, 65535]
            .iter()
            .flat_map(|x| x.to_le_bytes()),
    );
    let moves = file.accessor(json!({
        "bufferView": view, "componentType": component::UNSIGNED_SHORT, "count": 3, "type": "VEC3",
    }));
    let primitive =
        json!({"attributes": {"POSITION": positions}, "targets": [{"POSITION": moves}]});
    file.add("meshes", json!({"primitives": [primitive]}));
    file.add("nodes", json!({"mesh": 0}));
    file.add("scenes", json!({"nodes": [0]}));
    let text = read(&file.glb()).expect_err("not named");
    assert!(
        text.starts_with(
            "m: meshes[0].primitives[0].attributes.POSITION: accessors[0]: componentType 5120 (BYTE) is not \
             FLOAT (integers belong to KHR_mesh_quantization, which is not named)"
        ),
        "{text}"
    );
    for key in ["extensionsUsed", "extensionsRequired"] {
        let mut named = file.clone();
        named
            .document
            .insert(key.into(), json!(["KHR_mesh_quantization"]));
        let model = read(&named.glb()).expect("named");
        let expected = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        assert_eq!(model.mesh.positions, expected);
        let last = (2, [7.0, 8.0, 65535.0]);
        assert_eq!(model.morphs.targets[0].displacements[2], last);
    }
}

#[test]
fn sparse_targets_replace_their_base() {
    let mut file = Writer::default();
    let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let base = file.view(
        [1.0_f32, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0]
            .iter()
            .flat_map(|x| x.to_le_bytes()),
    );
    let over = file.sparse(3, Some(base), &[(1, [0.0; 3]), (2, [4.0, 5.0, 6.0])]);
    let alone = file.sparse(3, None, &[(1, [7.0, 8.0, 9.0])]);
    let zeros =
        file.accessor(json!({"componentType": component::FLOAT, "count": 3, "type": "VEC3"}));
    let targets =
        json!([{"POSITION": over}, {"POSITION": alone}, {"POSITION": zeros}, {"NORMAL": 0}]);
    file.add(
        "meshes",
        json!({
            "primitives": [{"attributes": {"POSITION": positions}, "targets": targets}],
            "extras": {"targetNames": ["over", 7]},
        }),
    );
    file.add("nodes", json!({"mesh": 0}));
    file.add("scenes", json!({"nodes": [0]}));
    let model = read(&file.glb()).expect("sound");
    let moves: Vec<_> = model
        .morphs
        .targets
        .iter()
        .map(|t| t.displacements.as_slice())
        .collect();
    assert_eq!(moves[0], [(0, [1.0, 0.0, 0.0]), (2, [4.0, 5.0, 6.0])]);
    assert_eq!(moves[1], [(1, [7.0, 8.0, 9.0])]);
    assert!(moves[2].is_empty() && moves[3].is_empty());
    let names: Vec<_> = model
        .morphs
        .targets
        .iter()
        .map(|t| t.name.as_deref())
        .collect();
    assert_eq!(names, [Some("over"), None, None, None]);
    let expected = [
        "m: meshes[0].extras.targetNames: 2 names for 4 morph targets",
        "m: meshes[0]: target 3 moves no positions",
    ];
    assert_eq!(model.mesh.warnings, expected);
}

#[test]
fn any_depth_of_nodes_will_do() {
    let depth = 100_000;
    let mut file = Writer::default();
    let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    file.add(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": positions}}]}),
    );
    let nodes = (0..depth).map(|i| json!({"children": [i + 1], "translation": [0, 0, 0.5]}));
    let nodes: Vec<_> = nodes.chain([json!({"mesh": 0})]).collect();
    file.document.insert("nodes".into(), json!(nodes));
    file.add("scenes", json!({"nodes": [0]}));
    let model = read(&file.glb()).expect("sound");
    assert_eq!(model.mesh.positions[1], [1.0, 0.0, 0.5 * f64::from(depth)]);
}
