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

use super::Scene;

/// The settings, and bodies that fall so far.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Head<S> {
    #[serde(flatten)]
    settings: S,
    added: usize,
}

fn magic<S: Scene>() -> String {
    format!("bdtree-{} 1 ", S::NAME)
}

/// Writes the file whole or not at all.
pub(super) fn write<S: Scene>(path: &Path, scene: &S) -> Result<(), Box<dyn Error>> {
    let head = serde_json::to_string(&Head {
        settings: scene.settings(),
        added: scene.fallen(),
    })?;
    let mut bytes = format!("{}{head}\n", magic::<S>()).into_bytes();
    scene.world().save(&mut bytes);
    write_whole(path, |out| out.write_all(&bytes))?;
    Ok(())
}

/// The head of a file's bytes, and the world's bytes.
fn divided<S: Scene>(bytes: &[u8]) -> Result<(Head<S::Settings>, &[u8]), String> {
    let end = bytes.iter().position(|byte| *byte == b'\n');
    let head = end.and_then(|end| str::from_utf8(&bytes[..end]).ok());
    let settings = head.and_then(|head| head.strip_prefix(&*magic::<S>()));
    let (Some(settings), Some(end)) = (settings, end) else {
        return Err(format!("is not a checkpoint of falling {}", S::NAME));
    };
    let head = serde_json::from_str(settings).map_err(|error| error.to_string())?;
    Ok((head, &bytes[end + 1..]))
}

/// The settings of a file: what a scene must have to be put into its state.
pub(crate) fn settings<S: Scene>(path: &Path) -> Result<S::Settings, Box<dyn Error>> {
    let refused = |why: String| format!("{}: {why}", path.display());
    let bytes = fs::read(path).map_err(|error| refused(error.to_string()))?;
    let (head, _) = divided::<S>(&bytes).map_err(refused)?;
    Ok(head.settings)
}

/// Puts a scene in which nothing falls yet into the state of a file.
pub(crate) fn read<S: Scene>(path: &Path, scene: &mut S) -> Result<(), Box<dyn Error>> {
    let refused = |why: String| format!("{}: {why}", path.display());
    let bytes = fs::read(path).map_err(|error| refused(error.to_string()))?;
    let (found, state) = divided::<S>(&bytes).map_err(refused)?;
    let expected = Head {
        settings: scene.settings(),
        added: found.added,
    };
    if found != expected || found.added > scene.count() {
        let why = format!("is of another run: {found:?} instead of {expected:?}");
        return Err(refused(why).into());
    }
    for _ in 0..found.added {
        scene.add(Transform::IDENTITY)?;
    }
    let restored = scene.world_mut().restore(state);
    restored.map_err(|error| refused(error.to_string()))?;
    Ok(())
}
