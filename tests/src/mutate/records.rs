//! Records set to values that hurt, wherever they stand: indices, counts, masks, numbers.

use std::mem::{offset_of, size_of};

use bdtree_format::{
    GroupRecord, Header, LANES, NodeRecord, ROWS_LEADING, ROWS_PER_PAIR, Row, SectionKind,
    SectionRecord, TriangleRecord, VertexModes, pair_count, pair_row,
};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{get_u32, pick, place, put, table};

/// Changes one to three records.
pub(super) fn change_some(bytes: &mut [u8], rng: &mut Pcg64Mcg) {
    for _ in 0..rng.random_range(1..=3) {
        change(bytes, rng);
    }
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
        SectionKind::ROWS if rng.random_range(0..3) > 0 => change_row(bytes, start, rng),
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

/// A whole row of some node, or one lane of it, to a value that hurts where it stands.
fn change_row(bytes: &mut [u8], rows: usize, rng: &mut Pcg64Mcg) {
    let count = get_u32(bytes, offset_of!(Header, node_count)) as usize;
    let nodes = place(bytes, table(bytes)).0; // NODE is the first section
    let node = nodes.saturating_add(size_of::<NodeRecord>() * rng.random_range(0..count.max(1)));
    let row_start = get_u32(
        bytes,
        node.saturating_add(offset_of!(NodeRecord, row_start)),
    );
    let modes = get_u32(
        bytes,
        node.saturating_add(offset_of!(NodeRecord, mode_count)),
    ) as u16;
    let pairs = pair_count(usize::from(modes));
    let row = match rng.random_range(0..4) {
        0 => rng.random_range(0..ROWS_LEADING),
        1 => pair_row(pairs) + rng.random_range(0..2),
        _ => ROWS_LEADING + rng.random_range(0..(ROWS_PER_PAIR * pairs).max(1)),
    };
    let at = rows.saturating_add((row_start as usize).saturating_add(row) * size_of::<Row>());
    let in_pairs = (ROWS_LEADING..pair_row(pairs)).contains(&row);
    let all = rng.random_bool(0.5);
    let lane = rng.random_range(0..LANES);
    for k in (0..LANES).filter(|k| all || *k == lane) {
        if in_pairs {
            let value = pick(&[0, 1, 0x7fff, 0x8000, 0x8001, 0xffff_u16], rng);
            put(
                bytes,
                at + 4 * k + 2 * rng.random_range(0..2),
                &value.to_le_bytes(),
            );
        } else {
            put(bytes, at + 4 * k, &real(rng).to_le_bytes());
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
            let at = at + offset_of!(NodeRecord, scale_exponents) + which;
            let exponent = pick(&[0, 1, 0x7f, 0x80, 0x82, 0xff, bytes[at] ^ 1], rng);
            bytes[at] = exponent;
        }
        _ => bytes[at + offset_of!(NodeRecord, level)] = value as u8,
    }
}

/// Header, mode table, section table, or a change of all nodes at once.
fn change_elsewhere(bytes: &mut [u8], which: usize, rng: &mut Pcg64Mcg) {
    let count = get_u32(bytes, offset_of!(Header, node_count)) as usize;
    match which {
        0 => match rng.random_range(0..4) {
            // What may stand there, and hardly ever does.
            0 => {
                let exponent = pick(&[-100, -99, -10, 10, 99, 100_i32], rng);
                put(
                    bytes,
                    offset_of!(Header, unit_exponent),
                    &exponent.to_le_bytes(),
                );
            }
            1 => {
                let x = pick(&[0.0, 1.0, -1e10, 1e17, (1_u128 << 80) as f64], rng);
                let at = offset_of!(Header, origin) + 8 * rng.random_range(0..3);
                put(bytes, at, &x.to_le_bytes());
            }
            _ => {
                let field = 4 * rng.random_range(2..24);
                put(bytes, field, &index(field, count, rng).to_le_bytes());
            }
        },
        1 => {
            let start = size_of::<Header>();
            let field = start + 4 * rng.random_range(0..(table(bytes) - start).max(32) / 4);
            match rng.random_range(0..3) {
                0 => put(bytes, field, &real(rng).to_le_bytes()),
                // Limits that are limits, and what no sane writer would choose.
                1 => {
                    let power = pick(&[1, 2, 64, 126, 127, 128, 129, 200, 253, 254_u32], rng) << 23;
                    put(bytes, field, &power.to_le_bytes());
                }
                _ => put(bytes, field & !7, &f64::from(real(rng)).to_le_bytes()),
            }
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
    let start = place(bytes, table(bytes)).0; // as above
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
