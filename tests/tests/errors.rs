//! Every rule that the runtime cites has an input that triggers it; the text names section, byte, rule, what was expected and what is there.

use std::collections::BTreeSet;
use std::mem::{offset_of, size_of};
use std::ops::ControlFlow;
use std::sync::LazyLock;

use bdtree_build::input::{GroupKind, RawGroup};
use bdtree_format::{
    FrameRecord, GroupRecord, Header, ModePair, ModeRecord, NodeRecord, ROW_RADIUS, Row,
    SectionKind, SectionRecord, TriangleRecord, VertexModes, pair_count, pair_row,
};
use bdtree_runtime::{
    AlignedBytes, Asset, Contact, FormatError, Pose, QueryError, StackEntry, Transform, TriangleId,
    VertexId, add_generalized_force, query,
};
use bdtree_tests::bake;
use bdtree_tests::mutate::{get_f32, get_u32, put, record, repair, section, table};

/// Several nodes, six local modes (so the header block ends with padding), frames, groups,
/// metadata.
static FILE: LazyLock<AlignedBytes> = LazyLock::new(|| {
    let mut mesh = bake::bumpy_sphere(14, 1);
    for name in ["a", "b"] {
        mesh.groups.push(RawGroup {
            kind: GroupKind::Group,
            name: name.to_string(),
            first_triangle: 3,
            triangle_count: 4,
        });
    }
    let mut basis = bake::smooth_basis(&mesh, 6, 1);
    let count = mesh.positions.len();
    for (k, u) in basis.fields.iter_mut().enumerate() {
        if mesh.positions[k % count][(k / count) % 3] < 0.5 {
            *u = [0.0; 3];
        }
    }
    bake::baked(&mesh, &bake::with_frames(basis, 3, 1.0, 1))
});

/// Rules that no input reaches: they guard what earlier rules already ensure.
const UNREACHABLE: [&str; 4] = [
    "SPEC 3.1: files are read on little-endian hosts only",
    "SPEC 2.2: the mode table lies inside the header block",
    "SPEC 2.3: the section table lies inside the header block",
    "SPEC 4.3: a section holds whole, aligned elements",
];

/// All rules that the sources cite.
fn rules() -> BTreeSet<String> {
    let sources = [
        include_str!("../../bdtree-runtime/src/open.rs"),
        include_str!("../../bdtree-runtime/src/open/sections.rs"),
        include_str!("../../bdtree-runtime/src/verify.rs"),
        include_str!("../../bdtree-runtime/src/verify/bounds.rs"),
        include_str!("../../bdtree-runtime/src/verify/frames.rs"),
        include_str!("../../bdtree-runtime/src/verify/metadata.rs"),
        include_str!("../../bdtree-runtime/src/verify/mode_lists.rs"),
        include_str!("../../bdtree-runtime/src/verify/vertex_modes.rs"),
        include_str!("../../bdtree-runtime/src/traverse/mod.rs"),
        include_str!("../../bdtree-runtime/src/view/mod.rs"),
        include_str!("../../bdtree-runtime/src/view/displacements.rs"),
    ];
    let mut rules = BTreeSet::new();
    for source in sources {
        for piece in source.split("\"SPEC ").skip(1) {
            let text = piece.split('"').next().expect("a closed string");
            let text: String = text.split("\\\n").map(|l| l.trim_start()).collect();
            rules.insert(format!("SPEC {text}"));
        }
    }
    rules
}

/// The rules of the errors seen so far; each error's text is checked when it is noted.
#[derive(Default)]
struct Seen(BTreeSet<String>);

impl Seen {
    fn note(&mut self, error: &FormatError) {
        let text = error.to_string();
        let expected = format!(
            "section {} at byte {}: {}: expected {}, found {}",
            error.section, error.byte, error.rule, error.expected, error.found
        );
        assert_eq!(text, expected);
        self.0.insert(error.rule.to_string());
    }

    /// Opens, verifies and asks; notes everything.
    fn everything(&mut self, bytes: &[u8]) {
        let bytes = AlignedBytes::copy_of(bytes);
        let asset = match Asset::open(&bytes) {
            Ok(asset) => asset,
            Err(error) => return self.note(&error),
        };
        asset.verify(&mut |error| {
            self.note(&error);
            ControlFlow::Continue(())
        });
        let mut memory = vec![0.0; asset.pose_len()];
        let q = vec![0.01; asset.mode_count()];
        let pose = Pose::new(&asset, &q, Transform::IDENTITY, &mut memory).expect("pose");
        let mut stack = vec![StackEntry::default(); asset.stack_len()];
        let mut found: Vec<Contact> = Vec::new();
        let ball = query::ball(&asset, &pose, [0.0; 3], 100.0, &mut stack, &mut found);
        if let Err(QueryError::Corrupt(error)) = ball {
            assert!(
                QueryError::from(error)
                    .to_string()
                    .ends_with(&error.to_string())
            );
            self.note(&error);
        }
    }
}

