//! The facts of a file, named as `info --json` prints them.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use bdtree_format::{ErrorMetadata, Metadata, ModeRecord, ROW_RADIUS, SectionKind, SectionRecord};
use bdtree_runtime::{Asset, Datum, FormatError, Transform};
use serde::Serialize;

use super::mass::Mass;
use crate::AssetFile;
use crate::error::ToolError;
use crate::frames::duration_s;
use crate::output::printable;

/// What a file holds. Lengths are mesh units; unknown values are null.
#[derive(Debug, Serialize)]
pub struct Info {
    /// Format version of the writer, major.minor.
    pub version: String,
    /// Length of the file.
    pub bytes: u64,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of modes.
    pub modes: usize,
    /// Number of eight-wide nodes.
    pub nodes: usize,
    /// Number of node levels.
    pub depth: usize,
    /// What stored positions are relative to.
    pub origin: [f64; 3],
    /// The box around the rest positions of all triangles; null without triangles.
    pub bounds: Option<Bounds>,
    /// The same with the bones at rest; null without a skin.
    pub bounds_at_rest: Option<Bounds>,
    /// Meters per mesh unit that masses and frequencies were computed with; null without.
    pub scale_m: Option<f64>,
    /// Mass, center of mass and inertia of the body at rest; null where they are unknown.
    pub mass: Option<Mass>,
    /// Hard limit of |q_j| per mode.
    pub q_limit: Vec<f32>,
    /// Typical largest |q_j| per mode.
    pub q_range: Vec<f32>,
    /// What was baked.
    pub source: Source,
    /// One entry per mode.
    pub mode_info: Vec<Mode>,
    /// Number of animation frames; null when there is no animation.
    pub frames: Option<usize>,
    /// Seconds from the first frame to the last; null when the source does not say.
    pub duration_s: Option<f64>,
    /// Frequency where a modal basis ends: the largest that is known.
    pub highest_frequency_hz: Option<f64>,
    /// The sections, in file order.
    pub sections: Vec<Section>,
    /// The tree's levels, from the root.
    pub levels: Vec<Level>,
    /// By level, the mean of the radii at q_range over those at rest, sphere by sphere; null where no mode moves
    /// anything.
    pub growth_mean: Vec<Option<f64>>,
    /// Mesh units per stored unit.
    pub unit: f64,
    /// Most triangles in one leaf lane.
    pub leaf_triangles_max: u32,
    /// What wrote the file.
    pub builder: Option<String>,
    /// Where the basis came from.
    pub basis: Option<String>,
    /// Error of the basis against its source over the bounding box's diagonal.
    pub basis_error_rel: Option<ErrorMetadata>,
    /// Settings of the bake.
    pub settings: Option<BTreeMap<String, String>>,
    /// What was odd about the source.
    pub warnings: Option<Vec<String>>,
    /// The source's groups.
    pub groups: Vec<Group>,
    /// The joints, in the order of joint matrices; null without a skin.
    pub joints: Option<Vec<Joint>>,
    /// The clips; null without a skin.
    pub clips: Option<Vec<ClipInfo>>,
    /// Bones: joints with an inverse bind matrix each; null without a skin.
    pub bones: Option<usize>,
    /// Largest number of bones that move one vertex; null without a skin.
    pub influences_max: Option<u32>,
}

/// A joint of the skeleton.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Joint {
    /// The source's name.
    pub name: String,
    /// Index of the nearest joint above it; null for none.
    pub parent: Option<usize>,
}

/// A clip of the skeleton.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClipInfo {
    /// The source's name.
    pub name: String,
    /// Seconds from time 0 to its last key.
    pub duration_s: f64,
}

/// A box with sides along the axes (mesh units).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bounds {
    /// Least coordinates.
    pub min: [f64; 3],
    /// Largest coordinates.
    pub max: [f64; 3],
}

impl Bounds {
    /// Lengths of the sides.
    pub fn size(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.max[k] - self.min[k])
    }

    /// Length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        self.size().iter().map(|x| x * x).sum::<f64>().sqrt()
    }
}

/// The file that was baked.
#[derive(Debug, Serialize)]
pub struct Source {
    /// Its name without folder.
    pub name: Option<String>,
    /// SHA-256 in hexadecimal.
    pub hash: Option<String>,
}

/// What is known about a mode.
#[derive(Debug, Serialize)]
pub struct Mode {
    /// Its name.
    pub name: Option<String>,
    /// ω / 2π.
    pub frequency_hz: Option<f64>,
    /// In kg.
    pub modal_mass_kg: Option<f64>,
    /// The source's default weight.
    pub default_q: Option<f64>,
}

/// A section's place.
#[derive(Debug, Serialize)]
pub struct Section {
    /// Four letters.
    pub kind: String,
    /// First byte.
    pub offset: u64,
    /// Length.
    pub bytes: u64,
}

