//! SPEC.md and the structs say the same: every offset, type, kind and constant, and the bytes of
//! the worked example.

use bdtree_format as fmt;
use bdtree_format::{
    BoneRecord, ChannelRecord, ClipRecord, FrameRecord, GroupRecord, Header, InfluenceRecord,
    MassRecord, ModeMomentum, ModePair, ModeRecord, NodeRecord, SectionKind, SectionRecord,
    SkeletonNode, SkinRecord, TriangleRecord, VertexModes,
};
use core::mem::offset_of;
use zerocopy::little_endian::{F32, F64, I32, U16, U32, U64};
use zerocopy::{FromBytes, FromZeros};

const SPEC: &str = include_str!("../SPEC.md");

/// How SPEC.md writes a type.
trait SpecType {
    fn text() -> String;
}

macro_rules! spec_type {
    ($($rust:ty => $text:literal),* $(,)?) => {
        $(impl SpecType for $rust { fn text() -> String { $text.into() } })*
    };
}
spec_type!(u8 => "u8", i8 => "i8", i16 => "i16", u16 => "u16", u32 => "u32", f32 => "f32", U16 => "u16", U32 => "u32", U64 => "u64",
    I32 => "i32", F32 => "f32", F64 => "f64", SectionKind => "[u8; 4]");

impl<T: SpecType, const K: usize> SpecType for [T; K] {
    fn text() -> String {
        format!("[{}; {K}]", T::text())
    }
}

fn type_of<T: SpecType>(_: &T) -> String {
    T::text()
}

/// One field: offset, type, name, size.
type Field = (usize, String, &'static str, usize);

/// All fields of a record. The pattern without `..` does not compile when a field is missing here.
macro_rules! fields {
    ($record:ident: $($field:ident),* $(,)?) => {{
        let record = $record::new_zeroed();
        let $record { $($field),* } = record;
        let all: Vec<Field> = vec![$((
            offset_of!($record, $field),
            type_of(&$field),
            stringify!($field),
            size_of_val(&$field),
        )),*];
        all
    }};
}

/// The rows of the first table behind the line that starts with `intro`, cells trimmed.
fn table_behind(intro: &str) -> Vec<Vec<&'static str>> {
    let mut lines = SPEC.lines().skip_while(|line| !line.starts_with(intro));
    assert!(lines.next().is_some(), "SPEC.md has no line `{intro}…`");
    let rows: Vec<Vec<&str>> = lines
        .skip_while(|line| !line.starts_with('|'))
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            line.trim_matches('|')
                .split('|')
                .map(|cell| cell.trim().trim_matches('`'))
                .collect()
        })
        .collect();
    assert!(rows.len() > 2, "no table behind `{intro}`");
    rows.into_iter().skip(2).collect()
}

fn check_record(name: &str, bytes: usize, fields: &[Field]) {
    let rows = table_behind(&format!("Record `{name}`, {bytes} bytes"));
    let spec: Vec<_> = rows
        .iter()
        .map(|row| (row[0].parse().expect("an offset"), row[1], row[2]))
        .collect();
    let code: Vec<_> = fields
        .iter()
        .map(|(offset, ty, field, _)| (*offset, ty.as_str(), *field))
        .collect();
    assert_eq!(spec, code, "{name}: SPEC.md (left) and the struct differ");

    let mut end = 0;
    for (offset, _, field, size) in fields {
        assert_eq!(
            *offset, end,
            "{name}.{field} does not follow its predecessor"
        );
        end += size;
    }
    assert_eq!(end, bytes, "{name} has bytes that no field names");
}

#[test]
fn header_table_matches_struct() {
    let all = fields!(Header: magic, version_major, version_minor, header_bytes, file_bytes,
        header_crc, features_required, features_optional, unit_exponent, origin, vertex_count,
        triangle_count, mode_count, node_count, depth, section_count, position_norm_max,
        leaf_triangles_max, reserved);
    check_record("Header", size_of::<Header>(), &all);
}

#[test]
fn mode_table_matches_struct() {
    let all = fields!(ModeRecord: q_limit, q_range, step_scale, field_norm_max, omega_rad_s,
        modal_mass_kg);
    check_record("ModeRecord", size_of::<ModeRecord>(), &all);
}

#[test]
fn section_table_matches_struct() {
    let all = fields!(SectionRecord: kind, layout, offset, length, crc, required);
    check_record("SectionRecord", size_of::<SectionRecord>(), &all);
}

#[test]
fn node_table_matches_struct() {
    let all = fields!(NodeRecord: first_child, first_slot, row_start, mode_list_start, mode_count,
        inner_mask, leaf_mask, leaf_counts, level, scale_exponents);
    check_record("NodeRecord", size_of::<NodeRecord>(), &all);
}

