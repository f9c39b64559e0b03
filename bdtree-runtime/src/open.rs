//! Bytes → [`Asset`]: header and tables only, so the cost does not depend on the file's size.

mod sections;

use bdtree_format::{
    BASE_ALIGNMENT, DEPTH_MAX, FrameRecord, GroupRecord, Header, LEAF_TRIANGLES_MAX, MAGIC,
    MODE_COUNT_MAX, ModeRecord, NodeRecord, Row, SECTION_ALIGNMENT, SectionKind, SectionRecord,
    TriangleRecord, VERSION_MAJOR, VertexModes, row_count,
};
use core::mem::{offset_of, size_of};
use zerocopy::FromBytes;

use crate::error::{Datum, FormatError, HEADER_SECTION};
use crate::simd::Kernel;
use crate::view::Asset;
use sections::{locate_sections, section_bytes, view};

/// The rule that a file too short for a header breaks.
pub(crate) const WHOLE_HEADER: &str = "SPEC 2.1: a file starts with a whole header";

/// Most sections a table may list, so that opening is O(1).
const SECTION_COUNT_MAX: u32 = 64;

/// Origins and unit exponents beyond these would leave the range in which the narrow phase's
/// predicates are exact.
const ORIGIN_MAX: f64 = (1_u128 << 80) as f64;
const UNIT_EXPONENT_MAX: i32 = 100;

/// The largest q_limit: its reciprocal is a normal number.
const LIMIT_MAX: f32 = f32::from_bits((127 + 126) << 23);

fn header_error(
    byte: usize,
    rule: &'static str,
    expected: impl Into<Datum>,
    found: impl Into<Datum>,
) -> FormatError {
    FormatError {
        section: HEADER_SECTION,
        byte: byte as u64,
        rule,
        expected: expected.into(),
        found: found.into(),
    }
}

impl From<&'static str> for Datum {
    fn from(text: &'static str) -> Self {
        Self::Text(text)
    }
}

impl From<u32> for Datum {
    fn from(x: u32) -> Self {
        Self::Integer(u64::from(x))
    }
}

impl From<u64> for Datum {
    fn from(x: u64) -> Self {
        Self::Integer(x)
    }
}

impl From<usize> for Datum {
    fn from(x: usize) -> Self {
        Self::Integer(x as u64)
    }
}

impl From<f32> for Datum {
    fn from(x: f32) -> Self {
        Self::Real(f64::from(x))
    }
}

impl From<f64> for Datum {
    fn from(x: f64) -> Self {
        Self::Real(x)
    }
}

impl<'a> Asset<'a> {
    /// The view of a file's bytes. Reads header, mode table and section table; call
    /// [`Asset::verify`] for the rest. The bytes must start at an address that is a multiple of
    /// 4 (64 advised): [`crate::include_bdt!`] sees to that, and [`Model`](crate::Model) to
    /// files and bytes of any address.
    ///
    /// # Errors
    /// The first rule of the format that header or tables break, with its place. Hosts whose
    /// numbers are big-endian are refused.
    pub fn open(bytes: &'a [u8]) -> Result<Self, FormatError> {
        if cfg!(target_endian = "big") {
            return Err(header_error(
                0,
                "SPEC 3.1: files are read on little-endian hosts only",
                "a little-endian host",
                "a big-endian host",
            ));
        }
        let header = fixed_header(bytes)?;
        let block = header_block(bytes, header)?;
        check_file(bytes, header)?;
        let modes = mode_table(block, header)?;
        let sections = section_table(block, header)?;
        check_ranges(header, modes)?;
        let found = locate_sections(bytes, header, sections)?;
        let slice = |kind: SectionKind| section_bytes(bytes, &found, kind);

        let positions = view::<[f32; 3]>(SectionKind::POSITIONS, slice)?;
        let nodes = view::<NodeRecord>(SectionKind::NODES, slice)?;
        let rows = view::<Row>(SectionKind::ROWS, slice)?;
        let row_stride = row_count(modes.len());
        let is_even = nodes.len().checked_mul(row_stride) == Some(rows.len());
        Ok(Self {
            bytes,
            header,
            modes,
            sections,
            nodes,
            rows,
            mode_lists: view::<u16>(SectionKind::MODE_LISTS, slice)?,
            triangles: view::<TriangleRecord>(SectionKind::TRIANGLES, slice)?,
            triangle_slots: view::<u32>(SectionKind::TRIANGLE_SLOTS, slice)?,
            positions,
            displacements: view::<[f32; 3]>(SectionKind::DISPLACEMENTS, slice)?,
            vertex_modes: view::<VertexModes>(SectionKind::VERTEX_MODES, slice)?,
            frames: view::<FrameRecord>(SectionKind::FRAMES, slice)?,
            frame_q: view::<f32>(SectionKind::FRAME_Q, slice)?,
            groups: view::<GroupRecord>(SectionKind::GROUPS, slice)?,
            group_names: slice(SectionKind::GROUP_NAMES).1,
            metadata: slice(SectionKind::METADATA).1,
            unit: power_of_two(header.unit_exponent.get()),
            kernel: Kernel::best(),
            row_stride: if is_even { row_stride } else { 0 },
        })
    }
}

