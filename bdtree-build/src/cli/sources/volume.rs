//! `--tets`: vibration modes of a given volume mesh.

use std::path::Path;

use bdtree_build::basis::embed::embed;
use bdtree_build::basis::modal::modal_basis;
use bdtree_build::basis::volume::{VolumeOptions, volume_modes};
use bdtree_build::error::BakeError;
use bdtree_build::input::read_mesh;
use bdtree_build::input::volume::{RawVolume, read_volume, surface};
use bdtree_build::progress::Progress;

use super::elastic::{count, fix_text};
use super::{Source, hexadecimal, name};
use crate::cli::Arguments;

/// The volume at `path`, and the mesh that it moves: INPUT, or the volume's own surface.
pub(super) fn read(arguments: &Arguments, path: &Path) -> Result<(RawVolume, Source), BakeError> {
    let volume = read_volume(path)?;
    let mut source = Source::rigid(match &arguments.input {
        Some(input) => read_mesh(input)?,
        None => surface(&volume),
    });
    if arguments.input.is_some() {
        // With the surface they come along.
        source.warnings.extend(volume.warnings.iter().cloned());
    }
    source.set("tets", name(path));
    source.set("tets-sha256", hexadecimal(volume.hash));
    Ok((volume, source))
}

/// Adds the volume's modes to the mesh.
pub(super) fn add(
    arguments: &Arguments,
    volume: &RawVolume,
    source: &mut Source,
    progress: &dyn Progress,
) -> Result<(), BakeError> {
    let default = VolumeOptions::default();
    let options = VolumeOptions {
        mode_count: count(arguments)?,
        young_pa: arguments.young,
        poisson: arguments.poisson,
        density_kg_m3: arguments.density,
        scale_m: arguments.scale.unwrap_or(default.scale_m),
        mass: arguments.mass.unwrap_or(default.mass),
        fixes: arguments.fix.clone(),
        memory_limit_bytes: arguments.memory_limit.saturating_mul(1 << 20),
        ..default
    };
    let (modes, report) = volume_modes(volume, &options, progress, &mut source.warnings)?;
    source.basis = if arguments.input.is_some() {
        progress.stage("vertices", None);
        let embedding = embed(&source.mesh.positions, volume, &mut source.warnings)?;
        let fields = modes.on_vertices(|field| embedding.apply(field));
        modal_basis(embedding.point_count(), fields, &mut source.warnings)
    } else {
        // The surface has the volume's nodes as its vertices.
        let fields = modes.on_vertices(<[_]>::to_vec);
        modal_basis(volume.nodes.len(), fields, &mut source.warnings)
    };
    source.kind = "volume";
    source.set_ranges(arguments);
    source.set("modes", options.mode_count);
    source.set("mass", options.mass);
    source.set("scale", options.scale_m);
    let material = [
        ("young", options.young_pa),
        ("poisson", options.poisson),
        ("density", options.density_kg_m3),
    ];
    for (name, value) in material {
        if let Some(value) = value {
            source.set(name, value);
        }
    }
    if !options.fixes.is_empty() {
        source.set("fix", fix_text(&options.fixes));
    }
    source.volume = Some(report);
    Ok(())
}
