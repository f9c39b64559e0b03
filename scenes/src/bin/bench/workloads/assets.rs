//! Bodies as files, baked once per build of this program.

use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::time::UNIX_EPOCH;

use bdtree_baselines::Body;
use bdtree_build::pipeline::{BakeSettings, bake};
use bdtree_build::progress::Silent;
use bdtree_runtime::AlignedBytes;

/// The file of a body, kept under `target/workloads/`: its name says which build made it.
pub(crate) fn baked(body: &Body) -> Result<AlignedBytes, Box<dyn Error>> {
    let program = std::env::current_exe()?;
    let made = fs::metadata(&program)?;
    let age = made.modified()?.duration_since(UNIX_EPOCH)?.as_millis();
    let folder = PathBuf::from("target/workloads");
    let stem = format!("{}-m{}-", body.name, body.modes);
    let path = folder.join(format!("{stem}{age:x}-{:x}.bdt", made.len()));
    if path.exists() {
        return Ok(AlignedBytes::read(&path)?);
    }
    eprintln!("baking {}, {} modes", body.name, body.modes);
    let settings = BakeSettings {
        threads: std::thread::available_parallelism().map_or(1, |n| n.get()),
        ..BakeSettings::default()
    };
    let bytes = bake(&body.mesh(), &body.basis(), &settings, &[], &Silent)?.bytes;
    fs::create_dir_all(&folder)?;
    // Those of earlier builds are of no use any more.
    for entry in fs::read_dir(&folder)? {
        let entry = entry?;
        let name = entry.file_name();
        if name.to_str().is_some_and(|name| name.starts_with(&stem)) {
            fs::remove_file(entry.path())?;
        }
    }
    fs::write(&path, &bytes)?;
    Ok(AlignedBytes::copy_of(&bytes))
}
