//! Every glTF file of the corpus bakes as its table says or says what is not supported; what is
//! read equals a second reading, and what is baked equals the file's weights.

use std::ops::ControlFlow;
use std::path::Path;

use serde_json::json;

use super::twin::{self, File, Matrix, Twin};
use bdtree_build::basis::dropped::Keep;
use bdtree_build::basis::morph::{MorphBasis, morph_basis};
use bdtree_build::input::gltf::read_gltf;
use bdtree_build::input::{Local, RawBone, RawModel, RawSkin, Rows, read_mesh};
use bdtree_fixtures::models::math::V3;
use bdtree_fixtures::{bake, corpus, oracle, poses};
use bdtree_runtime::{Ball, Contact, Transform, VertexId, Workspace};

/// Vertices and triangles as the corpus's table has them; targets, frames (none with bones), warnings.
const CHARACTERS: [(&str, [usize; 5]); 9] = [
    ("Fox.glb", [1728, 576, 0, 0, 0]),
    ("RiggedSimple.glb", [960, 892, 0, 0, 0]),
    ("CesiumMan.glb", [3273, 4672, 0, 0, 0]),
    ("RobotExpressive.glb", [7214, 3237, 9, 0, 4]),
    (
        "AnimatedMorphCube/AnimatedMorphCube.gltf",
        [24, 12, 2, 127, 0],
    ),
    (
        "AnimatedMorphSphere/AnimatedMorphSphere.gltf",
        [1876, 960, 2, 217, 0],
    ),
    (
        "MorphPrimitivesTest/MorphPrimitivesTest.gltf",
        [30, 32, 1, 0, 0],
    ),
    ("SimpleMorph/SimpleMorph.gltf", [3, 1, 2, 5, 0]),
    ("cake_parts.glb", [14616, 1332, 0, 0, 0]),
];

/// Files of `messy/gltf`: vertices and triangles, or the start of the first problem.
const MESSY: [(&str, Result<[usize; 2], &str>); 17] = [
    (
        "BoxWithInfinites.glb",
        Err("meshes[0].primitives[0].attributes.POSITION: vertex"),
    ),
    ("Flower_mangled.glb", Err("GLB header: length")),
    (
        "IndexOutOfRange.gltf",
        Err("meshes[0].primitives[0].indices: index"),
    ),
    (
        "Mesh_PrimitiveMode_00.gltf",
        Err("no triangles, only primitives that are not triangles: 1 of points"),
    ),
    (
        "Mesh_PrimitiveMode_02.gltf",
        Err("no triangles, only primitives that are not triangles: 1 of lines"),
    ),
    ("Mesh_PrimitiveMode_04.gltf", Ok([4, 2])),
    ("Mesh_PrimitiveMode_06.gltf", Ok([6, 2])),
    (
        "Mesh_PrimitiveMode_08.gltf",
        Err("no triangles, only primitives that are not triangles: 1 of lines"),
    ),
    (
        "Mesh_PrimitiveMode_10.gltf",
        Err("no triangles, only primitives that are not triangles: 1 of lines"),
    ),
    ("Mesh_PrimitiveMode_12.gltf", Ok([4, 2])),
    ("Mesh_PrimitiveMode_14.gltf", Ok([4, 2])),
    (
        "MissingBin.gltf",
        Err("buffers[0]: uri \"BoxTextured0.bin\": cannot be read"),
    ),
    (
        "NoScene.gltf",
        Err("scene 0 does not exist (the file has no scenes)"),
    ),
    (
        "RecursiveNodes.gltf",
        Err("nodes[0]: reached from scenes[0] and from nodes[1]"),
    ),
    (
        "badArray.gltf",
        Err("meshes[0].primitives: is an object, expected an array"),
    ),
    (
        "badNumber.gltf",
        Err("buffers[0]: uri \"BoxTextured0.bin\": cannot be read"),
    ),
    (
        "badUint.gltf",
        Err("buffers[0]: uri \"BoxTextured0.bin\": cannot be read"),
    ),
];