/// The spheres of the nodes of one level, at rest.
#[derive(Debug, Serialize)]
pub struct Level {
    /// 0: those in the root node.
    pub level: usize,
    /// How many.
    pub spheres: u64,
    /// Their mean radius; null when there is none.
    pub radius_mean: Option<f64>,
    /// Their largest radius.
    pub radius_max: Option<f64>,
    /// One of [`Info::growth_mean`].
    #[serde(skip)]
    pub growth_mean: Option<f64>,
}

/// A run of triangles under one name.
#[derive(Debug, Serialize)]
pub struct Group {
    /// `object`, `group` or `material`; other numbers as they are.
    pub kind: String,
    /// The source's name.
    pub name: String,
    /// First triangle id.
    pub first_triangle: u32,
    /// Number of triangles.
    pub triangles: u32,
}

impl Info {
    /// Reads header, tables, nodes, radii and metadata.
    ///
    /// # Errors
    /// What is read and breaks the format's rules.
    pub fn of(file: &AssetFile) -> Result<Self, ToolError> {
        let asset = file.asset();
        let levels = levels(asset).map_err(|error| file.error(error))?;
        let metadata = metadata(file)?;
        let metadata = metadata.as_ref();
        let header = asset.header();
        let known = |x: f64| (x != -1.0).then_some(x);
        let described = |j: usize| metadata?.modes.get(j);
        let mode = |(j, mode): (usize, &ModeRecord)| Mode {
            name: described(j).and_then(|m| m.name.clone()),
            frequency_hz: known(mode.omega_rad_s.get()).map(|omega| omega / TAU),
            modal_mass_kg: known(mode.modal_mass_kg.get()),
            default_q: described(j).and_then(|m| m.default_q),
        };
        let mode_info: Vec<Mode> = asset.modes().iter().enumerate().map(mode).collect();
        let frequencies = mode_info.iter().filter_map(|mode| mode.frequency_hz);
        let section = |section: &SectionRecord| Section {
            kind: section.kind.to_string(),
            offset: section.offset.get(),
            bytes: section.length.get(),
        };
        let group = |group: bdtree_runtime::Group<'_>| Group {
            kind: format!("{:?}", group.kind).to_lowercase(),
            name: group.name.to_string(),
            first_triangle: group.first_triangle.0,
            triangles: group.triangle_count,
        };
        let skeleton = asset.skeleton();
        let (major, minor) = (header.version_major.get(), header.version_minor.get());
        Ok(Self {
            version: format!("{major}.{minor}"),
            bytes: header.file_bytes.get(),
            vertices: asset.vertex_count(),
            triangles: asset.triangle_count(),
            modes: asset.mode_count(),
            nodes: asset.node_count(),
            depth: asset.depth(),
            origin: asset.origin(),
            bounds: bounds(asset),
            bounds_at_rest: bounds_at_rest(asset),
            scale_m: metadata.and_then(|m| m.settings.get("scale")?.parse().ok()),
            mass: asset.mass_properties().map(Mass::of),
            q_limit: asset.modes().iter().map(|m| m.q_limit.get()).collect(),
            q_range: asset.modes().iter().map(|m| m.q_range.get()).collect(),
            source: Source {
                name: metadata.map(|m| m.source_name.clone()),
                hash: metadata.map(|m| hexadecimal(&m.source_hash)),
            },
            frames: Some(asset.frame_count()).filter(|count| *count > 0),
            duration_s: duration_s(asset),
            highest_frequency_hz: frequencies.reduce(f64::max),
            mode_info,
            sections: asset.sections().iter().map(section).collect(),
            growth_mean: levels.iter().map(|level| level.growth_mean).collect(),
            levels,
            unit: asset.unit(),
            leaf_triangles_max: header.leaf_triangles_max.get(),
            builder: metadata.map(|m| m.builder.clone()),
            basis: metadata.map(|m| m.basis.clone()),
            basis_error_rel: metadata.and_then(|m| m.basis_error_rel),
            settings: metadata.map(|m| m.settings.clone()),
            warnings: metadata.map(|m| m.warnings.clone()),
            groups: asset.groups().map(group).collect(),
            joints: skeleton.map(|skeleton| {
                let joint = |j| Joint {
                    name: skeleton.joint_name(j).unwrap_or_default().to_string(),
                    parent: skeleton.joint_parent(j),
                };
                (0..skeleton.joint_count()).map(joint).collect()
            }),
            clips: skeleton.map(|skeleton| {
                let clip = |clip: bdtree_runtime::Clip<'_>| ClipInfo {
                    name: clip.name().to_string(),
                    duration_s: clip.duration_s(),
                };
                skeleton.clips().map(clip).collect()
            }),
            bones: skeleton.map(|_| asset.bone_count()),
            influences_max: asset.skin_record().map(|record| record.influences_max),
        })
    }
}

