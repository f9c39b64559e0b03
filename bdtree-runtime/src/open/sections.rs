//! The section table: order, places and lengths of sections, and their bytes as records.

use bdtree_format::{
    FrameRecord, GroupRecord, Header, LAYOUT_1, LAYOUT_2, ModeRecord, NodeRecord, Row,
    SECTION_ALIGNMENT, SECTION_LAYOUTS, SECTION_ORDER, SectionKind, SectionRecord, TriangleRecord,
    VertexModes,
};
use core::mem::{offset_of, size_of};
use zerocopy::FromBytes;

use super::header_error;
use crate::error::{Datum, FormatError};

/// The sections that every file has are the first ones of [`SECTION_ORDER`].
const SECTIONS_ALWAYS: usize = 7;

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
    let table = size_of::<Header>() + header.mode_count.get() as usize * size_of::<ModeRecord>();
    for (i, section) in sections.iter().enumerate() {
        let at = table + i * size_of::<SectionRecord>();
        let expected_offset = end.next_multiple_of(SECTION_ALIGNMENT as u64);
        let offset = section.offset.get();
        if offset != expected_offset {
            return Err(header_error(
                at + offset_of!(SectionRecord, offset),
                "SPEC 3.3: a section starts at the next multiple of 64 behind its predecessor",
                expected_offset,
                offset,
            ));
        }
        let length = section.length.get();
        end = offset.saturating_add(length);
        if end > bytes.len() as u64 {
            return Err(header_error(
                at + offset_of!(SectionRecord, length),
                "SPEC 4.1: a section lies inside the file",
                bytes.len() as u64 - offset.min(bytes.len() as u64),
                length,
            ));
        }
        let required = section.required.get();
        if required > 1 {
            return Err(header_error(
                at + offset_of!(SectionRecord, required),
                "SPEC 4.1: a section is required (1) or not (0)",
                1_u32,
                required,
            ));
        }
        if sections[..i].iter().any(|s| s.kind == section.kind) {
            return Err(header_error(
                at,
                "SPEC 4.4: no kind of section stands twice",
                "another kind",
                Datum::Kind(section.kind),
            ));
        }
        let Some(rank) = SECTION_ORDER.iter().position(|k| *k == section.kind) else {
            if required != 0 {
                return Err(header_error(
                    at,
                    "SPEC 4.4: unknown required sections are refused",
                    "a section kind of this version",
                    Datum::Kind(section.kind),
                ));
            }
            continue;
        };
        if rank < next_rank {
            return Err(header_error(
                at,
                "SPEC 4.2: known sections stand in the order of the table",
                Datum::Kind(SECTION_ORDER[next_rank.min(SECTION_ORDER.len() - 1)]),
                Datum::Kind(section.kind),
            ));
        }
        next_rank = rank + 1;
        let needed = u32::from(rank < SECTIONS_ALWAYS || section.kind == SectionKind::VERTEX_MODES);
        if required != needed {
            return Err(header_error(
                at + offset_of!(SectionRecord, required),
                "SPEC 4.2: sections that queries need are required, the others are not",
                needed,
                required,
            ));
        }
        let (layouts, layout) = (SECTION_LAYOUTS[rank], section.layout.get());
        if !layouts.contains(&layout) {
            return Err(FormatError {
                section: section.kind,
                ..header_error(
                    at + offset_of!(SectionRecord, layout),
                    "SPEC 4.4: unknown layouts are refused",
                    layouts.last().copied().unwrap_or(LAYOUT_1),
                    layout,
                )
            });
        }
        lists_modes |= section.kind == SectionKind::DISPLACEMENTS && layout == LAYOUT_2;
        check_length(header, section, at)?;
        located[rank] = Some((offset as usize, end as usize));
    }
    if let Some(rank) = located[..SECTIONS_ALWAYS].iter().position(Option::is_none) {
        return Err(header_error(
            table,
            "SPEC 4.2: NODE, ROWS, LIST, TRIS, SLOT, VERT and DISP are always there",
            Datum::Kind(SECTION_ORDER[rank]),
            "no such section",
        ));
    }
    let present = |kind| {
        let rank = SECTION_ORDER.iter().position(|k| *k == kind);
        rank.is_some_and(|rank| located[rank].is_some())
    };
    if present(SectionKind::GROUPS) != present(SectionKind::GROUP_NAMES) {
        return Err(header_error(
            table,
            "SPEC 4.2: GRPS and GNAM are both there or both absent",
            "both or none",
            "one of them",
        ));
    }
    if present(SectionKind::VERTEX_MODES) != lists_modes {
        return Err(header_error(
            table,
            "SPEC 4.2: VMOD is there exactly when DISP has layout 2",
            "both or none",
            "one of them",
        ));
    }
    check_animation(header, sections, table)?;
    if end != bytes.len() as u64 {
        return Err(header_error(
            offset_of!(Header, file_bytes),
            "SPEC 3.4: the file ends with its last section",
            end,
            bytes.len(),
        ));
    }
    Ok(located)
}

