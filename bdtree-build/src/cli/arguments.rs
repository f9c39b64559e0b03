//! What the command line says. Exit code 2 for what clap refuses.

use std::path::{Path, PathBuf};

use bdtree_build::basis::elastic::{ElasticOptions, Fix, RESOLUTION_MAX};
use bdtree_build::basis::given::Layout;
use bdtree_build::basis::pca::About;
use bdtree_build::basis::volume::MassMatrix;
use bdtree_build::recipe::Stated;
use bdtree_build::skin::Weights;
use bdtree_build::tree::Split;
use clap::Parser;

/// The error that `--advise` allows where none is given: 1 % of the diagonal.
const GOAL: f64 = 0.01;

/// Headings that several options stand under.
const GIVEN: &str = "Given fields";
const PCA: &str = "Animations";
const VOLUME: &str = "Given volumes";
const BODY: &str = "Elastic modes";
const MASS: &str = "Mass";
const SKIN: &str = "Skins";

/// Bakes a mesh and a deformation basis into a memory-mappable .bdt file.
///
/// The fields are the principal components of --animation, the vibration modes of --tets, the fields
/// of --basis, or the morph targets of a glTF file; else the lowest elastic (vibration) modes of the
/// body that the surface encloses are computed. --modes 0 bakes a rigid asset. Bones of a glTF file, or of
/// --skin-weights, carry what the fields have moved; a glTF file with bones gets no elastic modes unless --modes asks.
#[derive(Debug, Parser)]
#[command(
    name = "bdtree-build",
    version,
    after_help = "Exit codes: 0 done, 1 bad input or output, 2 usage."
)]
pub(crate) struct Arguments {
    /// The mesh: .obj, .ply, .stl (also .gz), .gltf or .glb; or a folder of .obj frames, as with
    /// --animation. --tets and --animation with a folder need no INPUT.
    pub(crate) input: Option<PathBuf>,

    /// Output file [default: INPUT, else --tets or --animation, with .bdt, beside it].
    #[arg(short, long, value_name = "OUT.bdt")]
    pub(crate) output: Option<PathBuf>,

    /// Leaves out faces of INPUT (.obj, .ply) that cannot be read, with a warning, instead of
    /// refusing the file. Triangle ids count the faces that remain.
    #[arg(long)]
    pub(crate) skip_bad_faces: bool,

    /// Number of modes, 0 to 512, or auto: as few as reach --max-error-rel [default: 10; with
    /// --basis and morph targets: all; with the bones of a glTF file alone: 0].
    #[arg(long, value_name = "K|auto")]
    pub(crate) modes: Option<String>,

    /// Largest error that --modes auto may leave at any vertex (frames: in any frame; morph targets
    /// and given fields: at any q within range), over the diagonal of the box around the rest
    /// positions, above 0. Implies --modes auto. Not for vibration modes, except with --advise.
    #[arg(long, value_parser = number, value_name = "E")]
    pub(crate) max_error_rel: Option<f64>,

    /// Given displacement fields (mesh units per unit of q): .npy, f32 or f64, shape (N,3,M),
    /// (3N,M) or (M,N,3).
    #[arg(long, value_name = "U.npy", help_heading = GIVEN)]
    pub(crate) basis: Option<PathBuf>,

    /// What the axes of the --basis array are, where its shape leaves it open: n3m, 3nm or mn3.
    #[arg(long, value_name = "LAYOUT", requires = "basis", help_heading = GIVEN)]
    pub(crate) basis_layout: Option<Layout>,

    /// Frequencies of the --basis fields in Hz: .npy or text, one number per field.
    #[arg(long, value_name = "FILE", requires = "basis", help_heading = GIVEN)]
    pub(crate) frequencies: Option<PathBuf>,

    /// Frames whose principal components are the fields: a folder of .obj frames in the order of
    /// their names, a .pc2, a .mdd or a .npy file of shape (T,N,3). A folder needs no INPUT: its
    /// first frame is the mesh.
    #[arg(long, value_name = "FRAMES", conflicts_with_all = ["basis", "tets"], help_heading = PCA)]
    pub(crate) animation: Option<PathBuf>,

    /// What the rest positions are: mean (of the frames) or input (the positions of INPUT) [default: mean].
    #[arg(long, value_name = "REST", help_heading = PCA)]
    pub(crate) about: Option<About>,

