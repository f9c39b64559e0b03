//! The whole bake.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use bdtree_format::{BASE_ALIGNMENT, ErrorMetadata, LEAF_TRIANGLES_MAX, Metadata, ModeMetadata};
use bdtree_runtime::{AlignedBytes, Asset};
use tempfile::NamedTempFile;

use crate::basis::{Basis, BasisError};
use crate::encode::{Parts, encode};
use crate::error::{BakeError, one_line};
use crate::input::RawMesh;
use crate::progress::Progress;
use crate::report::visits::{self, Visits};
use crate::report::{self, BakeReport};
use crate::tree::{self, Split, TreeSettings};
use crate::wrap;

/// Meshes above this many triangles get larger leaves, so that the file stays small.
const LARGE_MESH_TRIANGLES: usize = 1 << 19;

/// Most triangles in a leaf lane unless told otherwise: 4, and 8 for more than 2¹⁹ triangles
/// (docs/decisions/tree-split-and-leaf-size.md).
pub fn default_leaf_size(triangle_count: usize) -> usize {
    if triangle_count > LARGE_MESH_TRIANGLES {
        8
    } else {
        4
    }
}

/// Warnings that the file's metadata carries; the report has all.
const METADATA_WARNINGS_MAX: usize = 1000;

/// How a mesh and a basis become a file.
#[derive(Debug, Clone, PartialEq)]
pub struct BakeSettings {
    /// Most triangles in a leaf lane, 1 to 255; `None`: [`default_leaf_size`].
    pub leaf_size: Option<usize>,
    /// How sets of triangles are divided.
    pub split: Split,
    /// Whether spheres hold those below them at every q ([`wrap::nest`]): larger bounds, for bounded
    /// depth where proxies are to lie in their ancestors' spheres.
    pub nested: bool,
    /// Threads to work with; the bytes do not depend on it.
    pub threads: usize,
    /// Where the basis came from: `rigid`, `given`, `elastic`, …
    pub basis_kind: String,
    /// Error of the basis against its source, if there is a source to measure against.
    pub basis_error: Option<BasisError>,
    /// Settings for the metadata: option name and value. No paths, no thread counts.
    pub metadata: BTreeMap<String, String>,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            leaf_size: None,
            split: Split::default(),
            nested: false,
            threads: 1,
            basis_kind: "given".to_string(),
            basis_error: None,
            metadata: BTreeMap::new(),
        }
    }
}

/// A baked file and what was made.
#[derive(Debug, Clone)]
pub struct Baked {
    /// The `.bdt` file.
    pub bytes: Vec<u8>,
    /// Sizes, times, tightness.
    pub report: BakeReport,
}

/// The file of a mesh and its basis (rigid when the basis has no modes). `warnings` of earlier
/// stages join the mesh's own in report and metadata.
///
/// # Errors
/// Whatever [`wrap::store`], [`wrap::wrap`] and [`encode`] refuse, a leaf size out of range, a basis
/// error that is no number or of no vertex, and a file that [`Asset::open`] would refuse.
pub fn bake(
    mesh: &RawMesh,
    basis: &Basis,
    settings: &BakeSettings,
    warnings: &[String],
    progress: &dyn Progress,
) -> Result<Baked, BakeError> {
    let leaf_size = settings
        .leaf_size
        .unwrap_or_else(|| default_leaf_size(mesh.triangles.len()));
    if !(1..=LEAF_TRIANGLES_MAX).contains(&leaf_size) {
        let message = format!("{leaf_size} is not in 1..={LEAF_TRIANGLES_MAX}");
        return Err(BakeError::one("tree", "leaf size", message));
    }
    let mut stages = Stages::new(progress);
    let mut warnings: Vec<String> = [mesh.warnings.as_slice(), warnings]
        .concat()
        .iter()
        .map(|warning| one_line(warning).into_owned())
        .collect();

    stages.begin("store");
    let shape = wrap::store(mesh, basis, &mut warnings)?;

    stages.begin("tree");
    let tree = tree::build(
        &shape.positions,
        &mesh.triangles,
        &TreeSettings {
            split: settings.split,
            leaf_size,
            threads: settings.threads,
        },
    );

    stages.begin("wrap");
    let mut wrapped = wrap::wrap(&tree, &mesh.triangles, &shape, settings.threads)?;
    if settings.nested {
        wrap::nest(&mut wrapped);
    }

    stages.begin("encode");
    check_error(settings.basis_error, mesh)?;
    let metadata = metadata(mesh, basis, settings, &warnings);
    let bytes = encode(&Parts {
        mesh,
        basis,
        shape: &shape,
        tree: &tree,
        wrapped: &wrapped,
        metadata: &metadata,
    })?;

    stages.begin("report");
    let visits = measure_visits(&bytes)?;
    warnings.extend(visits::warning(
        visits,
        wrapped.nodes.len(),
        basis.mode_count(),
    ));
    let tightness = report::tightness(&tree, &mesh.triangles, &shape, &wrapped);
    let report = BakeReport {
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
        modes: basis.mode_count(),
        frames: shape.frames.as_ref().map(|frames| frames.records.len()),
        nodes: wrapped.nodes.len(),
        depth: tree.depth,
        bytes: bytes.len(),
        warnings,
        stages: stages.end(),
        frequencies_hz: report::frequencies_hz(basis),
        basis_error_rel: settings.basis_error.map(Into::into),
        tightness,
        visits,
    };
    Ok(Baked { bytes, report })
}

