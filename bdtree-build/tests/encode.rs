//! The file's bytes: canonical order, checksums, padding, the same bytes every time.

use std::collections::BTreeSet;

use crate::tree_support::*;
use bdtree_build::basis::{Animation, Basis};
use bdtree_build::input::{GroupKind, RawGroup, RawMesh};
use bdtree_build::pipeline::BakeSettings;
use bdtree_build::tree::Split;
use bdtree_format::{
    DEPTH_MAX, Header, SECTION_ORDER, SECTIONS_OF_CLIPS, SECTIONS_OF_SKINS, SectionKind, row_count,
};
use zerocopy::IntoBytes;

#[test]
fn bytes_do_not_depend_on_threads_or_run() {
    let mesh = soup(9000, 1);
    let basis = waves(&mesh, 5);
    for split in [Split::Quinlan, Split::Cost] {
        let bytes = |threads| {
            let settings = BakeSettings {
                threads,
                split,
                ..BakeSettings::default()
            };
            bake_with(&mesh, &basis, &settings).bytes
        };
        let first = bytes(1);
        assert!(first == bytes(1), "a second run differs");
        assert!(first == bytes(2), "two threads differ from one");
        assert!(first == bytes(5), "five threads differ from one");
    }
}

#[test]
fn nodes_rows_and_triangles_stand_in_canonical_order() {
    for (mesh, leaf_size) in [
        (grid(30), 8),
        (grid(30), 1),
        (soup(500, 2), 3),
        (soup(1, 2), 4),
    ] {
        for split in [Split::Quinlan, Split::Cost] {
            let settings = BakeSettings {
                leaf_size: Some(leaf_size),
                split,
                ..BakeSettings::default()
            };
            let bytes = bake_with(&mesh, &waves(&mesh, 3), &settings).bytes;
            check_canonical(&Decoded::new(&bytes), &mesh, leaf_size);
        }
    }
}

fn check_canonical(file: &Decoded, mesh: &RawMesh, leaf_size: usize) {
    let (mut child, mut slot, mut row) = (1, 0, 0);
    for (i, node) in file.nodes.iter().enumerate() {
        assert_eq!(node.first_child, child);
        assert_eq!(node.first_slot, slot);
        assert_eq!(node.row_start, row);
        assert_eq!(node.inner_mask & node.leaf_mask, 0);
        assert!(node.scale_exponents.iter().all(|&e| e >= -126));
        let used = node.inner_mask | node.leaf_mask;
        assert_eq!(used & used.wrapping_add(1), 0, "empty lanes stand last");
        let numbers = 6 + NUMBERS_PER_MODE * usize::from(node.mode_count);
        for k in 0..8 {
            for number in 0..numbers {
                let x = file.value(node, number, k);
                assert!(x.is_finite() && !x.is_subnormal());
                assert_ne!(x.to_bits(), (-0.0f32).to_bits());
            }
            let count = usize::from(node.leaf_counts[k]);
            assert_eq!(count > 0, node.leaf_mask >> k & 1 == 1);
            assert!(count <= leaf_size);
            if used >> k & 1 == 0 {
                for number in 0..numbers {
                    assert_eq!(file.value(node, number, k).to_bits(), 0);
                }
            }
        }
        for c in child..child + node.inner_mask.count_ones() {
            assert_eq!(file.nodes[c as usize].level, node.level + 1);
            assert!(c as usize > i);
        }
        child += node.inner_mask.count_ones();
        slot += node.leaf_counts.iter().map(|&c| u32::from(c)).sum::<u32>();
        row += row_count(usize::from(node.mode_count)) as u32;
        assert!(file.node_modes(node).is_sorted());
    }
    check_lists(file);
    assert_eq!(child as usize, file.nodes.len());
    assert_eq!(slot as usize, mesh.triangles.len());
    assert_eq!(row as usize, file.rows.len());
    let depth = file.nodes.iter().map(|node| node.level).max().unwrap() + 1;
    assert_eq!(u32::from(depth), file.header.depth.get());
    for (s, triangle) in file.triangles.iter().enumerate() {
        assert_eq!(triangle.corners, mesh.triangles[triangle.id as usize]);
        assert_eq!(file.slots[triangle.id as usize] as usize, s);
    }
}

