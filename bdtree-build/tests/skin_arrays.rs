//! Skins as arrays beside a mesh: `--skin-weights`, `--skin-joints`, `--inverse-bind`.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use bdtree_build::input::{Local, SkinArrays};
use bdtree_runtime::{Model, VertexId};
use serde_json::Value;

/// The bytes of a `.npy` file.
fn npy(dtype: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A triangle and its arrays in `folder`: two bones, the second of which stands at x = 2.
fn write(folder: &Path) -> SkinArrays {
    let put = |name: &str, bytes: Vec<u8>| -> PathBuf {
        let path = folder.join(name);
        std::fs::write(&path, bytes).expect("written");
        path
    };
    put("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec());
    let matrices = [
        [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        [0.5, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
    ];
    let joints: Vec<u8> = [0_i32, -1, 1, 0, 1, 1]
        .iter()
        .flat_map(|j| j.to_le_bytes())
        .collect();
    SkinArrays {
        weights: put(
            "w.npy",
            npy("<f8", "(3, 2)", &doubles(&[2.0, 0.0, 0.75, 0.25, 0.5, 0.5])),
        ),
        joints: put("j.npy", npy("<i4", "(3, 2)", &joints)),
        inverse_bind: put(
            "b.npy",
            npy("<f8", "(2, 3, 4)", &doubles(matrices.as_flattened())),
        ),
    }
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bdtree-build"))
        .args(["a.obj", "--modes", "0", "--json"])
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the command starts")
}

const ALL: [&str; 6] = [
    "--skin-weights",
    "w.npy",
    "--skin-joints",
    "j.npy",
    "--inverse-bind",
    "b.npy",
];

#[test]
fn arrays_are_a_skin() {
    let folder = tempfile::tempdir().expect("a folder");
    let skin = write(folder.path()).read(3).expect("sound");
    // The joint of a weight of 0 does not matter; one joint twice is a sum.
    assert_eq!(skin.influences.of(0), [(0, 2.0)]);
    assert_eq!(skin.influences.of(1), [(0, 0.25), (1, 0.75)]);
    assert_eq!(skin.influences.of(2), [(1, 1.0)]);
    assert_eq!(skin.skeleton[1].name, "joint 1");
    let rest = [
        [2.0, 0.0, 0.0, 2.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ];
    assert_eq!(skin.skeleton[1].local, Local::Matrix(rest));
    let output = run(folder.path(), &ALL);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{stderr}");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(
        (&json["joints"], &json["bones"], &json["clips"]),
        (&2.into(), &2.into(), &0.into())
    );
    let bytes = std::fs::read(folder.path().join("a.bdt")).expect("a file");
    let model = Model::from_bytes(&bytes).expect("opens");
    let influences = model.asset().influences(VertexId(0)).expect("in the file");
    assert_eq!((influences.len(), influences[0].weight), (1, 1.0));
    // They rest where they are bound.
    let rest = model.asset().bones()[1]
        .rest
        .map(|row| row.map(|x| x.get()));
    assert_eq!(
        rest,
        [
            [1.0, 0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0]
        ]
    );
}

#[test]
fn arrays_go_together_and_fit_the_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let arrays = write(folder.path());
    let output = run(folder.path(), &ALL[..4]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--inverse-bind"));
    let told = |count: usize| {
        arrays
            .read(count)
            .map(|_| ())
            .expect_err("a problem")
            .to_string()
    };
    assert!(told(4).contains("w.npy: shape [3, 2] is not (N, I) with N = 4 vertices"));
    let joints = std::fs::read(&arrays.joints).expect("written before");
    std::fs::write(&arrays.joints, npy("|u1", "(3, 1)", &[0, 0, 0])).expect("written");
    let message =
        "j.npy: shape [3, 1], but that of the weights is [3, 2]: one joint for each weight";
    assert!(told(3).contains(message), "{}", told(3));
    std::fs::write(&arrays.joints, joints).expect("written");
    // What is wrong with weights is in their file, not in the mesh's.
    let weights = std::fs::read(&arrays.weights).expect("written before");
    std::fs::write(&arrays.weights, npy("<f8", "(3, 2)", &[0; 48])).expect("written");
    let output = run(folder.path(), &ALL);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(
        message.contains("w.npy: vertex 0: all weights are zero"),
        "{message}"
    );
    std::fs::write(&arrays.weights, weights).expect("written");
    std::fs::write(&arrays.joints, npy("|u1", "(3, 2)", &[0, 0, 0, 2, 0, 0])).expect("written");
    assert!(told(3).contains("j.npy: vertex 1: joint 1 is 2, but there are 2 matrices"));
    std::fs::write(&arrays.joints, npy("<f4", "(3, 2)", &[0; 24])).expect("written");
    assert!(told(3).contains("dtype <f4: needs whole numbers"));
    std::fs::write(&arrays.inverse_bind, npy("<f8", "(1, 3, 4)", &[0; 96])).expect("written");
    assert!(told(3).contains("b.npy: entry 0: the matrix has no inverse"));
    // Options without a skin to use them.
    assert!(
        run(folder.path(), &["--weights", "normalize"])
            .status
            .success()
    );
    let output = run(folder.path(), &["--weights", "as-stored"]);
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(json["joints"].is_null() && json["clips"].is_null());
    let warnings = json["warnings"].to_string();
    assert!(
        warnings.contains("--weights is not used: the input has no skin"),
        "{warnings}"
    );
}
