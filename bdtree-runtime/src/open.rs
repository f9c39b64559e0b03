//! Bytes → [`Asset`]: header and tables only, so the cost does not depend on the file's size.

mod sections;
mod skin;

use bdtree_format::{
    BASE_ALIGNMENT, DEPTH_MAX, Header, LEAF_TRIANGLES_MAX, MAGIC, MODE_COUNT_MAX, ModeRecord,
    NodeRecord, ROW_RADIUS, Row, SECTION_ALIGNMENT, SectionKind, SectionRecord, UNIT_EXPONENT_MAX,
    VERSION_MAJOR, row_count,
};
use core::mem::{offset_of, size_of};
use zerocopy::{FromBytes, Immutable, KnownLayout};

use crate::error::{
    Check, Datum, FILE_LENGTH, FormatError, HEADER_CRC, HEADER_SECTION, MAGIC_BYTES, ONE_VERSION,
    WHOLE_HEADER, WHOLE_TABLES,
};
use crate::math::sqrt;
use crate::simd::Kernel;
use crate::view::Asset;
use sections::{locate_sections, section_bytes, view};

/// Most sections a table may list, so that opening is O(1).
const SECTION_COUNT_MAX: usize = 64;

/// Origins beyond this would leave the range in which the narrow phase's predicates are exact.
const ORIGIN_MAX: f64 = (1_u128 << 80) as f64;

/// The largest q_limit: its reciprocal is a normal number.
const LIMIT_MAX: f32 = f32::from_bits((127 + 126) << 23);

/// A place in the header block.
fn header_at(byte: usize) -> Check {
    Check::at(HEADER_SECTION, byte as u64)
}

impl<'a> Asset<'a> {
    /// The view of a file's bytes. Reads header, mode table and section table; call
    /// [`Asset::verify`] for the rest. The bytes must start at an address that is a multiple of
    /// 4 (64 advised): [`crate::include_bdt!`] sees to that, and [`Model`](crate::Model) to
    /// files and bytes of any address.
    ///
    /// # Errors
    /// The first rule of the format that header or tables break, with its place.
    pub fn open(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let header = fixed_header(bytes)?;
        let block = header_block(bytes, header)?;
        check_file(bytes, header)?;
        let modes = mode_table(block, header)?;
        let sections = section_table(block, header)?;
        check_ranges(header, modes)?;
        let found = locate_sections(bytes, header, sections)?;
        let slice = |kind: SectionKind| section_bytes(bytes, &found, kind);

        let nodes = view::<NodeRecord>(SectionKind::NODES, slice)?;
        let rows = view::<Row>(SectionKind::ROWS, slice)?;
        let row_stride = row_count(modes.len());
        let is_even = nodes.len().checked_mul(row_stride) == Some(rows.len());
        let mut asset = Self {
            bytes,
            header,
            modes,
            sections,
            nodes,
            rows,
            mode_lists: view(SectionKind::MODE_LISTS, slice)?,
            triangles: view(SectionKind::TRIANGLES, slice)?,
            triangle_slots: view(SectionKind::TRIANGLE_SLOTS, slice)?,
            positions: view(SectionKind::POSITIONS, slice)?,
            displacements: view(SectionKind::DISPLACEMENTS, slice)?,
            vertex_modes: view(SectionKind::VERTEX_MODES, slice)?,
            skin: skin::view_skin(header, slice)?,
            mass: view(SectionKind::MASS_PROPERTIES, slice)?.first(),
            momenta: view(SectionKind::MODE_MOMENTA, slice)?,
            frames: view(SectionKind::FRAMES, slice)?,
            frame_q: view(SectionKind::FRAME_Q, slice)?,
            groups: view(SectionKind::GROUPS, slice)?,
            group_names: slice(SectionKind::GROUP_NAMES).1,
            metadata: slice(SectionKind::METADATA).1,
            unit: power_of_two(header.unit_exponent.get()),
            kernel: Kernel::best(),
            row_stride: if is_even { row_stride } else { 0 },
            leaf_radius: 0.0,
        };
        asset.leaf_radius = leaf_radius(&asset);
        Ok(asset)
    }
}