fn node(bytes: &[u8], i: usize) -> usize {
    section(bytes, SectionKind::NODES).start + i * size_of::<NodeRecord>()
}

fn node_count(bytes: &[u8]) -> usize {
    get_u32(bytes, offset_of!(Header, node_count)) as usize
}

fn u32_at(bytes: &mut [u8], at: usize, value: u32) {
    put(bytes, at, &value.to_le_bytes());
}

/// Changes a number of a frame.
fn frame(bytes: &mut [u8], k: usize, offset: usize, value: f64) {
    let at = section(bytes, SectionKind::FRAMES).start + k * size_of::<FrameRecord>() + offset;
    put(bytes, at, &value.to_le_bytes());
}

/// A place of the root's rows: lane of the lowest bit set.
fn root_row(bytes: &[u8], row: usize) -> usize {
    let at = node(bytes, 0);
    let masks = bytes[at + offset_of!(NodeRecord, inner_mask)]
        | bytes[at + offset_of!(NodeRecord, leaf_mask)];
    section(bytes, SectionKind::ROWS).start
        + row * size_of::<Row>()
        + 4 * masks.trailing_zeros() as usize
}

fn field(kind: SectionKind, offset: usize, value: u32) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = record(b, kind) + offset;
        u32_at(b, at, value);
    }
}

fn header(offset: usize, value: u32) -> impl Fn(&mut Vec<u8>) {
    move |b| u32_at(b, offset, value)
}

fn of_node(i: usize, offset: usize, value: u8) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = node(b, i) + offset;
        b[at] = value;
    }
}

fn of_node_u32(i: usize, offset: usize, value: u32) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = node(b, i) + offset;
        u32_at(b, at, value);
    }
}

fn body(kind: SectionKind, offset: usize, value: u32) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = section(b, kind).start + offset;
        u32_at(b, at, value);
    }
}

/// Changes a vertex's record in VMOD.
fn vertex_record(vertex: usize, offset: usize, value: u32) -> impl Fn(&mut Vec<u8>) {
    body(
        SectionKind::VERTEX_MODES,
        vertex * size_of::<VertexModes>() + offset,
        value,
    )
}

/// Multiplies a bound of the root's first used lane.
fn root_bound(row: usize, factor: f32) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = root_row(b, row);
        let value = get_f32(b, at) * factor;
        put(b, at, &value.to_le_bytes());
    }
}

/// The same for a row of the root's k-th mode.
fn root_mode(bytes: &[u8], k: usize, offset: usize) -> usize {
    let first = root_row(bytes, 0);
    let lane = (first - section(bytes, SectionKind::ROWS).start) / size_of::<f32>();
    first - lane * size_of::<f32>()
        + pair_row(k / 2) * size_of::<Row>()
        + offset
        + lane * size_of::<[i16; 2]>()
        + k % 2 * size_of::<i16>()
}

/// Changes a ΔR of the root's first used lane.
fn root_growth(k: usize, change: impl Fn(i16) -> i16) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = root_mode(b, k, offset_of!(ModePair, growth));
        let value = change(i16::from_le_bytes([b[at], b[at + 1]]));
        put(b, at, &value.to_le_bytes());
    }
}

/// Every node's lanes 0 and 1 (or all lanes) lead to the nodes behind it; the last two are leaves.
fn shared_children(depth: u32, mask: u8) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        u32_at(b, offset_of!(Header, depth), depth);
        let count = node_count(b);
        for i in 0..count - 2 {
            let at = node(b, i);
            u32_at(b, at, i as u32 + 1);
            b[at + offset_of!(NodeRecord, inner_mask)] = mask;
            b[at + offset_of!(NodeRecord, leaf_mask)] = 0;
        }
        for i in count - 2..count {
            let at = node(b, i);
            b[at + offset_of!(NodeRecord, inner_mask)] = 0;
        }
        // All spheres are entered: NaN means visit.
        for at in section(b, SectionKind::ROWS).step_by(4) {
            put(b, at, &f32::NAN.to_le_bytes());
        }
    }
}

