//! From a recipe's files to a mesh and the fields that move it.

mod elastic;
mod frames;
mod given;
mod morphs;
mod volume;

use std::path::Path;

use crate::basis::elastic::ElasticReport;
use crate::basis::volume::VolumeReport;
use crate::basis::{Basis, BasisError};
use crate::error::{BakeError, Place};
use crate::input::sequence::FrameSequence;
use crate::input::volume::RawVolume;
use crate::input::{RawMesh, RawModel, RawSkin, read_model};
use crate::mass::Body;
use crate::pipeline::Provenance;
use crate::progress::Progress;
use crate::recipe::{Frames, Motion, Recipe, Source, Stated, Volume};

/// A mesh with the fields that move it, and what is known of them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Moving {
    pub(crate) mesh: RawMesh,
    pub(crate) basis: Basis,
    /// What carries the vertices; weights that its clips move are modes.
    pub(crate) skin: Option<RawSkin>,
    pub(crate) provenance: Provenance,
    /// How far the first 0, 1, … fields are from their source, where that was measured.
    pub(crate) errors_of_first: Option<Vec<BasisError>>,
    /// Number of fields that the source has, where more may be asked for than `basis` has.
    pub(crate) modes_available: Option<usize>,
    pub(crate) elastic: Option<ElasticReport>,
    pub(crate) volume: Option<VolumeReport>,
    /// What its modes were computed with, if that has a mass.
    pub(crate) body: Option<Body>,
}

/// What the files of a source hold, each kind beside what is asked of it.
pub(crate) enum Read<'r> {
    Surface(RawModel, &'r Motion),
    Volume(RawVolume, RawMesh, &'r Volume),
    Frames(Box<FrameSequence>, RawMesh, &'r Frames),
}

/// The files of `recipe`, read.
pub(crate) fn read<'r>(recipe: &'r Recipe, progress: &dyn Progress) -> Result<Read<'r>, BakeError> {
    let bad_faces = recipe.bad_faces;
    match &recipe.source {
        Source::Surface { path, clip, motion } => {
            let model = read_model(path, clip.as_deref(), bad_faces)?;
            Ok(Read::Surface(model, motion))
        }
        Source::Volume(volume) => volume::read(volume, bad_faces),
        Source::Frames(frames) => frames::read(frames, bad_faces, progress),
    }
}

impl Read<'_> {
    /// The mesh with the fields of `recipe`, whose source this is.
    pub(crate) fn moving(
        self,
        recipe: &Recipe,
        progress: &dyn Progress,
    ) -> Result<Moving, BakeError> {
        let moving = match self {
            Self::Surface(model, motion) => surface(model, motion, progress),
            Self::Volume(raw, mesh, volume) => volume::moving(raw, mesh, volume, progress),
            Self::Frames(sequence, mesh, frames) => {
                frames::moving(&sequence, &mesh, frames, frames.options.modes, progress)
            }
        }?;
        Ok(moving.carried(recipe)?.stating(recipe))
    }

    /// The same, of frames with more components where the recipe's number leaves more than `max_error_rel`: as many
    /// as that takes, or all that there are where none do.
    pub(crate) fn moving_within(
        self,
        recipe: &Recipe,
        max_error_rel: f64,
        progress: &dyn Progress,
    ) -> Result<Moving, BakeError> {
        match self {
            Self::Frames(sequence, mesh, frames) => {
                let moving = frames::within(&sequence, &mesh, frames, max_error_rel, progress)?;
                Ok(moving.carried(recipe)?.stating(recipe))
            }
            other => other.moving(recipe, progress),
        }
    }
}

/// A surface with the fields that its motion has.
fn surface(model: RawModel, motion: &Motion, progress: &dyn Progress) -> Result<Moving, BakeError> {
    let RawModel {
        mesh,
        morphs,
        mut skin,
    } = model;
    let target_count = morphs.targets.len();
    let mut moving = match motion {
        Motion::Morphs(asked)
        | Motion::MorphsElseElastic(asked, _)
        | Motion::MorphsElseSkin(asked, _)
            if target_count > 0 =>
        {
            return morphs::moving(mesh, &morphs, skin, asked);
        }
        Motion::Rigid => Moving::rigid(mesh),
        Motion::MorphsElseSkin(..) if skin.is_some() => Moving::rigid(mesh),
        Motion::Morphs(asked) => return Err(morphs::missing(&mesh, asked)),
        Motion::Elastic(elastic)
        | Motion::MorphsElseElastic(_, elastic)
        | Motion::MorphsElseSkin(_, elastic) => elastic::moving(mesh, elastic, progress)?,
        Motion::Given(given) => given::moving(mesh, given)?,
    };
    if target_count > 0 {
        let warning = format!("the {target_count} morph targets of the input are not used");
        moving.provenance.warnings.push(warning);
    }
    if let Some(skin) = &mut skin {
        skin.keep_targets(&[]);
    }
    moving.skin = skin;
    Ok(moving)
}

