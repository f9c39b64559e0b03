//! `deform`: positions, ids, groups, output files.

use bdtree_runtime::{Model, SkeletonPose};

use crate::support::{Folder, ball_mesh, basis, character, positions_of_npy};

/// The `v` lines of an OBJ.
fn vertices(obj: &str) -> Vec<[f64; 3]> {
    let lines = obj.lines().filter_map(|line| line.strip_prefix("v "));
    lines
        .map(|line| {
            let numbers: Vec<f64> = line.split(' ').map(|x| x.parse().unwrap()).collect();
            numbers.try_into().unwrap()
        })
        .collect()
}

#[test]
fn rest_positions_are_the_source_s() {
    let folder = Folder::new();
    let mesh = ball_mesh();
    let ran = folder.run(&["deform", "a.bdt"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let found = vertices(&ran.out);
    assert_eq!(found.len(), mesh.positions.len());
    for (x, y) in found.iter().zip(&mesh.positions) {
        for k in 0..3 {
            // Stored in f32 relative to the origin: half an ulp of about two units.
            assert!((x[k] - y[k]).abs() < 2e-7, "{x:?} {y:?}");
        }
    }
    let faces: Vec<String> = mesh
        .triangles
        .iter()
        .map(|[a, b, c]| format!("f {} {} {}", a + 1, b + 1, c + 1))
        .collect();
    let lines: Vec<&str> = ran.out.lines().filter(|l| l.starts_with("f ")).collect();
    assert_eq!(lines, faces);
}

#[test]
fn groups_stand_before_their_triangles() {
    let folder = Folder::new();
    let ran = folder.run(&["deform", "a.bdt"]);
    let lines: Vec<&str> = ran.out.lines().filter(|l| !l.starts_with('v')).collect();
    assert_eq!(lines[..3], ["o ball", "g top", "usemtl shiny"]);
    assert_eq!(lines[3 + 126], "g bottom half");
    assert_eq!(lines.len(), 4 + 252);
}

#[test]
fn q_moves_along_the_fields() {
    let folder = Folder::new();
    let (mesh, basis) = (ball_mesh(), basis(&ball_mesh()));
    let q = [-0.5, 0.75, 1.25];
    let found = folder.deformed("a.bdt", "-0.5,0.75, 1.25");
    for (i, x) in found.iter().enumerate() {
        for k in 0..3 {
            let moved: f64 = (0..3).map(|j| q[j] * basis.field(j)[i][k]).sum();
            let expected = mesh.positions[i][k] + moved;
            assert!((x[k] - expected).abs() < 1e-6, "vertex {i}: {x:?}");
        }
    }
}

#[test]
fn obj_and_npy_hold_the_same_numbers() {
    let folder = Folder::new();
    let q = "-0.1,0.2,3e-1";
    let ran = folder.run(&["deform", "a.bdt", "--q", q, "-o", "out.obj"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    assert_eq!(ran.out, "wrote out.obj: 141 vertices, 252 triangles\n");
    let text = String::from_utf8(folder.read("out.obj")).unwrap();
    let npy = folder.deformed("a.bdt", q);
    let bits = |x: &[[f64; 3]]| {
        x.as_flattened()
            .iter()
            .map(|x| x.to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(bits(&vertices(&text)), bits(&npy));
    let ran = folder.run(&["deform", "a.bdt", "--q=-0.1,0.2,0.3"]);
    assert_eq!(ran.out, text);
    // Overwriting is allowed, and nothing else stays behind.
    let ran = folder.run(&["deform", "rigid.bdt", "--q", "", "-o", "deformed.npy"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    assert_eq!(ran.out, "wrote deformed.npy: 141 vertices\n");
    assert_ne!(positions_of_npy(&folder.read("deformed.npy")), npy);
    let mut files: Vec<_> = std::fs::read_dir(folder.root())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(files, ["a.bdt", "deformed.npy", "out.obj", "rigid.bdt"]);
}

/// A `.npy` file.
fn npy(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let mut bytes = Vec::new();
    bdtree_npy::write(shape, values, &mut bytes).unwrap();
    bytes
}

#[test]
fn joints_of_a_file_pose_as_the_clip_that_they_are_from() {
    let folder = Folder::new();
    folder.write("tube.bdt", character("skinned_tube.glb"));
    let model = Model::load(folder.path("tube.bdt")).unwrap();
    let mut pose = SkeletonPose::new(&model).unwrap();
    let skeleton = model.asset().skeleton().unwrap();
    let wave = skeleton.clips().position(|clip| clip.name() == "wave");
    pose.play(wave.unwrap(), 0.7).unwrap();
    let joints = pose.joints();
    let q: Vec<String> = pose.q().iter().map(f32::to_string).collect();
    let q = format!("--q={}", q.join(","));

    let of_clip = folder.run(&["deform", "tube.bdt", "--clip", "wave", "--time", "0.7"]);
    assert_eq!((of_clip.code, of_clip.err.as_str()), (0, ""));
    let values = joints.as_flattened().as_flattened();
    folder.write("joints.npy", npy(&[joints.len(), 3, 4], values));
    let ran = folder.run(&["deform", "tube.bdt", "--joints", "joints.npy", &q]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    assert_eq!(ran.out, of_clip.out);
    let at_rest = folder.run(&["deform", "tube.bdt"]);
    assert_ne!(at_rest.out, of_clip.out);

    let zeros = |shape: &[usize]| npy(shape, &vec![0.0; shape.iter().product()]);
    folder.write("flat.npy", zeros(&[12, 4]));
    folder.write("few.npy", zeros(&[3, 3, 4]));
    let whole = folder.read("joints.npy");
    folder.write("cut.npy", &whole[..whole.len() - 1]);
    for (file, says) in [
        (
            "flat.npy",
            "expected an array of shape (joints, 3, 4), found [12, 4]",
        ),
        (
            "cut.npy",
            "truncated: shape [4, 3, 4] needs 384 bytes of data, found 383",
        ),
        ("few.npy", "3 matrices, but asset tube.bdt has 4 joints"),
        ("tube.bdt", "is not a .npy file (no NumPy signature)"),
        ("none.npy", "No such file or directory"),
    ] {
        let ran = folder.run(&["deform", "tube.bdt", "--joints", file]);
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{file}");
        assert!(ran.err.starts_with("--joints: "), "{}", ran.err);
        assert!(ran.err.contains(says), "{}", ran.err);
    }
}

#[test]
fn bad_input_is_placed() {
    let folder = Folder::new();
    let mut bytes = folder.read("a.bdt");
    let last = bytes.len() - 1;
    bytes[last] ^= 1; // in the metadata: nothing that deform reads
    folder.write("bad.bdt", bytes);
    for (arguments, text) in [
        (
            &["a.bdt", "--q", "1"][..],
            "--q: q has 1 number, asset a.bdt has 3 modes\n",
        ),
        (
            &["rigid.bdt", "--q", "0,0"],
            "--q: q has 2 numbers, asset rigid.bdt has 0 modes\n",
        ),
        (
            &["a.bdt", "--frame", "0"],
            "--frame: asset a.bdt has no animation\n",
        ),
    ] {
        let ran = folder.run(&[&["deform"], arguments].concat());
        assert_eq!((ran.code, ran.out.as_str()), (1, ""), "{arguments:?}");
        assert_eq!(ran.err, text);
    }
    // What no file could make right.
    for (arguments, text) in [
        (
            &["a.bdt", "-o", "out.stl"][..],
            "out.stl: unknown extension: .obj or .npy can be written\n",
        ),
        (
            &["a.bdt", "--q", "1;2;3"],
            "\"1;2;3\" is not a number; separate numbers with commas",
        ),
        (
            &["a.bdt", "--q", "0.5 0.5"],
            "\"0.5 0.5\" is not a number; separate numbers with commas",
        ),
        (
            &["a.bdt", "--q", "0,nan,inf"],
            "q[1]: \"nan\" is not a finite number",
        ),
        (&["a.bdt", "--frame", "-1"], "not a whole number, 0 or more"),
        (&["a.bdt", "--frame", "x"], "not a whole number, 0 or more"),
    ] {
        let ran = folder.run(&[&["deform"], arguments].concat());
        assert_eq!((ran.code, ran.out.as_str()), (2, ""), "{arguments:?}");
        assert!(ran.err.contains(text), "{}", ran.err);
    }
    let ran = folder.run(&["deform", "a.bdt", "--q", "0,-1e30,0"]);
    assert_eq!(ran.code, 1);
    assert!(
        ran.err
            .starts_with("--q: q[1]: -1000000000000000000000000000000 exceeds the limit of "),
        "{}",
        ran.err
    );
    let ran = folder.run(&["deform", "a.bdt", "-o", "no/such/out.obj"]);
    assert_eq!(ran.code, 1);
    assert_eq!(ran.err, "no/such/out.obj: folder no/such does not exist\n");
    // Before the checksums are.
    let ran = folder.run(&["deform", "bad.bdt", "-o", "no/out.obj"]);
    assert_eq!(ran.err, "no/out.obj: folder no does not exist\n");

    let ran = folder.run(&["deform", "bad.bdt"]);
    assert_eq!((ran.code, ran.out.as_str()), (1, ""));
    assert!(
        ran.err
            .starts_with("bad.bdt: damaged .bdt file: section META at byte ")
    );
    assert!(ran.err.contains("SPEC 4.1"));
    let ran = folder.run(&["deform", "bad.bdt", "--no-verify"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
}

#[cfg(unix)]
#[test]
fn a_device_stays_a_device() {
    use std::os::unix::fs::FileTypeExt;
    let folder = Folder::new();
    // A link, so that a broken build of this test replaces the link and nothing else.
    let link = folder.path("null.obj");
    std::os::unix::fs::symlink("/dev/null", &link).unwrap();
    let ran = folder.run(&["deform", "a.bdt", "-o", "null.obj"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    let kind = std::fs::metadata(&link).unwrap().file_type();
    assert!(kind.is_char_device());
}