type Change = Box<dyn Fn(&mut Vec<u8>)>;

/// Changes of a sound file, checksums repaired afterwards.
fn changes() -> Vec<Change> {
    let bits = |x: f32| x.to_bits();
    let mode = size_of::<Header>();
    let kind = offset_of!(SectionRecord, kind);
    let name = |n: &[u8; 4]| u32::from_le_bytes(*n);
    let step_row = |b: &[u8]| {
        let at = node(b, 0) + offset_of!(NodeRecord, mode_count);
        pair_row(pair_count(u16::from_le_bytes([b[at], b[at + 1]]).into()))
    };
    vec![
        Box::new(|b| b.clear()),
        Box::new(|b| *b = b"a text file, long enough for a header. ".repeat(10)),
        Box::new(header(offset_of!(Header, version_major), 1)),
        Box::new(|b| b.push(0)),
        Box::new(header(offset_of!(Header, features_required), 4)),
        Box::new(header(offset_of!(Header, mode_count), 513)),
        Box::new(header(offset_of!(Header, section_count), 65)),
        Box::new(header(offset_of!(Header, header_bytes), 64)),
        Box::new(|b| b.truncate(130)),
        Box::new(|b| {
            let count = get_u32(b, offset_of!(Header, section_count)) as usize;
            let at = table(b) + count * size_of::<SectionRecord>();
            assert!(at < get_u32(b, offset_of!(Header, header_bytes)) as usize);
            b[at] = 1;
        }),
        Box::new(header(offset_of!(Header, reserved), 1)),
        Box::new(|b| put(b, offset_of!(Header, origin), &f64::NAN.to_le_bytes())),
        Box::new(header(offset_of!(Header, unit_exponent), i32::MIN as u32)),
        Box::new(header(offset_of!(Header, depth), 33)),
        Box::new(header(offset_of!(Header, leaf_triangles_max), 0)),
        Box::new(header(offset_of!(Header, vertex_count), 0)),
        Box::new(header(mode + offset_of!(ModeRecord, q_range), 0)),
        Box::new(|b| {
            let at = size_of::<Header>() + offset_of!(ModeRecord, modal_mass_kg);
            put(b, at, &0.0_f64.to_le_bytes());
        }),
        Box::new(header(offset_of!(Header, position_norm_max), 1)),
        Box::new(header(offset_of!(Header, position_norm_max), bits(1e30))),
        Box::new(field(
            SectionKind::ROWS,
            offset_of!(SectionRecord, offset),
            64,
        )),
        Box::new(field(
            SectionKind::METADATA,
            offset_of!(SectionRecord, length),
            1 << 30,
        )),
        Box::new(field(
            SectionKind::NODES,
            offset_of!(SectionRecord, required),
            2,
        )),
        Box::new(field(SectionKind::GROUP_NAMES, kind, name(b"GRPS"))),
        Box::new(field(SectionKind::NODES, kind, name(b"NODX"))),
        Box::new(|b| {
            let (nodes, rows) = (record(b, SectionKind::NODES), record(b, SectionKind::ROWS));
            // Each with its layout.
            put(b, nodes, b"ROWS\x03");
            put(b, rows, b"NODE\x02");
        }),
        Box::new(field(
            SectionKind::METADATA,
            offset_of!(SectionRecord, required),
            1,
        )),
        Box::new(field(
            SectionKind::TRIANGLES,
            offset_of!(SectionRecord, layout),
            2,
        )),
        Box::new(header(offset_of!(Header, triangle_count), 1)),
        Box::new(|b| {
            let at = record(b, SectionKind::ROWS) + offset_of!(SectionRecord, length);
            let length = get_u32(b, at) - 4;
            u32_at(b, at, length);
        }),
        Box::new(|b| {
            let at = record(b, SectionKind::DISPLACEMENTS);
            put(b, at, b"DISX");
            u32_at(b, at + offset_of!(SectionRecord, required), 0);
        }),
        Box::new(field(SectionKind::GROUP_NAMES, kind, name(b"GNAX"))),
        Box::new(field(SectionKind::FRAMES, kind, name(b"FRMX"))),
        Box::new(|b| {
            // No frames: FRMS shrinks to nothing, and the rest of its place becomes a section that
            // nobody knows.
            let at = record(b, SectionKind::FRAMES);
            let start = section(b, SectionKind::FRAMES).start;
            let q = record(b, SectionKind::FRAME_Q);
            put(
                b,
                at + offset_of!(SectionRecord, length),
                &0_u64.to_le_bytes(),
            );
            put(
                b,
                q + offset_of!(SectionRecord, offset),
                &(start as u64).to_le_bytes(),
            );
            let end = section(b, SectionKind::GROUPS).start;
            let length = (end - start) as u64;
            put(
                b,
                q + offset_of!(SectionRecord, length),
                &length.to_le_bytes(),
            );
        }),
        Box::new(field(
            SectionKind::FRAME_Q,
            offset_of!(SectionRecord, length),
            76, // instead of 3 frames × 6 modes × 4 bytes, up to the same multiple of 64
        )),
        Box::new(|b| frame(b, 2, offset_of!(FrameRecord, time_s), 0.01)),
        Box::new(|b| frame(b, 1, offset_of!(FrameRecord, rotation), f64::NAN)),
        Box::new(|b| frame(b, 1, offset_of!(FrameRecord, translation) + 8, 1e25)),
        Box::new(body(SectionKind::FRAME_Q, 4, bits(f32::NAN))),
        Box::new(body(SectionKind::FRAME_Q, 4, bits(-1e30))),
        Box::new(|b| {
            b.push(0);
            let length = (b.len() as u64).to_le_bytes();
            put(b, offset_of!(Header, file_bytes), &length);
        }),
        // What only the deep check reads.
        Box::new(|b| {
            let end = section(b, SectionKind::POSITIONS).end;
            assert!(!end.is_multiple_of(64));
            b[end] = 1;
        }),
        Box::new(body(SectionKind::POSITIONS, 0, bits(f32::NAN))),
        Box::new(body(SectionKind::POSITIONS, 0, bits(100.0))),
        Box::new(of_node(1, offset_of!(NodeRecord, level), 9)),
        Box::new(of_node(0, offset_of!(NodeRecord, inner_mask), 0)),
        Box::new(of_node(0, offset_of!(NodeRecord, leaf_mask), 0xff)),
        Box::new(of_node(1, offset_of!(NodeRecord, scale_exponents), 0x81)),
        Box::new(of_node(1, offset_of!(NodeRecord, mode_count) + 1, 1)),
        Box::new(|b| {
            // Rows and list shrink to nothing, the list's start stays.
            let at = node(b, 1);
            put(b, at + offset_of!(NodeRecord, mode_count), &[0, 0]);
            u32_at(b, at + offset_of!(NodeRecord, mode_list_start), 2);
        }),
        Box::new(body(SectionKind::MODE_LISTS, 0, 0)),
        Box::new(body(SectionKind::MODE_LISTS, 0, u32::MAX)),
        Box::new(|b| {
            // A part of the root's list.
            let at = node(b, 1) + offset_of!(NodeRecord, mode_list_start);
            u32_at(b, at, 1);
        }),
        Box::new(|b| {
            // An empty lane of some node holds a number.
            let empty = (0..node_count(b)).find_map(|i| {
                let at = node(b, i);
                let used = b[at + offset_of!(NodeRecord, inner_mask)]
                    | b[at + offset_of!(NodeRecord, leaf_mask)];
                let row = get_u32(b, at + offset_of!(NodeRecord, row_start)) as usize;
                (used != 0xff).then(|| 32 * row + 4 * used.trailing_ones() as usize)
            });
            let at = section(b, SectionKind::ROWS).start + empty.expect("an empty lane");
            u32_at(b, at, 1.0_f32.to_bits());
        }),
        Box::new(header(offset_of!(Header, depth), 20)),
        Box::new(body(
            SectionKind::TRIANGLES,
            offset_of!(TriangleRecord, corners),
            u32::MAX,
        )),
        Box::new(body(
            SectionKind::TRIANGLES,
            offset_of!(TriangleRecord, id),
            u32::MAX,
        )),
        Box::new(body(SectionKind::GROUPS, size_of::<GroupRecord>(), 0)),
        Box::new(body(
            SectionKind::GROUPS,
            offset_of!(GroupRecord, name_bytes),
            99,
        )),
        Box::new(body(SectionKind::METADATA, 0, u32::MAX)),
        Box::new(root_bound(ROW_RADIUS, -1.0)),
        Box::new(root_bound(ROW_RADIUS, 0.99)),
        Box::new(root_growth(0, |n| n / 10 * 9)),
        Box::new(root_growth(0, |n| -n)),
        Box::new(|b| {
            // −2¹⁵ units.
            let at = root_mode(b, 0, offset_of!(ModePair, cross));
            put(b, at, &i16::MIN.to_le_bytes());
        }),
        Box::new(move |b| {
            let at = root_row(b, step_row(b));
            put(b, at, &0.0_f32.to_le_bytes());
        }),
        Box::new(|b| {
            // A vertex's displacements are those of other modes, which the node above leaves out.
            let bytes = AlignedBytes::copy_of(b);
            let asset = Asset::open(&bytes).expect("open");
            let modes = |v: usize| -> Vec<usize> {
                let own = asset.displacements(VertexId(v as u32)).expect("a vertex");
                own.iter().map(|(mode, _)| mode).collect()
            };
            let count = asset.vertex_count();
            let swap = asset.nodes().iter().find_map(|n| {
                let list = asset.node_modes(n).expect("list");
                let leaf = n.leaf_counts.iter().any(|c| *c > 0);
                let v = asset.triangles()[n.first_slot as usize].corners[0] as usize;
                let other = (0..count).find(|other| {
                    let other = modes(*other);
                    let left_out = |j: &usize| !list.contains(&(*j as u16));
                    other.len() == modes(v).len() && other.iter().any(left_out)
                });
                leaf.then_some((v, other?))
            });
            let (v, other) = swap.expect("local modes");
            let start = asset.vertex_modes()[other].mode_list_start;
            vertex_record(v, 4, start)(b);
        }),
        Box::new(vertex_record(7, 0, u32::MAX)),
        Box::new(vertex_record(0, 0, 1)),
        Box::new(|b| {
            // The record behind the last vertex's.
            let last = get_u32(b, offset_of!(Header, vertex_count)) as usize;
            vertex_record(last, 4, 1)(b);
        }),
        Box::new(|b| {
            // The vertex with the longest list has one mode less: part of a list.
            let bytes = AlignedBytes::copy_of(b);
            let asset = Asset::open(&bytes).expect("open");
            let records = asset.vertex_modes();
            let length = |v: &usize| records[v + 1].first_entry - records[*v].first_entry;
            let longest = (0..asset.vertex_count()).max_by_key(length).expect("one");
            let next = records[longest + 1].first_entry;
            vertex_record(longest + 1, 0, next - 1)(b);
        }),
        Box::new(|b| {
            // An empty list that stands elsewhere than at 0.
            let bytes = AlignedBytes::copy_of(b);
            let asset = Asset::open(&bytes).expect("open");
            let pairs = asset.vertex_modes().windows(2);
            let still = |pair: &[VertexModes]| pair[0].first_entry == pair[1].first_entry;
            let v = pairs.map(still).position(|x| x).expect("a vertex at rest");
            vertex_record(v, 4, 1)(b);
        }),
        Box::new(|b| {
            // The lists of the file, but none of them used by a vertex: all have the first.
            for v in 0..get_u32(b, offset_of!(Header, vertex_count)) as usize {
                vertex_record(v, 4, 0)(b);
            }
        }),
        Box::new(|b| {
            // Vertices of list 0 have one beyond the section instead, which queries meet.
            for v in 0..get_u32(b, offset_of!(Header, vertex_count)) as usize {
                vertex_record(v, 4, u32::MAX)(b);
            }
        }),
        Box::new(|b| {
            // Modes that do not exist, which queries meet.
            let lists = section(b, SectionKind::MODE_LISTS);
            b[lists].fill(0xff);
        }),
        Box::new(field(SectionKind::VERTEX_MODES, kind, name(b"VMOX"))),
        Box::new(|b| {
            let at = record(b, SectionKind::VERTEX_MODES);
            put(b, at, b"VMOX");
            u32_at(b, at + offset_of!(SectionRecord, required), 0);
        }),
        Box::new(|b| {
            // A leaf lane of the last node has one triangle less or more.
            let at = node(b, node_count(b) - 1);
            let lane = b[at + offset_of!(NodeRecord, leaf_mask)].trailing_zeros() as usize;
            let count = &mut b[at + offset_of!(NodeRecord, leaf_counts) + lane];
            *count = if *count > 1 { *count - 1 } else { 2 };
        }),
        // What queries meet.
        Box::new(of_node_u32(0, offset_of!(NodeRecord, first_child), 0)),
        Box::new(of_node_u32(0, offset_of!(NodeRecord, first_child), 1 << 20)),
        Box::new(of_node_u32(0, offset_of!(NodeRecord, row_start), u32::MAX)),
        Box::new(of_node_u32(
            0,
            offset_of!(NodeRecord, mode_list_start),
            u32::MAX,
        )),
        Box::new(|b| {
            for i in 0..node_count(b) {
                let at = node(b, i) + offset_of!(NodeRecord, first_slot);
                u32_at(b, at, u32::MAX);
            }
        }),
        Box::new(shared_children(32, 3)),
        Box::new(shared_children(1, 0xff)),
    ]
}

