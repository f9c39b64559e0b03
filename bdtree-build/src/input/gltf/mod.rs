//! glTF 2.0, `.gltf` and `.glb`: meshes where the scene's nodes put them, their morph targets, and what carries them.
//!
//! What is read and what is not, ids, names, clips and errors: `docs/reference/morph-targets.md`. The `gltf`
//! crate reads and validates the document; buffers and accessors are read here, checked first.
//!
//! Flow: container → document → nodes → plan → skeleton → mesh (with weights) → spaces → model → clip, or motions with a skin.

mod accessor;
mod affine;
mod buffers;
mod clip;
mod container;
mod curve;
mod document;
mod elements;
mod extensions;
mod mesh;
mod model;
mod motions;
mod nodes;
mod notes;
mod plan;
mod quiet;
mod samplers;
mod skeleton;
mod spaces;
mod topology;
mod uri;
mod weights;

use std::path::Path;

use sha2::{Digest, Sha256};

use super::{RawModel, RawMorphs, RawSkin, Rows, forget_folder};
use crate::error::BakeError;
use accessor::Accessors;
use buffers::Buffers;
use mesh::MeshData;
use model::Model;
use notes::Notes;
pub(super) use weights::add_equal;

/// The mesh and the morph targets in the glTF file at `path`, binary or text.
///
/// Vertices: the default scene's mesh nodes depth first, their primitives in order, each with all
/// elements of its positions, moved by the node's world matrix at rest unless a skin moves them. Buffers are the binary
/// chunk, `data:` URIs or files in the document's folder. `clip` names the animation to read;
/// `None` takes the first that moves weights. A file with a skin has all of them. The hash is that of the file at `path` alone.
///
/// # Errors
/// Every problem with its JSON path, the first 100: damaged or unsupported files, required
/// extensions that are not known, data out of bounds or of the wrong type, numbers that are not
/// finite, indices out of range, nodes with two parents, an unknown `clip`.
pub fn read_gltf(path: &Path, clip: Option<&str>) -> Result<RawModel, BakeError> {
    let place = path.display().to_string();
    let bytes = crate::input::read_file::read_file(path)
        .map_err(|e| BakeError::one("input", path, format!("cannot be read: {e}")))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut model = parse(&bytes, &place, folder, clip)?;
    model.mesh.hash = Sha256::digest(&bytes).into();
    model.mesh.name = path
        .file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default();
    forget_folder(path, &mut model.mesh.warnings);
    Ok(model)
}

/// What undoes an affine map; `None` where most of its digits would be lost.
pub(super) fn inverse(rows: &Rows) -> Option<Rows> {
    affine::Affine::of_rows(rows)
        .inverse()
        .map(|inverse| inverse.rows())
}

/// The model in the glTF bytes `bytes`; `name` and `hash` are left empty.
///
/// `place` is the file's name in problems and warnings, `folder` where files of buffers lie.
///
/// # Errors
/// See [`read_gltf`].
pub fn parse(
    bytes: &[u8],
    place: &str,
    folder: &Path,
    clip: Option<&str>,
) -> Result<RawModel, BakeError> {
    let mut notes = Notes::new(place.to_string());
    let model = read(bytes, folder, clip, &mut notes);
    let warnings = notes.into_warnings()?;
    let mut model = model.unwrap_or_default();
    model.mesh.warnings = warnings;
    Ok(model)
}

/// The model; `None` only after noting why there is none.
fn read(bytes: &[u8], folder: &Path, clip: Option<&str>, notes: &mut Notes) -> Option<RawModel> {
    let container = container::split(bytes, notes)?;
    let document = document::parse(&container.json, notes)?;
    let root = &document.root;
    let animated = skeleton::animated_nodes(&document);
    let mut scene = nodes::scene(&document, &animated, notes);
    plan::check(root, &scene.instances, notes);
    if !notes.is_clean() {
        return None;
    }
    let accessors = Accessors {
        list: &root.accessors,
        buffers: Buffers::new(root, container.binary.as_deref(), folder),
    };
    let mut rig = skeleton::read(&document, &mut scene, &accessors, notes);
    if !notes.is_clean() {
        return None;
    }
    let mut instances = scene.instances;
    let quantised = root
        .extensions_used
        .iter()
        .any(|name| name == extensions::QUANTIZATION);
    let mut meshes: Vec<MeshData> = Vec::new();
    meshes.resize_with(root.meshes.len(), MeshData::default);
    let mut is_read = vec![false; meshes.len()];
    let mut is_skinned = vec![false; meshes.len()];
    for instance in instances.iter().filter(|i| i.skin.is_some()) {
        if let Some(is_skinned) = is_skinned.get_mut(instance.mesh) {
            *is_skinned = true;
        }
    }
    for instance in &instances {
        if let Some(is_read) = is_read.get_mut(instance.mesh)
            && !std::mem::replace(is_read, true)
        {
            let index = instance.mesh;
            let which = (index, is_skinned[index]);
            meshes[index] = mesh::read(&document, &accessors, quantised, which, notes);
        }
    }
    if !notes.is_clean() {
        return None;
    }
    if let Some(rig) = &mut rig {
        spaces::unify(rig, &mut instances, &meshes, notes);
    }
    let model = Model::build(&document, &instances, &meshes, rig.as_ref(), notes);
    if model.mesh.triangles.is_empty() {
        let message = match notes.skipped() {
            Some(skipped) => format!("no triangles, only {skipped}"),
            None => "no triangles".to_string(),
        };
        notes.problem("", message);
    }
    if let Some(rig) = rig {
        return skinned(model, rig, root, &accessors, clip, notes);
    }
    let defaults: Vec<f64> = model.targets.iter().map(|t| t.default_weight).collect();
    let clip = clip::read(
        &root.animations,
        &accessors,
        &model.nodes,
        &defaults,
        clip,
        notes,
    );
    Some(RawModel {
        mesh: model.mesh,
        morphs: RawMorphs {
            targets: model.targets,
            clip,
        },
        skin: None,
    })
}

/// The model with its skin and all that its animations do.
fn skinned(
    model: Model,
    rig: skeleton::Rig,
    root: &gltf::json::Root,
    accessors: &Accessors<'_>,
    clip: Option<&str>,
    notes: &mut Notes,
) -> Option<RawModel> {
    if clip.is_some() {
        notes.warn(
            "animations",
            "--clip is not used: a file with a skin gets all of them",
        );
    }
    let mut clips = motions::read(&root.animations, accessors, &rig, &model.nodes, notes);
    motions::hold_defaults(&mut clips, &model.nodes, &model.targets);
    let skin = RawSkin {
        influences: model.influences,
        bones: rig.bones,
        joints: rig.joints,
        skeleton: rig.skeleton,
        clips,
    };
    let mut targets = model.targets;
    let largest = skin.largest_weights(targets.len());
    for (target, largest) in targets.iter_mut().zip(largest) {
        target.largest_weight = largest;
    }
    Some(RawModel {
        mesh: model.mesh,
        morphs: RawMorphs {
            targets,
            clip: None,
        },
        skin: Some(skin),
    })
}
