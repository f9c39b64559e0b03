//! From a path to a volume: the right reader for the file, its bytes, their hash.

use std::fs;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::{RawVolume, gmsh, veg, vtk};
use crate::error::{BakeError, Place};
use crate::input::load::{decompress, forget_folder, unreadable};
use crate::input::read_file::read_file;

/// What every refusal of a format ends with.
const SUPPORTED: &str = "read as volumes: .veg, .vtk, .msh, each also .gz";

/// Extensions of formats that are known but not read.
const KNOWN: [&str; 10] = [
    "vegb", "vtu", "node", "ele", "inp", "bdf", "mesh", "med", "exo", "obj",
];

/// The volume mesh at `path`, chosen by extension (any case): VegaFEM `.veg`, legacy VTK `.vtk` or
/// Gmsh `.msh`; compression is recognised by content.
///
/// Every element is positively oriented. The whole file is held in memory while it is read.
///
/// # Errors
/// A path that cannot be read, a format that is not read, damaged compression, and every problem of
/// the file, with its line or byte: numbers that are none or not finite, indices out of range,
/// counts that do not fit, solids other than linear tetrahedra and hexahedra, elements that repeat
/// a corner, have no volume or are folded, materials other than linear isotropic ones.
pub fn read_volume(path: &Path) -> Result<RawVolume, BakeError> {
    let place = path.display().to_string();
    let meta = fs::metadata(path).map_err(|e| unreadable(&place, &e))?;
    if meta.is_dir() {
        let message = format!("is a folder, not a volume file ({SUPPORTED})");
        return Err(BakeError::one("input", path, message));
    }
    parser(&place)?;
    let bytes = read_file(path).map_err(|e| unreadable(&place, &e))?;
    let mut volume = parse_volume(&bytes, &place)?;
    volume.hash = Sha256::digest(&bytes).into();
    volume.name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    forget_folder(path, &mut volume.warnings);
    Ok(volume)
}

/// The volume mesh in the bytes of a file, whose name `place` tells the format and stands in
/// messages; `name` and `hash` are left empty. See [`read_volume`].
///
/// # Errors
/// As [`read_volume`].
pub fn parse_volume(bytes: &[u8], place: &str) -> Result<RawVolume, BakeError> {
    let parse = parser(place)?;
    parse(&decompress(bytes, place)?, place)
}

/// Reads the bytes of a file; the second argument is its name in messages.
type Parser = fn(&[u8], &str) -> Result<RawVolume, BakeError>;

fn parser(place: &str) -> Result<Parser, BakeError> {
    let name = place.rsplit(['/', '\\']).next().unwrap_or_default();
    let name = name.to_lowercase();
    let inner = name.strip_suffix(".gz").unwrap_or(&name);
    let message = match inner.rsplit_once('.').map(|(_, extension)| extension) {
        Some("veg") => return Ok(veg::parse),
        Some("vtk") => return Ok(vtk::parse),
        Some("msh") => return Ok(gmsh::parse),
        Some(known) if KNOWN.contains(&known) => format!(".{known} files are not read"),
        Some(other) => format!("unknown volume format .{other}"),
        None => "no file extension to tell the volume format by".into(),
    };
    Err(BakeError::one(
        "input",
        Place::file(place),
        format!("{message} ({SUPPORTED})"),
    ))
}
