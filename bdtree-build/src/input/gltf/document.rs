//! The JSON text as the `gltf` crate's document, checked: every index that geometry needs exists.
//!
//! The crate's types and its validation do the work. Around them: mistakes in what a mesh looks
//! like cannot stop a bake, since those parts are not read; numbers that the crate rounds to f32
//! are read again as f64; what the crate refuses though glTF 2.0 allows it is filled in; and its
//! panics are contained (an accessor of a POSITION that does not exist is one).

use gltf::json::validation::{Error as Flaw, Validate};
use gltf::json::{Path, Root};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use serde_json::ser::{PrettyFormatter, Serializer};

use super::extensions;
use super::notes::Notes;
use super::quiet::contained;
use crate::figures::counted;

/// Parts of a document that say what a mesh looks like, and its skins, which are read where they are used.
const UNREAD: [&str; 6] = [
    "cameras",
    "images",
    "materials",
    "samplers",
    "skins",
    "textures",
];

/// Keys whose numbers may be beyond 32 bits; all others are indices or codes.
const LARGE: [&str; 12] = [
    "byteLength",
    "byteOffset",
    "count",
    "extensions",
    "extras",
    "matrix",
    "max",
    "min",
    "rotation",
    "scale",
    "translation",
    "weights",
];

/// A document whose indices were checked.
pub(super) struct Document {
    pub(super) root: Root,
    /// The numbers of `root` in f64, and its names of targets.
    pub(super) exact: Exact,
    /// Name of each material.
    pub(super) materials: Vec<Option<String>>,
    /// The skins as they stand; `root` has none.
    pub(super) skins: Vec<Value>,
}

/// What the crate's types leave out or round.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Exact {
    pub(super) nodes: Vec<ExactNode>,
    pub(super) meshes: Vec<ExactMesh>,
}

/// The numbers of a node.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactNode {
    pub(super) matrix: Option<[f64; 16]>,
    pub(super) translation: Option<[f64; 3]>,
    pub(super) rotation: Option<[f64; 4]>,
    pub(super) scale: Option<[f64; 3]>,
    pub(super) weights: Option<Vec<f64>>,
}

/// The numbers and notes of a mesh.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactMesh {
    pub(super) weights: Option<Vec<f64>>,
    pub(super) extras: Value,
    pub(super) primitives: Vec<ExactPrimitive>,
}

/// The notes of a primitive.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ExactPrimitive {
    pub(super) extras: Value,
}

/// The document in `json`; `None` after noting what is wrong with it.
pub(super) fn parse(json: &[u8], notes: &mut Notes) -> Option<Document> {
    let mut value: Value = match serde_json::from_slice(json) {
        Ok(value) => value,
        Err(error) => {
            return notes.refuse("JSON", error.to_string());
        }
    };
    check_version(&value, notes);
    let materials = names(&value, "materials");
    let skins = value["skins"].as_array().cloned().unwrap_or_default();
    fill_in(&mut value, notes);
    check_size(&value, &mut String::new(), notes);
    if !notes.is_clean() {
        return None;
    }
    // The crate's own function: its types are then compiled once, where they stand.
    let mut root = typed(&value, Root::from_slice, notes)?;
    let exact: Exact = typed(&value, |text| serde_json::from_slice(text), notes)?;
    drop(value);
    let required = std::mem::take(&mut root.extensions_required);
    extensions::check(&required, &root.extensions_used, notes);
    root.extensions_used.extend(required);
    validate(&root, notes);
    notes.is_clean().then_some(Document {
        root,
        exact,
        materials,
        skins,
    })
}

/// Refuses what is no glTF 2.
fn check_version(value: &Value, notes: &mut Notes) {
    if !value.is_object() {
        notes.problem("JSON", "is not an object");
    }
    for (key, wanted) in [("version", "2."), ("minVersion", "2.0")] {
        if let Some(version) = value["asset"][key].as_str()
            && !version.starts_with(wanted)
        {
            let at = format!("asset.{key}");
            notes.problem(at, format!("glTF {version:?} is not read; 2.0 is"));
        }
    }
}

