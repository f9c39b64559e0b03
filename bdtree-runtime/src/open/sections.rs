//! The section table: order, places and lengths of sections, and their bytes as records.

use bdtree_format::{
    BoneEntry, BoneRecord, ChannelRecord, ClipRecord, FrameRecord, GroupRecord, Header,
    InfluenceRecord, LAYOUT_1, LAYOUT_2, MassRecord, ModeMomentum, NodeRecord, Row,
    SECTION_ALIGNMENT, SECTION_LAYOUTS, SECTION_ORDER, SECTIONS_ALWAYS, SECTIONS_OF_CLIPS,
    SECTIONS_OF_SKINS, SectionKind, SectionRecord, SkeletonNode, SkinRecord, TriangleRecord,
    VertexModes, is_required,
};
use core::mem::{offset_of, size_of};
use core::ops::Range;
use zerocopy::FromBytes;

use super::{header_at, section_table_start};
use crate::error::{Check, Datum, FormatError};

/// Byte ranges of the known sections; `None` where an optional one is absent.
pub(super) type Located = [Option<(usize, usize)>; SECTION_ORDER.len()];

/// Checks the section table and finds the known sections.
pub(super) fn locate_sections(
    bytes: &[u8],
    header: &Header,
    sections: &[SectionRecord],
) -> Result<Located, FormatError> {
    let mut located: Located = [None; SECTION_ORDER.len()];
    let mut next_rank = 0;
    let mut lists_modes = false;
    let mut end = u64::from(header.header_bytes.get());
    let table = section_table_start(header);
    for (i, section) in sections.iter().enumerate() {
        let at = table + i * size_of::<SectionRecord>();
        let record = header_at(at);
        let length_field = header_at(at + offset_of!(SectionRecord, length));
        let required_field = header_at(at + offset_of!(SectionRecord, required));
        let (offset, length) = (section.offset.get(), section.length.get());
        let expected = end.next_multiple_of(SECTION_ALIGNMENT as u64);
        header_at(at + offset_of!(SectionRecord, offset))
            .rule("SPEC 3.3: a section starts at the next multiple of 64 behind its predecessor")
            .holds(offset == expected, expected, offset)?;
        end = offset.saturating_add(length);
        let room = (bytes.len() as u64).saturating_sub(offset);
        length_field
            .rule("SPEC 4.1: a section lies inside the file")
            .holds(end <= bytes.len() as u64, Datum::at_most(room), length)?;
        let required = section.required.get();
        required_field
            .rule("SPEC 4.1: a section is required (1) or not (0)")
            .holds(required <= 1, Datum::AtMost(1.0), required)?;
        let again = sections[..i].iter().any(|s| s.kind == section.kind);
        record
            .rule("SPEC 4.4: no kind of section stands twice")
            .holds(!again, "another kind", section.kind)?;
        let Some(rank) = rank(section.kind) else {
            record
                .rule("SPEC 4.4: unknown required sections are refused")
                .holds(
                    required == 0,
                    "a section kind of this version",
                    section.kind,
                )?;
            continue;
        };
        let next = SECTION_ORDER[next_rank.min(SECTION_ORDER.len() - 1)];
        record
            .rule("SPEC 4.2: known sections stand in the order of the table")
            .holds(rank >= next_rank, next, section.kind)?;
        next_rank = rank + 1;
        let needed = u32::from(is_required(rank));
        required_field
            .rule("SPEC 4.2: sections that queries need are required, the others are not")
            .holds(required == needed, needed, required)?;
        let (layouts, layout) = (SECTION_LAYOUTS[rank], section.layout.get());
        let newest = layouts.last().copied().unwrap_or(LAYOUT_1);
        Check::at(
            section.kind,
            (at + offset_of!(SectionRecord, layout)) as u64,
        )
        .rule("SPEC 4.4: unknown layouts are refused")
        .holds(layouts.contains(&layout), newest, layout)?;
        lists_modes |= section.kind == SectionKind::DISPLACEMENTS && layout == LAYOUT_2;
        check_length(header, section, length_field)?;
        located[rank] = Some((offset as usize, end as usize));
    }
    let table = header_at(table);
    if let Some(rank) = located[..SECTIONS_ALWAYS].iter().position(Option::is_none) {
        let rule = "SPEC 4.2: NODE, ROWS, LIST, TRIS, SLOT, VERT and DISP are always there";
        return Err(table
            .rule(rule)
            .broken(SECTION_ORDER[rank], "no such section"));
    }
    let present = |kind| rank(kind).is_some_and(|rank| located[rank].is_some());
    let groups = present(SectionKind::GROUPS) == present(SectionKind::GROUP_NAMES);
    table
        .rule("SPEC 4.2: GRPS and GNAM are both there or both absent")
        .holds(groups, "both or none", "one of them")?;
    let modes = present(SectionKind::VERTEX_MODES) == lists_modes;
    table
        .rule("SPEC 4.2: VMOD is there exactly when DISP has layout 2")
        .holds(modes, "both or none", "one of them")?;
    let frames = present(SectionKind::FRAMES) == present(SectionKind::FRAME_Q);
    table
        .rule("SPEC 4.2: FRMS and FRMQ are both there or both absent")
        .holds(frames, "both or none", "one of them")?;
    let all_or_none = |kinds: Range<usize>| {
        let mut there = located[kinds].iter().map(Option::is_some);
        let first = there.next();
        there.all(|other| Some(other) == first)
    };
    table
        .rule("SPEC 4.2: SKIN, INFS, INFL, BONE, BFLD, BLSS, BLST, BROW, SKEL, JNTS and SNAM are all there or all absent")
        .holds(all_or_none(SECTIONS_OF_SKINS), "all or none", "some of them")?;
    table
        .rule("SPEC 4.2: CLIP, CHAN and KEYS are all there or all absent")
        .holds(
            all_or_none(SECTIONS_OF_CLIPS),
            "all or none",
            "some of them",
        )?;
    let (skin, clips) = (present(SectionKind::SKIN), present(SectionKind::CLIPS));
    table
        .rule("SPEC 4.2: clips are those of a skin")
        .holds(skin || !clips, "SKIN", "none")?;
    table
        .rule("SPEC 4.2: a file with a skin has no frames")
        .holds(!(skin && present(SectionKind::FRAMES)), "no FRMS", "FRMS")?;
    let (mass, momenta) = (
        present(SectionKind::MASS_PROPERTIES),
        present(SectionKind::MODE_MOMENTA),
    );
    table
        .rule("SPEC 4.2: momenta of modes are those of a mass")
        .holds(mass || !momenta, "MASS", "none")?;
    check_animation(header, sections)?;
    header_at(offset_of!(Header, file_bytes))
        .rule("SPEC 3.4: the file ends with its last section")
        .holds(end == bytes.len() as u64, end, bytes.len())?;
    Ok(located)
}

