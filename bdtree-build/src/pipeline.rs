//! The whole bake: section 3.1 of the paper (D. L. James and D. K. Pai, "BD-Tree: output-sensitive collision detection
//! for reduced deformable models", SIGGRAPH 2004) from files to a file.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use bdtree_format::{BASE_ALIGNMENT, ErrorMetadata, LEAF_TRIANGLES_MAX, Metadata, ModeMetadata};
use bdtree_output::write_whole;
use bdtree_runtime::{Asset, Model, Transform};

use crate::basis::{Basis, BasisError};
use crate::encode::{Parts, encode};
use crate::error::{BakeError, Part, Place, one_line};
use crate::input::{RawMesh, RawSkin};
use crate::mass::{self, Body};
use crate::motion;
use crate::progress::Progress;
use crate::recipe::Recipe;
use crate::report::visits::{self, Visits};
use crate::report::{self, BakeReport, Bounds};
use crate::skin::{self, Weights};
use crate::tree::{self, Split, TreeSettings};
use crate::wrap;

/// Meshes above this many triangles get larger leaves, so that the file stays small.
const LARGE_MESH_TRIANGLES: usize = 1 << 19;

/// Most triangles in a leaf lane unless told otherwise: 4, and 8 for more than 2¹⁹ triangles
/// (docs/design/decisions/tree-split-and-leaf-size.md).
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
    /// What becomes of weights of bones whose sum is not 1.
    pub weights: Weights,
    /// What the body weighs. Bakes of vibration modes have it of their own.
    pub body: Body,
    /// Threads to work with; the bytes do not depend on it.
    pub threads: usize,
}

impl BakeSettings {
    /// Most triangles in a leaf lane of this mesh.
    pub(crate) fn leaf_size_for(&self, mesh: &RawMesh) -> usize {
        self.leaf_size
            .unwrap_or_else(|| default_leaf_size(mesh.triangles.len()))
    }
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            leaf_size: None,
            split: Split::default(),
            nested: false,
            weights: Weights::default(),
            body: Body::default(),
            threads: 1,
        }
    }
}

/// Where fields came from, as the file's metadata tells.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// `rigid`, `given`, `elastic`, `volume`, `morph` or `pca`.
    pub kind: String,
    /// Error of the basis against its source, if there is a source to measure against.
    pub error: Option<BasisError>,
    /// Settings: option name and value. No paths, no thread counts.
    pub settings: BTreeMap<String, String>,
    /// What was odd but kept, besides the mesh's own warnings.
    pub warnings: Vec<String>,
}

impl Default for Provenance {
    fn default() -> Self {
        Self {
            kind: "given".to_string(),
            error: None,
            settings: BTreeMap::new(),
            warnings: Vec::new(),
        }
    }
}

