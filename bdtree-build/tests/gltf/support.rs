//! Files with one thing changed.

use std::path::Path;

use bdtree_build::input::{RawModel, gltf};
use bdtree_fixtures::models::{self, gltf::pack, gltf::unpack};
use serde_json::Value;

/// A sound file, taken apart: two nodes with two morph targets each.
pub(crate) fn parts() -> (Value, Vec<u8>) {
    unpack(&models::content("morph_nodes.glb"))
}

/// The model in `bytes`, or the problems; the file is called `m`.
pub(crate) fn read(bytes: &[u8]) -> Result<RawModel, String> {
    gltf::parse(bytes, "m", Path::new("/nowhere"), None).map_err(|e| e.to_string())
}

/// The sound file with values of its document replaced (removed where `null`).
pub(crate) fn edited(edits: &[(&str, Value)]) -> Vec<u8> {
    let (mut document, binary) = parts();
    for (pointer, value) in edits {
        edit(&mut document, pointer, value);
    }
    pack(document.to_string().as_bytes(), &binary)
}

fn edit(document: &mut Value, pointer: &str, value: &Value) {
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    match document.pointer_mut(parent).expect(pointer) {
        Value::Object(fields) if value.is_null() => {
            fields.remove(key);
        }
        Value::Object(fields) => {
            fields.insert(key.to_string(), value.clone());
        }
        Value::Array(list) => match key.parse::<usize>() {
            Ok(at) => list[at] = value.clone(),
            Err(_) => list.push(value.clone()),
        },
        other => panic!("{pointer}: {other}"),
    }
}

/// The sound file with bytes of accessor `accessor` replaced, from its start plus `offset`.
pub(crate) fn rewritten(accessor: usize, offset: usize, bytes: &[u8]) -> Vec<u8> {
    let (document, mut binary) = parts();
    let accessor = &document["accessors"][accessor];
    let view = &document["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize];
    let start = view["byteOffset"].as_u64().expect("an offset") as usize + offset;
    binary[start..start + bytes.len()].copy_from_slice(bytes);
    pack(document.to_string().as_bytes(), &binary)
}