/// 2^e for |e| ≤ 1000.
fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((1023 + i64::from(e)) as u64) << 52)
}

fn fixed_header(bytes: &[u8]) -> Result<&Header, FormatError> {
    // Before the length, since most files that are none of ours say so in their first bytes.
    if bytes.get(..MAGIC.len()).is_some_and(|first| first != MAGIC) {
        return Err(header_error(
            0,
            "SPEC 9.1: the file starts with the magic bytes",
            "89 42 44 54 0d 0a 1a 0a",
            "other bytes (not a .bdt file, or changed by a text-mode transfer)",
        ));
    }
    let Ok((header, _)) = Header::ref_from_prefix(bytes) else {
        return Err(header_error(
            bytes.len(),
            WHOLE_HEADER,
            size_of::<Header>(),
            bytes.len(),
        ));
    };
    if !(bytes.as_ptr() as usize).is_multiple_of(BASE_ALIGNMENT) {
        return Err(header_error(
            0,
            "SPEC 3.2: the first byte lies at an address that is a multiple of 4",
            "an aligned buffer (Model or include_bdt!)",
            "a misaligned one",
        ));
    }
    let major = header.version_major.get();
    if major != VERSION_MAJOR {
        return Err(header_error(
            offset_of!(Header, version_major),
            "SPEC 9.1: readers know one major version",
            u32::from(VERSION_MAJOR),
            u32::from(major),
        ));
    }
    Ok(header)
}

/// The checked header block: fixed header, mode table, section table, padding.
fn header_block<'a>(bytes: &'a [u8], header: &Header) -> Result<&'a [u8], FormatError> {
    let modes = header.mode_count.get();
    if modes as usize > MODE_COUNT_MAX {
        return Err(header_error(
            offset_of!(Header, mode_count),
            "SPEC 2.1: at most 512 modes",
            MODE_COUNT_MAX,
            modes,
        ));
    }
    let sections = header.section_count.get();
    if sections > SECTION_COUNT_MAX {
        return Err(header_error(
            offset_of!(Header, section_count),
            "SPEC 2.1: at most 64 sections",
            SECTION_COUNT_MAX,
            sections,
        ));
    }
    let tables = size_of::<Header>()
        + modes as usize * size_of::<ModeRecord>()
        + sections as usize * size_of::<SectionRecord>();
    let needed = tables.next_multiple_of(SECTION_ALIGNMENT);
    let found = header.header_bytes.get() as usize;
    if found != needed {
        return Err(header_error(
            offset_of!(Header, header_bytes),
            "SPEC 2.3: header_bytes is 128 + 32 modes + 32 sections, rounded up to 64",
            needed,
            found,
        ));
    }
    let Some(block) = bytes.get(..found) else {
        return Err(header_error(
            bytes.len(),
            "SPEC 3.4: the header block lies inside the file",
            found,
            bytes.len(),
        ));
    };
    let at = offset_of!(Header, header_crc);
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&block[..at]);
    hasher.update(&[0; 4]);
    hasher.update(&block[at + 4..]);
    let crc = hasher.finalize();
    if crc != header.header_crc.get() {
        return Err(header_error(
            at,
            "SPEC 2.4: header_crc is the CRC-32 of the header block",
            crc,
            header.header_crc.get(),
        ));
    }
    Ok(block)
}