impl Provenance {
    pub(crate) fn set(&mut self, name: &str, value: impl ToString) {
        self.settings.insert(name.to_string(), value.to_string());
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

impl Baked {
    /// Puts the file at `path`: all of it or nothing ([`bdtree_output::write_whole`]).
    ///
    /// # Errors
    /// A folder that is missing or may not be written, a full disk.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), BakeError> {
        Ok(write_whole(path.as_ref(), |w| w.write_all(&self.bytes))?)
    }
}

/// The file that `recipe` describes, and what was made.
///
/// # Errors
/// Everything that is wrong with a file that is read or with what is asked of it, each problem with its place; what
/// [`bake_fields`] refuses.
pub fn bake(recipe: &Recipe, progress: &dyn Progress) -> Result<Baked, BakeError> {
    let named = |error: BakeError| error.in_file(recipe.source.main_file());
    let mut stages = Stages::new(progress);

    // All files first: what is wrong with one is told before minutes of work. `motion` asks for what moves; meshes
    // are read by `input` (OBJ by `input/obj`, GLB and glTF by `input/gltf`).
    stages.begin("input");
    let read = motion::read(recipe, progress).map_err(named)?;

    // Section 2: a shape is p' = p + U q, with fields U that are known before the tree is built. Whatever made them
    // (vibrations, frames, morph targets), nothing below asks where they came from.
    stages.begin("basis");
    let mut moving = read.moving(recipe, progress).map_err(named)?;
    let settings = BakeSettings {
        body: moving.body.unwrap_or(recipe.settings.body),
        ..recipe.settings.clone()
    };
    moving.say_unused_mass_options(recipe, &settings.body);

    let mut baked = build(
        (&moving.mesh, &moving.basis, moving.skin.as_ref()),
        &settings,
        &moving.provenance,
        stages,
    )
    .map_err(named)?;
    baked.report.scale_m = recipe.source.scale_m().filter(|_| moving.is_body());
    baked.report.elastic = moving.elastic;
    baked.report.volume = moving.volume;
    Ok(baked)
}

/// The file of a mesh and its basis in memory (rigid when the basis has no modes).
///
/// # Errors
/// Whatever [`wrap::store`], [`wrap::wrap`] and [`encode`] refuse, a leaf size out of range, a basis
/// error that is no number or of no vertex, and a file that [`Asset::open`] would refuse.
pub fn bake_fields(
    mesh: &RawMesh,
    basis: &Basis,
    settings: &BakeSettings,
    provenance: &Provenance,
    progress: &dyn Progress,
) -> Result<Baked, BakeError> {
    let stages = Stages::new(progress);
    build((mesh, basis, None), settings, provenance, stages)
}

/// The file of a mesh, its basis and what carries the vertices after the fields have moved them. Weights that the clips
/// of the skin move are modes.
///
/// # Errors
/// Those of [`bake_fields`]; what [`skin::store`] refuses; a skin and frames.
pub fn bake_skinned(
    mesh: &RawMesh,
    basis: &Basis,
    skin: &RawSkin,
    settings: &BakeSettings,
    provenance: &Provenance,
    progress: &dyn Progress,
) -> Result<Baked, BakeError> {
    let stages = Stages::new(progress);
    build((mesh, basis, Some(skin)), settings, provenance, stages)
}

/// Section 3.1, then the file.
fn build(
    (mesh, basis, skin): (&RawMesh, &Basis, Option<&RawSkin>),
    settings: &BakeSettings,
    provenance: &Provenance,
    mut stages: Stages<'_>,
) -> Result<Baked, BakeError> {
    let progress = stages.progress;
    let leaf_size = leaf_size(mesh, settings)?;
    check_body(&settings.body)?;
    let mut warnings: Vec<String> = (mesh.warnings.iter().chain(&provenance.warnings))
        .map(|warning| one_line(warning).into_owned())
        .collect();

    // p and U are rounded to f32 before anything is bounded, so that bounds are those of the numbers that queries
    // will read.
    stages.begin("store");
    let shape = wrap::store(mesh, basis, &mut warnings)?;
    if skin.is_some() && shape.frames.is_some() {
        let message = "a file with a skin has no frames: clips are what it plays";
        return Err(BakeError::one("skin", Part::The("animation"), message));
    }
    let store = |skin| skin::store(mesh, skin, settings.weights, &shape, &mut warnings);
    let stored_skin = skin.map(store).transpose()?;

    // What it weighs at rest, where its surface or its basis tells.
    let mass = (settings.body).properties(&mesh.positions, &mesh.triangles, &mut warnings);
    let momenta = mass.and_then(|mass| mass::momenta(basis, &mass));

    // The hierarchy is that of the undeformed mesh: fields are smooth, so triangles that are near at rest stay so.
    stages.begin("tree");
    // Bones carry vertices elsewhere: with them it is that of the pose at rest, drawn together by bones.
    let carried = stored_skin
        .as_ref()
        .map(|skin| skin::tree_positions(&shape, skin));
    let tree = tree::build_told(
        carried.as_deref().unwrap_or(&shape.positions),
        &mesh.triangles,
        &TreeSettings {
            split: settings.split,
            leaf_size,
            threads: settings.threads,
        },
        progress,
    );

    // A wrapped hierarchy: spheres around the geometry below them and not around their children's spheres, with what
    // each field adds to center and radius (section 3.2). Tighter, and each can be updated on its own.
    stages.begin_of("wrap", tree.nodes.len());
    let mut wrapped = wrap::wrap_told(&tree, &mesh.triangles, &shape, settings.threads, progress)?;
    if settings.nested {
        // Looser: only for those who stop at a level and need proxies inside their ancestors.
        wrap::nest(&mut wrapped);
        if skin.is_some() {
            let warning =
                "--nested: spheres hold those below them before bones carry them, not after";
            warnings.push(warning.to_string());
        }
    }
    // A lane's sphere is carried as its vertices are: by the ranges of their weights.
    let wrap_bones = |skin| wrap::wrap_bones(&tree, &mesh.triangles, skin, settings.threads);
    let bones = stored_skin.as_ref().map(wrap_bones).transpose()?;

    // Everything lies in the file as queries read it, so that opening one costs nothing.
    stages.begin("encode");
    check_error(provenance.error, mesh)?;
    let metadata = metadata(mesh, basis, provenance, &warnings);
    let bytes = encode(&Parts {
        mesh,
        basis,
        shape: &shape,
        tree: &tree,
        wrapped: &wrapped,
        skin: stored_skin.as_ref().zip(bones.as_ref()),
        mass: mass
            .as_ref()
            .map(|mass| (mass, momenta.as_deref().unwrap_or_default())),
        metadata: &metadata,
    })?;

    // Section 3.3: how tight the bounds are, and what that costs a query, measured on the file itself.
    stages.begin("report");
    let (visits, bounds_at_rest) = measure(&bytes)?;
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
        joints: stored_skin.as_ref().map(|skin| skin.joints.len()),
        bones: stored_skin.as_ref().map(|skin| skin.bones.len()),
        influences_max: stored_skin
            .as_ref()
            .map(|skin| skin.record.influences_max as usize),
        clips: stored_skin.as_ref().map(|skin| skin.clips.len()),
        frames: shape.frames.as_ref().map(|frames| frames.records.len()),
        duration_s: duration_s(basis),
        nodes: wrapped.nodes.len(),
        depth: tree.depth,
        bytes: bytes.len(),
        bounds: mesh.bounds(),
        bounds_at_rest,
        warnings,
        stages: stages.end(),
        frequencies_hz: report::frequencies_hz(basis),
        basis_error_rel: provenance.error,
        tightness,
        visits,
        mass,
        scale_m: None,
        elastic: None,
        volume: None,
    };
    Ok(Baked { bytes, report })
}