/// Each list of nodes and vertices once, the largest first, nothing else; the entries of vertices
/// without a gap.
fn check_lists(file: &Decoded) {
    let of_nodes = file.nodes.iter().map(|node| file.node_modes(node));
    let of_vertices = file.vertex_modes.windows(2).map(|pair| {
        let count = pair[1].first_entry - pair[0].first_entry;
        &file.lists[pair[0].mode_list_start as usize..][..count as usize]
    });
    let distinct: BTreeSet<&[u16]> = of_nodes.chain(of_vertices).collect();
    let stored: Vec<u16> = distinct.into_iter().rev().flatten().copied().collect();
    assert_eq!(file.lists, stored);
    for pair in file.vertex_modes.windows(2) {
        let is_empty = pair[0].first_entry == pair[1].first_entry;
        assert!(pair[0].first_entry <= pair[1].first_entry);
        assert!(!is_empty || pair[0].mode_list_start == 0);
    }
}

/// Displacements of listed modes where that saves a quarter of their bytes, from fields on all of the
/// mesh to fields on none.
#[test]
fn vertices_list_their_modes_where_it_saves_a_quarter() {
    let mesh = grid(30);
    let mut seen = BTreeSet::new();
    for step in 0..=40 {
        let width = 0.6 - 0.015 * f64::from(step);
        let local = basis(&mesh, 10, |j, p| {
            let distance = (p[0] - j as f64 / 9.0).abs();
            [0.0, 0.0, (width - distance).max(0.0)]
        });
        let bytes = bake_with(&mesh, &local, &BakeSettings::default()).bytes;
        let file = Decoded::new(&bytes);
        check_lists(&file);
        let modes_of = |i: usize| -> Vec<u16> {
            let row = &file.displacements[10 * i..10 * (i + 1)];
            let moved = (0..10).filter(|j| row[*j] != [0.0; 3]);
            moved.map(|j| j as u16).collect()
        };
        let n = file.positions.len();
        let lists: BTreeSet<Vec<u16>> = (0..n).map(modes_of).collect();
        let of_nodes: BTreeSet<Vec<u16>> = file
            .nodes
            .iter()
            .map(|x| file.node_modes(x).to_vec())
            .collect();
        let more: usize = lists.difference(&of_nodes).map(Vec::len).sum();
        let entries: usize = (0..n).map(|i| modes_of(i).len()).sum();
        let saves = 4 * (12 * entries + 8 * (n + 1) + 2 * more) <= 3 * 12 * n * 10;
        assert_eq!(!file.vertex_modes.is_empty(), saves, "width {width}");
        let length = file
            .sections
            .iter()
            .find(|s| s.kind == SectionKind::DISPLACEMENTS);
        let stored = if saves { entries } else { 10 * n };
        assert_eq!(length.unwrap().length.get() as usize, 12 * stored);
        assert_eq!(length.unwrap().layout.get(), if saves { 2 } else { 1 });
        seen.insert((saves, entries == 0));
    }
    assert_eq!(seen.len(), 3, "all modes, some, none");
}

#[test]
fn sections_are_aligned_ordered_checked_and_padded_with_zeros() {
    let mut mesh = grid(9);
    let mut basis = waves(&mesh, 3);
    for (groups, frames) in [(0u32, 0), (2, 0), (0, 3)] {
        basis.animation = (frames > 0).then(|| Animation {
            frame_count: frames,
            q: vec![0.25; 3 * frames],
            ..Animation::default()
        });
        mesh.groups = (0..groups)
            .map(|i| RawGroup {
                kind: GroupKind::Material,
                name: format!("steel {i}"),
                first_triangle: i,
                triangle_count: 1,
            })
            .collect();
        let bytes = bake_with(&mesh, &basis, &BakeSettings::default()).bytes;
        let file = Decoded::new(&bytes);
        let kinds: Vec<SectionKind> = file.sections.iter().map(|s| s.kind).collect();
        // Without a skin nothing of one.
        let of_skins = &SECTION_ORDER[SECTIONS_OF_SKINS.start..SECTIONS_OF_CLIPS.end];
        let expected: Vec<SectionKind> = SECTION_ORDER
            .into_iter()
            .filter(|k| !of_skins.contains(k))
            .filter(|k| groups > 0 || ![SectionKind::GROUPS, SectionKind::GROUP_NAMES].contains(k))
            .filter(|k| frames > 0 || ![SectionKind::FRAMES, SectionKind::FRAME_Q].contains(k))
            .filter(|k| *k != SectionKind::VERTEX_MODES)
            // The grid is open.
            .filter(|k| ![SectionKind::MASS_PROPERTIES, SectionKind::MODE_MOMENTA].contains(k))
            .collect();
        assert_eq!(kinds, expected);
        let mut end = file.header.header_bytes.get() as usize;
        for section in &file.sections {
            let (start, length) = (section.offset.get() as usize, section.length.get() as usize);
            assert_eq!(start, end.next_multiple_of(64));
            assert!(bytes[end..start].iter().all(|&b| b == 0));
            end = start + length;
            assert_eq!(section.crc.get(), crc32fast::hash(&bytes[start..end]));
        }
        assert_eq!(end, bytes.len());
        assert_eq!(file.header.file_bytes.get() as usize, bytes.len());
        let mut header = file.header;
        header.header_crc = 0.into();
        let mut block = bytes[..header.header_bytes.get() as usize].to_vec();
        block[..size_of::<Header>()].copy_from_slice(header.as_bytes());
        assert_eq!(file.header.header_crc.get(), crc32fast::hash(&block));
    }
}