    /// Takes the rigid motion out of each frame; playback puts it back.
    #[arg(long, help_heading = PCA)]
    pub(crate) align: bool,

    /// Frames per second, above 0; replaces the times of a .mdd file [default: the times of a .mdd file; otherwise
    /// unknown].
    #[arg(long, value_parser = number, value_name = "FPS", help_heading = PCA)]
    pub(crate) fps: Option<f64>,

    /// Which animation of a glTF file without bones gives the weights over time, by name [default:
    /// the first that moves a weight].
    #[arg(long, value_name = "NAME", help_heading = "Morph targets")]
    pub(crate) clip: Option<String>,

    /// What becomes of weights of bones whose sum is not 1: normalise (divide by it) or as-stored [default: normalise].
    #[arg(long, value_name = "HOW", help_heading = SKIN)]
    pub(crate) weights: Option<Weights>,

    /// Weights of the bones of each vertex, for meshes without a skin of their own: .npy, f32 or f64, shape (N,I).
    #[arg(long, value_name = "W.npy", requires_all = ["skin_joints", "inverse_bind"], help_heading = SKIN)]
    pub(crate) skin_weights: Option<PathBuf>,

    /// The joint of each of --skin-weights: .npy, whole numbers, shape (N,I).
    #[arg(long, value_name = "J.npy", requires_all = ["skin_weights", "inverse_bind"], help_heading = SKIN)]
    pub(crate) skin_joints: Option<PathBuf>,

    /// Inverse bind matrix of each joint, from mesh coordinates to the joint's space, where it rests: .npy, f32 or f64,
    /// shape (B,4,4) or (B,3,4).
    #[arg(long, value_name = "B.npy", requires_all = ["skin_weights", "skin_joints"], help_heading = SKIN)]
    pub(crate) inverse_bind: Option<PathBuf>,

    /// A volume mesh of tetrahedra or hexahedra whose modes move the mesh: .veg (VegaFEM), .vtk
    /// (legacy) or .msh (Gmsh). Without INPUT its surface is the mesh.
    #[arg(long, value_name = "VOLUME", conflicts_with = "basis", help_heading = VOLUME)]
    pub(crate) tets: Option<PathBuf>,

    /// How the elements of --tets carry their mass: consistent or lumped [default: consistent].
    #[arg(long, value_name = "MASS", help_heading = VOLUME)]
    pub(crate) mass: Option<MassMatrix>,

    /// Lattice cells along the longest side, 1 to 1024 [default: chosen from the mesh to limit time and
    /// memory, at most 256].
    #[arg(long, value_name = "CELLS", value_parser = clap::value_parser!(u32).range(1..=i64::from(RESOLUTION_MAX)), help_heading = BODY)]
    pub(crate) resolution: Option<u32>,

    /// Young's modulus in Pa, above 0 [default: that of --tets, else 2e9].
    #[arg(long, value_parser = number, value_name = "PA", help_heading = BODY)]
    pub(crate) young: Option<f64>,

    /// Poisson's ratio, in (-1, 0.5) [default: that of --tets, else 0.35].
    #[arg(long, value_parser = number, value_name = "NU", allow_hyphen_values = true, help_heading = BODY)]
    pub(crate) poisson: Option<f64>,

    /// Thickness of open sheets in mesh units, above 0 [default: 1 % of the box diagonal].
    #[arg(long, value_parser = number, value_name = "LENGTH", help_heading = BODY)]
    pub(crate) thickness: Option<f64>,

    /// Holds part of the body along axes: AXES:xmin,ymin,zmin,xmax,ymax,zmax (mesh units),
    /// AXES:GROUP, or AXES:@FILE with numbers of vertices from 1, AXES being letters of xyz. May be
    /// given several times.
    #[arg(long, value_name = "AXES:BOX|GROUP|@FILE", help_heading = BODY)]
    pub(crate) fix: Vec<Fix>,

    /// Density in kg/m³, above 0, of vibration modes and of what a closed mesh weighs [default: that of --tets, else
    /// 1000].
    #[arg(long, value_parser = number, value_name = "KG_M3", help_heading = MASS)]
    pub(crate) density: Option<f64>,

    /// Meters per mesh unit, above 0, of vibration modes and of what a closed mesh weighs [default: 1].
    #[arg(long, value_parser = number, value_name = "M", help_heading = MASS)]
    pub(crate) scale: Option<f64>,