/// About the radius of spheres above leaves of four triangles (stored units): the root's spheres,
/// each a piece of surface, cut into as many pieces as make leaves.
fn leaf_radius(asset: &Asset<'_>) -> f64 {
    let Some(root) = asset.nodes.first() else {
        return 0.0;
    };
    let Ok(rows) = asset.node_rows(root) else {
        return 0.0; // the first visit says so
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for (lane, radius) in rows.leading[ROW_RADIUS].iter().enumerate() {
        if (root.leaf_mask | root.inner_mask) & (1 << lane) != 0 {
            sum += f64::from(*radius);
            count += 1.0;
        }
    }
    // sum / count · √(4 count / F)
    2.0 * sum / sqrt(count * asset.triangle_count() as f64).max(1.0)
}

/// 2^e for |e| ≤ 1000.
fn power_of_two(e: i32) -> f64 {
    f64::from_bits(((1023 + i64::from(e)) as u64) << 52)
}

fn fixed_header(bytes: &[u8]) -> Result<&Header, FormatError> {
    // Before the length, since most files that are none of ours say so in their first bytes.
    if bytes.get(..MAGIC.len()).is_some_and(|first| first != MAGIC) {
        let rule = header_at(0).rule(MAGIC_BYTES);
        return Err(rule.broken(
            "89 42 44 54 0d 0a 1a 0a",
            "other bytes (not a .bdt file, or changed by a text-mode transfer)",
        ));
    }
    let Ok((header, _)) = Header::ref_from_prefix(bytes) else {
        let rule = header_at(bytes.len()).rule(WHOLE_HEADER);
        return Err(rule.broken(Datum::at_least(size_of::<Header>()), bytes.len()));
    };
    let aligned = (bytes.as_ptr() as usize).is_multiple_of(BASE_ALIGNMENT);
    header_at(0)
        .rule("SPEC 3.2: the first byte lies at an address that is a multiple of 4")
        .holds(
            aligned,
            "an aligned buffer (Model or include_bdt!)",
            "a misaligned one",
        )?;
    let major = header.version_major.get();
    header_at(offset_of!(Header, version_major))
        .rule(ONE_VERSION)
        .holds(major == VERSION_MAJOR, VERSION_MAJOR, major)?;
    Ok(header)
}

/// The checked header block: fixed header, mode table, section table, padding.
fn header_block<'a>(bytes: &'a [u8], header: &Header) -> Result<&'a [u8], FormatError> {
    let modes = header.mode_count.get() as usize;
    header_at(offset_of!(Header, mode_count))
        .rule("SPEC 2.1: at most 512 modes")
        .holds(
            modes <= MODE_COUNT_MAX,
            Datum::at_most(MODE_COUNT_MAX),
            modes,
        )?;
    let sections = header.section_count.get() as usize;
    header_at(offset_of!(Header, section_count))
        .rule("SPEC 2.1: at most 64 sections")
        .holds(
            sections <= SECTION_COUNT_MAX,
            Datum::at_most(SECTION_COUNT_MAX),
            sections,
        )?;
    let tables = section_table_start(header) + sections * size_of::<SectionRecord>();
    let needed = tables.next_multiple_of(SECTION_ALIGNMENT);
    let found = header.header_bytes.get() as usize;
    header_at(offset_of!(Header, header_bytes))
        .rule("SPEC 2.3: header_bytes is 128 + 32 modes + 32 sections, rounded up to 64")
        .holds(found == needed, needed, found)?;
    let Some(block) = bytes.get(..found) else {
        let place = header_at(bytes.len()).rule(WHOLE_TABLES);
        return Err(place.broken(Datum::at_least(found), bytes.len()));
    };
    let at = offset_of!(Header, header_crc);
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&block[..at]);
    hasher.update(&[0; 4]);
    hasher.update(&block[at + 4..]);
    let (crc, stored) = (hasher.finalize(), header.header_crc.get());
    header_at(at)
        .rule(HEADER_CRC)
        .holds(crc == stored, crc, stored)?;
    Ok(block)
}