/// What the checksum has to vouch for first (SPEC 2.4).
fn check_file(bytes: &[u8], header: &Header) -> Result<(), FormatError> {
    if header.file_bytes.get() != bytes.len() as u64 {
        return Err(header_error(
            offset_of!(Header, file_bytes),
            "SPEC 3.4: file_bytes is the file's length (a shorter file is truncated)",
            header.file_bytes.get(),
            bytes.len(),
        ));
    }
    let features = header.features_required.get();
    if features != 0 {
        return Err(header_error(
            offset_of!(Header, features_required),
            "SPEC 9.3: unknown required features are refused",
            0_u32,
            features,
        ));
    }
    Ok(())
}

fn mode_table<'a>(block: &'a [u8], header: &Header) -> Result<&'a [ModeRecord], FormatError> {
    let count = header.mode_count.get() as usize;
    let table = block.get(size_of::<Header>()..).unwrap_or_default();
    match <[ModeRecord]>::ref_from_prefix_with_elems(table, count) {
        Ok((modes, _)) => Ok(modes),
        Err(_) => Err(header_error(
            size_of::<Header>(),
            "SPEC 2.2: the mode table lies inside the header block",
            count * size_of::<ModeRecord>(),
            table.len(),
        )),
    }
}

fn section_table<'a>(block: &'a [u8], header: &Header) -> Result<&'a [SectionRecord], FormatError> {
    let start = size_of::<Header>() + header.mode_count.get() as usize * size_of::<ModeRecord>();
    let count = header.section_count.get() as usize;
    let table = block.get(start..).unwrap_or_default();
    match <[SectionRecord]>::ref_from_prefix_with_elems(table, count) {
        Ok((sections, rest)) => {
            if let Some(i) = rest.iter().position(|b| *b != 0) {
                return Err(header_error(
                    block.len() - rest.len() + i,
                    "SPEC 2.3: the header block ends with zeros",
                    0_u32,
                    u32::from(rest[i]),
                ));
            }
            Ok(sections)
        }
        Err(_) => Err(header_error(
            start,
            "SPEC 2.3: the section table lies inside the header block",
            count * size_of::<SectionRecord>(),
            table.len(),
        )),
    }
}

