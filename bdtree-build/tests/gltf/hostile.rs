//! Damaged files: no panic, no hang, and what is read holds together.

use bdtree_build::input::RawModel;
use bdtree_fixtures::models;
use bdtree_fixtures::models::gltf::pack;
use bdtree_fixtures::poses::rng;
use rand::RngExt;
use serde_json::{Value, json};

use crate::support::{parts, read};

/// Whatever is read: indices and times hold, numbers are numbers.
fn check(model: &RawModel) {
    let n = model.mesh.positions.len() as u32;
    assert!(model.mesh.positions.iter().flatten().all(|x| x.is_finite()));
    assert!(model.mesh.triangles.iter().flatten().all(|&i| i < n));
    let count = model.mesh.triangles.len() as u32;
    let groups = &model.mesh.groups;
    assert!(
        groups
            .iter()
            .all(|g| g.first_triangle + g.triangle_count <= count)
    );
    assert!(
        groups
            .windows(2)
            .all(|pair| pair[0].first_triangle <= pair[1].first_triangle)
    );
    for target in &model.morphs.targets {
        let moves = &target.displacements;
        assert!(moves.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert!(
            moves
                .iter()
                .all(|(i, u)| *i < n && u.iter().all(|x| x.is_finite()))
        );
        assert!(target.default_weight.is_finite());
    }
    if let Some(clip) = &model.morphs.clip {
        assert_eq!(
            clip.weights.len(),
            clip.times_s.len() * model.morphs.targets.len()
        );
        assert!(clip.times_s.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(
            clip.weights
                .iter()
                .chain(&clip.times_s)
                .all(|x| x.is_finite())
        );
    }
}

/// Reads `bytes`; true if there is a model.
fn survives(bytes: &[u8]) -> bool {
    match read(bytes) {
        Ok(model) => {
            check(&model);
            true
        }
        Err(text) => {
            assert!(text.starts_with("m: "), "{text}");
            false
        }
    }
}

#[test]
fn any_byte_may_be_wrong() {
    let mut models = 0;
    for name in ["morph_nodes.glb", "strips_fans.glb", "morph_nodes.gltf"] {
        let mut bytes = models::content(name);
        for at in 0..bytes.len() {
            let right = bytes[at];
            for wrong in [0, 0xff, right ^ 0x10, right.wrapping_add(1)] {
                bytes[at] = wrong;
                models += usize::from(survives(&bytes));
            }
            bytes[at] = right;
        }
    }
    println!("{models} models");
    assert!(models > 1000, "{models}");
}

#[test]
fn any_end_may_be_missing() {
    for name in ["morph_nodes.glb", "strips_fans.glb", "morph_nodes.gltf"] {
        let bytes = models::content(name);
        for end in 0..bytes.len() {
            // The text ends in a line feed that JSON does not need.
            assert_eq!(
                survives(&bytes[..end]),
                end + 1 == bytes.len() && name.ends_with("f"),
                "{name} {end}"
            );
            // The same with a header that fits.
            if end >= 20 && name.ends_with("b") {
                let mut whole = bytes[..end].to_vec();
                whole[8..12].copy_from_slice(&(end as u32).to_le_bytes());
                survives(&whole);
            }
        }
    }
}

/// Replaces, removes or repeats values of the document, at random places.
#[test]
fn any_value_may_be_wrong() {
    let values = [
        json!(null),
        json!(true),
        json!(0),
        json!(1),
        json!(2),
        json!(-1),
        json!(255),
        json!(65535),
        json!(4294967295_u32),
        json!(4294967296_u64),
        json!(18446744073709551615_u64),
        json!(0.5),
        json!(1e300),
        json!(-1e-300),
        json!(""),
        json!("POSITION"),
        json!("VEC3"),
        json!("STEP"),
        json!("CUBICSPLINE"),
        json!("../x"),
        json!([]),
        json!([0]),
        json!([0, 0]),
        json!([1, 1, 1]),
        json!({}),
        json!({"POSITION": 0}),
    ];
    let (sound, binary) = parts();
    let mut rng = rng(5);
    let mut models = 0;
    for _ in 0..6000 {
        let mut document = sound.clone();
        for _ in 0..rng.random_range(1..4) {
            let mut pointers = Vec::new();
            walk(&document, String::new(), &mut pointers);
            let pointer = &pointers[rng.random_range(0..pointers.len())];
            let value = values[rng.random_range(0..values.len())].clone();
            let (parent, key) = pointer.rsplit_once('/').expect("not the root");
            let key = key.replace("~1", "/");
            match (document.pointer_mut(parent), rng.random_range(0..4)) {
                (Some(Value::Object(fields)), 0) => drop(fields.remove(&key)),
                (Some(Value::Array(list)), 0) => {
                    let again = list[0].clone();
                    list.push(again);
                }
                (Some(Value::Object(fields)), _) => drop(fields.insert(key, value)),
                (Some(Value::Array(list)), _) => {
                    let at = key.parse::<usize>().expect("an index");
                    list[at] = value;
                }
                (other, _) => panic!("{pointer}: {other:?}"),
            }
        }
        models += usize::from(survives(&pack(document.to_string().as_bytes(), &binary)));
    }
    println!("{models} models");
    assert!(models > 300, "{models}");
}

/// Pointers to all values below the root.
fn walk(value: &Value, at: String, pointers: &mut Vec<String>) {
    if !at.is_empty() {
        pointers.push(at.clone());
    }
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                walk(value, format!("{at}/{}", key.replace('/', "~1")), pointers);
            }
        }
        Value::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                walk(value, format!("{at}/{i}"), pointers);
            }
        }
        _ => {}
    }
}