    /// Refuses bakes that would take more than this many MiB.
    #[arg(long, value_name = "MIB", value_parser = whole_number, default_value_t = ElasticOptions::default().memory_limit_bytes >> 20)]
    pub(crate) memory_limit: u64,

    /// Typical range of q for elastic modes and given fields: how far a mode moves the vertex that it moves most, over
    /// the diagonal of the box, above 0 [default: 0.05]. The `bounds` line of the summary is measured at this q.
    #[arg(long, value_parser = number, value_name = "SHARE")]
    pub(crate) range_rel: Option<f64>,

    /// Largest number of triangles in a leaf, 1 to 255 [default: 4; 8 above 524288 triangles].
    #[arg(long, value_name = "TRIANGLES", value_parser = clap::value_parser!(u8).range(1..), help_heading = "Tree")]
    pub(crate) leaf_size: Option<u8>,

    /// How sets of triangles are divided: cost (fewest visits) or quinlan (as in the paper, for comparison).
    #[arg(long, value_name = "SPLIT", default_value_t = Split::default(), help_heading = "Tree")]
    pub(crate) split: Split,

    /// Makes each sphere contain its children's spheres at every q. Bounds become looser. Needed only
    /// if your program relies on nested spheres.
    #[arg(long, help_heading = "Tree")]
    pub(crate) nested: bool,

    /// Number of threads, 1 to 256. The output file is the same for every value [default: as many as
    /// the processor runs at once].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: Option<u16>,

    /// Prints one JSON object instead of the summary.
    #[arg(long, conflicts_with = "quiet")]
    pub(crate) json: bool,

    /// Prints nothing but errors.
    #[arg(long)]
    pub(crate) quiet: bool,

    /// Recommends a mode count (at most --modes) that keeps the error within --max-error-rel [default here: 0.01],
    /// and the fastest leaf size, with what both save. Times are measured on this machine. Writes no file; the last
    /// line is the command to use.
    #[arg(long, conflicts_with = "quiet")]
    pub(crate) advise: bool,
}

/// A number of an option.
fn number(text: &str) -> Result<f64, String> {
    let percent = text.strip_suffix('%').map(str::trim_end);
    match (text.parse(), percent.map(str::parse::<f64>)) {
        (Ok(number), _) => Ok(number),
        (_, Some(Ok(percent))) => Err(format!("not a number; write {} for it", percent / 100.0)),
        _ => Err("not a number".to_string()),
    }
}

/// A whole number of an option, 0 or more.
fn whole_number(text: &str) -> Result<u64, String> {
    text.parse()
        .map_err(|_| "not a whole number of at least 0".to_string())
}

impl Arguments {
    /// The options that were given and that only some kinds of sources use.
    pub(crate) fn stated(&self) -> Vec<Stated> {
        const LATTICE: &[&str] = &["elastic"];
        const BODIES: &[&str] = &["elastic", "volume"];
        const FREE: &[&str] = &["elastic", "volume", "given"];
        [
            (self.resolution.is_some(), "--resolution", LATTICE),
            (self.thickness.is_some(), "--thickness", LATTICE),
            (self.young.is_some(), "--young", BODIES),
            (self.poisson.is_some(), "--poisson", BODIES),
            (self.density.is_some(), "--density", &[Stated::MASS]),
            (self.scale.is_some(), "--scale", &[Stated::MASS]),
            (!self.fix.is_empty(), "--fix", BODIES),
            (self.range_rel.is_some(), "--range-rel", FREE),
            (self.mass.is_some(), "--mass", &["volume"]),
            (self.clip.is_some(), "--clip", &["morph"]),
            (self.weights.is_some(), "--weights", &[Stated::SKIN]),
        ]
        .into_iter()
        .filter(|(is_given, ..)| *is_given)
        .map(|(_, option, kinds)| Stated { option, kinds })
        .collect()
    }

    /// The frames and the mesh that they move: `--animation` and INPUT, or INPUT alone where it is a folder, which can
    /// hold nothing else.
    pub(crate) fn frames(&self) -> Option<(PathBuf, Option<PathBuf>)> {
        if let Some(frames) = &self.animation {
            return Some((frames.clone(), self.input.clone()));
        }
        let other = self.basis.is_some() || self.tets.is_some();
        let folder = self.input.as_deref().filter(|path| !other && path.is_dir());
        folder.map(|folder| (folder.to_path_buf(), None))
    }

