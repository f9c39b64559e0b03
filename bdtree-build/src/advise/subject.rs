//! What is advised on: a mesh and its fields with the settings that it is baked with, from a bake or from a file.

use std::collections::BTreeMap;

use bdtree_format::{ErrorMetadata, Metadata};
use bdtree_runtime::{Asset, FormatError, TriangleId, VertexId};

use super::errors::{Errors, Over};
use crate::basis::dropped::{Keep, keep_fields};
use crate::basis::{Animation, Basis, BasisError, BasisMode, RigidMotion};
use crate::error::BakeError;
use crate::input::{GroupKind, RawGroup, RawMesh, RawSkin};
use crate::motion;
use crate::pipeline::{BakeSettings, Provenance};
use crate::progress::Progress;
use crate::recipe::{Recipe, Source};
use crate::tree::Split;
use crate::wrap::RANGE_DIAGONALS;

/// Given fields and morph targets (`kind` is the metadata's word for the basis) have no order: those that an error
/// limit keeps, by number, and what they leave out over the diagonal. `None` for other kinds, whose first modes matter
/// most, and where no choice keeps to the limit.
pub fn kept_fields(
    kind: &str,
    mesh: &RawMesh,
    basis: &Basis,
    max_error_rel: f64,
) -> Option<(Vec<usize>, f64)> {
    if !matches!(kind, "given" | "morph") {
        return None;
    }
    let kept = keep_fields(mesh, basis.clone(), Keep::Auto { max_error_rel }).ok()?;
    Some((kept.fields, kept.error.max_rel))
}

/// A mesh with its fields.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    /// The mesh.
    pub mesh: RawMesh,
    /// All fields that there are. Advice is to keep the first few of them.
    pub basis: Basis,
    /// What carries the vertices, where that is known ([`Subject::of_asset`] does not know it).
    pub skin: Option<RawSkin>,
    /// How it is baked.
    pub settings: BakeSettings,
    /// Where the fields came from.
    pub provenance: Provenance,
    /// What keeping few costs.
    pub errors: Errors,
    /// What is not known, and what is assumed instead: sentences.
    pub missing: Vec<String>,
    /// Number of modes that the source has, where that is known: no fewer than the basis.
    pub modes_available: Option<usize>,
}

impl Subject {
    /// What a recipe makes before it is baked. `within`: of frames as many components as keep this error over the
    /// diagonal, where the recipe's number of them does not.
    ///
    /// # Errors
    /// What [`bake`](crate::bake) says of the recipe's files.
    pub fn of_recipe(
        recipe: &Recipe,
        within: Option<f64>,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let mut recipe = recipe.clone();
        if let Source::Frames(frames) = &mut recipe.source {
            // What the first few leave out is measured against the frames.
            frames.options.measures_all = true;
        }
        Self::prepared(&recipe, within, progress)
            .map_err(|error| error.in_file(recipe.source.main_file()))
    }

    fn prepared(
        recipe: &Recipe,
        within: Option<f64>,
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        progress.stage("input", None);
        let read = motion::read(recipe, progress)?;
        progress.stage("basis", None);
        let moving = match within {
            Some(max_error_rel) => read.moving_within(recipe, max_error_rel, progress)?,
            None => read.moving(recipe, progress)?,
        };
        let provenance = moving.provenance;
        let mut missing: Vec<String> = assumed_ranges(&provenance.kind, &provenance.settings)
            .into_iter()
            .collect();
        if matches!(provenance.kind.as_str(), "elastic" | "volume") {
            let text = "The error leaves out the vibration modes above those computed here.";
            missing.push(text.to_string());
        }
        if moving.skin.is_some() && moving.basis.mode_count() > 0 {
            let text = "Errors are those before bones carry the vertices.";
            missing.push(text.to_string());
        }
        let errors = match moving.errors_of_first {
            Some(errors) => Errors::measured(errors),
            None => Errors::against_all(
                &moving.basis,
                moving.mesh.diagonal(),
                Over::Ranges,
                provenance.error,
            ),
        };
        Ok(Self {
            mesh: moving.mesh,
            basis: moving.basis,
            skin: moving.skin,
            settings: recipe.settings.clone(),
            provenance,
            errors,
            missing,
            modes_available: moving.modes_available,
        })
    }

    /// What an opened file holds: its numbers are exact, so that a bake of all modes with these settings gives the
    /// same tree. Threads stay 1. A skin is left out, which `missing` says.
    ///
    /// # Errors
    /// Records that break the format's rules.
    pub fn of_asset(asset: &Asset<'_>) -> Result<Self, FormatError> {
        let mesh = mesh(asset)?;
        let mut missing = Vec::new();
        let metadata = match Metadata::from_bytes(asset.metadata()) {
            Ok(metadata) => metadata,
            Err(_) => {
                let text = "The file does not say how it was made (no metadata that can be read): leaf size \
                            and split are taken to be the defaults.";
                missing.push(text.to_string());
                Metadata::default()
            }
        };
        let basis = basis(asset, &metadata)?;
        missing.extend(assumed_ranges(&metadata.basis, &metadata.settings));
        if asset.has_skin() {
            let text = "What is advised is measured before bones carry the vertices: the skin is left out.";
            missing.push(text.to_string());
        }
        let own = metadata.basis_error_rel.map(basis_error);
        // Weights of a face are its user's; a clip is an example.
        let over = if metadata.basis == "morph" {
            Over::Ranges
        } else {
            Over::Frames
        };
        let diagonal = mesh.diagonal();
        Ok(Self {
            errors: Errors::against_all(&basis, diagonal, over, own),
            settings: settings(&metadata),
            provenance: Provenance {
                kind: metadata.basis,
                error: own,
                settings: metadata.settings,
                warnings: Vec::new(),
            },
            mesh: RawMesh {
                name: metadata.source_name,
                hash: metadata.source_hash,
                ..mesh
            },
            basis,
            skin: None,
            missing,
            modes_available: None,
        })
    }
}

