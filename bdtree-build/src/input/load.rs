//! From a path to a mesh: the right reader for the file, its bytes, their hash.

use std::borrow::Cow;
use std::fs;
use std::io::Read;
use std::path::Path;

use flate2::bufread::MultiGzDecoder;
use sha2::{Digest, Sha256};

use super::read_file::read_file;
use super::{BadFaces, RawMesh, RawModel, faces, gltf, obj, ply, stl};
use crate::error::{BakeError, Place};

/// What every refusal of a format ends with.
const SUPPORTED: &str = "Mesh formats: .obj, .ply, .stl (each also as .gz), .gltf, .glb";

/// Extensions of formats that are known but not read yet.
const LATER: [&str; 4] = ["off", "abc", "fbx", "dae"];

/// Extensions of what is read, but not as the mesh.
const VOLUMES: [&str; 3] = ["veg", "vtk", "msh"];
const SEQUENCES: [&str; 3] = ["pc2", "mdd", "npy"];

/// A format by its extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Obj,
    Ply,
    Stl,
    Gltf,
}

/// The mesh at `path`, chosen by extension (any case): `.obj`, `.ply`, `.stl`, each of them also compressed
/// (`.obj.gz`), `.gltf` or `.glb`.
///
/// Compression is recognized by content, so a compressed `.obj` and a plain `.obj.gz` are read
/// too. The whole file is held in memory while it is read. Of a glTF file this is the mesh with all
/// weights at 0, in its bind pose; [`gltf::read_gltf`] has morph targets and the skin too.
///
/// # Errors
/// A path that cannot be read, a format that is not read, damaged compression, and every problem
/// of the file (see [`obj::parse`], [`ply::parse`], [`stl::parse`], [`gltf::read_gltf`]), each with the
/// path as given and the line, the face or the JSON path.
pub fn read_mesh(path: &Path) -> Result<RawMesh, BakeError> {
    read(path, None, BadFaces::Refuse).map(RawModel::into_mesh)
}

/// The mesh at `path`, as [`read_mesh`] reads it, with its morph targets and its skin if it has some; `clip`
/// names the animation that gives their weights over time, `bad_faces` says whether faces that cannot be read are
/// left out.
///
/// # Errors
/// Those of [`read_mesh`]; an animation of another name.
pub fn read_model(
    path: &Path,
    clip: Option<&str>,
    bad_faces: BadFaces,
) -> Result<RawModel, BakeError> {
    read(path, clip, bad_faces).map_err(faces::with_option)
}

fn read(path: &Path, clip: Option<&str>, bad_faces: BadFaces) -> Result<RawModel, BakeError> {
    let place = path.display().to_string();
    let meta = fs::metadata(path).map_err(|e| unreadable(&place, &e))?;
    if meta.is_dir() {
        return Err(BakeError::one(
            "input",
            Place::file(place),
            format!(
                "is a folder, not a mesh file: give frames as INPUT alone, or as --animation beside the mesh that they deform. {SUPPORTED}"
            ),
        ));
    }
    let format = format(path, &place)?;
    if format == Format::Gltf {
        return gltf::read_gltf(path, clip);
    }
    let bytes = read_file(path).map_err(|e| unreadable(&place, &e))?;
    let text = decompress(&bytes, &place)?;
    let mut mesh = match format {
        Format::Ply => ply::parse(&text, &place, bad_faces),
        Format::Stl => stl::parse(&text, &place),
        Format::Obj | Format::Gltf => obj::parse(&text, &place, bad_faces),
    }?;
    mesh.hash = Sha256::digest(&bytes).into();
    mesh.name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    forget_folder(path, &mut mesh.warnings);
    Ok(RawModel {
        mesh,
        ..RawModel::default()
    })
}

/// Takes the folder of `path` out of warnings: they go into the file, which names no folders and
/// must not depend on how a path was typed.
pub(crate) fn forget_folder(path: &Path, warnings: &mut [String]) {
    let full = path.display().to_string();
    let full = full.trim_end_matches('/');
    let Some(name) = path.file_name().map(|name| name.to_string_lossy()) else {
        return;
    };
    for warning in warnings.iter_mut().filter(|_| full != name) {
        *warning = warning.replace(full, &name);
    }
}

pub(super) fn unreadable(place: &str, error: &std::io::Error) -> BakeError {
    BakeError::one(
        "input",
        Place::file(place),
        format!("cannot be read: {error}"),
    )
}

/// What the extension says; glTF is not read compressed.
fn format(path: &Path, place: &str) -> Result<Format, BakeError> {
    let name = path
        .file_name()
        .map(|name| name.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    let inner = name.strip_suffix(".gz").unwrap_or(&name);
    let Some((_, extension)) = inner.rsplit_once('.') else {
        return Err(BakeError::one(
            "input",
            Place::file(place),
            format!("no file extension to tell the mesh format by. {SUPPORTED}"),
        ));
    };
    let message = match extension {
        "obj" => return Ok(Format::Obj),
        "ply" => return Ok(Format::Ply),
        "stl" => return Ok(Format::Stl),
        "gltf" | "glb" if inner == name => return Ok(Format::Gltf),
        known if LATER.contains(&known) => {
            format!(
                ".{known} files are not supported yet: export .glb, or the frames of an animation as .pc2, .mdd or a \
                 folder of .obj files. {SUPPORTED}"
            )
        }
        volume if VOLUMES.contains(&volume) => {
            format!("is a volume mesh, not a surface: give it as --tets. {SUPPORTED}")
        }
        sequence if SEQUENCES.contains(&sequence) => {
            format!(
                "not a mesh file. Give frames with --animation, displacement fields with --basis. {SUPPORTED}"
            )
        }
        "bdt" => "is a baked file already: `bdtree info` tells what it holds".to_string(),
        "gltf" | "glb" => format!("compressed .{extension} files are not read. {SUPPORTED}"),
        other => format!("unknown mesh format .{other}. {SUPPORTED}"),
    };
    Err(BakeError::one("input", Place::file(place), message))
}

/// Most bytes of text in a compressed file: this, or [`TEXT_PER_BYTE`] times the file's size where
/// that is more. Meshes compress to a third or a tenth; a few kilobytes of zeros to gigabytes.
const TEXT_BYTES: usize = 64 << 20;
const TEXT_PER_BYTE: usize = 100;

/// The text inside `bytes`: gunzipped (all members) when they begin like gzip, else as they are.
pub(super) fn decompress<'a>(bytes: &'a [u8], place: &str) -> Result<Cow<'a, [u8]>, BakeError> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(Cow::Borrowed(bytes));
    }
    let most = TEXT_BYTES.max(TEXT_PER_BYTE.saturating_mul(bytes.len()));
    let mut text = Vec::new();
    MultiGzDecoder::new(bytes)
        .take(most as u64 + 1)
        .read_to_end(&mut text)
        .map_err(|e| {
            BakeError::one(
                "input",
                Place::file(place),
                format!(
                    "damaged or truncated gzip after {} bytes of text: {e}",
                    text.len()
                ),
            )
        })?;
    if text.len() > most {
        let message = format!(
            "more than {} MiB of text in {} bytes of gzip: decompress it first",
            most >> 20,
            bytes.len()
        );
        return Err(BakeError::one("input", Place::file(place), message));
    }
    Ok(Cow::Owned(text))
}