#[test]
fn mode_pair_table_matches_struct() {
    let all = fields!(ModePair: center, growth, cross);
    check_record("ModePair", size_of::<ModePair>(), &all);
}

#[test]
fn triangle_table_matches_struct() {
    let all = fields!(TriangleRecord: corners, id);
    check_record("TriangleRecord", size_of::<TriangleRecord>(), &all);
}

#[test]
fn vertex_table_matches_struct() {
    let all = fields!(VertexModes: first_entry, mode_list_start);
    check_record("VertexModes", size_of::<VertexModes>(), &all);
}

#[test]
fn skin_tables_match_structs() {
    let all =
        fields!(SkinRecord: influences_max, node_bones_max, weight_defect, minor_share, reserved);
    check_record("SkinRecord", size_of::<SkinRecord>(), &all);
    let all = fields!(InfluenceRecord: weight, bone, reserved);
    check_record("InfluenceRecord", size_of::<InfluenceRecord>(), &all);
    let all =
        fields!(BoneRecord: joint, reserved, inverse_bind, rest, low, high, core_low, core_high);
    check_record("BoneRecord", size_of::<BoneRecord>(), &all);
    let all = fields!(SkeletonNode: parent, name_start, name_bytes, kind, local);
    check_record("SkeletonNode", size_of::<SkeletonNode>(), &all);
    let all = fields!(ClipRecord: duration_s, name_start, name_bytes, first_channel, channel_count);
    check_record("ClipRecord", size_of::<ClipRecord>(), &all);
    let all = fields!(ChannelRecord: target, target_count, path, interpolation, key_count,
        first_number, reserved);
    check_record("ChannelRecord", size_of::<ChannelRecord>(), &all);
    assert!(SPEC.contains("0 translation, 1 rotation, 2 scale, 3 modes"));
    assert!(SPEC.contains("0 linear, 1 step, 2 cubic"));
    assert!(SPEC.contains("0 parts, 1 matrix"));
}

#[test]
fn bone_rows_match_constants() {
    let rows = table_behind("### 6.10");
    let named: Vec<(&str, &str)> = rows.iter().take(2).map(|row| (row[0], row[1])).collect();
    let code = [
        (fmt::BONE_ROW_SPREAD.to_string(), "BONE_ROW_SPREAD"),
        (fmt::BONE_ROW_DEFECT.to_string(), "BONE_ROW_DEFECT"),
    ];
    assert_eq!(
        named,
        code.each_ref().map(|(row, name)| (row.as_str(), *name))
    );
    assert_eq!(fmt::bone_row_count(5), 2 + 2 * 5);
}

#[test]
fn group_table_matches_struct() {
    let all = fields!(GroupRecord: first_triangle, triangle_count, kind, name_start, name_bytes);
    check_record("GroupRecord", size_of::<GroupRecord>(), &all);
    assert!(SPEC.contains("0 object, 1 group, 2 material"));
    assert_eq!(
        [
            fmt::group_kind::OBJECT,
            fmt::group_kind::GROUP,
            fmt::group_kind::MATERIAL
        ],
        [0, 1, 2]
    );
}

#[test]
fn frame_table_matches_struct() {
    let all = fields!(FrameRecord: time_s, rotation, translation);
    check_record("FrameRecord", size_of::<FrameRecord>(), &all);
}

#[test]
fn mass_tables_match_structs() {
    let all = fields!(MassRecord: mass_kg, center_of_mass, inertia, density_kg_m3, scale_m, volume,
        source, reserved);
    check_record("MassRecord", size_of::<MassRecord>(), &all);
    let all = fields!(ModeMomentum: linear, angular);
    check_record("ModeMomentum", size_of::<ModeMomentum>(), &all);
    assert!(SPEC.contains("1 closed surface, 2 lattice, 3 elements"));
    let sources = [
        fmt::mass_source::SURFACE,
        fmt::mass_source::LATTICE,
        fmt::mass_source::ELEMENTS,
    ];
    assert_eq!(sources, [1, 2, 3]);
    assert!(SPEC.contains("10⁻⁹") && fmt::MASS_TOLERANCE == 1e-9);
}