/// Lengths follow from the counts, or are whole multiples where the count is not in the header.
fn check_length(header: &Header, section: &SectionRecord, at: usize) -> Result<(), FormatError> {
    let count = |n: u32, size: usize| Some(u64::from(n) * size as u64);
    let (n, f, m) = (
        header.vertex_count.get(),
        header.triangle_count.get(),
        header.mode_count.get(),
    );
    let (exact, multiple) = match section.kind {
        SectionKind::NODES => (count(header.node_count.get(), size_of::<NodeRecord>()), 1),
        SectionKind::ROWS => (None, size_of::<Row>()),
        SectionKind::MODE_LISTS => (None, 2),
        SectionKind::TRIANGLES => (count(f, size_of::<TriangleRecord>()), 1),
        SectionKind::TRIANGLE_SLOTS => (count(f, 4), 1),
        SectionKind::POSITIONS => (count(n, 12), 1),
        SectionKind::DISPLACEMENTS if section.layout.get() == LAYOUT_2 => (None, 12),
        SectionKind::DISPLACEMENTS => (count(n, 12 * m as usize), 1),
        // One ends the last vertex's.
        SectionKind::VERTEX_MODES => {
            let record = size_of::<VertexModes>();
            (count(n, record).map(|bytes| bytes + record as u64), 1)
        }
        SectionKind::FRAMES => (None, size_of::<FrameRecord>()),
        SectionKind::GROUPS => (None, size_of::<GroupRecord>()),
        _ => (None, 1),
    };
    let length = section.length.get();
    let at = at + offset_of!(SectionRecord, length);
    match exact {
        Some(expected) if expected != length => Err(header_error(
            at,
            "SPEC 4.3: a section's length is its count times its element size",
            expected,
            length,
        )),
        None if !length.is_multiple_of(multiple as u64) => Err(FormatError {
            section: section.kind,
            byte: section.offset.get(),
            rule: "SPEC 4.3: a section's length is a multiple of its element size",
            expected: Datum::Integer(multiple as u64),
            found: Datum::Integer(length),
        }),
        _ => Ok(()),
    }
}

/// Both sections or none; at least one frame, and q for each frame and mode.
fn check_animation(
    header: &Header,
    sections: &[SectionRecord],
    table: usize,
) -> Result<(), FormatError> {
    let find = |kind| {
        let (i, section) = sections.iter().enumerate().find(|(_, s)| s.kind == kind)?;
        let at = table + i * size_of::<SectionRecord>() + offset_of!(SectionRecord, length);
        Some((at, section.length.get()))
    };
    let (frames, q) = match (find(SectionKind::FRAMES), find(SectionKind::FRAME_Q)) {
        (None, None) => return Ok(()),
        (Some(frames), Some(q)) => (frames, q),
        _ => {
            return Err(header_error(
                table,
                "SPEC 4.2: FRMS and FRMQ are both there or both absent",
                "both or none",
                "one of them",
            ));
        }
    };
    let (at, length) = frames;
    if length == 0 {
        return Err(header_error(
            at,
            "SPEC 7.5: an animation has at least one frame",
            size_of::<FrameRecord>(),
            0_u32,
        ));
    }
    let (at, found) = q;
    let numbers = (length / size_of::<FrameRecord>() as u64) * 4;
    let expected = numbers.saturating_mul(u64::from(header.mode_count.get()));
    if found != expected {
        return Err(header_error(
            at,
            "SPEC 4.3: FRMQ holds one number per frame and mode",
            expected,
            found,
        ));
    }
    Ok(())
}

/// Offset and bytes of a section; empty when it is absent.
pub(super) fn section_bytes<'a>(
    bytes: &'a [u8],
    located: &Located,
    kind: SectionKind,
) -> (usize, &'a [u8]) {
    SECTION_ORDER
        .iter()
        .position(|k| *k == kind)
        .and_then(|rank| located[rank])
        .map_or((0, &[]), |(start, end)| {
            (start, bytes.get(start..end).unwrap_or_default())
        })
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
    <[T]>::ref_from_bytes(bytes).map_err(|_| FormatError {
        section: kind,
        byte: offset as u64,
        rule: "SPEC 4.3: a section holds whole, aligned elements",
        expected: Datum::Integer(size_of::<T>() as u64),
        found: Datum::Integer(bytes.len() as u64),
    })
}