/// The time of the last frame after the first, if frames have times.
fn duration_s(basis: &Basis) -> Option<f64> {
    let times = basis.animation.as_ref()?.times_s.as_ref()?;
    Some(times.last()? - times.first()?)
}

/// The leaf size that the settings ask for.
fn leaf_size(mesh: &RawMesh, settings: &BakeSettings) -> Result<usize, BakeError> {
    let leaf_size = settings.leaf_size_for(mesh);
    if (1..=LEAF_TRIANGLES_MAX).contains(&leaf_size) {
        return Ok(leaf_size);
    }
    let message = format!("{leaf_size} is not in 1..={LEAF_TRIANGLES_MAX}");
    Err(BakeError::one("tree", Part::The("leaf size"), message))
}

/// Density and scale are numbers that something can have.
fn check_body(body: &Body) -> Result<(), BakeError> {
    for (option, value) in [("--density", body.density_kg_m3), ("--scale", body.scale_m)] {
        if !(value.is_finite() && value > 0.0) {
            let message = format!("{value} is not a positive number");
            return Err(BakeError::one("store", Place::option(option), message));
        }
    }
    Ok(())
}

/// Opens the file that was made and queries it; of a file with a skin also the box of the mesh with its bones at rest.
/// Bytes that readers would refuse are refused here: no such file is written.
fn measure(bytes: &[u8]) -> Result<(Visits, Option<Bounds>), BakeError> {
    // Allocators align large blocks, so the copy is for small files.
    let misaligned = !(bytes.as_ptr() as usize).is_multiple_of(BASE_ALIGNMENT);
    let copy = misaligned.then(|| Model::from_bytes(bytes).ok()).flatten();
    let aligned = copy.as_ref().map_or(bytes, |copy| copy.asset().bytes());
    let fail = |what: String| {
        let message = format!("the file that was made cannot be {what}");
        BakeError::one("encode", Place::NOWHERE, message)
    };
    let asset = Asset::open(aligned).map_err(|error| fail(format!("opened: {error}")))?;
    let visits = visits::visits(&asset).ok_or_else(|| fail("queried".to_string()))?;
    if !asset.has_skin() {
        return Ok((visits, None));
    }
    let (q, mut memory) = (vec![0.0; asset.mode_count()], vec![0.0; asset.pose_len()]);
    let pose = asset.pose(&q, Transform::IDENTITY, &mut memory);
    let pose = pose.map_err(|error| fail(format!("posed: {error}")))?;
    let at_rest = pose.exact_aabb();
    let at_rest = at_rest.map_err(|error| fail(format!("posed: {error}")))?;
    Ok((visits, Some([at_rest.min, at_rest.max])))
}

fn metadata(
    mesh: &RawMesh,
    basis: &Basis,
    provenance: &Provenance,
    warnings: &[String],
) -> Metadata {
    let mut kept = warnings[..warnings.len().min(METADATA_WARNINGS_MAX)].to_vec();
    if kept.len() < warnings.len() {
        kept.push(format!("and {} more", warnings.len() - kept.len()));
    }
    Metadata {
        builder: concat!("bdtree-build ", env!("CARGO_PKG_VERSION")).to_string(),
        source_name: mesh.name.clone(),
        source_hash: mesh.hash,
        basis: provenance.kind.clone(),
        settings: provenance.settings.clone(),
        modes: basis
            .modes
            .iter()
            .map(|mode| ModeMetadata {
                name: mode.name.clone(),
                default_q: mode.default_q,
            })
            .collect(),
        basis_error_rel: provenance.error.map(|e| ErrorMetadata {
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
    Err(BakeError::one(
        "encode",
        Part::The("error of the basis"),
        message,
    ))
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

    /// Begins a stage of so many steps.
    fn begin_of(&mut self, name: &'static str, steps: usize) {
        self.progress.stage(name, Some(steps as u64));
        self.begun.push((name, Instant::now()));
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
