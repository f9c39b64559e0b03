//! What is advised on: a mesh and its fields with the settings that it is baked with, from a bake or from a file.

use std::collections::BTreeMap;

use super::errors::{Errors, Over};
use crate::basis::Basis;
use crate::basis::dropped::{Keep, keep_fields};
use crate::error::BakeError;
use crate::input::{RawMesh, RawSkin};
use crate::motion;
use crate::pipeline::{BakeSettings, Provenance};
use crate::progress::Progress;
use crate::recipe::{Recipe, Source};
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

/// What to say of errors of fields that bones carry on.
pub(super) const BEFORE_BONES: &str = "Errors are those before bones carry the vertices.";

/// A mesh with its fields.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    /// The mesh.
    pub mesh: RawMesh,
    /// All fields that there are. Advice is to keep the first few of them.
    pub basis: Basis,
    /// What carries the vertices, if bones do.
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
            missing.push(BEFORE_BONES.to_string());
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
            settings: BakeSettings {
                body: moving.body.unwrap_or(recipe.settings.body),
                ..recipe.settings.clone()
            },
            provenance,
            errors,
            missing,
            modes_available: moving.modes_available,
        })
    }
}

/// What to say of ranges that no source has: those of vibration modes and given fields that were baked without
/// `--range-rel`. `kind` and `settings` are those of the metadata.
pub fn assumed_ranges(kind: &str, settings: &BTreeMap<String, String>) -> Option<String> {
    let have_none = matches!(kind, "elastic" | "volume" | "given");
    (have_none && !settings.contains_key("range-rel")).then(|| {
        format!(
            "No amplitudes are known: each mode is taken to move the vertex that it moves most by up to {:.0} % of the \
             box diagonal (--range-rel says otherwise).",
            100.0 * RANGE_DIAGONALS
        )
    })
}