#[test]
fn characters_are_what_their_table_says() {
    let test = "gltf_characters_are_what_their_table_says";
    let Some(folder) = corpus::path(test, "characters") else {
        return;
    };
    for (name, expected) in CHARACTERS {
        let path = folder.join(name);
        let model = read_gltf(&path, None).unwrap_or_else(|e| panic!("{name}: {e}"));
        println!("{name}: {:#?}", model.mesh.warnings);
        let names: Vec<_> = model
            .morphs
            .targets
            .iter()
            .map(|t| t.name.as_deref())
            .collect();
        println!("{name}: {names:?}");
        let frames = model
            .morphs
            .clip
            .as_ref()
            .map_or(0, |clip| clip.times_s.len());
        let found = [
            model.mesh.positions.len(),
            model.mesh.triangles.len(),
            model.morphs.targets.len(),
            frames,
            model.mesh.warnings.len(),
        ];
        assert_eq!(found, expected, "{name}");
        let file = File::open(&path);
        let twin = file.scene();
        same(&model, &twin, name);
        let samplers = file.samplers(0, &twin);
        if let Some(clip) = &model.morphs.clip {
            for sampler in &samplers {
                assert_eq!(sampler.interpolation, "LINEAR", "{name}");
                let width = sampler.values.len() / sampler.times.len();
                for (k, t) in sampler.times.iter().enumerate() {
                    let frame = clip
                        .times_s
                        .iter()
                        .position(|x| x == t)
                        .expect("a frame per key");
                    let row = &clip.weights[frame * expected[2] + sampler.first_target..][..width];
                    assert_eq!(row, &sampler.values[k * width..(k + 1) * width], "{name}");
                }
            }
        }
        let mut warnings = Vec::new();
        let morph = morph_basis(
            &model.mesh,
            &model.morphs,
            Keep::All,
            4 << 30,
            &mut warnings,
        );
        let morph = morph.unwrap_or_else(|e| panic!("{name}: {e}"));
        println!("{name}: {:?} {warnings:?}", morph.error);
        assert!(morph.error.max_rel < 1e-6, "{name}");
        baked_weights_move_what_the_file_says(&model, &morph, &twin, name);
    }
}

/// Triangles, and positions and displacements where joints put them at rest, to a few roundings of f64.
pub(crate) fn same(model: &RawModel, twin: &Twin, name: &str) {
    assert_eq!(model.mesh.triangles, twin.triangles, "{name}");
    assert_eq!(model.mesh.positions.len(), twin.positions.len(), "{name}");
    let carried = model.skin.as_ref().map(carried_at_rest);
    let carried = carried.unwrap_or_else(|| vec![twin::IDENTITY; twin.positions.len()]);
    let twins = twin.positions.iter().zip(&twin.carried);
    let twins: Vec<V3> = twins.map(|(p, m)| twin::apply(m, p, 1.0)).collect();
    let size = |points: &[V3]| {
        let all = points.as_flattened().iter();
        all.fold(0.0_f64, |m, x| m.max(x.abs()))
    };
    let size = size(&twins).max(size(&twin.positions));
    let close = |a: &V3, b: &V3| (0..3).all(|k| (a[k] - b[k]).abs() <= 1e-13 * size);
    for (i, (p, b)) in model.mesh.positions.iter().zip(&twins).enumerate() {
        let a = twin::apply(&carried[i], p, 1.0);
        assert!(close(&a, b), "{name}: vertex {i}: {a:?} {b:?}");
    }
    assert_eq!(model.morphs.targets.len(), twin.fields.len(), "{name}");
    for (j, (target, field)) in model.morphs.targets.iter().zip(&twin.fields).enumerate() {
        assert_eq!(target.default_weight, twin.weights[j], "{name}");
        let mut dense = vec![[0.0; 3]; field.len()];
        let mut last = None;
        for &(i, u) in &target.displacements {
            assert!(last < Some(i), "{name}: ascending");
            last = Some(i);
            dense[i as usize] = u;
        }
        for (i, (a, b)) in dense.iter().zip(field).enumerate() {
            let a = twin::apply(&carried[i], a, 0.0);
            let b = twin::apply(&twin.carried[i], b, 0.0);
            assert!(close(&a, &b), "{name}: target {j}: {a:?} {b:?}");
        }
    }
}

/// The matrix of each vertex at rest, from what was read.
fn carried_at_rest(skin: &RawSkin) -> Vec<Matrix> {
    let columns = |rows: &Rows| -> Matrix {
        [0, 1, 2, 3].map(|c| {
            let [x, y, z] = rows.map(|row| row[c]);
            [x, y, z, f64::from(u8::from(c == 3))]
        })
    };
    let mut nodes: Vec<Matrix> = Vec::new();
    for node in &skin.skeleton {
        let local = match node.local {
            Local::Matrix(rows) => columns(&rows),
            Local::Parts {
                translation,
                rotation,
                scale,
            } => twin::placement(&json!({
                "translation": translation, "rotation": rotation, "scale": scale,
            })),
        };
        nodes.push(match node.parent {
            Some(parent) => twin::product(&nodes[parent as usize], &local),
            None => local,
        });
    }
    let bone = |bone: &RawBone| {
        let joint = &nodes[skin.joints[bone.joint as usize] as usize];
        twin::product(joint, &columns(&bone.inverse_bind))
    };
    let bones: Vec<Matrix> = skin.bones.iter().map(bone).collect();
    let blended = |i: usize| {
        let mut sum = [[0.0; 4]; 4];
        for &(bone, weight) in skin.influences.of(i) {
            let bone = &bones[usize::from(bone)];
            for (sum, x) in sum.as_flattened_mut().iter_mut().zip(bone.as_flattened()) {
                *sum += weight * x;
            }
        }
        let whole = sum[3][3];
        sum.map(|column| column.map(|x| x / whole))
    };
    (0..skin.influences.vertex_count()).map(blended).collect()
}

