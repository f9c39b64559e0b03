//! What the command line says. Exit code 2 for what clap refuses.

use bdtree_build::basis::elastic::{ElasticOptions, Fix, RESOLUTION_MAX};
use bdtree_build::basis::given::Layout;
use bdtree_build::tree::Split;
use clap::Parser;
use std::path::PathBuf;

/// Bakes a mesh and a deformation basis into a memory-mappable .bdt file.
///
/// Without --basis the lowest elastic (vibration) modes of the body that the surface encloses are
/// computed; --modes 0 bakes a rigid asset.
#[derive(Debug, Parser)]
#[command(name = "bdtree-build", version)]
pub(crate) struct Arguments {
    /// The mesh: .obj or .obj.gz.
    pub(crate) input: Option<PathBuf>,

    /// Output file [default: INPUT with .bdt, beside it].
    #[arg(short, long, value_name = "OUT.bdt")]
    pub(crate) output: Option<PathBuf>,

    /// Number of modes, 0 to 512 [default: 10; with --basis: all its fields].
    #[arg(long, value_name = "K")]
    pub(crate) modes: Option<String>,

    /// Given displacement fields (mesh units per unit of q): .npy, f32 or f64, shape (N,3,M),
    /// (3N,M) or (M,N,3).
    #[arg(long, value_name = "U.npy", help_heading = "Given fields")]
    pub(crate) basis: Option<PathBuf>,

    /// What the axes of the --basis array are, where its shape leaves it open: n3m, 3nm or mn3.
    #[arg(
        long,
        value_name = "LAYOUT",
        requires = "basis",
        help_heading = "Given fields"
    )]
    pub(crate) basis_layout: Option<Layout>,

    /// Frequencies of the --basis fields in Hz: .npy or text, one number per field.
    #[arg(
        long,
        value_name = "FILE",
        requires = "basis",
        help_heading = "Given fields"
    )]
    pub(crate) frequencies: Option<PathBuf>,

    /// Lattice cells along the longest side, 1 to 1024 [default: as many as a fixed budget of
    /// lattice nodes allows].
    #[arg(long, value_name = "CELLS", value_parser = clap::value_parser!(u32).range(1..=i64::from(RESOLUTION_MAX)), help_heading = "Elastic modes")]
    pub(crate) resolution: Option<u32>,

    /// Young's modulus in Pa, above 0 [default: 2e9].
    #[arg(long, value_name = "PA", help_heading = "Elastic modes")]
    pub(crate) young: Option<f64>,

    /// Poisson's ratio, in (-1, 0.5) [default: 0.35].
    #[arg(
        long,
        value_name = "NU",
        allow_hyphen_values = true,
        help_heading = "Elastic modes"
    )]
    pub(crate) poisson: Option<f64>,

    /// Density in kg/m³, above 0 [default: 1000].
    #[arg(long, value_name = "KG_M3", help_heading = "Elastic modes")]
    pub(crate) density: Option<f64>,

    /// Metres per mesh unit, above 0 [default: 1].
    #[arg(long, value_name = "M", help_heading = "Elastic modes")]
    pub(crate) scale: Option<f64>,

    /// Thickness of open sheets in mesh units, above 0 [default: 1 % of the box diagonal].
    #[arg(long, value_name = "LENGTH", help_heading = "Elastic modes")]
    pub(crate) thickness: Option<f64>,

    /// Holds part of the body along axes: AXES:xmin,ymin,zmin,xmax,ymax,zmax (mesh units),
    /// AXES:GROUP, or AXES:@FILE with numbers of vertices from 1, AXES being letters of xyz. May be
    /// given several times.
    #[arg(
        long,
        value_name = "AXES:BOX|GROUP|@FILE",
        help_heading = "Elastic modes"
    )]
    pub(crate) fix: Vec<Fix>,

    /// Refuses bakes that would take more than this many MiB.
    #[arg(long, value_name = "MIB", default_value_t = ElasticOptions::default().memory_limit_bytes >> 20, help_heading = "Elastic modes")]
    pub(crate) memory_limit: u64,

    /// Most triangles in a leaf lane, 1 to 255 [default: 4; 8 above 524288 triangles].
    #[arg(long, value_name = "TRIANGLES", value_parser = clap::value_parser!(u8).range(1..), help_heading = "Tree")]
    pub(crate) leaf_size: Option<u8>,

    /// How sets of triangles are divided: cost or quinlan.
    #[arg(long, value_name = "SPLIT", default_value_t = Split::default(), help_heading = "Tree")]
    pub(crate) split: Split,

    /// Threads for order-independent work, 1 to 256; the bytes do not depend on it [default: the
    /// processor's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub(crate) threads: Option<u16>,

    /// Prints one JSON object instead of the summary.
    #[arg(long, conflicts_with = "quiet")]
    pub(crate) json: bool,

    /// Prints nothing but errors.
    #[arg(long)]
    pub(crate) quiet: bool,

    /// Not supported yet: compressed animations.
    #[arg(long, hide = true)]
    pub(crate) animation: Option<PathBuf>,
    /// Not supported yet: given volume meshes.
    #[arg(long, hide = true)]
    pub(crate) tets: Option<PathBuf>,
    /// Not supported yet.
    #[arg(long, hide = true)]
    pub(crate) max_error_rel: Option<f64>,
    /// Not supported yet.
    #[arg(long, hide = true)]
    pub(crate) align: bool,
    /// Not supported yet.
    #[arg(long, hide = true)]
    pub(crate) about: Option<String>,
    /// Not supported yet.
    #[arg(long, hide = true)]
    pub(crate) bound: Option<String>,
    /// Not supported yet.
    #[arg(long, hide = true)]
    pub(crate) advise: bool,
}

impl Arguments {
    /// The options that were given but only elastic modes use.
    pub(crate) fn elastic_only(&self) -> Vec<&'static str> {
        [
            (self.resolution.is_some(), "--resolution"),
            (self.young.is_some(), "--young"),
            (self.poisson.is_some(), "--poisson"),
            (self.density.is_some(), "--density"),
            (self.scale.is_some(), "--scale"),
            (self.thickness.is_some(), "--thickness"),
            (!self.fix.is_empty(), "--fix"),
        ]
        .into_iter()
        .filter_map(|(given, name)| given.then_some(name))
        .collect()
    }

    /// The first option that later versions will know.
    pub(crate) fn unsupported(&self) -> Option<&'static str> {
        [
            (self.animation.is_some(), "--animation"),
            (self.tets.is_some(), "--tets"),
            (self.modes.as_deref() == Some("auto"), "--modes auto"),
            (self.max_error_rel.is_some(), "--max-error-rel"),
            (self.align, "--align"),
            (self.about.is_some(), "--about"),
            (self.bound.is_some(), "--bound"),
            (self.advise, "--advise"),
        ]
        .into_iter()
        .find_map(|(given, name)| given.then_some(name))
    }

    /// K of `--modes K`, if given.
    pub(crate) fn mode_count(&self) -> Result<Option<usize>, String> {
        let Some(text) = &self.modes else {
            return Ok(None);
        };
        match text.parse::<usize>() {
            Ok(k) if k <= bdtree_format::MODE_COUNT_MAX => Ok(Some(k)),
            _ => Err(format!(
                "`{text}` is not a number of modes from 0 to {}",
                bdtree_format::MODE_COUNT_MAX
            )),
        }
    }
}
