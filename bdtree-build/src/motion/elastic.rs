//! Vibration modes of the body that a surface encloses.

use super::Moving;
use crate::basis::elastic::{Fix, elastic_basis};
use crate::error::BakeError;
use crate::input::RawMesh;
use crate::mass::Body;
use crate::progress::Progress;
use crate::recipe::Elastic;

/// A mesh with its elastic modes.
pub(super) fn moving(
    mesh: RawMesh,
    elastic: &Elastic,
    progress: &dyn Progress,
) -> Result<Moving, BakeError> {
    let mut moving = Moving::rigid(mesh);
    let options = &elastic.options;
    if options.mode_count == 0 {
        moving.body = Some(Body {
            density_kg_m3: options.density_kg_m3,
            scale_m: options.scale_m,
            ..Body::default()
        });
        return Ok(moving);
    }
    let warnings = &mut moving.provenance.warnings;
    let (basis, report) = elastic_basis(&moving.mesh, options, progress, warnings)?;
    moving.basis = basis;
    moving.provenance.kind = "elastic".to_string();
    moving.set_ranges(elastic.range_rel);
    moving.set("modes", options.mode_count);
    moving.set("resolution", report.resolution);
    moving.set("young", options.young_pa);
    moving.set("poisson", options.poisson);
    moving.set("density", options.density_kg_m3);
    moving.set("scale", options.scale_m);
    moving.set_some("thickness", options.thickness);
    set_fixes(&mut moving, &options.fixes);
    moving.body = Some(report.body);
    moving.elastic = Some(report);
    Ok(moving)
}

/// What is held, for the metadata, which names no folders.
pub(super) fn set_fixes(moving: &mut Moving, fixes: &[Fix]) {
    if !fixes.is_empty() {
        let own = fixes.iter().map(|fix| fix.without_folders().to_string());
        moving.set("fix", own.collect::<Vec<_>>().join(" "));
    }
}
