//! Where mesh and fields come from, as the arguments say.

mod animation;
mod elastic;
mod given;
mod morph;
mod volume;

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use bdtree_build::basis::elastic::ElasticReport;
use bdtree_build::basis::volume::VolumeReport;
use bdtree_build::basis::{Basis, BasisError};
use bdtree_build::error::BakeError;
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::input::volume::RawVolume;
use bdtree_build::input::{RawMesh, RawMorphs, read_model};
use bdtree_build::progress::Progress;

use super::Arguments;
use super::arguments::Modes;

/// Modes where neither the arguments nor the source name a number.
const MODES_DEFAULT: usize = 10;

/// A mesh with its fields, and what came with them.
pub(super) struct Source {
    pub(super) mesh: RawMesh,
    pub(super) basis: Basis,
    /// For the metadata: `rigid`, `given`, `elastic`, …
    pub(super) kind: &'static str,
    /// How far the fields are from what they were made of.
    pub(super) error: Option<BasisError>,
    /// With `--advise`: how far the first 0, 1, … fields are from what they were made of, where that was measured.
    pub(super) errors_of_first: Option<Vec<BasisError>>,
    pub(super) elastic: Option<ElasticReport>,
    pub(super) volume: Option<VolumeReport>,
    /// Options for the metadata: name and value.
    pub(super) settings: BTreeMap<String, String>,
    pub(super) warnings: Vec<String>,
    /// Seconds per stage.
    pub(super) seconds: BTreeMap<String, f64>,
}

impl Source {
    /// A mesh that does not move yet.
    fn rigid(mesh: RawMesh) -> Self {
        Self {
            basis: Basis {
                vertex_count: mesh.positions.len(),
                ..Basis::default()
            },
            mesh,
            kind: "rigid",
            error: None,
            errors_of_first: None,
            elastic: None,
            volume: None,
            settings: BTreeMap::new(),
            warnings: Vec::new(),
            seconds: BTreeMap::new(),
        }
    }

    /// What `--range-rel` says, for fields that have no range of their own.
    fn set_ranges(&mut self, arguments: &Arguments) {
        if let Some(share) = arguments.range_rel {
            self.basis.set_ranges(share * self.mesh.diagonal());
            self.set("range-rel", share);
        }
    }

    fn set(&mut self, name: &str, value: impl ToString) {
        self.settings.insert(name.to_string(), value.to_string());
    }
}

/// What an input file holds besides its mesh.
enum Extra {
    Nothing,
    Morphs(RawMorphs),
    Frames(Box<FrameSequence>),
    Volume(RawVolume),
}

/// Reads and computes what the arguments ask for.
pub(super) fn read(arguments: &Arguments, progress: &dyn Progress) -> Result<Source, BakeError> {
    let begin = Instant::now();
    progress.stage("input", None);
    let (mut source, extra) = read_files(arguments, progress)?;
    let input_seconds = begin.elapsed().as_secs_f64();

    let begin = Instant::now();
    progress.stage("basis", None);
    let targets = match &extra {
        Extra::Morphs(morphs) => morphs.targets.len(),
        _ => 0,
    };
    match (&arguments.basis, extra) {
        (Some(path), _) => given::add(arguments, path, &mut source)?,
        (None, Extra::Frames(frames)) => {
            animation::add(arguments, &frames, &mut source, progress)?;
        }
        (None, Extra::Morphs(morphs)) => morph::add(arguments, &morphs, &mut source)?,
        // Rigid, whatever the input could do.
        _ if arguments.modes() == Modes::Count(0) => {}
        (None, Extra::Volume(volume)) => {
            volume::add(arguments, &volume, &mut source, progress)?;
        }
        (None, Extra::Nothing) => elastic::add(arguments, &mut source, progress)?,
    }
    if targets > 0 && source.kind != "morph" {
        let warning = format!("the {targets} morph targets of the input are not used");
        source.warnings.push(warning);
    }
    for (option, users) in arguments.used_by() {
        if !users.contains(&source.kind) {
            let users = users.join(" and ");
            let warning = format!("{option} is not used: only {users} modes need it");
            source.warnings.push(warning);
        }
    }
    let basis_seconds = begin.elapsed().as_secs_f64();
    source.seconds = BTreeMap::from([
        ("input".to_string(), input_seconds),
        ("basis".to_string(), basis_seconds),
    ]);
    Ok(source)
}

fn read_files(
    arguments: &Arguments,
    progress: &dyn Progress,
) -> Result<(Source, Extra), BakeError> {
    if let Some(path) = &arguments.animation {
        let (frames, source) = animation::read(arguments, path, progress)?;
        return Ok((source, Extra::Frames(Box::new(frames))));
    }
    if let Some(path) = &arguments.tets {
        let (volume, source) = volume::read(arguments, path)?;
        return Ok((source, Extra::Volume(volume)));
    }
    let input = arguments.input.as_deref().unwrap_or(Path::new(""));
    let model = read_model(input, arguments.clip.as_deref())?;
    let extra = if model.morphs.targets.is_empty() {
        Extra::Nothing
    } else {
        Extra::Morphs(model.morphs)
    };
    Ok((Source::rigid(model.mesh), extra))
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
