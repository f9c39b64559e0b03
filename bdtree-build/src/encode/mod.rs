//! The file's bytes: offsets are planned first, then everything is written once. The same input
//! gives the same bytes.

mod plan;

use std::borrow::Cow;

use bdtree_format::{
    GroupRecord, Header, LAYOUT_1, LAYOUT_2, MAGIC, Metadata, ModeRecord, SECTION_LAYOUTS,
    SECTION_ORDER, SectionKind, SectionRecord, TriangleRecord, VERSION_MAJOR, VERSION_MINOR,
    group_kind,
};
use zerocopy::IntoBytes;

use crate::basis::Basis;
use crate::error::{BakeError, Part, Place};
use crate::input::{GroupKind, RawGroup, RawMesh};
use crate::tree::Tree;
use crate::wrap::{StoredShape, WrappedTree};
use plan::Plan;

#[cfg(target_endian = "big")]
compile_error!("the big arrays of a .bdt file are written as they lie in memory, little-endian");

/// Sections that every file has.
const REQUIRED_SECTIONS: usize = 7;

/// What a file is made of.
#[derive(Debug, Clone, Copy)]
pub struct Parts<'a> {
    /// Triangles and groups.
    pub mesh: &'a RawMesh,
    /// Frequencies and masses.
    pub basis: &'a Basis,
    /// Positions and fields as stored.
    pub shape: &'a StoredShape,
    /// The order of triangles.
    pub tree: &'a Tree,
    /// Nodes and rows.
    pub wrapped: &'a WrappedTree,
    /// What people want to know.
    pub metadata: &'a Metadata,
}

/// The whole file.
///
/// # Errors
/// Metadata or group names that are too long.
pub fn encode(parts: &Parts) -> Result<Vec<u8>, BakeError> {
    let triangles = triangle_records(parts);
    let slots = triangle_slots(&triangles);
    let (groups, names) = group_records(&parts.mesh.groups)?;
    let metadata = parts
        .metadata
        .to_bytes()
        .map_err(|e| BakeError::one("encode", Place::NOWHERE, e.to_string()))?;

    let fields = displacements(parts);
    let mut sections: Vec<(SectionKind, &[u8])> = Vec::with_capacity(SECTION_ORDER.len());
    for kind in SECTION_ORDER {
        let bytes: &[u8] = match kind {
            SectionKind::NODES => parts.wrapped.nodes.as_bytes(),
            SectionKind::ROWS => parts.wrapped.rows.as_bytes(),
            SectionKind::MODE_LISTS => parts.wrapped.mode_lists.as_bytes(),
            SectionKind::TRIANGLES => triangles.as_bytes(),
            SectionKind::TRIANGLE_SLOTS => slots.as_bytes(),
            SectionKind::POSITIONS => parts.shape.positions.as_bytes(),
            SectionKind::DISPLACEMENTS => fields.as_bytes(),
            SectionKind::VERTEX_MODES if has_lists(parts) => parts.wrapped.vertex_modes.as_bytes(),
            SectionKind::FRAMES | SectionKind::FRAME_Q => match (&parts.shape.frames, kind) {
                (None, _) => continue,
                (Some(frames), SectionKind::FRAMES) => frames.records.as_bytes(),
                (Some(frames), _) => frames.q.as_bytes(),
            },
            SectionKind::GROUPS if !groups.is_empty() => groups.as_bytes(),
            SectionKind::GROUP_NAMES if !groups.is_empty() => names.as_bytes(),
            SectionKind::METADATA => &metadata,
            _ => continue,
        };
        sections.push((kind, bytes));
    }

    let lengths: Vec<usize> = sections.iter().map(|(_, bytes)| bytes.len()).collect();
    let plan = Plan::new(parts.shape.mode_count(), &lengths);
    let mut file = vec![0u8; plan.file_bytes];
    for ((_, bytes), &offset) in sections.iter().zip(&plan.offsets) {
        file[offset..offset + bytes.len()].copy_from_slice(bytes);
    }
    write_header_block(parts, &plan, &sections, &mut file);
    Ok(file)
}

