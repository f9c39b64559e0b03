//! Meshes of several bind spaces are brought to one, and no vertex of a pose moves by it.

use bdtree_build::input::RawModel;
use bdtree_fixtures::models::gltf::{Writer, component};
use serde_json::{Value, json};

use super::corpus::same;
use super::skins::corner;
use super::support::read;
use super::twin::File;

/// A second mesh in the scene of `corner`, with a skin of its own over joint `a`, whose inverse bind matrix has these
/// columns.
fn second(file: &mut Writer, document: &mut Value, joint: usize, columns: [[f64; 4]; 4]) {
    let bind = file.numbers("MAT4", component::FLOAT, false, columns.as_flattened(), 16);
    let positions = file.vectors(&[[0.5, 0.0, 0.25], [0.75, 0.0, 0.25], [0.5, 0.125, 0.25]]);
    let moves = file.vectors(&[[0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]]);
    let joints = file.numbers("VEC4", component::UNSIGNED_BYTE, false, &[0.0; 12], 4);
    let weights = [[1.0, 0.0, 0.0, 0.0]; 3];
    let weights = file.numbers("VEC4", component::FLOAT, false, weights.as_flattened(), 4);
    let push = |list: &mut Value, element: Value| {
        list.as_array_mut().expect("a list").push(element);
    };
    push(
        &mut document["meshes"],
        json!({"primitives": [{
            "attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights},
            "targets": [{"POSITION": moves}],
        }]}),
    );
    push(
        &mut document["skins"],
        json!({"joints": [joint], "inverseBindMatrices": bind}),
    );
    push(&mut document["nodes"], json!({"mesh": 1, "skin": 1}));
    push(&mut document["scenes"][0]["nodes"], json!(4));
}

/// The model, which puts vertices at rest where a plain reading of the document does.
fn checked(bytes: &[u8]) -> RawModel {
    let model = read(bytes).expect("sound");
    let folder = std::path::Path::new("");
    same(&model, &File::new(bytes, folder).scene(), "spaces");
    model
}

const fn scale(s: f64, t: [f64; 3]) -> [[f64; 4]; 4] {
    let [x, y, z] = t;
    [
        [s, 0.0, 0.0, 0.0],
        [0.0, s, 0.0, 0.0],
        [0.0, 0.0, s, 0.0],
        [x, y, z, 1.0],
    ]
}

#[test]
fn a_skin_in_other_units_is_brought_to_the_others() {
    let model = checked(&corner(|file, document| {
        second(file, document, 2, scale(64.0, [0.0, 0.0, 2.0]));
    }));
    let [warning] = model.mesh.warnings.as_slice() else {
        panic!("{:?}", model.mesh.warnings);
    };
    let start = "skins[1]: its bind pose had another scale or place than that of skins[0] and was converted";
    assert!(warning.contains(start), "{warning}");
    // The first skin's mesh has most vertices, none more than the second's, and is the first.
    assert_eq!(model.mesh.positions[1], [1.0, 0.0, 0.0]);
    let low = model.mesh.positions[3..].as_flattened();
    assert!(low.iter().any(|x| x.abs() > 8.0), "{low:?}");
    // V G⁻¹ has the units of the first skin's matrices.
    let found = model.skin.expect("a skin").bones[2].inverse_bind;
    assert!(
        found.as_flattened().iter().all(|x| x.abs() < 4.0),
        "{found:?}"
    );
}

#[test]
fn a_skin_far_from_meshes_without_one_is_brought_to_the_scene() {
    let bytes = corner(|file, document| {
        second(file, document, 2, scale(1.0, [50.0, 0.0, 0.0]));
        document["nodes"][1]["mesh"] = json!(0);
    });
    let model = checked(&bytes);
    let warnings = &model.mesh.warnings;
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(
        warnings
            .iter()
            .all(|w| w.contains("than that of the scene"))
    );
    // Mesh 0 twice, and the far one.
    let x = |vertices: std::ops::Range<usize>| model.mesh.positions[vertices].iter().map(|p| p[0]);
    assert!(x(0..9).fold(0.0, f64::max) > 50.0);
}

#[test]
fn skins_of_one_bind_space_stay_as_they_are() {
    let own = [[0.5, 0.0, 0.25], [0.75, 0.0, 0.25], [0.5, 0.125, 0.25]];
    // Nearly the matrix that the first skin has for the joint; a joint of its own, little moved; what cannot be undone.
    for (joint, columns) in [
        (2, scale(1.0, [1e-6, 0.0, 0.0])),
        (3, scale(1.0, [0.1, 0.0, 0.0])),
        (2, scale(0.0, [0.0; 3])),
    ] {
        let model = checked(&corner(|file, document| {
            second(file, document, joint, columns);
        }));
        assert!(model.mesh.warnings.is_empty(), "{:?}", model.mesh.warnings);
        assert!(model.mesh.positions.ends_with(&own));
    }
}
