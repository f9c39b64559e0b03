//! Mutated inputs for every reader of the builder and the tools: seeded, deterministic, in-process.
//!
//! A [`Case`] is a format, a seed and a number; its file is a seed file of the format
//! (`seeds`), changed in ways that know the format (`mutate`). `read` reads it as the
//! commands do. What must hold for each: a result or an error that names the file, no panic, bounded
//! time and memory ([`Limits`]); a share of the results goes on to a bake, `verify` and queries
//! beside brute force (`follow`). docs/design/fuzzing.md has the promises and the commands.

mod binary;
mod container;
mod follow;
mod json;
pub mod memory;
mod mutate;
mod read;
mod run;
mod scenes;
mod seeds;
mod text;
mod watch;
mod written_out;

use std::fmt;
use std::str::FromStr;

pub use run::{Campaign, Tally};
pub use seeds::Seeds;

/// What is read, and by which door.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// A mesh.
    Obj,
    /// A compressed mesh.
    ObjGz,
    /// A folder of frames, one of them mutated.
    Frames,
    /// Binary glTF.
    Glb,
    /// glTF as text.
    Gltf,
    /// A point cache.
    Pc2,
    /// A point cache.
    Mdd,
    /// A sequence as an array.
    Npy,
    /// Fields as an array.
    Basis,
    /// Frequencies of fields, as text or as an array.
    Frequencies,
    /// A list of nodes to hold (`--fix xyz:@FILE`).
    List,
    /// A volume of VegaFEM.
    Veg,
    /// A volume of VTK.
    Vtk,
    /// A volume of Gmsh.
    Msh,
    /// A scene of `bdtree query`.
    Scene,
    /// A mesh as text or binary.
    Ply,
    /// A mesh as text or binary.
    Stl,
}

impl Format {
    /// All of them.
    pub const ALL: [Format; 17] = [
        Format::Obj,
        Format::ObjGz,
        Format::Frames,
        Format::Glb,
        Format::Gltf,
        Format::Pc2,
        Format::Mdd,
        Format::Npy,
        Format::Basis,
        Format::Frequencies,
        Format::List,
        Format::Veg,
        Format::Vtk,
        Format::Msh,
        Format::Scene,
        Format::Ply,
        Format::Stl,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::ObjGz => "obj.gz",
            Self::Frames => "frames",
            Self::Glb => "glb",
            Self::Gltf => "gltf",
            Self::Pc2 => "pc2",
            Self::Mdd => "mdd",
            Self::Npy => "npy",
            Self::Basis => "basis",
            Self::Frequencies => "frequencies",
            Self::List => "list",
            Self::Veg => "veg",
            Self::Vtk => "vtk",
            Self::Msh => "msh",
            Self::Scene => "scene",
            Self::Ply => "ply",
            Self::Stl => "stl",
        }
    }
}

impl fmt::Display for Format {
    /// As `--format` takes it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Format {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|format| format.name() == text)
            .ok_or_else(|| format!("none of {}", Self::ALL.map(Self::name).join(", ")))
    }
}

/// One mutated file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Case {
    /// What it is read as.
    pub format: Format,
    /// Of the campaign.
    pub seed: u64,
    /// Its number in the campaign.
    pub number: u64,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            format,
            seed,
            number,
        } = self;
        write!(f, "--format {format} --seed {seed} --case {number}")
    }
}

/// What a case may take.
#[derive(Debug, Clone, Copy)]
pub enum Limits {}

impl Limits {
    /// Seconds of the processor for baking, `verify` and queries.
    pub const FOLLOW_SECONDS: f64 = 20.0;
    /// Seconds by the clock after which a case counts as hanging.
    pub const HANG_SECONDS: u64 = 120;
    /// Bytes of memory at which the process ends, so that the machine's memory is not taken.
    pub const STOP_BYTES: usize = 2 << 30;

    /// Bytes of memory per byte of glTF accessors, counted as often as they are used.
    pub const BYTES_WRITTEN_OUT: usize = 8;

    /// Seconds of the processor for reading; scenes are answered too, and may hold thousands of
    /// queries.
    pub fn read_seconds(format: Format) -> f64 {
        match format {
            Format::Scene => 10.0,
            _ => 1.0,
        }
    }

    /// Bytes of memory for reading, whatever the file's size; lists are read for a solver, which
    /// takes some itself.
    pub fn read_bytes(format: Format) -> usize {
        match format {
            Format::List => 8 << 20,
            _ => 1 << 20,
        }
    }

    /// Bytes of memory per byte of the file (of compressed ones, of the text in it). A query of a
    /// scene has 50 bytes and may be answered with all triangles of its asset.
    pub fn read_bytes_per_byte(format: Format) -> usize {
        match format {
            Format::Scene => 4096,
            _ => 256,
        }
    }
}