/// The place of a known kind in [`SECTION_ORDER`].
fn rank(kind: SectionKind) -> Option<usize> {
    SECTION_ORDER.iter().position(|k| *k == kind)
}

/// Lengths follow from the counts, or are whole multiples where the count is not in the header.
fn check_length(header: &Header, section: &SectionRecord, field: Check) -> Result<(), FormatError> {
    let (n, f) = (header.vertex_count.get(), header.triangle_count.get());
    let m = header.mode_count.get() as usize;
    let count_of_nodes = header.node_count.get();
    let (count, size) = match section.kind {
        SectionKind::SKIN => (Some(1), size_of::<SkinRecord>()),
        SectionKind::INFLUENCE_STARTS => (Some(n), 4),
        SectionKind::INFLUENCES => (None, size_of::<InfluenceRecord>()),
        SectionKind::BONES => (None, size_of::<BoneRecord>()),
        SectionKind::BONE_FIELDS | SectionKind::JOINTS | SectionKind::KEYS => (None, 4),
        SectionKind::BONE_LIST_STARTS => (Some(count_of_nodes), 4),
        SectionKind::BONE_LISTS => (None, size_of::<BoneEntry>()),
        SectionKind::BONE_ROWS => (None, size_of::<Row>()),
        SectionKind::SKELETON => (None, size_of::<SkeletonNode>()),
        SectionKind::CLIPS => (None, size_of::<ClipRecord>()),
        SectionKind::CHANNELS => (None, size_of::<ChannelRecord>()),
        SectionKind::NODES => (Some(count_of_nodes), size_of::<NodeRecord>()),
        SectionKind::ROWS => (None, size_of::<Row>()),
        SectionKind::MODE_LISTS => (None, 2),
        SectionKind::TRIANGLES => (Some(f), size_of::<TriangleRecord>()),
        SectionKind::TRIANGLE_SLOTS => (Some(f), 4),
        SectionKind::POSITIONS => (Some(n), 12),
        SectionKind::DISPLACEMENTS if section.layout.get() == LAYOUT_2 => (None, 12),
        SectionKind::DISPLACEMENTS => (Some(n), 12 * m),
        SectionKind::VERTEX_MODES => (Some(n), size_of::<VertexModes>()),
        SectionKind::MASS_PROPERTIES => (Some(1), size_of::<MassRecord>()),
        SectionKind::MODE_MOMENTA => (Some(header.mode_count.get()), size_of::<ModeMomentum>()),
        SectionKind::FRAMES => (None, size_of::<FrameRecord>()),
        SectionKind::GROUPS => (None, size_of::<GroupRecord>()),
        _ => (None, 1),
    };
    let (length, size) = (section.length.get(), size as u64);
    let Some(count) = count else {
        return Check::at(section.kind, section.offset.get())
            .rule("SPEC 4.3: a section's length is a multiple of its element size")
            .holds(length.is_multiple_of(size), size, length);
    };
    // One more record ends the last vertex's modes or influences, and the last node's bones.
    let ends = u64::from(matches!(
        section.kind,
        SectionKind::VERTEX_MODES | SectionKind::INFLUENCE_STARTS | SectionKind::BONE_LIST_STARTS
    ));
    let expected = (u64::from(count) + ends) * size;
    field
        .rule("SPEC 4.3: a section's length is its count times its element size")
        .holds(length == expected, expected, length)
}