/// Refuses indices beyond 32 bits, which the crate would cut.
fn check_size(value: &Value, at: &mut String, notes: &mut Notes) {
    let length = at.len();
    match value {
        Value::Number(number) if number.as_u64() > Some(u32::MAX.into()) => {
            notes.problem(&*at, format!("{number} is beyond 32 bits"));
        }
        Value::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                at.push_str(&format!("[{i}]"));
                check_size(value, at, notes);
                at.truncate(length);
            }
        }
        Value::Object(fields) => {
            for (key, value) in fields {
                if LARGE.contains(&key.as_str()) {
                    continue;
                }
                let dot = if at.is_empty() { "" } else { "." };
                at.push_str(&format!("{dot}{key}"));
                check_size(value, at, notes);
                at.truncate(length);
            }
        }
        _ => {}
    }
}

/// The `name` of each element of the list `key`.
fn names(value: &Value, key: &str) -> Vec<Option<String>> {
    let list = value[key].as_array();
    list.into_iter()
        .flatten()
        .map(|element| element["name"].as_str().map(str::to_string))
        .collect()
}

/// Takes out what is not read, and fills in what glTF 2.0 lets a file leave out but the crate's
/// types demand.
fn fill_in(value: &mut Value, notes: &mut Notes) {
    let Some(root) = value.as_object_mut() else {
        return;
    };
    for key in UNREAD {
        root.remove(key);
    }
    let list = |list: Option<&mut Value>| match list {
        Some(Value::Array(list)) => std::mem::take(list),
        _ => Vec::new(),
    };
    if let Some(Value::Array(scenes)) = root.get_mut("scenes") {
        for scene in scenes.iter_mut().filter_map(Value::as_object_mut) {
            scene.entry("nodes").or_insert(Value::Array(Vec::new()));
        }
    }
    if let Some(Value::Array(animations)) = root.get_mut("animations") {
        for (i, animation) in animations.iter_mut().enumerate() {
            let mut channels = list(animation.get_mut("channels"));
            let all = channels.len();
            channels.retain(|channel| {
                !channel["target"].is_object() || channel["target"].get("node").is_some()
            });
            if channels.len() < all {
                let at = format!("animations[{i}]");
                let without = counted(all - channels.len(), "channel");
                let message = format!("ignored {without} without a node");
                notes.warn(at, message);
            }
            if all > 0 {
                animation["channels"] = Value::Array(channels);
            }
        }
    }
}

/// `value` as a `T`, by `read`; its mistake is noted with its JSON path.
///
/// The text is written again with one element per line, so that the line of serde_json's error
/// tells the element. (serde_path_to_error does the same, but compiles every type of glTF
/// a second time: 4 % of the program.)
fn typed<T>(
    value: &Value,
    read: fn(&[u8]) -> serde_json::Result<T>,
    notes: &mut Notes,
) -> Option<T> {
    match contained(|| read(&by_lines(value)?)) {
        Ok(Ok(typed)) => Some(typed),
        Ok(Err(error)) => {
            let mut at = String::new();
            find_line(value, &mut error.line().saturating_sub(1), &mut at);
            let message = error.to_string();
            // The place in the text written here would mislead: the file's differs.
            let place = format!(" at line {} column {}", error.line(), error.column());
            notes.refuse(
                at,
                in_words(message.strip_suffix(&place).unwrap_or(&message)),
            )
        }
        Err(panic) => notes.refuse("JSON", format!("damaged: {panic}")),
    }
}

/// The text of a value, each element on a line of its own, without indentation: of nested elements it would be most of the text.
fn by_lines(value: &Value) -> serde_json::Result<Vec<u8>> {
    let mut text = Vec::new();
    let lines = PrettyFormatter::with_indent(b"");
    value.serialize(&mut Serializer::with_formatter(&mut text, lines))?;
    Ok(text)
}

