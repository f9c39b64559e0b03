//! What only the deep check reads.

use std::mem::{offset_of, size_of};

use bdtree_fixtures::bake;
use bdtree_fixtures::mutate::{get_u32, put, record, repair, section};
use bdtree_format::{
    GroupRecord, Header, ModePair, NodeRecord, ROW_RADIUS, SectionKind, SectionRecord,
    TriangleRecord, VertexModes, pair_count, pair_row,
};
use bdtree_runtime::{Model, VertexId};

use crate::edits::{
    Change, body, field, header, node, node_count, of_node, root_bound, root_growth, root_mode,
    root_row, u32_at, vertex_record,
};

/// Changes of a sound file, checksums repaired afterwards.
pub(crate) fn changes() -> Vec<Change> {
    let bits = |x: f32| x.to_bits();
    let kind = offset_of!(SectionRecord, kind);
    let name = |n: &[u8; 4]| u32::from_le_bytes(*n);
    let step_row = |b: &[u8]| {
        let at = node(b, 0) + offset_of!(NodeRecord, mode_count);
        pair_row(pair_count(u16::from_le_bytes([b[at], b[at + 1]]).into()))
    };
    vec![
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
            let model = Model::from_bytes(b).expect("open");
            let asset = model.asset();
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
            let model = Model::from_bytes(b).expect("open");
            let asset = model.asset();
            let records = asset.vertex_modes();
            let length = |v: &usize| records[v + 1].first_entry - records[*v].first_entry;
            let longest = (0..asset.vertex_count()).max_by_key(length).expect("one");
            let next = records[longest + 1].first_entry;
            vertex_record(longest + 1, 0, next - 1)(b);
        }),
        Box::new(|b| {
            // An empty list that stands elsewhere than at 0.
            let model = Model::from_bytes(b).expect("open");
            let asset = model.asset();
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
    ]
}

/// A second copy of the first list, which the last node uses or nobody: built on a tree with one
/// list only.
pub(crate) fn list_twice(used: bool) -> Vec<u8> {
    let mesh = bake::bumpy_sphere(8, 1);
    let model = bake::baked(&mesh, &bake::smooth_basis(&mesh, 2, 1));
    let mut bytes = model.asset().bytes().to_vec();
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
