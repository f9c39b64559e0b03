//! Vibration modes of the body that a surface encloses.

use bdtree_build::basis::elastic::{ElasticOptions, Fix, elastic_basis};
use bdtree_build::error::BakeError;
use bdtree_build::progress::Progress;

use super::{MODES_DEFAULT, Source};
use crate::cli::Arguments;
use crate::cli::arguments::Modes;

/// Adds elastic modes to a mesh.
pub(super) fn add(
    arguments: &Arguments,
    source: &mut Source,
    progress: &dyn Progress,
) -> Result<(), BakeError> {
    let default = ElasticOptions::default();
    let options = ElasticOptions {
        mode_count: count(arguments)?,
        resolution: arguments.resolution,
        young_pa: arguments.young.unwrap_or(default.young_pa),
        poisson: arguments.poisson.unwrap_or(default.poisson),
        density_kg_m3: arguments.density.unwrap_or(default.density_kg_m3),
        scale_m: arguments.scale.unwrap_or(default.scale_m),
        thickness: arguments.thickness,
        fixes: arguments.fix.clone(),
        memory_limit_bytes: arguments.memory_limit.saturating_mul(1 << 20),
        ..default
    };
    let (basis, report) = elastic_basis(&source.mesh, &options, progress, &mut source.warnings)?;
    source.basis = basis;
    source.kind = "elastic";
    source.set_ranges(arguments);
    source.set("modes", options.mode_count);
    source.set("resolution", report.resolution);
    source.set("young", options.young_pa);
    source.set("poisson", options.poisson);
    source.set("density", options.density_kg_m3);
    source.set("scale", options.scale_m);
    if let Some(thickness) = options.thickness {
        source.set("thickness", thickness);
    }
    if !options.fixes.is_empty() {
        source.set("fix", fix_text(&options.fixes));
    }
    source.elastic = Some(report);
    Ok(())
}

/// Vibration modes have no end and nothing to be compared with, so their number must be given.
pub(super) fn count(arguments: &Arguments) -> Result<usize, BakeError> {
    match arguments.modes() {
        Modes::Unsaid => Ok(MODES_DEFAULT),
        Modes::Count(count) => Ok(count),
        Modes::Auto(_) => Err(BakeError::one(
            "basis",
            "--modes auto",
            "elastic modes have no source to measure an error against: give their number \
             (--modes K); the bake states the frequency where they end",
        )),
    }
}

/// For the metadata, which names no folders.
pub(super) fn fix_text(fixes: &[Fix]) -> String {
    let text: Vec<String> = fixes
        .iter()
        .map(|fix| fix.without_folders().to_string())
        .collect();
    text.join(" ")
}