/// What to say of ranges that no source has: those of vibration modes and given fields that were baked without
/// `--range-rel`. `kind` and `settings` are those of the metadata.
pub fn assumed_ranges(kind: &str, settings: &BTreeMap<String, String>) -> Option<String> {
    let have_none = matches!(kind, "elastic" | "volume" | "given");
    (have_none && !settings.contains_key("range-rel")).then(|| {
        format!(
            "No amplitudes are known: each mode is taken to move its farthest vertex by up to {:.0} % of the box \
             diagonal (--range-rel says otherwise).",
            100.0 * RANGE_DIAGONALS
        )
    })
}

fn mesh(asset: &Asset<'_>) -> Result<RawMesh, FormatError> {
    let (origin, unit) = (asset.origin(), asset.unit());
    let place = |p: &[f32; 3]| [0, 1, 2].map(|k| origin[k] + unit * f64::from(p[k]));
    let triangle = |id: usize| -> Result<[u32; 3], FormatError> {
        Ok(asset
            .triangle(TriangleId(id as u32))?
            .map(|corner| corner.0))
    };
    let groups = asset.groups().filter_map(|group| {
        let kind = match group.kind {
            bdtree_runtime::GroupKind::Object => GroupKind::Object,
            bdtree_runtime::GroupKind::Group => GroupKind::Group,
            bdtree_runtime::GroupKind::Material => GroupKind::Material,
            _ => return None,
        };
        Some(RawGroup {
            kind,
            name: group.name.to_string(),
            first_triangle: group.first_triangle.0,
            triangle_count: group.triangle_count,
        })
    });
    Ok(RawMesh {
        positions: asset.positions().iter().map(place).collect(),
        triangles: (0..asset.triangle_count())
            .map(triangle)
            .collect::<Result<_, _>>()?,
        groups: groups.collect(),
        ..RawMesh::default()
    })
}

fn basis(asset: &Asset<'_>, metadata: &Metadata) -> Result<Basis, FormatError> {
    let (n, m) = (asset.vertex_count(), asset.mode_count());
    let unit = asset.unit();
    let mut fields = vec![[0.0; 3]; n * m];
    for vertex in 0..n {
        for (mode, u) in asset.displacements(VertexId(vertex as u32))?.iter() {
            // A list that names no mode of the file is the reader's to report.
            if mode < m {
                fields[mode * n + vertex] = u.map(|x| unit * f64::from(x));
            }
        }
    }
    let known = |x: f64| (x >= 0.0).then_some(x);
    let modes = asset.modes().iter().enumerate().map(|(j, mode)| {
        let words = metadata.modes.get(j);
        BasisMode {
            name: words.and_then(|words| words.name.clone()),
            omega_rad_s: known(mode.omega_rad_s.get()),
            modal_mass_kg: known(mode.modal_mass_kg.get()),
            q_range: Some(f64::from(mode.q_range.get())),
            default_q: words.and_then(|words| words.default_q),
        }
    });
    Ok(Basis {
        vertex_count: n,
        fields,
        modes: modes.collect(),
        animation: animation(asset),
    })
}

fn animation(asset: &Asset<'_>) -> Option<Animation> {
    let frames: Option<Vec<_>> = (0..asset.frame_count()).map(|t| asset.frame(t)).collect();
    let frames = frames.filter(|frames| !frames.is_empty())?;
    let q = frames.iter().flat_map(|frame| frame.q());
    let motions: Vec<RigidMotion> = frames
        .iter()
        .map(|frame| RigidMotion {
            rotation: frame.transform().rotation,
            translation: frame.transform().translation,
        })
        .collect();
    let moves = motions
        .iter()
        .any(|motion| *motion != RigidMotion::IDENTITY);
    Some(Animation {
        frame_count: frames.len(),
        times_s: frames.iter().map(|frame| frame.time_s()).collect(),
        q: q.map(|&x| f64::from(x)).collect(),
        motions: if moves { motions } else { Vec::new() },
    })
}

fn basis_error(error: ErrorMetadata) -> BasisError {
    BasisError {
        max_rel: error.max,
        rms_rel: error.rms,
        frame: error.frame.map(|frame| frame as usize),
        vertex: error.vertex.unwrap_or(0) as usize,
    }
}

/// The settings that the metadata state; those it does not, by default.
fn settings(metadata: &Metadata) -> BakeSettings {
    let value = |name: &str| metadata.settings.get(name);
    BakeSettings {
        leaf_size: value("leaf-size").and_then(|text| text.parse().ok()),
        split: value("split")
            .and_then(|text| text.parse::<Split>().ok())
            .unwrap_or_default(),
        nested: value("nested").is_some_and(|text| text == "true"),
        ..BakeSettings::default()
    }
}
