//! The file's bytes: sections behind the room of the header block, which is filled in at the end. The same input
//! gives the same bytes.

use std::borrow::Cow;

use bdtree_format::{
    GroupRecord, Header, LAYOUT_1, LAYOUT_2, MAGIC, Metadata, ModeMomentum, ModeRecord,
    SECTION_ALIGNMENT, SECTION_LAYOUTS, SECTION_ORDER, SectionKind, SectionRecord, SkinRecord,
    TriangleRecord, VERSION_MAJOR, VERSION_MINOR, group_kind, is_required,
};
use zerocopy::IntoBytes;

use crate::basis::Basis;
use crate::error::{BakeError, Part, Place};
use crate::input::{GroupKind, RawGroup, RawMesh};
use crate::mass::MassProperties;
use crate::skin::StoredSkin;
use crate::tree::Tree;
use crate::wrap::{StoredShape, WrappedBones, WrappedTree};

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
    /// What carries the vertices, and what nodes have of it.
    pub skin: Option<(&'a StoredSkin, &'a WrappedBones)>,
    /// The mass, with the momenta of all modes where they are known.
    pub mass: Option<(&'a MassProperties, &'a [ModeMomentum])>,
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
    let skin_record = parts.skin.map(|(skin, bones)| SkinRecord {
        node_bones_max: bones.node_bones_max,
        ..skin.record
    });
    let mass = parts.mass.map(|(mass, momenta)| (mass.record(), momenta));
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
            SectionKind::MASS_PROPERTIES | SectionKind::MODE_MOMENTA => match (&mass, kind) {
                (Some((record, _)), SectionKind::MASS_PROPERTIES) => record.as_bytes(),
                (Some((_, momenta)), _) if !momenta.is_empty() => momenta.as_bytes(),
                _ => continue,
            },
            SectionKind::GROUPS if !groups.is_empty() => groups.as_bytes(),
            SectionKind::GROUP_NAMES if !groups.is_empty() => names.as_bytes(),
            SectionKind::METADATA => &metadata,
            _ => match skin_section(parts, skin_record.as_ref(), kind) {
                Some(bytes) => bytes,
                None => continue,
            },
        };
        sections.push((kind, bytes));
    }

    let header_bytes = (size_of::<Header>()
        + parts.shape.mode_count() * size_of::<ModeRecord>()
        + sections.len() * size_of::<SectionRecord>())
    .next_multiple_of(SECTION_ALIGNMENT);
    let room = |(_, bytes): &(SectionKind, &[u8])| bytes.len().next_multiple_of(SECTION_ALIGNMENT);
    let mut file = Vec::with_capacity(header_bytes + sections.iter().map(room).sum::<usize>());
    file.resize(header_bytes, 0);
    let mut records = Vec::with_capacity(sections.len());
    for (kind, bytes) in sections {
        file.resize(file.len().next_multiple_of(SECTION_ALIGNMENT), 0);
        records.push(section_record(parts, kind, file.len(), bytes));
        file.extend_from_slice(bytes);
    }
    write_header_block(parts, header_bytes, &records, &mut file);
    Ok(file)
}

/// The bytes of a section of the skin; `None` where the file has none.
fn skin_section<'a>(
    parts: &Parts<'a>,
    record: Option<&'a SkinRecord>,
    kind: SectionKind,
) -> Option<&'a [u8]> {
    let (skin, bones) = parts.skin?;
    let has_clips = !skin.clips.is_empty();
    Some(match kind {
        SectionKind::SKIN => record?.as_bytes(),
        SectionKind::INFLUENCE_STARTS => skin.starts.as_bytes(),
        SectionKind::INFLUENCES => skin.influences.as_bytes(),
        SectionKind::BONES => skin.bones.as_bytes(),
        SectionKind::BONE_FIELDS => skin.bone_fields.as_bytes(),
        SectionKind::BONE_LIST_STARTS => bones.list_starts.as_bytes(),
        SectionKind::BONE_LISTS => bones.lists.as_bytes(),
        SectionKind::BONE_ROWS => bones.rows.as_bytes(),
        SectionKind::SKELETON => skin.skeleton.as_bytes(),
        SectionKind::JOINTS => skin.joints.as_bytes(),
        SectionKind::SKELETON_NAMES => skin.names.as_bytes(),
        SectionKind::CLIPS if has_clips => skin.clips.as_bytes(),
        SectionKind::CHANNELS if has_clips => skin.channels.as_bytes(),
        SectionKind::KEYS if has_clips => skin.keys.as_bytes(),
        _ => return None,
    })
}

/// The record of a section with these bytes.
fn section_record(parts: &Parts, kind: SectionKind, offset: usize, bytes: &[u8]) -> SectionRecord {
    let place = SECTION_ORDER.iter().position(|k| *k == kind);
    let layout = match kind {
        SectionKind::DISPLACEMENTS if has_lists(parts) => LAYOUT_2,
        SectionKind::DISPLACEMENTS => LAYOUT_1,
        _ => place
            .and_then(|p| SECTION_LAYOUTS[p].last().copied())
            .unwrap_or(0),
    };
    SectionRecord {
        kind,
        layout: layout.into(),
        offset: (offset as u64).into(),
        length: (bytes.len() as u64).into(),
        crc: crc32fast::hash(bytes).into(),
        required: u32::from(place.is_some_and(is_required)).into(),
    }
}

/// Header, mode table and section table; then the checksum over all three.
fn write_header_block(
    parts: &Parts,
    header_bytes: usize,
    sections: &[SectionRecord],
    file: &mut [u8],
) {
    let mut header = Header {
        magic: MAGIC,
        version_major: VERSION_MAJOR.into(),
        version_minor: VERSION_MINOR.into(),
        header_bytes: (header_bytes as u32).into(),
        file_bytes: (file.len() as u64).into(),
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
    let mut block = header.as_bytes().to_vec();
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
        block.extend_from_slice(record.as_bytes());
    }
    block.extend_from_slice(sections.as_bytes());
    block.resize(header_bytes, 0);
    header.header_crc = crc32fast::hash(&block).into();
    block[..size_of::<Header>()].copy_from_slice(header.as_bytes());
    file[..header_bytes].copy_from_slice(&block);
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
