//! Real assets of different kinds.

use std::error::Error;
use std::fs;
use std::path::Path;

use bdtree_build::advise::errors::{Errors, Over};
use bdtree_build::advise::{Goal, Subject};
use bdtree_build::basis::dropped::{Keep, keep_fields};
use bdtree_build::basis::elastic::{ElasticOptions, elastic_basis};
use bdtree_build::basis::morph::morph_basis;
use bdtree_build::basis::pca::{Modes, PcaOptions, pca_basis};
use bdtree_build::basis::{Basis, BasisError, BasisMode};
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::input::{RawMesh, read_mesh, read_model};
use bdtree_build::pipeline::{BakeSettings, Provenance};
use bdtree_build::progress::Silent;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// What is advised on.
pub(crate) struct Asset {
    pub(crate) name: &'static str,
    /// What its modes are, in words.
    pub(crate) source: &'static str,
    /// Largest error over the diagonal.
    pub(crate) goal: f64,
    kind: Kind,
}

enum Kind {
    /// Mesh, frames, components.
    Frames(&'static str, &'static str, usize),
    /// Mesh, vibration modes.
    Elastic(&'static str, usize),
    /// The bridge's own modes, of a file of VegaFEM.
    Bridge,
    /// A glTF file with morph targets.
    Morphs(&'static str),
}

pub(crate) fn all() -> [Asset; 6] {
    let asset = |name, source, goal, kind| Asset {
        name,
        source,
        goal,
        kind,
    };
    let (rest, frames) = (
        "animations/curtain_large/curtain_large_rest.obj",
        "animations/curtain_large/curtain_large.pc2",
    );
    let (wind_rest, wind) = (
        "animations/curtain_wind/curtain_wind_000.obj",
        "animations/curtain_wind/curtain_wind.pc2",
    );
    [
        asset(
            "curtain_large",
            "32 components of 50 frames",
            0.01,
            Kind::Frames(rest, frames, 32),
        ),
        asset(
            "curtain_wind",
            "32 components of 100 frames",
            0.01,
            Kind::Frames(wind_rest, wind, 32),
        ),
        asset("bridge", "20 given fields", 0.2, Kind::Bridge),
        asset(
            "turtle",
            "20 vibration modes",
            0.2,
            Kind::Elastic("meshes/turtle.obj", 20),
        ),
        asset(
            "AnimatedMorphSphere",
            "2 morph targets",
            0.01,
            Kind::Morphs("characters/AnimatedMorphSphere/AnimatedMorphSphere.gltf"),
        ),
        asset(
            "RobotExpressive",
            "3 morph targets",
            0.05,
            Kind::Morphs("characters/RobotExpressive.glb"),
        ),
    ]
}

impl Asset {
    /// The asset as `--advise` takes it.
    pub(crate) fn load(&self, corpus: &Path, seconds: f64) -> Result<(Subject, Goal)> {
        let mut goal = Goal {
            max_error_rel: self.goal,
            seconds,
            ..Goal::default()
        };
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
        let settings = BakeSettings {
            threads,
            ..BakeSettings::default()
        };
        let mut warnings = Vec::new();
        let (mesh, basis, errors) = match self.kind {
            Kind::Frames(mesh, frames, count) => {
                let mesh = read_mesh(&corpus.join(mesh))?;
                let frames = FrameSequence::open(&corpus.join(frames), Some(&mesh), None, &Silent)?;
                let options = PcaOptions {
                    modes: Modes::Count(count),
                    measures_all: true,
                    ..PcaOptions::default()
                };
                let pca = pca_basis(&mesh, &frames, &options, &Silent, &mut warnings)?;
                let errors = pca.curve.iter().map(|point| point.error).collect();
                (pca.mesh, pca.basis, Errors::measured(errors))
            }
            Kind::Elastic(mesh, mode_count) => {
                let mesh = read_mesh(&corpus.join(mesh))?;
                let options = ElasticOptions {
                    mode_count,
                    ..ElasticOptions::default()
                };
                let (basis, _) = elastic_basis(&mesh, &options, &Silent, &mut warnings)?;
                let errors = within(&mesh, &basis, None);
                (mesh, basis, errors)
            }
            Kind::Bridge => {
                let mesh = read_mesh(&corpus.join("modal/bridge_rest.obj.gz"))?;
                let basis = bridge(&corpus.join("modal/bridge_modes_U.f32"), &mesh)?;
                free(mesh, basis, &mut goal)?
            }
            Kind::Morphs(path) => {
                let model = read_model(&corpus.join(path), None)?;
                let limit = PcaOptions::default().memory_limit_bytes;
                let (mesh, morphs) = (model.mesh, model.morphs);
                let morph = morph_basis(&mesh, &morphs, Keep::All, limit, &mut warnings)?;
                free(mesh, morph.basis, &mut goal)?
            }
        };
        let subject = Subject {
            mesh,
            basis,
            settings,
            provenance: Provenance::default(),
            errors,
            missing: Vec::new(),
        };
        Ok((subject, goal))
    }
}

/// Fields of which any may go.
fn free(mesh: RawMesh, basis: Basis, goal: &mut Goal) -> Result<(RawMesh, Basis, Errors)> {
    let all = keep_fields(&mesh, basis, Keep::All)?;
    let keep = Keep::Auto {
        max_error_rel: goal.max_error_rel,
    };
    let kept = keep_fields(&mesh, all.basis.clone(), keep)?;
    goal.subset = Some((kept.fields, kept.error.max_rel));
    let errors = within(&mesh, &all.basis, Some(all.error));
    Ok((mesh, all.basis, errors))
}

fn within(mesh: &RawMesh, basis: &Basis, own: Option<BasisError>) -> Errors {
    Errors::against_all(basis, mesh.diagonal(), Over::Ranges, own)
}

/// 20 fields: counts of numbers and fields as i32, then field after field.
fn bridge(path: &Path, mesh: &RawMesh) -> Result<Basis> {
    let bytes = fs::read(path)?;
    let n = mesh.positions.len();
    let numbers: Vec<f32> = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .skip(2)
        .map(|x| f32::from_le_bytes(*x))
        .collect();
    let fields: Vec<[f64; 3]> = numbers
        .as_chunks::<3>()
        .0
        .iter()
        .map(|u| u.map(f64::from))
        .collect();
    let modes = fields.len() / n;
    if modes * n != fields.len() {
        return Err(format!("{}: not {n} vertices per field", path.display()).into());
    }
    Ok(Basis {
        vertex_count: n,
        fields,
        modes: vec![BasisMode::default(); modes],
        animation: None,
    })
}
