//! A run's state as a file: a line of settings, then the world's own bytes.
//!
//! The settings say which bodies there are, so that whoever goes on adds them again; where they are is in the world's
//! bytes. Going on gives the same bytes as a run without a break.

use std::error::Error;
use std::fs;
use std::path::Path;

use bdtree_output::write_whole;
use bdtree_runtime::Transform;
use serde::{Deserialize, Serialize};

use super::Arguments;
use super::scene::Scene;

const MAGIC: &str = "bdtree-chairs 1 ";

/// What must be the same in the run that goes on. The number of threads, pictures and checks may differ.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Settings {
    bodies: u32,
    seed: u64,
    rigid: bool,
    level: usize,
    /// FNV-1a of the asset's bytes.
    asset: String,
    /// Bodies so far.
    added: usize,
}

impl Settings {
    fn of(arguments: &Arguments, scene: &Scene) -> Self {
        Self {
            bodies: arguments.bodies,
            seed: arguments.seed,
            rigid: arguments.rigid,
            level: scene.spheres.level,
            asset: format!("{:016x}", hash(scene.model.asset().bytes())),
            added: scene.world.len(),
        }
    }
}

fn hash(bytes: &[u8]) -> u64 {
    let add = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, add)
}

/// Writes the file whole or not at all.
pub(super) fn write(
    path: &Path,
    arguments: &Arguments,
    scene: &Scene,
) -> Result<(), Box<dyn Error>> {
    let settings = serde_json::to_string(&Settings::of(arguments, scene))?;
    write_whole(path, |out| {
        out.write_all(format!("{MAGIC}{settings}\n").as_bytes())?;
        out.write_all(&scene.bytes())
    })?;
    Ok(())
}

/// Puts a scene without bodies into the state of a file.
pub(super) fn read(
    path: &Path,
    arguments: &Arguments,
    scene: &mut Scene,
) -> Result<(), Box<dyn Error>> {
    let refused = |why: String| format!("{}: {why}", path.display());
    let bytes = fs::read(path).map_err(|error| refused(error.to_string()))?;
    let end = bytes.iter().position(|byte| *byte == b'\n');
    let head = end.and_then(|end| str::from_utf8(&bytes[..end]).ok());
    let settings = head.and_then(|head| head.strip_prefix(MAGIC));
    let (Some(settings), Some(end)) = (settings, end) else {
        return Err(refused("is not a checkpoint of falling chairs".to_string()).into());
    };
    let found: Settings =
        serde_json::from_str(settings).map_err(|error| refused(error.to_string()))?;
    let expected = Settings {
        added: found.added,
        ..Settings::of(arguments, scene)
    };
    if found != expected || found.added > found.bodies as usize {
        let why = format!("is of another run: {found:?} instead of {expected:?}");
        return Err(refused(why).into());
    }
    for _ in 0..found.added {
        scene.add(Transform::IDENTITY)?;
    }
    let restored = scene.world.restore(&bytes[end + 1..]);
    restored.map_err(|error| refused(error.to_string()))?;
    Ok(())
}
