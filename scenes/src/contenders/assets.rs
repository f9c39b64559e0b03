//! Bodies as files, baked once per build of this program.

use std::error::Error;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::time::UNIX_EPOCH;

use bdtree_build::basis::Basis;
use bdtree_build::input::RawMesh;
use bdtree_build::pipeline::{BakeSettings, Provenance, bake_fields};
use bdtree_build::progress::Silent;
use bdtree_fixtures::models;
use bdtree_measure::Body;
use bdtree_runtime::Model;

/// The model of a body, whose file is kept under `target/workloads/`: its name says which build made it.
///
/// # Errors
/// A body that cannot be baked, a file that cannot be read or written.
pub fn baked(body: &Body) -> Result<Model, Box<dyn Error>> {
    let program = std::env::current_exe()?;
    let made = fs::metadata(&program)?;
    let age = made.modified()?.duration_since(UNIX_EPOCH)?.as_millis();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/workloads");
    let (name, count) = (body.name, body.triangles.len());
    let stem = format!("{name}-{count}-m{}-", body.modes);
    let path = folder.join(format!("{stem}{age:x}-{:x}.bdt", made.len()));
    if path.exists() {
        return Ok(Model::read(&path)?);
    }
    eprintln!("baking {}, {} modes", body.name, body.modes);
    let model = baked_mesh(&body.mesh(), &body.basis())?;
    fs::create_dir_all(&folder)?;
    // Those of earlier builds are of no use any more; another program may be at it too.
    for entry in fs::read_dir(&folder)? {
        let entry = entry?;
        let name = entry.file_name();
        if name.to_str().is_some_and(|name| name.starts_with(&stem)) {
            match fs::remove_file(entry.path()) {
                Err(e) if e.kind() != ErrorKind::NotFound => return Err(e.into()),
                _ => {}
            }
        }
    }
    models::write(&path, model.asset().bytes())?;
    Ok(model)
}

/// The model of a mesh and its modes, with the settings that a bake has by itself.
///
/// # Errors
/// Those of the bake.
pub fn baked_mesh(mesh: &RawMesh, basis: &Basis) -> Result<Model, Box<dyn Error>> {
    let settings = BakeSettings {
        threads: std::thread::available_parallelism().map_or(1, |n| n.get()),
        ..BakeSettings::default()
    };
    let baked = bake_fields(mesh, basis, &settings, &Provenance::default(), &Silent)?;
    Ok(Model::from_bytes(&baked.bytes)?)
}