/// Where the section table begins: behind the mode table.
fn section_table_start(header: &Header) -> usize {
    size_of::<Header>() + header.mode_count.get() as usize * size_of::<ModeRecord>()
}

/// What the checksum has to vouch for first (SPEC 2.4).
fn check_file(bytes: &[u8], header: &Header) -> Result<(), FormatError> {
    let file_bytes = header.file_bytes.get();
    header_at(offset_of!(Header, file_bytes))
        .rule(FILE_LENGTH)
        .holds(file_bytes == bytes.len() as u64, file_bytes, bytes.len())?;
    let features = header.features_required.get();
    header_at(offset_of!(Header, features_required))
        .rule("SPEC 9.3: unknown required features are refused")
        .holds(features == 0, 0_u32, features)
}

/// The `count` records of a table that starts at byte `start` of the header block, and the bytes behind it.
fn table<'a, T>(
    block: &'a [u8],
    start: usize,
    count: usize,
    rule: &'static str,
) -> Result<(&'a [T], &'a [u8]), FormatError>
where
    T: FromBytes + Immutable + KnownLayout,
{
    let rest = block.get(start..).unwrap_or_default();
    <[T]>::ref_from_prefix_with_elems(rest, count).map_err(|_| {
        let rule = header_at(start).rule(rule);
        rule.broken(Datum::at_least(count * size_of::<T>()), rest.len())
    })
}

fn mode_table<'a>(block: &'a [u8], header: &Header) -> Result<&'a [ModeRecord], FormatError> {
    let rule = "SPEC 2.2: the mode table lies inside the header block";
    let count = header.mode_count.get() as usize;
    Ok(table(block, size_of::<Header>(), count, rule)?.0)
}

fn section_table<'a>(block: &'a [u8], header: &Header) -> Result<&'a [SectionRecord], FormatError> {
    let rule = "SPEC 2.3: the section table lies inside the header block";
    let count = header.section_count.get() as usize;
    let (sections, rest) = table(block, section_table_start(header), count, rule)?;
    let rule = "SPEC 2.3: the header block ends with zeros";
    check_zeros(rest, block.len() - rest.len(), rule)?;
    Ok(sections)
}

/// Bytes of the header block that say nothing, from `start` on.
fn check_zeros(bytes: &[u8], start: usize, rule: &'static str) -> Result<(), FormatError> {
    match bytes.iter().position(|b| *b != 0) {
        Some(i) => Err(header_at(start + i).rule(rule).broken(0_u32, bytes[i])),
        None => Ok(()),
    }
}

