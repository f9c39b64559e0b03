//! What to bake: where the mesh comes from, what moves it, how the file is made.

use std::path::{Path, PathBuf};

use crate::basis::dropped::Keep;
use crate::basis::elastic::{ElasticOptions, Fix, FixRegion};
use crate::basis::given::Layout;
use crate::basis::pca::PcaOptions;
use crate::basis::volume::VolumeOptions;
use crate::input::{BadFaces, SkinArrays};
use crate::pipeline::BakeSettings;

/// A whole bake, for [`bake`](crate::bake).
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    /// The mesh and what moves it.
    pub source: Source,
    /// How the file is made of them.
    pub settings: BakeSettings,
    /// What becomes of faces of the mesh file that cannot be read; frames and volumes are always read whole.
    pub bad_faces: BadFaces,
    /// What carries the vertices, for sources that say nothing of it.
    pub skin: Option<SkinArrays>,
    /// Options that a user gave, whether or not the source turns out to use them: those that it does not become
    /// warnings.
    pub stated: Vec<Stated>,
}

/// An option that a user gave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stated {
    /// Its name.
    pub option: &'static str,
    /// The kinds of motion ([`Provenance::kind`](crate::pipeline::Provenance)) that use it.
    pub kinds: &'static [&'static str],
}

impl Stated {
    /// The kind of sources with a skin, whatever else moves them.
    pub const SKIN: &'static str = "skin";
    /// The kind of sources with a mass, whatever moves them.
    pub const MASS: &'static str = "mass";
}

/// A mesh and what moves it. Paths are read when the recipe is baked.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A mesh file: `.obj`, `.ply`, `.stl`, `.gltf` or `.glb`.
    Surface {
        /// The file.
        path: PathBuf,
        /// Which of a glTF file's animations gives the weights over time, by name; `None`: the first that moves any.
        clip: Option<String>,
        /// What moves the mesh.
        motion: Motion,
    },
    /// The vibration modes of a volume mesh.
    Volume(Volume),
    /// The principal components of an animation.
    Frames(Frames),
}

/// What moves a surface.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// Nothing: a file without modes.
    Rigid,
    /// Vibration modes of the body that the surface encloses.
    Elastic(Elastic),
    /// The morph targets of the surface's own file, which must have some.
    Morphs(Morphs),
    /// The morph targets of the surface's own file, or vibration modes where it has none.
    MorphsElseElastic(Morphs, Elastic),
    /// What a file holds: its morph targets, nothing beside a skin without them, or vibration modes where it has
    /// neither.
    MorphsElseSkin(Morphs, Elastic),
    /// Fields made elsewhere.
    Given(Given),
}

/// Vibration modes of the body that a surface encloses.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Elastic {
    /// How many and of what; no modes make a rigid asset.
    pub options: ElasticOptions,
    /// Typical range of q: how far a mode moves the vertex that it moves most, over the diagonal of the box, above 0; `None`:
    /// [`RANGE_DIAGONALS`](crate::wrap::RANGE_DIAGONALS).
    pub range_rel: Option<f64>,
}

/// Morph targets.
#[derive(Debug, Clone, PartialEq)]
pub struct Morphs {
    /// Which of them.
    pub keep: Keep,
    /// Bakes that would take more are refused before they do. Default 4 GiB.
    pub memory_limit_bytes: u64,
}

impl Default for Morphs {
    fn default() -> Self {
        Self {
            keep: Keep::All,
            memory_limit_bytes: ElasticOptions::default().memory_limit_bytes,
        }
    }
}

/// Fields made elsewhere ([`given_basis`](crate::basis::given::given_basis)).
#[derive(Debug, Clone, PartialEq)]
pub struct Given {
    /// The `.npy` array.
    pub path: PathBuf,
    /// What its axes are, where its shape leaves it open.
    pub layout: Option<Layout>,
    /// A file with a frequency in Hz for each field.
    pub frequencies: Option<PathBuf>,
    /// Which of the fields.
    pub keep: Keep,
    /// As [`Elastic::range_rel`].
    pub range_rel: Option<f64>,
}