/// The numbers of header and mode table that the runtime's rounding analysis relies on.
fn check_ranges(header: &Header, modes: &[ModeRecord]) -> Result<(), FormatError> {
    if let Some(i) = header.reserved.iter().position(|b| *b != 0) {
        return Err(header_error(
            offset_of!(Header, reserved) + i,
            "SPEC 2.1: reserved bytes are zero",
            0_u32,
            u32::from(header.reserved[i]),
        ));
    }
    for (i, x) in header.origin.iter().enumerate() {
        if !(x.get().abs() <= ORIGIN_MAX) {
            return Err(header_error(
                offset_of!(Header, origin) + 8 * i,
                "SPEC 5.2: the origin is finite and at most 2^80",
                ORIGIN_MAX,
                x.get(),
            ));
        }
    }
    let e = header.unit_exponent.get();
    if e.unsigned_abs() > UNIT_EXPONENT_MAX.unsigned_abs() {
        return Err(FormatError {
            section: HEADER_SECTION,
            byte: offset_of!(Header, unit_exponent) as u64,
            rule: "SPEC 5.2: the unit exponent lies within ±100",
            expected: Datum::Signed(i64::from(UNIT_EXPONENT_MAX)),
            found: Datum::Signed(i64::from(e)),
        });
    }
    let depth = header.depth.get();
    if depth == 0 || depth as usize > DEPTH_MAX {
        return Err(header_error(
            offset_of!(Header, depth),
            "SPEC 2.1: a tree has 1 to 32 levels",
            DEPTH_MAX,
            depth,
        ));
    }
    let leaf = header.leaf_triangles_max.get();
    if leaf == 0 || leaf as usize > LEAF_TRIANGLES_MAX {
        return Err(header_error(
            offset_of!(Header, leaf_triangles_max),
            "SPEC 2.1: leaf_triangles_max is 1 to 255",
            LEAF_TRIANGLES_MAX,
            leaf,
        ));
    }
    for (offset, count) in [
        (offset_of!(Header, node_count), header.node_count),
        (offset_of!(Header, vertex_count), header.vertex_count),
        (offset_of!(Header, triangle_count), header.triangle_count),
    ] {
        if count.get() == 0 {
            return Err(header_error(
                offset,
                "SPEC 2.1: there is at least one node, vertex and triangle",
                1_u32,
                0_u32,
            ));
        }
    }
    let p = f64::from(header.position_norm_max.get());
    let mut reach = p;
    for (j, mode) in modes.iter().enumerate() {
        let at = size_of::<Header>() + j * size_of::<ModeRecord>();
        let limit = mode.q_limit.get();
        let w = mode.field_norm_max.get();
        let range = mode.q_range.get();
        let positive = |x: f32| x > 0.0 && x.is_normal();
        // A normal reciprocal, too.
        let is_limit = |x: f32| {
            let mantissa = x.to_bits() & ((1 << (f32::MANTISSA_DIGITS - 1)) - 1);
            positive(x) && mantissa == 0 && x <= LIMIT_MAX
        };
        for (offset, ok, x) in [
            (offset_of!(ModeRecord, q_limit), is_limit(limit), limit),
            (
                offset_of!(ModeRecord, q_range),
                positive(range) && range <= limit,
                range,
            ),
            (
                offset_of!(ModeRecord, step_scale),
                positive(mode.step_scale.get()),
                mode.step_scale.get(),
            ),
            (
                offset_of!(ModeRecord, field_norm_max),
                w == 0.0 || positive(w),
                w,
            ),
        ] {
            if !ok {
                return Err(header_error(
                    at + offset,
                    "SPEC 2.2: q_limit is a power of two, 2^-126 to 2^126, q_range and step_scale \
                     are finite and positive, q_range at most q_limit, field_norm_max finite and not negative; none is \
                     subnormal (SPEC 5.1)",
                    "a number in range",
                    x,
                ));
            }
        }
        let (omega, mass) = (mode.omega_rad_s.get(), mode.modal_mass_kg.get());
        for (offset, ok, x) in [
            (offset_of!(ModeRecord, omega_rad_s), omega >= 0.0, omega),
            (offset_of!(ModeRecord, modal_mass_kg), mass > 0.0, mass),
        ] {
            if !(x.is_finite() && (ok || x == -1.0)) {
                return Err(header_error(
                    at + offset,
                    "SPEC 2.2: a frequency is finite and not negative, a mass finite and positive, \
                     or -1: unknown",
                    -1.0_f64,
                    x,
                ));
            }
        }
        reach += f64::from(w) * f64::from(limit);
    }
    const REACH_MIN: f64 = 1.0 / (1_u64 << 20) as f64;
    const REACH_MAX: f64 = (1_u64 << 60) as f64;
    if !(p == 0.0 || p > 0.0 && header.position_norm_max.get().is_normal()) {
        return Err(header_error(
            offset_of!(Header, position_norm_max),
            "SPEC 5.1: position_norm_max is a norm: finite, not negative, not subnormal",
            "a number in range",
            p,
        ));
    }
    if !(REACH_MIN..=REACH_MAX).contains(&reach) {
        return Err(header_error(
            offset_of!(Header, position_norm_max),
            "SPEC 5.4: position_norm_max + sum of field_norm_max x q_limit lies within \
             2^-20 to 2^60",
            "a reach in range",
            reach,
        ));
    }
    Ok(())
}
