//! What an opened file was baked from, read back from its sections.

mod skin;

use bdtree_format::{ErrorMetadata, Metadata};
use bdtree_runtime::{Asset, FormatError, TriangleId, VertexId};

use super::AdviceError;
use super::errors::{Errors, Over};
use super::subject::{BEFORE_BONES, Subject, assumed_ranges};
use crate::basis::{Animation, Basis, BasisError, BasisMode, RigidMotion};
use crate::input::{GroupKind, RawGroup, RawMesh};
use crate::mass::{Body, MassProperties, Momentum};
use crate::pipeline::{BakeSettings, Provenance};
use crate::skin::Weights;
use crate::tree::Split;

impl Subject {
    /// What an opened file holds: its numbers are exact, so that a bake of all modes with these settings gives the
    /// same tree. Threads stay 1.
    ///
    /// # Errors
    /// Records that break the format's rules; a skin whose clips have more keys than the file has numbers, because
    /// channels share them.
    pub fn of_asset(asset: &Asset<'_>) -> Result<Self, AdviceError> {
        let mesh = mesh(asset)?;
        let mut missing = Vec::new();
        let metadata = match Metadata::from_bytes(asset.metadata()) {
            Ok(metadata) => metadata,
            Err(_) => {
                let text = "The file does not say how it was made (no metadata that can be read): leaf size \
                            and split are taken to be the defaults.";
                missing.push(text.to_string());
                Metadata::default()
            }
        };
        let basis = basis(asset, &metadata)?;
        missing.extend(assumed_ranges(&metadata.basis, &metadata.settings));
        let skin = skin::skin(asset)?;
        if skin.is_some() && asset.mode_count() > 0 {
            missing.push(BEFORE_BONES.to_string());
        }
        let own = metadata.basis_error_rel.map(basis_error);
        // Weights of a face are its user's; a clip is an example.
        let over = if metadata.basis == "morph" {
            Over::Ranges
        } else {
            Over::Frames
        };
        let diagonal = mesh.diagonal();
        Ok(Self {
            errors: Errors::against_all(&basis, diagonal, over, own),
            settings: settings(asset, &metadata),
            provenance: Provenance {
                kind: metadata.basis,
                error: own,
                settings: metadata.settings,
                warnings: Vec::new(),
            },
            mesh: RawMesh {
                name: metadata.source_name,
                hash: metadata.source_hash,
                ..mesh
            },
            basis,
            skin,
            missing,
            modes_available: None,
        })
    }
}

fn mesh(asset: &Asset<'_>) -> Result<RawMesh, FormatError> {
    let (origin, unit) = (asset.origin(), asset.unit());
    let place = |p: &[f32; 3]| [0, 1, 2].map(|k| origin[k] + unit * f64::from(p[k]));
    let triangle = |id: usize| -> Result<[u32; 3], FormatError> {
        Ok(asset
            .triangle(TriangleId(id as u32))?
            .map(|corner| corner.0))
    };
    let groups = asset.groups().filter_map(|group| {
        let kind = match group.kind {
            bdtree_runtime::GroupKind::Object => GroupKind::Object,
            bdtree_runtime::GroupKind::Group => GroupKind::Group,
            bdtree_runtime::GroupKind::Material => GroupKind::Material,
            _ => return None,
        };
        Some(RawGroup {
            kind,
            name: group.name.to_string(),
            first_triangle: group.first_triangle.0,
            triangle_count: group.triangle_count,
        })
    });
    Ok(RawMesh {
        positions: asset.positions().iter().map(place).collect(),
        triangles: (0..asset.triangle_count())
            .map(triangle)
            .collect::<Result<_, _>>()?,
        groups: groups.collect(),
        ..RawMesh::default()
    })
}

fn basis(asset: &Asset<'_>, metadata: &Metadata) -> Result<Basis, FormatError> {
    let (n, m) = (asset.vertex_count(), asset.mode_count());
    let unit = asset.unit();
    let mut fields = vec![[0.0; 3]; n * m];
    for vertex in 0..n {
        for (mode, u) in asset.displacements(VertexId(vertex as u32))?.iter() {
            // A list that names no mode of the file is the reader's to report.
            if mode < m {
                fields[mode * n + vertex] = u.map(|x| unit * f64::from(x));
            }
        }
    }
    let known = |x: f64| (x >= 0.0).then_some(x);
    let modes = asset.modes().iter().enumerate().map(|(j, mode)| {
        let words = metadata.modes.get(j);
        BasisMode {
            name: words.and_then(|words| words.name.clone()),
            omega_rad_s: known(mode.omega_rad_s.get()),
            modal_mass_kg: known(mode.modal_mass_kg.get()),
            momentum: momentum(asset, j),
            q_range: Some(f64::from(mode.q_range.get())),
            default_q: words.and_then(|words| words.default_q),
        }
    });
    Ok(Basis {
        vertex_count: n,
        fields,
        modes: modes.collect(),
        animation: animation(asset),
    })
}

/// The momentum of a mode, if the file has it.
fn momentum(asset: &Asset<'_>, mode: usize) -> Option<Momentum> {
    let record = asset.mode_momenta()?.get(mode)?;
    Some(Momentum {
        about: asset.mass_properties()?.center_of_mass.map(|x| x.get()),
        linear: record.linear.map(|x| x.get()),
        angular: record.angular.map(|x| x.get()),
    })
}

fn animation(asset: &Asset<'_>) -> Option<Animation> {
    let frames: Option<Vec<_>> = (0..asset.frame_count()).map(|t| asset.frame(t)).collect();
    let frames = frames.filter(|frames| !frames.is_empty())?;
    let q = frames.iter().flat_map(|frame| frame.q());
    let motions: Vec<RigidMotion> = frames
        .iter()
        .map(|frame| RigidMotion {
            rotation: frame.transform().rotation,
            translation: frame.transform().translation,
        })
        .collect();
    let moves = motions
        .iter()
        .any(|motion| *motion != RigidMotion::IDENTITY);
    Some(Animation {
        frame_count: frames.len(),
        times_s: frames.iter().map(|frame| frame.time_s()).collect(),
        q: q.map(|&x| f64::from(x)).collect(),
        motions: if moves { motions } else { Vec::new() },
    })
}

fn basis_error(error: ErrorMetadata) -> BasisError {
    BasisError {
        max_rel: error.max,
        rms_rel: error.rms,
        frame: error.frame.map(|frame| frame as usize),
        vertex: error.vertex.unwrap_or(0) as usize,
    }
}

/// The settings that the metadata state; those it does not, by default.
fn settings(asset: &Asset<'_>, metadata: &Metadata) -> BakeSettings {
    let value = |name: &str| metadata.settings.get(name);
    BakeSettings {
        leaf_size: value("leaf-size").and_then(|text| text.parse().ok()),
        split: value("split")
            .and_then(|text| text.parse::<Split>().ok())
            .unwrap_or_default(),
        nested: value("nested").is_some_and(|text| text == "true"),
        // Those of a file are as they shall be.
        weights: Weights::AsStored,
        // So is the mass, which may be that of a body that the file does not hold.
        body: Body {
            known: asset.mass_properties().and_then(MassProperties::of_record),
            ..Body::default()
        },
        ..BakeSettings::default()
    }
}