impl Moving {
    /// A mesh without fields.
    fn rigid(mesh: RawMesh) -> Self {
        let basis = Basis {
            vertex_count: mesh.positions.len(),
            ..Basis::default()
        };
        Self::new(mesh, basis, "rigid")
    }

    /// A mesh with its fields; `kind` is the metadata's word for them.
    fn new(mesh: RawMesh, basis: Basis, kind: &str) -> Self {
        Self {
            mesh,
            basis,
            skin: None,
            provenance: Provenance {
                kind: kind.to_string(),
                ..Provenance::default()
            },
            errors_of_first: None,
            modes_available: None,
            elastic: None,
            volume: None,
            body: None,
        }
    }

    /// True if the fields are the vibration modes of a body.
    pub(crate) fn is_body(&self) -> bool {
        self.elastic.is_some() || self.volume.is_some()
    }

    /// Notes a setting for the metadata.
    fn set(&mut self, name: &str, value: impl ToString) {
        self.provenance.set(name, value);
    }

    /// Notes a setting that has a value.
    fn set_some(&mut self, name: &str, value: Option<impl ToString>) {
        if let Some(value) = value {
            self.set(name, value);
        }
    }

    /// Gives fields without a range of their own the one that is asked for.
    fn set_ranges(&mut self, range_rel: Option<f64>) {
        if let Some(share) = range_rel {
            self.basis.set_ranges(share * self.mesh.diagonal());
            self.set("range-rel", share);
        }
    }

    /// With the skin that the recipe gives it.
    fn carried(mut self, recipe: &Recipe) -> Result<Self, BakeError> {
        let Some(arrays) = &recipe.skin else {
            return Ok(self);
        };
        if self.skin.is_some() {
            let message = "the input has a skin of its own: give one or the other";
            return Err(BakeError::one(
                "skin",
                Place::option("--skin-weights"),
                message,
            ));
        }
        self.skin = Some(arrays.read(self.mesh.positions.len())?);
        for (setting, path) in ["skin-weights", "skin-joints", "inverse-bind"]
            .iter()
            .zip(arrays.files())
        {
            self.set(setting, name(path));
        }
        if self.basis.animation.take().is_some() {
            let warning = "the frames are not stored: a file with a skin plays clips";
            self.provenance.warnings.push(warning.to_string());
        }
        Ok(self)
    }

    /// With what the recipe says of the tree in the metadata, and warnings of stated options that are of no use here.
    fn stating(mut self, recipe: &Recipe) -> Self {
        for stated in &recipe.stated {
            if stated.kinds == [Stated::MASS] {
                // Said once it is known whether there is a mass.
            } else if stated.kinds == [Stated::SKIN] {
                if self.skin.is_none() {
                    let warning = format!("{} is not used: the input has no skin", stated.option);
                    self.provenance.warnings.push(warning);
                }
            } else if self.skin.is_some() && stated.option == "--clip" {
                // Its reader has said so, with another reason.
            } else if !stated.kinds.contains(&self.provenance.kind.as_str()) {
                let users = stated.kinds.join(" and ");
                let warning = format!("{} is not used: only {users} modes need it", stated.option);
                self.provenance.warnings.push(warning);
            }
        }
        let settings = &recipe.settings;
        if !self.is_body() {
            // Of vibration modes they are noted with the others.
            let (own, default) = (settings.body, Body::default());
            let density = Some(own.density_kg_m3).filter(|x| *x != default.density_kg_m3);
            self.set_some("density", density);
            self.set_some("scale", Some(own.scale_m).filter(|x| *x != default.scale_m));
        }
        self.set("leaf-size", settings.leaf_size_for(&self.mesh));
        self.set("split", settings.split);
        if settings.nested {
            self.set("nested", true);
        }
        if self.skin.is_some() {
            self.set("weights", settings.weights);
        }
        self
    }

    /// Warns of stated options that only a mass uses, where there is none.
    pub(crate) fn say_unused_mass_options(&mut self, recipe: &Recipe, body: &Body) {
        let mut stated = recipe.stated.iter().filter(|s| s.kinds == [Stated::MASS]);
        let Some(first) = stated.next() else {
            return;
        };
        let RawMesh {
            positions,
            triangles,
            ..
        } = &self.mesh;
        if self.is_body()
            || body
                .properties(positions, triangles, &mut Vec::new())
                .is_some()
        {
            return;
        }
        for stated in [first].into_iter().chain(stated) {
            let warning = format!(
                "{} is not used: the mesh encloses no volume that could have a mass",
                stated.option
            );
            self.provenance.warnings.push(warning);
        }
    }
}

/// SHA-256 as text.
fn hexadecimal(hash: [u8; 32]) -> String {
    hash.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The file's name without its folder.
fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
