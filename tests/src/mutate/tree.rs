//! Trees that are none: chains, children and leaves that many nodes share, more levels than nodes,
//! and spheres that keep no query out.

use std::mem::{offset_of, size_of};

use bdtree_format::{Header, LANES, NodeRecord, ROW_RADIUS, Row, SectionKind};
use bdtree_runtime::AlignedBytes;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{get_u32, pick, put};
use crate::sections::{Part, put_together, take_apart};

/// Most nodes of such a tree: as many visits as the smallest files' brute force, several times over; or
/// what an interpreter can walk.
const NODES: usize = if cfg!(miri) { 4 } else { 60 };

pub(super) fn change(sound: &AlignedBytes, rng: &mut Pcg64Mcg) -> Vec<u8> {
    let mut parts = take_apart(sound);
    let triangles = get_u32(sound, offset_of!(Header, triangle_count));
    let count = rng.random_range(1..=NODES);
    let depth = pick(&[1_u32, 2, 3, 32, 32], rng);
    if rng.random_bool(0.7)
        && let Some(rows) = part(&mut parts, SectionKind::ROWS)
    {
        keep_out_nothing(&mut rows.body, rng);
    }
    if let Some(nodes) = part(&mut parts, SectionKind::NODES) {
        nodes.body = made(&nodes.body, count, triangles, rng);
    }
    let mut bytes = put_together(sound, parts);
    for (at, value) in [
        (offset_of!(Header, node_count), count as u32),
        (offset_of!(Header, depth), depth),
        (offset_of!(Header, leaf_triangles_max), 255),
    ] {
        put(&mut bytes, at, &value.to_le_bytes());
    }
    bytes
}

fn part(parts: &mut [Part], kind: SectionKind) -> Option<&mut Part> {
    parts.iter_mut().find(|part| part.kind() == kind)
}

/// Radii of every row that may be one: endless, or none.
fn keep_out_nothing(rows: &mut [u8], rng: &mut Pcg64Mcg) {
    let radius = pick(&[1e18_f32, f32::NAN, f32::INFINITY, 1e5], rng);
    // The first node's rows are those of all, if nodes share them.
    let first = ROW_RADIUS * size_of::<Row>();
    let all = rng.random_bool(0.5);
    for lane in 0..LANES {
        put(rows, first + 4 * lane, &radius.to_le_bytes());
    }
    if all {
        for at in (first..rows.len()).step_by(size_of::<Row>() * 6) {
            put(rows, at, &radius.to_le_bytes());
        }
    }
}

/// `count` nodes, each like some node of the file but for what it leads to.
fn made(nodes: &[u8], count: usize, triangles: u32, rng: &mut Pcg64Mcg) -> Vec<u8> {
    let size = size_of::<NodeRecord>();
    let shared_rows = rng.random_bool(0.7);
    let ahead = pick(&[0, 1, 1, 1, 2, 5], rng);
    let inner = pick(&[0_u8, 1, 3, 0x0f, 0x7f, 0xff], rng);
    let leaf = pick(&[0_u8, 1, 0x80, 0xf0, 0xff], rng);
    let most = triangles.min(255);
    let in_leaf = pick(&[1, 4, most / 8, most], rng).clamp(1, most) as u8;
    let mut body = Vec::with_capacity(count * size);
    for i in 0..count {
        let own = if shared_rows {
            0
        } else {
            i % (nodes.len() / size)
        };
        let mut node = nodes[own * size..][..size].to_vec();
        // The last ones have no children, so that chains end.
        let inner = if i + ahead < count { inner & !leaf } else { 0 };
        let leaf = if inner == 0 { leaf | 1 } else { leaf };
        let child = (i + ahead).min(count.saturating_sub(inner.count_ones() as usize));
        put(
            &mut node,
            offset_of!(NodeRecord, first_child),
            &(child as u32).to_le_bytes(),
        );
        let lanes = leaf.count_ones();
        let slot = triangles.saturating_sub(u32::from(in_leaf) * lanes.max(1));
        let slot = if slot == 0 {
            0
        } else {
            rng.random_range(0..=slot)
        };
        put(
            &mut node,
            offset_of!(NodeRecord, first_slot),
            &slot.to_le_bytes(),
        );
        node[offset_of!(NodeRecord, inner_mask)] = inner;
        node[offset_of!(NodeRecord, leaf_mask)] = leaf;
        node[offset_of!(NodeRecord, level)] = i.min(31) as u8;
        for lane in 0..LANES {
            let here = leaf >> lane & 1 == 1;
            node[offset_of!(NodeRecord, leaf_counts) + lane] = if here { in_leaf } else { 0 };
        }
        body.extend(node);
    }
    body
}
