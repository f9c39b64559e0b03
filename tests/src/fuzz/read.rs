//! Reading a case as the commands do: the file on disk, the public door of its format, and what an
//! error must say.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use bdtree_build::basis::elastic::Fix;
use bdtree_build::basis::given::{GivenBasis, Layout, given_basis};
use bdtree_build::basis::volume::{VolumeOptions, volume_modes};
use bdtree_build::error::BakeError;
use bdtree_build::input::sequence::FrameSequence;
use bdtree_build::input::volume::{RawVolume, read_volume};
use bdtree_build::input::{BadFaces, RawMesh, RawModel, read_mesh, read_model};
use bdtree_build::progress::Silent;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use tempfile::TempDir;

use super::{Format, scenes, seeds};
use bdtree_fixtures::models::{self, fields};

/// Longest line of an error or a warning, without the file's path.
const LINE_MAX: usize = 1000;

/// What a file held.
pub(super) enum Thing {
    /// A mesh, perhaps with morph targets.
    Model(RawModel),
    /// Frames, and the mesh that they move.
    Sequence(Box<FrameSequence>, RawMesh),
    /// Fields of a mesh.
    Basis(GivenBasis, RawMesh),
    /// A volume.
    Volume(RawVolume),
    /// The scene at this path, and its answers.
    Scene(PathBuf, String),
    /// Nothing that can be baked by itself.
    Used,
}

/// Where cases are written, and what they are read with.
pub(super) struct Desk {
    folder: TempDir,
    wave: RawMesh,
    /// Fields for `wave`.
    fields: PathBuf,
    /// What lists of nodes are for.
    volume: RawVolume,
}

/// The problems of a refused file, checked.
pub(super) type Refused = Vec<String>;

impl Desk {
    pub(super) fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let wave = models::folder().join("wave/wave_00.obj");
        let frames = folder.path().join("frames");
        fs::create_dir(&frames).expect("a folder");
        for k in [0, 2] {
            let from = models::folder().join(format!("wave/wave_{k:02}.obj"));
            fs::copy(from, frames.join(format!("{k}.obj"))).expect("a frame");
        }
        let wave = read_mesh(&wave).expect("a mesh");
        assert_eq!(wave.positions.len(), seeds::WAVE_VERTICES);
        let count = wave.positions.len() * 3 * seeds::FIELDS;
        let values = (0..count).map(|k| ((k * k) % 17) as f64 - 8.0);
        let path = folder.path().join("fields.npy");
        let shape = [wave.positions.len(), 3, seeds::FIELDS];
        fs::write(&path, fields::npy(&shape, values)).expect("fields");
        scenes::write_assets(folder.path());
        let nodes = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(f64::from));
        let volume = RawVolume {
            name: "cube".into(),
            nodes: nodes.collect(),
            hexahedra: vec![[0, 1, 3, 2, 4, 5, 7, 6]],
            ..RawVolume::default()
        };
        Self {
            folder,
            wave,
            fields: path,
            volume,
        }
    }

    /// Writes a case's file.
    pub(super) fn put(&self, format: Format, bytes: &[u8]) -> PathBuf {
        let name = match format {
            Format::Frames => "frames/1.obj".to_string(),
            Format::Basis => "case.npy".to_string(),
            Format::Frequencies | Format::List => "case.txt".to_string(),
            Format::Scene => "case.json".to_string(),
            _ => format!("case.{format}"),
        };
        let path = self.folder.path().join(name);
        fs::write(&path, bytes).expect("a case");
        path
    }

    /// Reads the file at `path`.
    pub(super) fn read(
        &self,
        format: Format,
        path: &Path,
        rng: &mut Pcg64Mcg,
    ) -> Result<Thing, Failed> {
        let fps = [None, Some(24.0)][rng.random_range(0..2)];
        match format {
            Format::Obj | Format::ObjGz | Format::Ply | Format::Stl => {
                let bad_faces = [BadFaces::Refuse, BadFaces::Skip][rng.random_range(0..2)];
                Ok(Thing::Model(read_model(path, None, bad_faces)?))
            }
            Format::Glb | Format::Gltf => {
                let clip = [None, None, Some("talk"), Some("nothing")][rng.random_range(0..4)];
                Ok(Thing::Model(read_model(path, clip, BadFaces::Refuse)?))
            }
            Format::Frames => {
                let folder = path.parent().unwrap_or(path);
                let input = (rng.random_range(0..2) == 0).then_some(&self.wave);
                let sequence = FrameSequence::open(folder, input, fps, &Silent)?;
                let mesh = input.or(sequence.first_mesh.as_ref()).cloned();
                Ok(Thing::Sequence(
                    Box::new(sequence),
                    mesh.unwrap_or_default(),
                ))
            }
            Format::Pc2 | Format::Mdd | Format::Npy => {
                let sequence = FrameSequence::open(path, Some(&self.wave), fps, &Silent)?;
                Ok(Thing::Sequence(Box::new(sequence), self.wave.clone()))
            }
            Format::Basis => {
                let layout = [None, None, Some(Layout::N3M), Some(Layout::MN3)];
                let layout = layout[rng.random_range(0..4)];
                // Other meshes make other shapes fit.
                let vertices = [self.wave.positions.len(); 4];
                let vertices = [vertices[0], vertices[1], 1, 0][rng.random_range(0..4)];
                let basis = given_basis(path, layout, None, vertices)?;
                Ok(match vertices {
                    0 | 1 => Thing::Used,
                    _ => Thing::Basis(basis, self.wave.clone()),
                })
            }
            Format::Frequencies => {
                let vertices = self.wave.positions.len();
                let basis = given_basis(&self.fields, None, Some(path), vertices)?;
                Ok(Thing::Basis(basis, self.wave.clone()))
            }
            Format::List => {
                let fix: Fix = format!("xyz:@{}", path.display()).parse().expect("a fix");
                let options = VolumeOptions {
                    mode_count: 1,
                    fixes: vec![fix],
                    ..VolumeOptions::default()
                };
                volume_modes(&self.volume, &options, &Silent, &mut Vec::new())?;
                Ok(Thing::Used)
            }
            Format::Veg | Format::Vtk | Format::Msh => Ok(Thing::Volume(read_volume(path)?)),
            Format::Scene => {
                let arguments: [OsString; 3] = ["bdtree".into(), "query".into(), path.into()];
                let (mut out, mut err) = (Vec::new(), Vec::new());
                let code = bdtree_tools::run(arguments, &mut out, &mut err);
                Failed::unless_done(code, &out, err)?;
                let lines = String::from_utf8(out).map_err(|e| Failed::Wrong(e.to_string()))?;
                Ok(Thing::Scene(path.to_path_buf(), lines))
            }
        }
    }
}

