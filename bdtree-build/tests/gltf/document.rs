//! Every mistake in a document is named with its place.

use serde_json::Value;

use crate::support::{edited, read};

/// An edit of the sound file, and the one problem it leads to.
const DOCUMENT: &[(&str, &str, &str)] = &[
    // The document.
    (
        "/asset/version",
        "\"1.0\"",
        "asset.version: glTF \"1.0\" is not read; 2.0 is",
    ),
    (
        "/asset/minVersion",
        "\"2.1\"",
        "asset.minVersion: glTF \"2.1\" is not read; 2.0 is",
    ),
    ("/asset", "null", "missing field `asset`"),
    ("/meshes", "{}", "meshes: is an object, expected an array"),
    (
        "/nodes/0/scale",
        "[2, \"x\", 2]",
        "nodes[0].scale[1]: is the string \"x\", expected a number",
    ),
    (
        "/nodes/0/scale",
        "[2, 2]",
        "nodes[0].scale: invalid length 2, expected an array of length 3",
    ),
    (
        "/extensionsRequired",
        "[\"EXT_meshopt_compression\"]",
        "extensionsRequired[0]: EXT_meshopt_compression is not supported: export without mesh compression",
    ),
    // Nodes.
    (
        "/scene",
        "5",
        "scene 5 does not exist (the file has 1 scene)",
    ),
    (
        "/nodes/0/children",
        "[1, 9]",
        "nodes[0].children[1]: refers to an element that the file does not have",
    ),
    (
        "/nodes/0/children",
        "[1, 1]",
        "nodes[1]: reached from nodes[0] and from nodes[0]; a node has one parent",
    ),
    (
        "/scenes/0/nodes",
        "[0, 2]",
        "nodes[2]: reached from nodes[0] and from scenes[0]; a node has one parent",
    ),
    (
        "/nodes/1/mesh",
        "7",
        "nodes[1].mesh: refers to an element that the file does not have",
    ),
    (
        "/nodes/1/mesh",
        "4294967296",
        "nodes[1].mesh: 4294967296 is beyond 32 bits",
    ),
    (
        "/nodes/0/rotation",
        "[0, 0, 0, 0]",
        "nodes[0]: rotation [0.0, 0.0, 0.0, 0.0] has no direction",
    ),
    (
        "/nodes/2/matrix/3",
        "0.5",
        "nodes[2]: matrix: its last row is not 0, 0, 0, 1",
    ),
    (
        "/nodes/2/weights",
        "[1]",
        "nodes[2].weights: 1 weights for 2 morph targets",
    ),
    // Meshes.
    (
        "/meshes/0/weights",
        "[]",
        "meshes[0].weights: 0 weights for 2 morph targets",
    ),
    (
        "/meshes/0/primitives/0/attributes",
        "{}",
        "meshes[0].primitives[0].attributes[\"POSITION\"]: is missing",
    ),
    (
        "/meshes/0/primitives/0/mode",
        "7",
        "meshes[0].primitives[0].mode: is not a value that glTF 2.0 knows",
    ),
    (
        "/meshes/0/primitives/0/indices",
        "null",
        "meshes[0].primitives[0]: corner count is not a multiple of 3: 26",
    ),
    (
        "/meshes/0/primitives/0/indices",
        "88",
        "meshes[0].primitives[0].indices: refers to an element that the file does not have",
    ),
    (
        "/meshes/0/primitives/0/indices",
        "0",
        "meshes[0].primitives[0].indices: accessors[0] is not of type SCALAR",
    ),
    (
        "/meshes/0/primitives/0/targets/1/POSITION",
        "88",
        "meshes[0].primitives[0].targets[1].POSITION: refers to an element that the file does not have",
    ),
    (
        "/meshes/0/primitives/0/targets/1/POSITION",
        "1",
        "meshes[0].primitives[0].targets[1].POSITION: accessors[1] is not of type VEC3",
    ),
    (
        "/meshes/0/primitives/-",
        "{\"attributes\": {\"POSITION\": 0}, \"indices\": 1}",
        "meshes[0].primitives[1]: 0 morph targets, but primitives[0] of the same mesh has 2",
    ),
    // Accessors.
    (
        "/accessors/0/type",
        "\"VEC5\"",
        "accessors[0].type: is not a value that glTF 2.0 knows",
    ),
    (
        "/accessors/0/type",
        "\"VEC4\"",
        "meshes[0].primitives[0].attributes.POSITION: accessors[0] is not of type VEC3",
    ),
    (
        "/accessors/0/componentType",
        "5130",
        "accessors[0].componentType: is not a value that glTF 2.0 knows",
    ),
    (
        "/accessors/0/componentType",
        "5125",
        "meshes[0].primitives[0].attributes.POSITION: accessors[0]: componentType 5125 (UNSIGNED_INT) is not FLOAT (integers belong to KHR_mesh_quantization, which is not named)",
    ),
    (
        "/accessors/0/count",
        "27",
        "meshes[0].primitives[0].attributes.POSITION: accessors[0]: 27 elements of 12 bytes, 12 apart from byte 0, end beyond bufferViews[0], which has 312 bytes",
    ),
    (
        "/accessors/0/count",
        "4294967296",
        "8589934592 vertices with every node's mesh written out; at most 134217728 are read",
    ),
    (
        "/accessors/0/count",
        "-1",
        "accessors[0].count: invalid value: integer `-1`, expected u64",
    ),
    (
        "/accessors/0/bufferView",
        "null",
        "meshes[0].primitives[0].attributes.POSITION: accessors[0] has no bufferView: its data may be in an extension",
    ),
    (
        "/accessors/0/bufferView",
        "77",
        "accessors[0].bufferView: refers to an element that the file does not have",
    ),
    (
        "/accessors/0/byteOffset",
        "18446744073709551615",
        "meshes[0].primitives[0].attributes.POSITION: accessors[0]: 26 elements of 12 bytes, 12 apart from byte 18446744073709551615, end beyond bufferViews[0], which has 312 bytes",
    ),
    (
        "/accessors/1/componentType",
        "5126",
        "meshes[0].primitives[0].indices: accessors[1]: componentType 5126 (FLOAT) is not UNSIGNED_BYTE, UNSIGNED_SHORT or UNSIGNED_INT",
    ),
    (
        "/accessors/1/count",
        "142",
        "meshes[0].primitives[0]: corner count is not a multiple of 3: 142",
    ),
    (
        "/accessors/1/count",
        "2",
        "meshes[0].primitives[0]: 2 corners; a triangle has 3",
    ),
    (
        "/accessors/2/count",
        "25",
        "meshes[0].primitives[0].targets[0].POSITION: 25 displacements for 26 vertices",
    ),
    (
        "/accessors/3/sparse/count",
        "27",
        "meshes[0].primitives[0].targets[1].POSITION: accessors[3].sparse replaces 27 of 26 elements",
    ),
    (
        "/accessors/3/sparse/count",
        "9",
        "meshes[0].primitives[0].targets[1].POSITION: accessors[3].sparse.indices: 9 elements of 1 bytes, 1 apart from byte 0, end beyond bufferViews[3], which has 1 bytes",
    ),
    (
        "/accessors/3/sparse/indices/componentType",
        "5126",
        "accessors[3].sparse.indices.componentType: is not a value that glTF 2.0 knows",
    ),
    (
        "/accessors/3/sparse/values/bufferView",
        "40",
        "accessors[3].sparse.values.bufferView: refers to an element that the file does not have",
    ),
    // Buffers.
    (
        "/bufferViews/0/buffer",
        "3",
        "bufferViews[0].buffer: refers to an element that the file does not have",
    ),
    (
        "/bufferViews/0/byteStride",
        "8",
        "meshes[0].primitives[0].attributes.POSITION: accessors[0]: stride 8 of bufferViews[0] is below 12",
    ),
    (
        "/bufferViews/0/byteOffset",
        "18446744073709551615",
        "meshes[0].primitives[0].attributes.POSITION: bufferViews[0] of 312 bytes from byte 18446744073709551615 ends beyond buffers[0], which has 1084",
    ),
    (
        "/buffers/0/byteLength",
        "1000000000",
        "buffers[0]: byteLength is 1000000000, but there are 1084 bytes",
    ),
    // Animations.
    (
        "/animations/0/samplers/0/input",
        "99",
        "animations[0].samplers[0].input: there is no accessors[99]",
    ),
    (
        "/animations/0/samplers/0/input",
        "0",
        "animations[0].samplers[0].input: accessors[0] is not of type SCALAR",
    ),
    (
        "/animations/0/samplers/0/output",
        "7",
        "animations[0].samplers[0].output: 4 values for 3 keys of 2 morph targets",
    ),
    (
        "/animations/0/samplers/0/output",
        "1",
        "animations[0].samplers[0].output: accessors[1]: componentType 5123 (UNSIGNED_SHORT) is not FLOAT or normalized BYTE or SHORT",
    ),
    (
        "/animations/0/samplers/0/interpolation",
        "\"CURVE\"",
        "animations[0].samplers[0]: interpolation is none of LINEAR, STEP, CUBICSPLINE",
    ),
    (
        "/animations/0/samplers/0/interpolation",
        "\"CUBICSPLINE\"",
        "animations[0].samplers[0].output: 6 values for 3 keys of 3 values of 2 morph targets",
    ),
    (
        "/animations/0/channels/1/sampler",
        "5",
        "animations[0].samplers[5]: there is no such element",
    ),
    (
        "/animations/0/channels/1/target/node",
        "1",
        "animations[0].channels[1]: moves the weights of a node that another channel moves",
    ),
    (
        "/animations/0/channels",
        "5",
        "animations[0].channels: is the integer `5`, expected an array",
    ),
];

#[test]
fn mistakes_in_the_document_are_named() {
    for (pointer, value, problem) in DOCUMENT {
        let value: Value = serde_json::from_str(value).expect(value);
        let text = read(&edited(&[(pointer, value.clone())])).expect_err(pointer);
        assert_eq!(text, format!("m: {problem}"), "{pointer} = {value}");
    }
}
