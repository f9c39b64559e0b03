//! The state as a file: a line that says which bodies there are, then the world's own bytes.

use std::fs;
use std::path::Path;

use bdtree_output::{OutputError, write_whole};
use bdtree_tools::ToolError;
use serde::{Deserialize, Serialize};

use super::simulation::{Simulation, State};

const MAGIC: &str = "bdtree-playground 1 ";

/// What must be the same where it goes on. The number of threads and the seed may differ.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Head {
    /// FNV-1a of each file's bytes, and its name.
    files: Vec<(String, String)>,
    step_s: f64,
    scale: f64,
    is_deformable: bool,
    level: Option<usize>,
    /// Which of the files each body is of.
    of: Vec<usize>,
    added: u64,
}

fn hash(bytes: &[u8]) -> String {
    let add = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    format!("{:016x}", bytes.iter().fold(0xcbf2_9ce4_8422_2325, add))
}

fn files(simulation: &Simulation) -> Vec<(String, String)> {
    let kinds = simulation.kinds().iter();
    kinds
        .map(|kind| (hash(kind.model.asset().bytes()), kind.name.clone()))
        .collect()
}

/// Writes the file whole or not at all.
///
/// # Errors
/// Those of [`write_whole`].
pub(super) fn write(path: &Path, simulation: &Simulation) -> Result<(), OutputError> {
    let state = simulation.state();
    let settings = simulation.settings();
    let head = Head {
        files: files(simulation),
        step_s: settings.step_s,
        scale: settings.scale,
        is_deformable: settings.is_deformable,
        level: settings.level,
        of: state.of,
        added: state.added,
    };
    write_whole(path, |out| {
        writeln!(out, "{MAGIC}{}", serde_json::to_string(&head)?)?;
        out.write_all(&state.world)
    })
}

/// Reads the first line of a file, and what follows it.
fn parts(path: &Path) -> Result<(Head, Vec<u8>), ToolError> {
    let refused = |why: String| ToolError::input(path.display(), why);
    let bytes = fs::read(path).map_err(|error| refused(format!("cannot be read: {error}")))?;
    let end = bytes.iter().position(|byte| *byte == b'\n');
    let head = end.and_then(|end| str::from_utf8(&bytes[..end]).ok());
    let (Some(end), Some(head)) = (end, head.and_then(|head| head.strip_prefix(MAGIC))) else {
        return Err(refused("is not a checkpoint of the playground".to_string()));
    };
    let head = serde_json::from_str(head).map_err(|error| refused(error.to_string()))?;
    Ok((head, bytes[end + 1..].to_vec()))
}

/// The step that a file was written with, seconds.
///
/// # Errors
/// A file that cannot be read or is none of these.
pub(super) fn step_s(path: &Path) -> Result<f64, ToolError> {
    Ok(parts(path)?.0.step_s)
}

/// Puts a simulation into the state of a file.
///
/// # Errors
/// A file that cannot be read or is none of these; other settings; a body whose file is not among those of the simulation.
pub(super) fn read(path: &Path, simulation: &mut Simulation) -> Result<(), ToolError> {
    let refused = |why: String| ToolError::input(path.display(), why);
    let (head, world) = parts(path)?;
    let settings = simulation.settings();
    if head.scale != settings.scale {
        return Err(refused(format!("is of bodies with --scale {}", head.scale)));
    }
    if head.step_s != settings.step_s {
        let rate = (1.0 / head.step_s).round();
        return Err(refused(format!("is of --rate {rate}")));
    }
    if head.is_deformable != settings.is_deformable {
        let what = if head.is_deformable {
            "without"
        } else {
            "with"
        };
        return Err(refused(format!("is of a run {what} --rigid")));
    }
    if head.level != settings.level {
        return Err(refused(match head.level {
            Some(level) => format!("is of --level {level}"),
            None => "is of a run without --level".to_string(),
        }));
    }
    // Files may come in another order, and others beside them.
    let known = files(simulation);
    let kind = |of: &usize| {
        let (hash, name) = (head.files.get(*of))
            .ok_or_else(|| refused(format!("has a body of file {of}, which it does not name")))?;
        let found = known.iter().position(|(known, _)| known == hash);
        found.ok_or_else(|| refused(format!("has bodies of another file, {name}: open it, too")))
    };
    let state = State {
        of: head.of.iter().map(kind).collect::<Result<_, _>>()?,
        added: head.added,
        world,
    };
    simulation.set_state(&state).map_err(refused)
}
