//! Damaged files: changed records under repaired checksums, so that damage reaches the code
//! behind the checks.

use std::mem::{offset_of, size_of};
use std::ops::Range;

use bdtree_format::{
    GroupRecord, Header, ModeRecord, NodeRecord, SectionKind, SectionRecord, TriangleRecord,
    VertexModes,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// A little-endian u32; 0 beyond the end.
pub fn get_u32(bytes: &[u8], at: usize) -> u32 {
    let four = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
    u32::from_le_bytes(four.unwrap_or_default())
}

/// A little-endian f32; 0 beyond the end.
pub fn get_f32(bytes: &[u8], at: usize) -> f32 {
    f32::from_bits(get_u32(bytes, at))
}

/// Writes what fits.
pub fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    if let Some(place) = bytes.get_mut(at..at + value.len()) {
        place.copy_from_slice(value);
    }
}

/// Start of the section table.
pub fn table(bytes: &[u8]) -> usize {
    let modes = get_u32(bytes, offset_of!(Header, mode_count)) as usize;
    size_of::<Header>() + modes.min(512) * size_of::<ModeRecord>()
}

/// Start of a section's record in the table.
///
/// # Panics
/// When the file has no such section.
pub fn record(bytes: &[u8], kind: SectionKind) -> usize {
    let count = get_u32(bytes, offset_of!(Header, section_count)) as usize;
    (0..count)
        .map(|i| table(bytes) + i * size_of::<SectionRecord>())
        .find(|at| bytes[*at..*at + 4] == kind.0)
        .unwrap_or_else(|| panic!("no section {kind}"))
}

/// The bytes of a section.
///
/// # Panics
/// When the file has no such section.
pub fn section(bytes: &[u8], kind: SectionKind) -> Range<usize> {
    let (start, length) = place(bytes, record(bytes, kind));
    start..start + length
}

/// Offset and length in a section record.
fn place(bytes: &[u8], at: usize) -> (usize, usize) {
    let long = |at: usize| u64::from(get_u32(bytes, at)) | u64::from(get_u32(bytes, at + 4)) << 32;
    let start = long(at + offset_of!(SectionRecord, offset));
    let length = long(at + offset_of!(SectionRecord, length));
    (start as usize, length as usize)
}

fn crc(parts: &[&[u8]]) -> [u8; 4] {
    let mut crc = flate2::Crc::new();
    parts.iter().for_each(|p| crc.update(p));
    crc.sum().to_le_bytes()
}

/// Writes the checksums of all sections that lie inside the file, and of the header block.
pub fn repair(bytes: &mut [u8]) {
    let count = get_u32(bytes, offset_of!(Header, section_count)).min(64) as usize;
    for i in 0..count {
        let at = table(bytes) + i * size_of::<SectionRecord>();
        let (start, length) = place(bytes, at);
        if let Some(body) = bytes.get(start..start.saturating_add(length)) {
            let sum = crc(&[body]);
            put(bytes, at + offset_of!(SectionRecord, crc), &sum);
        }
    }
    let at = offset_of!(Header, header_crc);
    let end = get_u32(bytes, offset_of!(Header, header_bytes)) as usize;
    if let Some(block) = bytes.get(..end)
        && end > at + 4
    {
        let sum = crc(&[&block[..at], &[0; 4], &block[at + 4..]]);
        put(bytes, at, &sum);
    }
}

/// Changes one to three records and repairs the checksums.
pub fn mutate(bytes: &mut [u8], rng: &mut Pcg64Mcg) {
    for _ in 0..rng.random_range(1..=3) {
        change(bytes, rng);
    }
    repair(bytes);
}

fn pick<T: Copy>(choices: &[T], rng: &mut Pcg64Mcg) -> T {
    choices[rng.random_range(0..choices.len())]
}