/// The box around the rest positions of all triangles.
pub(crate) fn bounds(asset: &Asset<'_>) -> Option<Bounds> {
    let corners = asset
        .triangles()
        .iter()
        .flat_map(|triangle| triangle.corners);
    let positions = corners.filter_map(|vertex| asset.positions().get(vertex as usize));
    let (origin, unit) = (asset.origin(), asset.unit());
    let world = positions.map(|p| [0, 1, 2].map(|k| origin[k] + unit * f64::from(p[k])));
    let point = |p| Bounds { min: p, max: p };
    world.map(point).reduce(|a, b| Bounds {
        min: [0, 1, 2].map(|k| a.min[k].min(b.min[k])),
        max: [0, 1, 2].map(|k| a.max[k].max(b.max[k])),
    })
}

/// The box around the triangles as bones at rest carry them; `None` without bones, and where the file is damaged there.
fn bounds_at_rest(asset: &Asset<'_>) -> Option<Bounds> {
    asset.has_skin().then_some(())?;
    let (q, mut memory) = (vec![0.0; asset.mode_count()], vec![0.0; asset.pose_len()]);
    let pose = asset.pose(&q, Transform::IDENTITY, &mut memory).ok()?;
    let aabb = pose.exact_aabb().ok()?;
    let (min, max) = (aabb.min, aabb.max);
    (asset.triangle_count() > 0).then_some(Bounds { min, max })
}

/// `mode 3`, with its name where it has one.
pub(crate) fn mode_name(file: &AssetFile, mode: usize) -> Result<String, ToolError> {
    let metadata = metadata(file)?;
    let name = metadata.and_then(|m| m.modes.into_iter().nth(mode)?.name);
    Ok(name.map_or(format!("mode {mode}"), |name| {
        format!("mode {mode} ({})", printable(&name))
    }))
}

/// The metadata section, if there is one.
pub(crate) fn metadata(file: &AssetFile) -> Result<Option<Metadata>, ToolError> {
    let asset = file.asset();
    if asset.metadata().is_empty() {
        return Ok(None);
    }
    let metadata = Metadata::from_bytes(asset.metadata());
    metadata.map(Some).map_err(|error| ToolError::Metadata {
        path: file.path().to_path_buf(),
        error,
    })
}

/// Two digits per byte.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// Counts and radii of the lanes that are not empty, by the level of their node.
fn levels(asset: &Asset<'_>) -> Result<Vec<Level>, FormatError> {
    let mut radii = vec![Vec::new(); asset.depth()];
    let mut growths = vec![Vec::new(); asset.depth()];
    let q: Vec<f32> = asset.modes().iter().map(|m| m.q_range.get()).collect();
    let mut memory = vec![0.0; asset.pose_len()];
    // Of records that are not checked: without a pose there is no growth to tell.
    let moves = q.iter().any(|q| *q > 0.0);
    let pose = asset
        .pose(&q, Transform::IDENTITY, &mut memory)
        .ok()
        .filter(|_| moves);
    for (i, node) in asset.nodes().iter().enumerate() {
        let Some(radii) = radii.get_mut(usize::from(node.level)) else {
            return Err(FormatError {
                section: SectionKind::NODES,
                byte: section_start(asset, SectionKind::NODES) + (i * size_of_val(node)) as u64,
                rule: "SPEC 6.6: a node's level is below the header's depth",
                expected: Datum::Integer(asset.depth() as u64),
                found: Datum::Integer(u64::from(node.level)),
            });
        };
        let row = asset.node_rows(node)?.leading[ROW_RADIUS];
        radii.extend(node.lanes().map(|lane| f64::from(row[lane])));
        if let Some(Ok(moved)) = pose.as_ref().map(|pose| pose.node_spheres(i as u32)) {
            let growth = |lane: usize| f64::from(moved.radius[lane]) / f64::from(row[lane]);
            let own = node.lanes().map(growth).filter(|growth| growth.is_finite());
            growths[usize::from(node.level)].extend(own);
        }
    }
    let level = |(level, (radii, growths)): (usize, (Vec<f64>, Vec<f64>))| {
        let growth = growths.iter().sum::<f64>() / growths.len() as f64;
        let mean = radii.iter().sum::<f64>() / radii.len() as f64;
        let max = radii.iter().copied().reduce(f64::max);
        Level {
            level,
            spheres: radii.len() as u64,
            radius_mean: max.map(|_| mean * asset.unit()),
            radius_max: max.map(|max| max * asset.unit()),
            growth_mean: (!growths.is_empty()).then_some(growth),
        }
    };
    Ok(radii
        .into_iter()
        .zip(growths)
        .enumerate()
        .map(level)
        .collect())
}

/// Where a section begins; 0 if there is none.
pub(crate) fn section_start(asset: &Asset<'_>, kind: SectionKind) -> u64 {
    let section = asset.sections().iter().find(|s| s.kind == kind);
    section.map_or(0, |s| s.offset.get())
}