/// Header, mode table and section table; then the checksum over all three.
fn write_header_block(
    parts: &Parts,
    plan: &Plan,
    sections: &[(SectionKind, &[u8])],
    file: &mut [u8],
) {
    let mut header = Header {
        magic: MAGIC,
        version_major: VERSION_MAJOR.into(),
        version_minor: VERSION_MINOR.into(),
        header_bytes: (plan.header_bytes as u32).into(),
        file_bytes: (plan.file_bytes as u64).into(),
        header_crc: 0.into(),
        features_required: 0.into(),
        features_optional: 0.into(),
        unit_exponent: parts.shape.unit_exponent.into(),
        origin: parts.shape.origin.map(Into::into),
        vertex_count: (parts.shape.positions.len() as u32).into(),
        triangle_count: (parts.mesh.triangles.len() as u32).into(),
        mode_count: (parts.shape.mode_count() as u32).into(),
        node_count: (parts.wrapped.nodes.len() as u32).into(),
        depth: (parts.tree.depth as u32).into(),
        section_count: (sections.len() as u32).into(),
        position_norm_max: parts.wrapped.position_norm_max.into(),
        leaf_triangles_max: leaf_triangles_max(parts).into(),
        reserved: [0; 32],
    };
    let mut block = vec![0u8; plan.header_bytes];
    let mut end = size_of::<Header>();
    let mut append = |bytes: &[u8], block: &mut [u8]| {
        block[end..end + bytes.len()].copy_from_slice(bytes);
        end += bytes.len();
    };
    for (j, mode) in parts.basis.modes.iter().enumerate() {
        let limits = parts.shape.limits[j];
        let record = ModeRecord {
            q_limit: limits.q_limit.into(),
            q_range: limits.q_range.into(),
            step_scale: limits.step_scale.into(),
            field_norm_max: parts.wrapped.field_norms_max[j].into(),
            omega_rad_s: mode.omega_rad_s.unwrap_or(-1.0).into(),
            modal_mass_kg: mode.modal_mass_kg.unwrap_or(-1.0).into(),
        };
        append(record.as_bytes(), &mut block);
    }
    for ((kind, bytes), &offset) in sections.iter().zip(&plan.offsets) {
        let place = SECTION_ORDER.iter().position(|k| k == kind);
        let layout = match *kind {
            SectionKind::DISPLACEMENTS if has_lists(parts) => LAYOUT_2,
            SectionKind::DISPLACEMENTS => LAYOUT_1,
            _ => place
                .and_then(|p| SECTION_LAYOUTS[p].last().copied())
                .unwrap_or(0),
        };
        let is_required =
            place.is_some_and(|p| p < REQUIRED_SECTIONS) || *kind == SectionKind::VERTEX_MODES;
        let record = SectionRecord {
            kind: *kind,
            layout: layout.into(),
            offset: (offset as u64).into(),
            length: (bytes.len() as u64).into(),
            crc: crc32fast::hash(bytes).into(),
            required: u32::from(is_required).into(),
        };
        append(record.as_bytes(), &mut block);
    }
    block[..size_of::<Header>()].copy_from_slice(header.as_bytes());
    header.header_crc = crc32fast::hash(&block).into();
    block[..size_of::<Header>()].copy_from_slice(header.as_bytes());
    file[..block.len()].copy_from_slice(&block);
}

/// Whether displacements are those of the vertices' mode lists only (layout 2).
fn has_lists(parts: &Parts) -> bool {
    !parts.wrapped.vertex_modes.is_empty()
}

/// The displacements that are stored.
fn displacements<'a>(parts: &Parts<'a>) -> Cow<'a, [[f32; 3]]> {
    let (shape, wrapped) = (parts.shape, parts.wrapped);
    if !has_lists(parts) {
        return Cow::Borrowed(&shape.displacements);
    }
    let rows = shape.displacements.chunks_exact(shape.mode_count().max(1));
    let mut stored = Vec::new();
    for (row, records) in rows.zip(wrapped.vertex_modes.windows(2)) {
        let start = records[0].mode_list_start as usize;
        let count = (records[1].first_entry - records[0].first_entry) as usize;
        let modes = &wrapped.mode_lists[start..start + count];
        stored.extend(modes.iter().map(|&j| row[usize::from(j)]));
    }
    Cow::Owned(stored)
}

fn leaf_triangles_max(parts: &Parts) -> u32 {
    let counts = parts.wrapped.nodes.iter().flat_map(|node| node.leaf_counts);
    counts.max().map_or(0, u32::from)
}

fn triangle_records(parts: &Parts) -> Vec<TriangleRecord> {
    let record = |id: u32| TriangleRecord {
        corners: parts.mesh.triangles[id as usize],
        id,
    };
    parts.tree.leaf_order().map(record).collect()
}

/// The place of each triangle id in leaf order.
fn triangle_slots(triangles: &[TriangleRecord]) -> Vec<u32> {
    let mut slots = vec![0; triangles.len()];
    for (slot, triangle) in (0..).zip(triangles) {
        slots[triangle.id as usize] = slot;
    }
    slots
}

fn group_records(groups: &[RawGroup]) -> Result<(Vec<GroupRecord>, String), BakeError> {
    let mut names = String::new();
    let mut records = Vec::with_capacity(groups.len());
    for group in groups {
        let start = names.len();
        names.push_str(&group.name);
        if u32::try_from(names.len()).is_err() {
            let message = "group names are longer than 4 GiB together";
            return Err(BakeError::one(
                "encode",
                Part::Group(group.name.clone()),
                message,
            ));
        }
        records.push(GroupRecord {
            first_triangle: group.first_triangle,
            triangle_count: group.triangle_count,
            kind: match group.kind {
                GroupKind::Object => group_kind::OBJECT,
                GroupKind::Group => group_kind::GROUP,
                GroupKind::Material => group_kind::MATERIAL,
            },
            name_start: start as u32,
            name_bytes: group.name.len() as u32,
        });
    }
    Ok((records, names))
}