    /// The error that `--advise` allows, over the box diagonal.
    pub(crate) fn goal(&self) -> f64 {
        self.max_error_rel.unwrap_or(GOAL)
    }

    /// What `--modes` and `--max-error-rel` ask for, where [`Arguments::check`] passed. With `--advise` only
    /// numbers count: the error is what the advice is about.
    pub(crate) fn modes(&self) -> Modes {
        if self.advise {
            let number = self.modes.as_deref().map(str::parse);
            return number
                .and_then(Result::ok)
                .map_or(Modes::Unsaid, Modes::Count);
        }
        match (self.modes.as_deref(), self.max_error_rel) {
            (None | Some("auto"), Some(error)) => Modes::Auto(error),
            (Some(text), _) => text.parse().map_or(Modes::Unsaid, Modes::Count),
            (None, None) => Modes::Unsaid,
        }
    }

    /// What clap cannot see: a usage error.
    pub(crate) fn check(&self) -> Result<(), String> {
        self.check_numbers()?;
        self.check_modes()?;
        if self.input.is_none() && self.tets.is_none() && self.animation.is_none() {
            let text =
                "no INPUT: name a mesh (.obj, .ply, .stl, .gltf, .glb); --help shows all options";
            return Err(text.to_string());
        }
        self.check_skipping()?;
        let of_frames = [
            (self.about.is_some(), "--about"),
            (self.align, "--align"),
            (self.fps.is_some(), "--fps"),
        ];
        match of_frames.into_iter().find(|(is_given, _)| *is_given) {
            Some((_, option)) if self.frames().is_none() => Err(format!(
                "{option} needs frames: give --animation, or a folder of frames as INPUT"
            )),
            _ => Ok(()),
        }
    }

    /// Only readers of OBJ and PLY files skip faces.
    fn check_skipping(&self) -> Result<(), String> {
        let is_skipped = |path: &Path| {
            let name = path.display().to_string().to_lowercase();
            let name = name.strip_suffix(".gz").unwrap_or(&name);
            name.ends_with(".obj") || name.ends_with(".ply")
        };
        match &self.input {
            _ if !self.skip_bad_faces => Ok(()),
            Some(path) if is_skipped(path) && !path.is_dir() => Ok(()),
            Some(path) => Err(format!(
                "--skip-bad-faces is for .obj and .ply files, not for {}",
                path.display()
            )),
            None => Err("--skip-bad-faces is for an INPUT, .obj or .ply".to_string()),
        }
    }

    fn check_numbers(&self) -> Result<(), String> {
        for (name, value) in [
            ("--max-error-rel", self.max_error_rel),
            ("--range-rel", self.range_rel),
            ("--fps", self.fps),
            ("--young", self.young),
            ("--density", self.density),
            ("--scale", self.scale),
            ("--thickness", self.thickness),
        ] {
            if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
                let kind = if value == f64::INFINITY {
                    "finite"
                } else {
                    "positive"
                };
                return Err(format!("{name}: {value} is not a {kind} number"));
            }
        }
        if let Some(poisson) = self.poisson.filter(|nu| !(*nu > -1.0 && *nu < 0.5)) {
            return Err(format!("--poisson: {poisson} is not between -1 and 0.5"));
        }
        Ok(())
    }

    fn check_modes(&self) -> Result<(), String> {
        match (self.modes.as_deref(), self.max_error_rel) {
            (Some("auto"), None) if !self.advise => {
                Err("--modes auto needs --max-error-rel E".to_string())
            }
            (None | Some("auto"), _) => Ok(()),
            (Some(text), error) => match text.parse::<usize>() {
                Ok(k) if k > bdtree_format::MODE_COUNT_MAX => Err(format!(
                    "--modes: {k} is more than {}",
                    bdtree_format::MODE_COUNT_MAX
                )),
                Ok(_) if error.is_some() && !self.advise => Err(format!(
                    "--modes {text} and --max-error-rel both say how many modes: give one"
                )),
                Ok(_) => Ok(()),
                Err(_) => Err(format!(
                    "--modes: `{text}` is neither `auto` nor a number of modes from 0 to {}",
                    bdtree_format::MODE_COUNT_MAX
                )),
            },
        }
    }
}

/// How many modes are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Modes {
    /// As the kind of source has it.
    Unsaid,
    /// This many.
    Count(usize),
    /// As few as leave at most this error over the box diagonal.
    Auto(f64),
}
