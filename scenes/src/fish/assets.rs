//! The two assets: a fish with three vibration modes, and the bridge with ten components of its sway.

use std::error::Error;
use std::fs;
use std::path::Path;

use bdtree_build::basis::pca::PcaOptions;
use bdtree_build::basis::volume::VolumeOptions;
use bdtree_build::pipeline::BakeSettings;
use bdtree_build::progress::Silent;
use bdtree_build::recipe::{Frames, Recipe, Source, Volume};
use bdtree_fixtures::models;
use bdtree_runtime::Model;

/// Meters per mesh unit: fish are 0.75 m long.
pub(super) const FISH_SCALE: f64 = 2.5;

/// Soft enough that fish are seen to bend: the lowest mode has 4 Hz.
const FISH_YOUNG_PA: f64 = 3e5;

/// Of the cells around the fish, which are two and a half times as large as it, kg/m³: together they weigh as much as
/// water in its place.
const CELLS_DENSITY: f64 = 390.0;

/// The asset of a folder, which is baked and kept there if it is not yet; without a folder it is baked.
///
/// # Errors
/// A bake that fails, a file that cannot be read or written.
pub(super) fn get(
    folder: Option<&Path>,
    name: &str,
    recipe: impl Fn() -> Result<Recipe, Box<dyn Error>>,
) -> Result<Model, Box<dyn Error>> {
    let path = folder.map(|folder| folder.join(format!("{name}.bdt")));
    if let Some(path) = path.as_ref().filter(|path| path.exists()) {
        return Ok(Model::read(path)?);
    }
    eprintln!("baking the {name}");
    let baked = bdtree_build::bake(&recipe()?, &Silent)?;
    if let (Some(folder), Some(path)) = (folder, &path) {
        fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        baked.write(path)?;
    }
    Ok(Model::from_bytes(&baked.bytes)?)
}

/// The fish of the fixtures with the three lowest modes of coarse cells around it: its own lowest ones move nothing but
/// tips of fins.
pub(super) fn fish() -> Result<Recipe, Box<dyn Error>> {
    let options = VolumeOptions {
        mode_count: 3,
        young_pa: Some(FISH_YOUNG_PA),
        density_kg_m3: Some(CELLS_DENSITY),
        scale_m: FISH_SCALE,
        threads: threads(),
        ..VolumeOptions::default()
    };
    Ok(with_threads(Recipe::new(Source::Volume(Volume {
        path: models::path("fish_cells.vtk"),
        surface: Some(models::path("fish")),
        options,
        range_rel: None,
    }))))
}

/// The bridge of the fixtures in the wind, with ten components.
pub(super) fn bridge() -> Result<Recipe, Box<dyn Error>> {
    let (mesh, frames) = models::animation::bridge_sway()?;
    Ok(with_threads(Recipe::new(Source::Frames(Frames {
        path: frames,
        surface: Some(mesh),
        fps: Some(models::animation::BRIDGE_FPS),
        options: PcaOptions::default(),
    }))))
}

fn with_threads(recipe: Recipe) -> Recipe {
    Recipe {
        settings: BakeSettings {
            threads: threads(),
            ..recipe.settings
        },
        ..recipe
    }
}

fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}