#[test]
fn kinds_match_section_order() {
    use SectionKind as K;
    let rows = table_behind("### 4.2");
    let order: Vec<String> = rows.iter().map(|row| row[0].to_string()).collect();
    let code: Vec<String> = fmt::SECTION_ORDER.iter().map(K::to_string).collect();
    assert_eq!(order, code);

    let named = [
        ("NODES", K::NODES, "1", size_of::<NodeRecord>()),
        ("ROWS", K::ROWS, "1", size_of::<fmt::Row>()),
        ("MODE_LISTS", K::MODE_LISTS, "1", size_of::<u16>()),
        ("TRIANGLES", K::TRIANGLES, "1", size_of::<TriangleRecord>()),
        ("TRIANGLE_SLOTS", K::TRIANGLE_SLOTS, "1", size_of::<u32>()),
        ("POSITIONS", K::POSITIONS, "1", size_of::<[f32; 3]>()),
        (
            "DISPLACEMENTS",
            K::DISPLACEMENTS,
            "1",
            size_of::<[f32; 3]>(),
        ),
        (
            "VERTEX_MODES",
            K::VERTEX_MODES,
            "1",
            size_of::<VertexModes>(),
        ),
        ("SKIN", K::SKIN, "1", size_of::<SkinRecord>()),
        (
            "INFLUENCE_STARTS",
            K::INFLUENCE_STARTS,
            "1",
            size_of::<u32>(),
        ),
        (
            "INFLUENCES",
            K::INFLUENCES,
            "1",
            size_of::<InfluenceRecord>(),
        ),
        ("BONES", K::BONES, "1", size_of::<BoneRecord>()),
        ("BONE_FIELDS", K::BONE_FIELDS, "1", size_of::<f32>()),
        (
            "BONE_LIST_STARTS",
            K::BONE_LIST_STARTS,
            "1",
            size_of::<u32>(),
        ),
        (
            "BONE_LISTS",
            K::BONE_LISTS,
            "1",
            size_of::<fmt::BoneEntry>(),
        ),
        ("BONE_ROWS", K::BONE_ROWS, "1", size_of::<fmt::Row>()),
        ("SKELETON", K::SKELETON, "1", size_of::<SkeletonNode>()),
        ("JOINTS", K::JOINTS, "1", size_of::<u32>()),
        ("SKELETON_NAMES", K::SKELETON_NAMES, "1", 1),
        ("CLIPS", K::CLIPS, "0", size_of::<ClipRecord>()),
        ("CHANNELS", K::CHANNELS, "0", size_of::<ChannelRecord>()),
        ("KEYS", K::KEYS, "0", size_of::<f32>()),
        (
            "MASS_PROPERTIES",
            K::MASS_PROPERTIES,
            "0",
            size_of::<MassRecord>(),
        ),
        (
            "MODE_MOMENTA",
            K::MODE_MOMENTA,
            "0",
            size_of::<ModeMomentum>(),
        ),
        ("FRAMES", K::FRAMES, "0", size_of::<FrameRecord>()),
        ("FRAME_Q", K::FRAME_Q, "0", size_of::<f32>()),
        ("GROUPS", K::GROUPS, "0", size_of::<GroupRecord>()),
        ("GROUP_NAMES", K::GROUP_NAMES, "0", 1),
        ("METADATA", K::METADATA, "0", 1),
    ];
    assert_eq!(rows.len(), named.len());
    let layouts =
        fmt::SECTION_LAYOUTS.map(|ids| ids.iter().map(u32::to_string).collect::<Vec<_>>());
    for ((row, (name, kind, required, bytes)), layout) in rows.iter().zip(named).zip(layouts) {
        let expected = [
            kind.to_string(),
            name.into(),
            required.into(),
            bytes.to_string(),
            layout.join(", "),
        ];
        assert_eq!(row[..5], expected.each_ref().map(String::as_str));
    }
}

#[test]
fn rows_match_constants() {
    let leading: Vec<(String, &str)> = table_behind("### 6.5")
        .iter()
        .take(fmt::ROWS_LEADING)
        .map(|row| (row[0].to_string(), row[1]))
        .collect();
    let code = [
        (fmt::ROW_CENTER_X.to_string(), "ROW_CENTER_X"),
        (fmt::ROW_CENTER_Y.to_string(), "ROW_CENTER_Y"),
        (fmt::ROW_CENTER_Z.to_string(), "ROW_CENTER_Z"),
        (fmt::ROW_RADIUS.to_string(), "ROW_RADIUS"),
    ];
    assert_eq!(leading, code);
    for m in [0, 1, 3, fmt::MODE_COUNT_MAX] {
        assert_eq!(fmt::pair_row(m), 4 + 6 * m);
        assert_eq!(fmt::row_count(m), 6 + 6 * m.div_ceil(2));
    }
}