/// Weight 1 of each target, and every 16th frame of the clip: vertices to rounding of f32, balls as
/// brute force finds them.
fn baked_weights_move_what_the_file_says(
    model: &RawModel,
    morph: &MorphBasis,
    twin: &Twin,
    name: &str,
) {
    let baked = bake::baked(&model.mesh, &morph.basis);
    let asset = baked.asset();
    let sound = asset.verify(&mut |e| {
        println!("{name}: {e}");
        ControlFlow::Continue(())
    });
    assert!(sound, "{name}");
    let count = twin.fields.len();
    let one = |j: usize| {
        (0..count)
            .map(|k| f64::from(u8::from(k == j)))
            .collect::<Vec<f64>>()
    };
    let mut weights: Vec<Vec<f64>> = (0..count).map(one).collect();
    weights.push(morph.default_weights.clone());
    if let Some(animation) = &morph.basis.animation {
        let frames = animation.q.chunks_exact(count).step_by(16);
        weights.extend(frames.map(<[f64]>::to_vec));
    }
    let diagonal = poses::diagonal(asset) * asset.unit();
    let mut memory = vec![0.0; asset.pose_len()];
    let mut workspace = Workspace::new();
    for w in weights {
        let q: Vec<f32> = w.iter().map(|w| *w as f32).collect();
        let pose = asset
            .pose(&q, Transform::IDENTITY, &mut memory)
            .expect("pose");
        // Without bones, those of a skin stand where they were read.
        for (i, p) in model.mesh.positions.iter().enumerate() {
            let found = pose.deformed(VertexId(i as u32)).expect("vertex");
            for k in 0..3 {
                let moves = (0..count).map(|j| w[j] * twin.fields[j][i][k]);
                // p and each U are rounded to f32, q too, and so is the sum once more per term; the
                // world matrices of both readings differ by roundings of f64.
                let terms: Vec<f64> = std::iter::once(p[k]).chain(moves).collect();
                let size: f64 = terms.iter().map(|x| x.abs()).sum();
                let slack = f64::from(f32::EPSILON) * (1 + count) as f64 * size + 1e-14 * diagonal;
                let exact: f64 = terms.iter().sum();
                assert!(
                    (found[k] - exact).abs() <= slack,
                    "{name}: vertex {i}: {found:?} {exact}"
                );
            }
        }
        let triangles = oracle::deformed_triangles(&pose);
        let radius = 0.05 * diagonal;
        for triangle in triangles.iter().step_by(1 + triangles.len() / 10) {
            let center = triangle[0];
            let mut found: Vec<Contact> = Vec::new();
            pose.query(&mut workspace)
                .contacts(Ball::new(center, radius), &mut found)
                .expect("ball");
            let mut ids: Vec<u32> = found.iter().map(|c| c.triangle.0).collect();
            ids.sort_unstable();
            let expected = oracle::ball(&triangles, center, radius);
            let expected: Vec<u32> = expected.iter().map(|e| e.0).collect();
            assert_eq!(ids, expected, "{name}");
        }
    }
}

#[test]
fn messy_files_are_read_or_say_why_not() {
    let test = "gltf_messy_files_are_read_or_say_why_not";
    let Some(folder) = corpus::path(test, "messy/gltf") else {
        return;
    };
    for (name, expected) in MESSY {
        let path = folder.join(name);
        let read = read_mesh(&path);
        match (&read, expected) {
            (Ok(mesh), Ok(counts)) => {
                println!("{name}: {:?}", mesh.warnings);
                assert_eq!(
                    [mesh.positions.len(), mesh.triangles.len()],
                    counts,
                    "{name}"
                );
                let twin = File::open(&path).scene();
                assert_eq!(mesh.positions, twin.positions, "{name}");
                assert_eq!(mesh.triangles, twin.triangles, "{name}");
            }
            (Err(error), Err(start)) => {
                println!("{error}");
                let start = format!("{}: {start}", path.display());
                assert!(
                    error.to_string().starts_with(&start),
                    "{name}: {error}\n{start}"
                );
            }
            (Ok(_), Err(_)) => panic!("{name} should not be readable"),
            (Err(error), Ok(_)) => panic!("{name}: {error}"),
        }
    }
}

#[test]
fn no_file_is_missing_from_the_tables() {
    let test = "gltf_no_file_is_missing_from_the_tables";
    let Some(folder) = corpus::path(test, "") else {
        return;
    };
    let known = |name: &str| {
        let characters = CHARACTERS.iter().map(|(name, _)| *name);
        characters
            .chain(MESSY.iter().map(|(name, _)| *name))
            .any(|n| n.ends_with(name))
    };
    let mut count = 0;
    for folder in [folder.join("characters"), folder.join("messy/gltf")] {
        for name in files(&folder) {
            if name.ends_with(".glb") || name.ends_with(".gltf") {
                assert!(known(&name), "{name}");
                count += 1;
            }
        }
    }
    assert_eq!(count, CHARACTERS.len() + MESSY.len());
}

/// Names of the files in `folder` and below.
fn files(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        if entry.path().is_dir() {
            names.extend(files(&entry.path()));
        } else {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    names
}