/// The numbers of header and mode table that the runtime's rounding analysis relies on.
fn check_ranges(header: &Header, modes: &[ModeRecord]) -> Result<(), FormatError> {
    let rule = "SPEC 2.1: reserved bytes are zero";
    check_zeros(&header.reserved, offset_of!(Header, reserved), rule)?;
    for (i, x) in header.origin.iter().enumerate() {
        header_at(offset_of!(Header, origin) + 8 * i)
            .rule("SPEC 5.2: the origin is finite and at most 2^80")
            .holds(
                x.get().abs() <= ORIGIN_MAX,
                Datum::Within(-ORIGIN_MAX, ORIGIN_MAX),
                x.get(),
            )?;
    }
    let (e, max) = (header.unit_exponent.get(), UNIT_EXPONENT_MAX);
    header_at(offset_of!(Header, unit_exponent))
        .rule("SPEC 5.2: the unit exponent lies within ±100")
        .holds(
            (-max..=max).contains(&e),
            Datum::Within((-max).into(), max.into()),
            e,
        )?;
    let depth = header.depth.get() as usize;
    header_at(offset_of!(Header, depth))
        .rule("SPEC 2.1: a tree has 1 to 32 levels")
        .holds(
            (1..=DEPTH_MAX).contains(&depth),
            Datum::Within(1.0, DEPTH_MAX as f64),
            depth,
        )?;
    let (leaf, max) = (header.leaf_triangles_max.get() as usize, LEAF_TRIANGLES_MAX);
    header_at(offset_of!(Header, leaf_triangles_max))
        .rule("SPEC 2.1: leaf_triangles_max is 1 to 255")
        .holds(
            (1..=max).contains(&leaf),
            Datum::Within(1.0, max as f64),
            leaf,
        )?;
    for (offset, count) in [
        (offset_of!(Header, node_count), header.node_count),
        (offset_of!(Header, vertex_count), header.vertex_count),
        (offset_of!(Header, triangle_count), header.triangle_count),
    ] {
        header_at(offset)
            .rule("SPEC 2.1: there is at least one node, vertex and triangle")
            .holds(count.get() != 0, Datum::AtLeast(1.0), 0_u32)?;
    }
    let p = header.position_norm_max.get();
    let mut reach = f64::from(p);
    for (j, mode) in modes.iter().enumerate() {
        check_mode(mode, size_of::<Header>() + j * size_of::<ModeRecord>())?;
        reach += f64::from(mode.field_norm_max.get()) * f64::from(mode.q_limit.get());
    }
    const REACH_MIN: f64 = 1.0 / (1_u64 << 20) as f64;
    const REACH_MAX: f64 = (1_u64 << 60) as f64;
    let norm = header_at(offset_of!(Header, position_norm_max));
    norm.rule("SPEC 5.1: position_norm_max is a norm: finite, not negative, not subnormal")
        .holds(p == 0.0 || is_positive(p), "a number in range", p)?;
    norm.rule(
        "SPEC 5.4: position_norm_max + sum of field_norm_max x q_limit lies within 2^-20 to 2^60",
    )
    .holds(
        (REACH_MIN..=REACH_MAX).contains(&reach),
        Datum::Within(REACH_MIN, REACH_MAX),
        reach,
    )
}

/// Whether a number is positive, finite and not subnormal.
fn is_positive(x: f32) -> bool {
    x > 0.0 && x.is_normal()
}

/// The numbers of a mode, whose record lies at byte `at`.
fn check_mode(mode: &ModeRecord, at: usize) -> Result<(), FormatError> {
    let (limit, range) = (mode.q_limit.get(), mode.q_range.get());
    let (scale, norm) = (mode.step_scale.get(), mode.field_norm_max.get());
    let mantissa = limit.to_bits() & ((1 << (f32::MANTISSA_DIGITS - 1)) - 1);
    let is_limit = is_positive(limit) && mantissa == 0 && limit <= LIMIT_MAX;
    let is_range = is_positive(range) && range <= limit;
    let (is_scale, is_norm) = (is_positive(scale), norm == 0.0 || is_positive(norm));
    for (offset, ok, x) in [
        (offset_of!(ModeRecord, q_limit), is_limit, limit),
        (offset_of!(ModeRecord, q_range), is_range, range),
        (offset_of!(ModeRecord, step_scale), is_scale, scale),
        (offset_of!(ModeRecord, field_norm_max), is_norm, norm),
    ] {
        header_at(at + offset)
            .rule(
                "SPEC 2.2: q_limit is a power of two, 2^-126 to 2^126, q_range and step_scale \
                 are finite and positive, q_range at most q_limit, field_norm_max finite and not negative; none is \
                 subnormal (SPEC 5.1)",
            )
            .holds(ok, "a number in range", x)?;
    }
    let (omega, mass) = (mode.omega_rad_s.get(), mode.modal_mass_kg.get());
    for (offset, ok, x) in [
        (offset_of!(ModeRecord, omega_rad_s), omega >= 0.0, omega),
        (offset_of!(ModeRecord, modal_mass_kg), mass > 0.0, mass),
    ] {
        let known = x.is_finite() && (ok || x == -1.0);
        header_at(at + offset)
            .rule(
                "SPEC 2.2: a frequency is finite and not negative, a mass finite and positive, \
                 or -1: unknown",
            )
            .holds(known, "a number in range, or -1", x)?;
    }
    Ok(())
}