/// Opens the file that was made and queries it. Bytes that readers would refuse are refused here:
/// no such file is written.
fn measure_visits(bytes: &[u8]) -> Result<Visits, BakeError> {
    let copy;
    let aligned = if (bytes.as_ptr() as usize).is_multiple_of(BASE_ALIGNMENT) {
        bytes
    } else {
        copy = AlignedBytes::copy_of(bytes);
        &copy
    };
    let asset = Asset::open(aligned).map_err(|error| {
        let message = format!("the file that was made cannot be opened: {error}");
        BakeError::one("encode", "", message)
    })?;
    visits::visits(&asset)
        .ok_or_else(|| BakeError::one("encode", "", "the file that was made cannot be queried"))
}

fn metadata(
    mesh: &RawMesh,
    basis: &Basis,
    settings: &BakeSettings,
    warnings: &[String],
) -> Metadata {
    let mut kept: Vec<String> = warnings
        .iter()
        .take(METADATA_WARNINGS_MAX)
        .cloned()
        .collect();
    if kept.len() < warnings.len() {
        kept.push(format!("and {} more", warnings.len() - kept.len()));
    }
    Metadata {
        builder: concat!("bdtree-build ", env!("CARGO_PKG_VERSION")).to_string(),
        source_name: mesh.name.clone(),
        source_hash: mesh.hash,
        basis: settings.basis_kind.clone(),
        settings: settings.metadata.clone(),
        modes: basis
            .modes
            .iter()
            .map(|mode| ModeMetadata {
                name: mode.name.clone(),
                default_q: mode.default_q,
            })
            .collect(),
        basis_error_rel: settings.basis_error.map(|e| ErrorMetadata {
            max: e.max_rel,
            rms: e.rms_rel,
            frame: e.frame.map(|frame| frame as u64),
            vertex: Some(e.vertex as u64),
        }),
        warnings: kept,
    }
}

/// A stated error is a measured one (SPEC 8).
fn check_error(error: Option<BasisError>, mesh: &RawMesh) -> Result<(), BakeError> {
    let Some(error) = error else {
        return Ok(());
    };
    let is_norm = |x: f64| x >= 0.0 && x.is_finite();
    if is_norm(error.max_rel) && is_norm(error.rms_rel) && error.vertex < mesh.positions.len() {
        return Ok(());
    }
    let message = format!(
        "{error:?} is no error of a mesh of {} vertices",
        mesh.positions.len()
    );
    Err(BakeError::one("encode", "error of the basis", message))
}

/// The stages that have begun, with their times.
struct Stages<'a> {
    progress: &'a dyn Progress,
    begun: Vec<(&'static str, Instant)>,
}

impl<'a> Stages<'a> {
    fn new(progress: &'a dyn Progress) -> Self {
        Self {
            progress,
            begun: Vec::new(),
        }
    }

    fn begin(&mut self, name: &'static str) {
        self.progress.stage(name, None);
        self.begun.push((name, Instant::now()));
    }

    /// Seconds per stage.
    fn end(self) -> BTreeMap<String, f64> {
        let ends = self.begun.iter().skip(1).map(|(_, begin)| *begin);
        self.begun
            .iter()
            .zip(ends.chain([Instant::now()]))
            .map(|((name, begin), end)| (name.to_string(), (end - *begin).as_secs_f64()))
            .collect()
    }
}

/// Writes a file so that `path` holds either what it held before or all of `bytes`: into a
/// temporary file in the same folder, which then takes the name. Links are followed; a device or
/// a pipe is written to and stays what it is. A process that is killed meanwhile leaves the
/// temporary file, `.bdtree-*.tmp`.
///
/// # Errors
/// A folder that is missing or may not be written, a full disk.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), BakeError> {
    if is_special(path) {
        return fs::OpenOptions::new()
            .write(true)
            .open(path)
            .and_then(|mut device| device.write_all(bytes))
            .map_err(|e| failed(path, "cannot write", &e));
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| PathBuf::from(path));
    let mut file = temporary(path, &target)?;
    file.write_all(bytes)
        .and_then(|()| file.as_file().sync_all())
        .map_err(|e| failed(path, "cannot write", &e))?;
    file.persist(&target)
        .map_err(|e| failed(path, "cannot put the finished file in place", &e.error))?;
    Ok(())
}

/// Nothing, if [`write_atomically`] could begin now: told before a bake that takes minutes.
///
/// # Errors
/// A path that is a folder, a folder that is missing or may not be written.
pub fn check_writable(path: &Path) -> Result<(), BakeError> {
    if path.is_dir() {
        let place = path.display().to_string();
        return Err(BakeError::one("file", place, "is a folder: name a file"));
    }
    if !is_special(path) {
        let target = fs::canonicalize(path).unwrap_or_else(|_| PathBuf::from(path));
        temporary(path, &target)?;
    }
    Ok(())
}

/// A device or a pipe.
fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir())
}

/// An empty file beside `target`, gone when it is dropped; `path` is what errors name.
fn temporary(path: &Path, target: &Path) -> Result<NamedTempFile, BakeError> {
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".bdtree-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // What any new file gets (the process's mask applies), not the private mode of
        // temporary files.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder
        .tempfile_in(folder)
        .map_err(|e| failed(path, "cannot create a file in this folder", &e))
}

fn failed(path: &Path, what: &str, error: &std::io::Error) -> BakeError {
    let message = format!("{what}: {}", cause(error));
    BakeError::one("file", path.display().to_string(), message)
}

/// An error without the name of the temporary file, which says nothing to anyone. (`tempfile` puts
/// it behind the system's text, and hides the system's error number.)
fn cause(error: &std::io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" at path ") {
        Some((cause, _)) => cause.to_string(),
        None => text,
    }
}