/// At least one frame, and q for each frame and mode, where there are any.
fn check_animation(header: &Header, sections: &[SectionRecord]) -> Result<(), FormatError> {
    let find = |kind| {
        let i = sections.iter().position(|s| s.kind == kind)?;
        let at = section_table_start(header) + i * size_of::<SectionRecord>();
        let field = header_at(at + offset_of!(SectionRecord, length));
        Some((field, sections[i].length.get()))
    };
    let (Some((field, length)), Some((field_q, found))) =
        (find(SectionKind::FRAMES), find(SectionKind::FRAME_Q))
    else {
        return Ok(());
    };
    field
        .rule("SPEC 7.5: an animation has at least one frame")
        .holds(
            length != 0,
            Datum::at_least(size_of::<FrameRecord>()),
            0_u32,
        )?;
    let numbers = (length / size_of::<FrameRecord>() as u64) * 4;
    let expected = numbers.saturating_mul(u64::from(header.mode_count.get()));
    field_q
        .rule("SPEC 4.3: FRMQ holds one number per frame and mode")
        .holds(found == expected, expected, found)
}

/// Offset and bytes of a section; empty when it is absent.
pub(super) fn section_bytes<'a>(
    bytes: &'a [u8],
    located: &Located,
    kind: SectionKind,
) -> (usize, &'a [u8]) {
    match rank(kind).and_then(|rank| located[rank]) {
        Some((start, end)) => (start, bytes.get(start..end).unwrap_or_default()),
        None => (0, &[]),
    }
}

/// A section as a slice of records.
pub(super) fn view<'a, T>(
    kind: SectionKind,
    slice: impl Fn(SectionKind) -> (usize, &'a [u8]),
) -> Result<&'a [T], FormatError>
where
    T: FromBytes + zerocopy::Immutable + zerocopy::KnownLayout,
{
    let (offset, bytes) = slice(kind);
    if bytes.is_empty() {
        return Ok(&[]); // an absent section has no address, so no alignment either
    }
    <[T]>::ref_from_bytes(bytes).map_err(|_| {
        Check::at(kind, offset as u64)
            .rule("SPEC 4.3: a section holds whole, aligned elements")
            .broken(size_of::<T>(), bytes.len())
    })
}