/// A second copy of the first list, which the last node uses or nobody: built on a tree with one
/// list only.
fn list_twice(used: bool) -> Vec<u8> {
    let mesh = bake::bumpy_sphere(8, 1);
    let mut bytes = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 1)).to_vec();
    let at = record(&bytes, SectionKind::MODE_LISTS) + offset_of!(SectionRecord, length);
    assert_eq!(get_u32(&bytes, at), 4, "one list of two modes");
    u32_at(&mut bytes, at, 8);
    let start = section(&bytes, SectionKind::MODE_LISTS).start;
    bytes.copy_within(start..start + 4, start + 4); // into the padding
    if used {
        let last = node(&bytes, node_count(&bytes) - 1);
        u32_at(
            &mut bytes,
            last + offset_of!(NodeRecord, mode_list_start),
            2,
        );
    }
    repair(&mut bytes);
    bytes
}

#[test]
fn every_rule_is_triggered() {
    let mut seen = Seen::default();
    seen.everything(&FILE);
    assert!(seen.0.is_empty(), "{:?}", seen.0);
    for change in changes() {
        let mut bytes = FILE.to_vec();
        change(&mut bytes);
        repair(&mut bytes);
        seen.everything(&bytes);
    }
    seen.everything(&list_twice(true));
    seen.everything(&list_twice(false));
    // Checksums that are not repaired.
    for at in [100, FILE.len() - 1] {
        let mut bytes = FILE.to_vec();
        bytes[at] ^= 1;
        seen.everything(&bytes);
    }
    // A misaligned base.
    let copy = AlignedBytes::copy_of(&[&[0; 4][..], &FILE].concat());
    for start in 1..4 {
        let mut shifted = copy.to_vec();
        shifted.rotate_left(4 - start);
        let shifted = AlignedBytes::copy_of(&shifted);
        let error = Asset::open(&shifted[start..start + FILE.len()]).expect_err("misaligned");
        assert!(error.rule.starts_with("SPEC 3.2"), "{error}");
        seen.note(&error);
    }
    assert!(
        Asset::open(&copy[4..]).is_ok(),
        "an alignment of 4 is enough"
    );
    // Accessors.
    let asset = Asset::open(&FILE).expect("open");
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = Pose::new(&asset, &[0.0; 6], Transform::IDENTITY, &mut memory).expect("pose");
    seen.note(
        &asset
            .triangle(TriangleId(u32::MAX))
            .expect_err("no such triangle"),
    );
    seen.note(
        &asset
            .deformed(&pose, VertexId(u32::MAX))
            .expect_err("no such vertex"),
    );
    let short = add_generalized_force(
        &asset,
        &pose,
        TriangleId(0),
        [1.0, 0.0, 0.0],
        [1.0; 3],
        &mut [0.0; 5],
    );
    seen.note(&short.expect_err("too short"));

    let all = rules();
    assert!(all.len() > 60, "{}", all.len());
    let missing: Vec<_> = all
        .iter()
        .filter(|r| !seen.0.contains(*r) && !UNREACHABLE.contains(&r.as_str()))
        .collect();
    assert!(missing.is_empty(), "not triggered: {missing:#?}");
    for rule in UNREACHABLE {
        assert!(all.contains(rule) && !seen.0.contains(rule), "{rule}");
    }
    let unknown: Vec<_> = seen.0.difference(&all).collect();
    assert!(unknown.is_empty(), "not in the sources: {unknown:#?}");
}

/// Cited numbers exist, and speak of the part that they are cited for.
#[test]
fn cited_rules_stand_in_the_specification() {
    let spec = include_str!("../../format-spec/SPEC.md");
    for rule in rules() {
        let number = rule["SPEC ".len()..]
            .split([':', ')'])
            .next()
            .expect("a number");
        let cited = spec.lines().any(|line| {
            line.trim_start_matches('#')
                .trim_start()
                .starts_with(&format!("{number} "))
                && line.starts_with("##")
        });
        assert!(cited, "{rule}");
    }
}