#[test]
fn any_input_stays_within_the_largest_depth() {
    let doubling = |n: i32| RawMesh {
        positions: (0..n).map(|i| [1.1f64.powi(i), 0.0, 0.0]).collect(),
        triangles: (0..n as u32 - 2).map(|i| [i, i + 1, i + 2]).collect(),
        ..RawMesh::default()
    };
    for mesh in [doubling(600), doubling(100)] {
        for split in [Split::Quinlan, Split::Cost] {
            let settings = BakeSettings {
                leaf_size: Some(1),
                split,
                ..BakeSettings::default()
            };
            let file = Decoded::new(&bake_with(&mesh, &Basis::default(), &settings).bytes);
            assert!(file.header.depth.get() as usize <= DEPTH_MAX);
            check_canonical(&file, &mesh, 1);
        }
    }
}

#[test]
fn f32_sources_are_stored_as_they_are() {
    let mut mesh = soup(50, 9);
    for offset in [0.0, 1e4] {
        for p in &mut mesh.positions {
            *p = p.map(|x| f64::from((x + offset) as f32));
        }
        let file = bake_default(&mesh, &Basis::default());
        let origin = file.header.origin.map(|x| x.get());
        for (p, stored) in mesh.positions.iter().zip(&file.positions) {
            for k in 0..3 {
                assert_eq!(origin[k] + f64::from(stored[k]), p[k]);
            }
        }
    }
}

#[test]
fn limits_follow_the_longest_displacement() {
    let mesh = grid(5);
    let mut fields = basis(&mesh, 3, |j, p| {
        if j == 1 {
            [0.0; 3]
        } else {
            [0.0, 0.0, p[0] * 3.0]
        }
    });
    fields.modes[2].q_range = Some(0.75);
    let file = bake_default(&mesh, &fields);
    let diagonal = (2.0f64 + 0.01).sqrt();
    let limit = f64::from(file.modes[0].q_limit.get());
    let reach = limit * 3.0 / diagonal;
    assert!((95.0..215.0).contains(&reach), "{reach}");
    assert_eq!(limit.log2().fract(), 0.0);
    assert_eq!(file.modes[1].q_limit.get(), 2f32.powi(60));
    assert_eq!(file.modes[1].q_range.get(), 1.0);
    assert_eq!(file.modes[2].q_range.get(), 0.75);
    assert_eq!(file.modes[2].step_scale.get(), 0.75);
    let range = f64::from(file.modes[0].q_range.get()) * 3.0 / diagonal;
    assert!((0.049..0.051).contains(&range), "{range}");
}

/// The tree itself takes any floats: it is built before anyone has judged them.
#[test]
fn trees_of_bad_positions_are_still_trees() {
    use bdtree_build::tree::{TreeSettings, build};
    let bad = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        -0.0,
        1e-45,
        1.0,
    ];
    let positions: Vec<[f32; 3]> = (0..300)
        .map(|i| [bad[i % 7], bad[i / 7 % 7], bad[i / 49 % 7]])
        .collect();
    let triangles: Vec<[u32; 3]> = (0..298).map(|i| [i, i + 1, i + 2]).collect();
    for split in [Split::Quinlan, Split::Cost] {
        for leaf_size in [1, 4] {
            let settings = TreeSettings {
                split,
                leaf_size,
                threads: 1,
            };
            let tree = build(&positions, &triangles, &settings);
            let mut ids: Vec<u32> = tree.leaf_order().collect();
            ids.sort_unstable();
            assert!(ids.into_iter().eq(0..298));
            assert!(tree.depth <= DEPTH_MAX);
            assert_eq!(build(&[], &[], &settings).nodes.len(), 1);
        }
    }
}
