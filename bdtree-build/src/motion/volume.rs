//! Vibration modes of a given volume mesh.

use super::elastic::set_fixes;
use super::{Moving, Read, hexadecimal, name};
use crate::basis::embed::embed;
use crate::basis::modal::modal_basis;
use crate::basis::volume::{volume_body, volume_modes};
use crate::error::BakeError;
use crate::input::volume::{RawVolume, read_volume, surface};
use crate::input::{BadFaces, RawMesh, read_model};
use crate::progress::Progress;
use crate::recipe::Volume;

/// The volume, and the mesh that it moves.
pub(super) fn read(volume: &Volume, bad_faces: BadFaces) -> Result<Read<'_>, BakeError> {
    let raw = read_volume(&volume.path)?;
    let mesh = match &volume.surface {
        Some(path) => read_model(path, None, bad_faces)?.into_mesh(),
        None => surface(&raw),
    };
    Ok(Read::Volume(raw, mesh, volume))
}

/// The mesh with the volume's modes.
pub(super) fn moving(
    raw: RawVolume,
    mesh: RawMesh,
    volume: &Volume,
    progress: &dyn Progress,
) -> Result<Moving, BakeError> {
    let options = &volume.options;
    let mut moving = Moving::rigid(mesh);
    moving.set("tets", name(&volume.path));
    moving.set("tets-sha256", hexadecimal(raw.hash));
    let mut warnings = Vec::new();
    if volume.surface.is_some() {
        // With the volume's own surface they come along.
        warnings.clone_from(&raw.warnings);
    }
    if options.mode_count > 0 {
        let (modes, report) = volume_modes(&raw, options, progress, &mut warnings)?;
        moving.basis = if volume.surface.is_some() {
            progress.stage("vertices", None);
            let embedding = embed(&moving.mesh.positions, &raw, &mut warnings)?;
            let fields = modes.on_vertices(|field| embedding.apply(field));
            modal_basis(embedding.point_count(), fields, &mut warnings)
        } else {
            // The surface has the volume's nodes as its vertices.
            let fields = modes.on_vertices(<[_]>::to_vec);
            modal_basis(raw.nodes.len(), fields, &mut warnings)
        };
        moving.provenance.kind = "volume".to_string();
        moving.set_ranges(volume.range_rel);
        moving.set("modes", options.mode_count);
        moving.set("mass", options.mass);
        moving.set("scale", options.scale_m);
        moving.set_some("young", options.young_pa);
        moving.set_some("poisson", options.poisson);
        moving.set_some("density", options.density_kg_m3);
        set_fixes(&mut moving, &options.fixes);
        moving.body = Some(report.body);
        moving.volume = Some(report);
    } else {
        match volume_body(&raw, options) {
            Ok(body) => moving.body = Some(body),
            Err(error) => warnings.push(format!("the file has no mass: {error}")),
        }
    }
    moving.provenance.warnings = warnings;
    Ok(moving)
}