/// serde's words for JSON types as JSON's own: `is an object, expected an array`.
fn in_words(message: &str) -> String {
    let Some((found, wanted)) = message
        .strip_prefix("invalid type: ")
        .and_then(|rest| rest.split_once(", expected "))
    else {
        return message.to_string();
    };
    let word = |text: &str| match text {
        "map" | "a map" => "an object".to_string(),
        "sequence" | "a sequence" => "an array".to_string(),
        "f32" | "f64" => "a number".to_string(),
        other => other.to_string(),
    };
    let found = match found.split_once(' ') {
        None if found == "null" => found.to_string(),
        None => word(found),
        // `integer `5``, `string "a"`
        Some(_) => format!("the {found}"),
    };
    let wanted = match wanted.strip_prefix("struct ") {
        Some(_) => "an object".to_string(),
        None => word(wanted),
    };
    format!("is {found}, expected {wanted}")
}

/// Extends `at`, the path of `value`, to the element that is `lines` lines below where `value`
/// begins in the text with one element per line. True once found; otherwise `lines` is what is
/// left after the last line of `value`.
fn find_line(value: &Value, lines: &mut usize, at: &mut String) -> bool {
    let length = at.len();
    if *lines == 0 {
        return true;
    }
    let mut inside = |step: String, value: &Value| {
        *lines -= 1;
        at.push_str(&step);
        let found = find_line(value, lines, at);
        if !found {
            at.truncate(length);
        }
        found
    };
    let dot = if length == 0 { "" } else { "." };
    let (found, empty) = match value {
        Value::Array(list) => (
            (list.iter().enumerate()).any(|(i, value)| inside(format!("[{i}]"), value)),
            list.is_empty(),
        ),
        Value::Object(fields) => (
            fields
                .iter()
                .any(|(key, value)| inside(format!("{dot}{key}"), value)),
            fields.is_empty(),
        ),
        _ => (false, true),
    };
    if found || empty {
        return found;
    }
    // The line of the closing bracket.
    *lines -= 1;
    *lines == 0
}

/// Notes what the crate's validation finds wrong with geometry.
fn validate(root: &Root, notes: &mut Notes) {
    let mut found: Vec<(Path, Flaw)> = Vec::new();
    let end = contained(|| {
        root.validate(root, Path::new, &mut |path, flaw| {
            found.push((path(), flaw))
        });
    });
    for (path, flaw) in found {
        let at = path.as_str().replace(".positions", ".POSITION");
        if at == "scene"
            && let Some(scene) = &root.scene
        {
            let scenes = match root.scenes.len() {
                0 => "no scenes".to_string(),
                count => counted(count, "scene"),
            };
            let message = format!(
                "scene {} does not exist (the file has {scenes})",
                scene.value()
            );
            notes.problem("", message);
        } else if matters(&at, flaw) {
            let message = match flaw {
                Flaw::IndexOutOfBounds => "refers to an element that the file does not have",
                Flaw::Invalid => "is not a value that glTF 2.0 knows",
                Flaw::Missing => "is missing",
                Flaw::Oversize => "is larger than any memory",
                Flaw::Unsupported => "is not supported",
            };
            notes.problem(at, message);
        }
    }
    if let Err(panic) = end
        && notes.is_clean()
    {
        notes.problem("JSON", format!("damaged: {panic}"));
    }
}

/// False for flaws in parts that are not read, or that are looked at where they are used.
fn matters(at: &str, flaw: Flaw) -> bool {
    let key = at.rsplit('.').next().unwrap_or(at);
    match key {
        // The elements were taken out.
        "camera" | "material" | "skin" | "normals" | "tangents" => false,
        // Bounds are not used.
        "min" | "max" => false,
        // An accessor without data is one of zeros.
        "bufferView" => flaw != Flaw::Missing,
        _ if at.starts_with("animations") => false,
        _ if key.starts_with("attributes[") => key.contains("POSITION"),
        _ => true,
    }
}
