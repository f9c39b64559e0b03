//! From a path to a mesh: the right reader for the file, its bytes, their hash.

use std::borrow::Cow;
use std::fs;
use std::io::Read;
use std::path::Path;

use flate2::bufread::MultiGzDecoder;
use sha2::{Digest, Sha256};

use super::{RawMesh, obj};
use crate::error::BakeError;

/// What every refusal of a format ends with.
const SUPPORTED: &str = "read now: .obj, .obj.gz";

/// Extensions of formats that are known but not read yet.
const LATER: [&str; 13] = [
    "gltf", "glb", "ply", "stl", "off", "veg", "vtk", "msh", "pc2", "mdd", "abc", "fbx", "dae",
];

/// The mesh at `path`, chosen by extension (any case): `.obj` or `.obj.gz`.
///
/// Compression is recognised by content, so a compressed `.obj` and a plain `.obj.gz` are read
/// too. The whole file is held in memory while it is read.
///
/// # Errors
/// A path that cannot be read, a format that is not read, damaged compression, and every problem
/// of the OBJ text (see [`obj::parse`]), each with the path as given and the line.
pub fn read_mesh(path: &Path) -> Result<RawMesh, BakeError> {
    let place = path.display().to_string();
    let meta = fs::metadata(path).map_err(|e| unreadable(&place, &e))?;
    if meta.is_dir() {
        return Err(BakeError::one(
            "input",
            place,
            format!("is a folder, not a mesh file ({SUPPORTED})"),
        ));
    }
    check_format(path, &place)?;
    let bytes = fs::read(path).map_err(|e| unreadable(&place, &e))?;
    let text = decompress(&bytes, &place)?;
    let mut mesh = obj::parse(&text, &place)?;
    mesh.hash = Sha256::digest(&bytes).into();
    mesh.name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    Ok(mesh)
}

pub(super) fn unreadable(place: &str, error: &std::io::Error) -> BakeError {
    BakeError::one("input", place, format!("cannot be read: {error}"))
}

/// Refuses every extension but `.obj` and `.obj.gz`.
fn check_format(path: &Path, place: &str) -> Result<(), BakeError> {
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    let inner = name.strip_suffix(".gz").unwrap_or(&name);
    let Some((_, extension)) = inner.rsplit_once('.') else {
        return Err(BakeError::one(
            "input",
            place,
            format!("no file extension to tell the mesh format by ({SUPPORTED})"),
        ));
    };
    let message = match extension {
        "obj" => return Ok(()),
        known if LATER.contains(&known) => {
            format!(".{known} files are not supported yet ({SUPPORTED})")
        }
        other => format!("unknown mesh format .{other} ({SUPPORTED})"),
    };
    Err(BakeError::one("input", place, message))
}

/// The text inside `bytes`: gunzipped (all members) when they begin like gzip, else as they are.
fn decompress<'a>(bytes: &'a [u8], place: &str) -> Result<Cow<'a, [u8]>, BakeError> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut text = Vec::new();
    MultiGzDecoder::new(bytes)
        .read_to_end(&mut text)
        .map_err(|e| {
            BakeError::one(
                "input",
                place,
                format!(
                    "damaged or truncated gzip after {} bytes of text: {e}",
                    text.len()
                ),
            )
        })?;
    Ok(Cow::Owned(text))
}