/// Why there is no thing.
pub(super) enum Failed {
    /// A refusal, one line per problem.
    Refused(Refused),
    /// What must not happen.
    Wrong(String),
}

impl From<BakeError> for Failed {
    fn from(error: BakeError) -> Self {
        Self::Refused(error.problems.iter().map(ToString::to_string).collect())
    }
}

impl Failed {
    fn unless_done(code: u8, out: &[u8], err: Vec<u8>) -> Result<(), Self> {
        let err = String::from_utf8(err).map_err(|e| Self::Wrong(e.to_string()))?;
        match code {
            0 if err.is_empty() => Ok(()),
            1 if out.is_empty() => {
                let lines = err.strip_suffix('\n').unwrap_or(&err).split('\n');
                Err(Self::Refused(lines.map(str::to_string).collect()))
            }
            _ => Err(Self::Wrong(format!(
                "exit code {code} after {} bytes of answers: {err}",
                out.len()
            ))),
        }
    }
}

/// What is wrong with the lines of a refusal, or with warnings. Those of a reader name the file at
/// `path` (warnings without its folder).
pub(super) fn wrong_lines(lines: &[String], path: Option<&Path>) -> Option<String> {
    let full = path.map_or(String::new(), |path| path.display().to_string());
    let names: Vec<String> = path
        .into_iter()
        // A folder of frames names itself.
        .flat_map(|path| path.ancestors().take(2))
        .filter_map(Path::file_name)
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    for line in lines {
        let about = if line.is_empty() {
            "is empty"
        } else if line.replace(&full, "").chars().count() > LINE_MAX && !full.is_empty() {
            "is too long"
        } else if line.chars().any(char::is_control) {
            "holds control characters"
        } else if !names.is_empty() && !names.iter().any(|name| line.contains(name)) {
            "does not name the file"
        } else {
            continue;
        };
        return Some(format!("a line {about}: {line:?}"));
    }
    None
}