/// An index that hurts: around `own`, around `count`, or extreme.
fn index(own: usize, count: usize, rng: &mut Pcg64Mcg) -> u32 {
    let (own, count) = (own as u32, count as u32);
    let near = rng.random_range(0..=count);
    let choices = [
        0,
        1,
        own,
        own.wrapping_sub(1),
        own + 1,
        count.wrapping_sub(1),
        count,
        near,
        i32::MAX as u32,
        u32::MAX - 1,
        u32::MAX,
    ];
    pick(&choices, rng)
}

/// An f32 that hurts.
fn real(rng: &mut Pcg64Mcg) -> f32 {
    let choices = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        f32::MIN_POSITIVE,
        f32::from_bits(1),
        1e-20,
        1e20,
    ];
    pick(&choices, rng)
}

/// Changes one thing. Most changes leave a file that opens.
fn change(bytes: &mut [u8], rng: &mut Pcg64Mcg) {
    let kinds = [
        SectionKind::NODES,
        SectionKind::NODES,
        SectionKind::NODES,
        SectionKind::ROWS,
        SectionKind::ROWS,
        SectionKind::MODE_LISTS,
        SectionKind::TRIANGLES,
        SectionKind::TRIANGLE_SLOTS,
        SectionKind::POSITIONS,
        SectionKind::DISPLACEMENTS,
        SectionKind::VERTEX_MODES,
        SectionKind::FRAMES,
        SectionKind::FRAME_Q,
        SectionKind::GROUPS,
        SectionKind::GROUP_NAMES,
        SectionKind::METADATA,
    ];
    let which = rng.random_range(0..kinds.len() + 4);
    let Some(kind) = kinds.get(which).copied() else {
        return change_elsewhere(bytes, which - kinds.len(), rng);
    };
    let count = get_u32(bytes, offset_of!(Header, section_count)).min(64) as usize;
    let Some(at) = (0..count)
        .map(|i| table(bytes) + i * size_of::<SectionRecord>())
        .find(|at| bytes.get(*at..*at + 4) == Some(&kind.0[..]))
    else {
        return;
    };
    let (start, length) = place(bytes, at);
    if length == 0 || start.saturating_add(length) > bytes.len() {
        return;
    }
    let element = |size: usize, rng: &mut Pcg64Mcg| {
        let count = (length / size).max(1);
        let i = rng.random_range(0..count);
        (i, count, start + i * size)
    };
    match kind {
        SectionKind::NODES => {
            let (i, count, at) = element(size_of::<NodeRecord>(), rng);
            change_node(bytes, at, i, count, rng);
        }
        SectionKind::ROWS if rng.random_range(0..2) == 0 => {
            // A number in 16 bits, or a row of them.
            let (_, _, at) = element(2, rng);
            let value = pick(&[0, 1, 0x7fff, 0x8000, 0xffff_u16], rng).to_le_bytes();
            for k in 0..pick(&[1, 8], rng) {
                if at + 2 * k < start + length {
                    put(bytes, at + 2 * k, &value);
                }
            }
        }
        SectionKind::FRAMES => {
            let (_, _, at) = element(8, rng);
            put(bytes, at, &f64::from(real(rng)).to_le_bytes());
        }
        SectionKind::ROWS
        | SectionKind::POSITIONS
        | SectionKind::DISPLACEMENTS
        | SectionKind::FRAME_Q => {
            let (_, _, at) = element(4, rng);
            let value = real(rng).to_le_bytes();
            // One value, or a run: a whole row, a whole triangle.
            for k in 0..pick(&[1, 3, 8, 64], rng) {
                if at + 4 * k < start + length {
                    put(bytes, at + 4 * k, &value);
                }
            }
        }
        SectionKind::MODE_LISTS => {
            let (i, count, at) = element(2, rng);
            let value = index(i, count, rng) as u16;
            put(bytes, at, &value.to_le_bytes());
        }
        SectionKind::TRIANGLES => {
            let (i, count, at) = element(size_of::<TriangleRecord>(), rng);
            let field = 4 * rng.random_range(0..4);
            put(bytes, at + field, &index(i, count, rng).to_le_bytes());
        }
        SectionKind::TRIANGLE_SLOTS | SectionKind::VERTEX_MODES | SectionKind::GROUPS => {
            let size = match kind {
                SectionKind::GROUPS => size_of::<GroupRecord>(),
                SectionKind::VERTEX_MODES => size_of::<VertexModes>(),
                _ => 4,
            };
            let (i, count, at) = element(size, rng);
            let field = 4 * rng.random_range(0..size / 4);
            put(bytes, at + field, &index(i, count, rng).to_le_bytes());
        }
        _ => {
            let (_, _, at) = element(1, rng);
            bytes[at] = pick(&[0, 1, 2, 0x7f, 0x80, 0xc0, 0xff], rng);
        }
    }
}

