//! Where mesh and fields come from, as the arguments say.

mod elastic;
mod given;
mod morph;

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

use bdtree_build::basis::elastic::ElasticReport;
use bdtree_build::basis::{Basis, BasisError};
use bdtree_build::error::BakeError;
use bdtree_build::input::{RawMesh, read_model};
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
    pub(super) elastic: Option<ElasticReport>,
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
            elastic: None,
            settings: BTreeMap::new(),
            warnings: Vec::new(),
            seconds: BTreeMap::new(),
        }
    }

    fn set(&mut self, name: &str, value: impl ToString) {
        self.settings.insert(name.to_string(), value.to_string());
    }
}

/// Reads and computes what the arguments ask for.
pub(super) fn read(arguments: &Arguments, progress: &dyn Progress) -> Result<Source, BakeError> {
    let begin = Instant::now();
    progress.stage("input", None);
    let input = arguments.input.as_deref().unwrap_or(Path::new(""));
    let model = read_model(input, arguments.clip.as_deref())?;
    let mut source = Source::rigid(model.mesh);
    let input_seconds = begin.elapsed().as_secs_f64();

    let begin = Instant::now();
    progress.stage("basis", None);
    if let Some(path) = &arguments.basis {
        given::add(arguments, path, &mut source)?;
    } else if arguments.modes() == Modes::Count(0) {
        // Rigid, whatever the input could do.
    } else if !model.morphs.targets.is_empty() {
        morph::add(arguments, &model.morphs, &mut source)?;
    } else {
        elastic::add(arguments, &mut source, progress)?;
    }
    if arguments.clip.is_some() && source.kind != "morph" {
        let warning = "--clip is not used: only morph targets need it".to_string();
        source.warnings.push(warning);
    }
    if source.kind != "elastic" {
        for option in arguments.elastic_only() {
            let warning = format!("{option} is not used: only elastic modes need it");
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

/// The file's name without its folder.
fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