#[test]
fn constants_match() {
    let magic: Vec<String> = fmt::MAGIC.iter().map(|b| format!("{b:02X}")).collect();
    let code = [
        ("MAGIC", magic.join(" ")),
        ("VERSION_MAJOR", fmt::VERSION_MAJOR.to_string()),
        ("VERSION_MINOR", fmt::VERSION_MINOR.to_string()),
        ("SECTION_ALIGNMENT", fmt::SECTION_ALIGNMENT.to_string()),
        ("BASE_ALIGNMENT", fmt::BASE_ALIGNMENT.to_string()),
        ("MODE_COUNT_MAX", fmt::MODE_COUNT_MAX.to_string()),
        ("DEPTH_MAX", fmt::DEPTH_MAX.to_string()),
        ("LEAF_TRIANGLES_MAX", fmt::LEAF_TRIANGLES_MAX.to_string()),
        ("LAYOUT_1", fmt::LAYOUT_1.to_string()),
        ("LAYOUT_2", fmt::LAYOUT_2.to_string()),
        ("LAYOUT_3", fmt::LAYOUT_3.to_string()),
        ("LANES", fmt::LANES.to_string()),
        ("ROWS_LEADING", fmt::ROWS_LEADING.to_string()),
        ("ROWS_PER_PAIR", fmt::ROWS_PER_PAIR.to_string()),
        ("ROWS_FIXED", fmt::ROWS_FIXED.to_string()),
        ("BONE_COUNT_MAX", fmt::BONE_COUNT_MAX.to_string()),
        ("SKELETON_NODES_MAX", fmt::SKELETON_NODES_MAX.to_string()),
        ("INFLUENCES_MAX", fmt::INFLUENCES_MAX.to_string()),
        ("BONE_ROWS_FIXED", fmt::BONE_ROWS_FIXED.to_string()),
        ("BONE_ROWS_PER_ENTRY", fmt::BONE_ROWS_PER_ENTRY.to_string()),
    ];
    let spec: Vec<(&str, String)> = table_behind("### 9.4")
        .iter()
        .map(|row| (row[0], row[1].to_string()))
        .collect();
    assert_eq!(spec, code);
}

/// The worked example as a file.
const EXAMPLE: &[u8] = include_bytes!("example.bdt");

/// The bytes of the hex dump in section 10: `offset  hex bytes`, `*` repeats the line above.
fn example() -> Vec<u8> {
    let mut bytes: Vec<u8> = Vec::new();
    let mut repeat = false;
    let dump = SPEC
        .lines()
        .skip_while(|line| !line.starts_with("## 10 "))
        .skip_while(|line| !line.starts_with("    00000000 "))
        .take_while(|line| line.starts_with("    "));
    for line in dump {
        let mut words = line.split_whitespace();
        let first = words.next().expect("a line of the dump");
        if first == "*" {
            repeat = true;
            continue;
        }
        let offset = usize::from_str_radix(first, 16).expect("a hexadecimal offset");
        if repeat {
            let row: [u8; 16] = *bytes.last_chunk().expect("a line before `*`");
            while bytes.len() < offset {
                bytes.extend(row);
            }
            repeat = false;
        }
        assert_eq!(bytes.len(), offset, "the dump skips bytes");
        bytes.extend(words.map(|w| u8::from_str_radix(w, 16).expect("a byte")));
    }
    bytes
}

/// CRC-32/ISO-HDLC, bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc: u32, b| {
        (0..8).fold(crc ^ u32::from(*b), |c, _| {
            (c >> 1) ^ (0xEDB8_8320 & (c & 1).wrapping_neg())
        })
    })
}

#[test]
fn worked_example_is_consistent() {
    assert_eq!(crc(b"123456789"), 0xCBF4_3926);
    let bytes = example();
    assert_eq!(
        bytes, EXAMPLE,
        "SPEC.md section 10 and tests/example.bdt differ"
    );
    let (header, rest) = Header::read_from_prefix(&bytes).expect("a header");
    assert_eq!(header.magic, fmt::MAGIC);
    assert_eq!(header.file_bytes.get(), bytes.len() as u64);

    let header_bytes = header.header_bytes.get() as usize;
    let mut block = bytes[..header_bytes].to_vec();
    block[offset_of!(Header, header_crc)..][..4].fill(0);
    assert_eq!(header.header_crc.get(), crc(&block));

    let (modes, rest) =
        <[ModeRecord]>::ref_from_prefix_with_elems(rest, header.mode_count.get() as usize)
            .expect("the mode table");
    assert_eq!(modes.len(), 1);
    let (sections, _) =
        <[SectionRecord]>::ref_from_prefix_with_elems(rest, header.section_count.get() as usize)
            .expect("the section table");
    let kinds: Vec<SectionKind> = sections.iter().map(|s| s.kind).collect();
    assert_eq!(kinds, fmt::SECTION_ORDER[..7]);

    let mut end = header_bytes;
    for section in sections {
        let offset = section.offset.get() as usize;
        assert_eq!(offset, end.next_multiple_of(fmt::SECTION_ALIGNMENT));
        assert!(bytes[end..offset].iter().all(|b| *b == 0));
        end = offset + section.length.get() as usize;
        assert_eq!(
            section.crc.get(),
            crc(&bytes[offset..end]),
            "{}",
            section.kind
        );
    }
    assert_eq!(end, bytes.len());
}