fn change_node(bytes: &mut [u8], at: usize, i: usize, count: usize, rng: &mut Pcg64Mcg) {
    let value = index(i, count, rng);
    match rng.random_range(0..10) {
        field @ 0..4 => put(bytes, at + 4 * field, &value.to_le_bytes()),
        4 => put(
            bytes,
            at + offset_of!(NodeRecord, mode_count),
            &(value as u16).to_le_bytes(),
        ),
        5 => bytes[at + offset_of!(NodeRecord, inner_mask)] = pick(&[0, 1, 0x80, 0xff], rng),
        6 => bytes[at + offset_of!(NodeRecord, leaf_mask)] = pick(&[0, 1, 0x80, 0xff], rng),
        7 => {
            let lane = rng.random_range(0..8);
            bytes[at + offset_of!(NodeRecord, leaf_counts) + lane] = pick(&[0, 1, 8, 255], rng);
        }
        8 => {
            let which = rng.random_range(0..3);
            let exponent = pick(&[0, 1, 0x7f, 0x80, 0x82, 0xff], rng);
            bytes[at + offset_of!(NodeRecord, scale_exponents) + which] = exponent;
        }
        _ => bytes[at + offset_of!(NodeRecord, level)] = value as u8,
    }
}

/// Header, mode table, section table, or a change of all nodes at once.
fn change_elsewhere(bytes: &mut [u8], which: usize, rng: &mut Pcg64Mcg) {
    let count = get_u32(bytes, offset_of!(Header, node_count)) as usize;
    match which {
        0 => {
            let field = 4 * rng.random_range(2..24);
            put(bytes, field, &index(field, count, rng).to_le_bytes());
        }
        1 => {
            let start = size_of::<Header>();
            let field = start + 4 * rng.random_range(0..(table(bytes) - start).max(32) / 4);
            put(bytes, field, &real(rng).to_le_bytes());
        }
        2 => {
            let sections = get_u32(bytes, offset_of!(Header, section_count)).clamp(1, 64) as usize;
            let field = table(bytes) + 4 * rng.random_range(0..8 * sections);
            put(bytes, field, &index(field, count, rng).to_le_bytes());
        }
        _ => change_all_nodes(bytes, count, rng),
    }
}

/// Chains, shared children, self reference, a depth that does not fit.
fn change_all_nodes(bytes: &mut [u8], count: usize, rng: &mut Pcg64Mcg) {
    let depth = pick(&[1_u32, 2, 3, 31, 32], rng).to_le_bytes();
    put(bytes, offset_of!(Header, depth), &depth);
    let count_max = bytes.len() / size_of::<NodeRecord>();
    let start = place(bytes, table(bytes)).0; // NODE is the first section
    let ahead = pick(&[0_usize, 1, 1, 2, 8], rng);
    let mask = pick(&[1_u8, 3, 0xff], rng);
    for i in 0..count.min(count_max) {
        let at = start.saturating_add(i * size_of::<NodeRecord>());
        if at + size_of::<NodeRecord>() > bytes.len() {
            return;
        }
        let child = (i + ahead).min(count.saturating_sub(1)) as u32;
        put(bytes, at, &child.to_le_bytes());
        bytes[at + offset_of!(NodeRecord, inner_mask)] = mask;
        bytes[at + offset_of!(NodeRecord, leaf_mask)] = !mask;
    }
}