/// The vibration modes of a volume mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Volume {
    /// The volume mesh: `.veg`, `.vtk` or `.msh`.
    pub path: PathBuf,
    /// The mesh that it moves; `None`: its own surface.
    pub surface: Option<PathBuf>,
    /// How many and of what; no modes make a rigid asset.
    pub options: VolumeOptions,
    /// As [`Elastic::range_rel`].
    pub range_rel: Option<f64>,
}

/// The principal components of an animation.
#[derive(Debug, Clone, PartialEq)]
pub struct Frames {
    /// A folder of OBJ frames, a `.pc2`, `.mdd` or `.npy` file.
    pub path: PathBuf,
    /// The mesh that they move; `None`: the first frame of a folder.
    pub surface: Option<PathBuf>,
    /// Frames per second, above 0; replaces the times of a `.mdd` file. `None`: the times of a `.mdd` file; otherwise
    /// unknown.
    pub fps: Option<f64>,
    /// How many components, and of what.
    pub options: PcaOptions,
}

impl Recipe {
    /// `source` with default settings.
    pub fn new(source: Source) -> Self {
        Self {
            source,
            settings: BakeSettings::default(),
            bad_faces: BadFaces::Refuse,
            skin: None,
            stated: Vec::new(),
        }
    }

    /// Every file and folder that the bake reads by its name.
    pub fn files(&self) -> Vec<&Path> {
        let mut files = self.source.files();
        files.extend(self.skin.iter().flat_map(SkinArrays::files));
        files
    }

    /// The mesh at `path`, moved by `motion`, with default settings.
    pub fn of_surface(path: impl Into<PathBuf>, motion: Motion) -> Self {
        Self::new(Source::Surface {
            path: path.into(),
            clip: None,
            motion,
        })
    }
}

impl Source {
    /// The file that the mesh comes from: what names the output where nothing else does.
    pub fn main_file(&self) -> &Path {
        match self {
            Self::Surface { path, .. } => path,
            Self::Volume(volume) => volume.surface.as_ref().unwrap_or(&volume.path),
            Self::Frames(frames) => frames.surface.as_ref().unwrap_or(&frames.path),
        }
    }

    /// Meters per mesh unit, of sources that may have vibration modes.
    pub(crate) fn scale_m(&self) -> Option<f64> {
        match self {
            Self::Surface { motion, .. } => match motion {
                Motion::Elastic(elastic)
                | Motion::MorphsElseElastic(_, elastic)
                | Motion::MorphsElseSkin(_, elastic) => Some(elastic.options.scale_m),
                Motion::Rigid | Motion::Morphs(_) | Motion::Given(_) => None,
            },
            Self::Volume(volume) => Some(volume.options.scale_m),
            Self::Frames(_) => None,
        }
    }

    /// Every file and folder that the bake reads by its name.
    pub fn files(&self) -> Vec<&Path> {
        let mut files = Vec::new();
        match self {
            Self::Surface { path, motion, .. } => {
                files.push(path.as_path());
                match motion {
                    Motion::Elastic(elastic)
                    | Motion::MorphsElseElastic(_, elastic)
                    | Motion::MorphsElseSkin(_, elastic) => {
                        files.extend(lists(&elastic.options.fixes));
                    }
                    Motion::Given(given) => {
                        files.push(&given.path);
                        files.extend(given.frequencies.as_deref());
                    }
                    Motion::Rigid | Motion::Morphs(_) => {}
                }
            }
            Self::Volume(volume) => {
                files.extend(volume.surface.as_deref());
                files.push(&volume.path);
                files.extend(lists(&volume.options.fixes));
            }
            Self::Frames(frames) => {
                files.extend(frames.surface.as_deref());
                files.push(&frames.path);
            }
        }
        files
    }
}

/// The files that list what is held.
fn lists(fixes: &[Fix]) -> impl Iterator<Item = &Path> {
    fixes.iter().filter_map(|fix| match &fix.region {
        FixRegion::List(path) => Some(path.as_path()),
        _ => None,
    })
}
