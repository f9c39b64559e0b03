//! Numbers changed to others that may stand in their place: bounds made smaller, centres, vertices
//! and limits moved. The file's structure stays sound.

use std::mem::{offset_of, size_of};

use bdtree_format::{Header, ModeRecord, NodeRecord, SectionKind};
use bdtree_runtime::{AlignedBytes, Asset};
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{get_f32, pick, put, section};
use crate::lanes::{Number, place};

/// Changes one to four numbers of a sound file.
pub(super) fn change_some(bytes: &mut [u8], sound: &AlignedBytes, rng: &mut Pcg64Mcg) {
    let asset = Asset::open(sound).expect("a sound file opens");
    for _ in 0..rng.random_range(1..=4) {
        match rng.random_range(0..10) {
            0 => scale_some(bytes, SectionKind::POSITIONS, rng),
            1 => scale_some(bytes, SectionKind::DISPLACEMENTS, rng),
            2 => change_header(bytes, &asset, rng),
            3 => change_unit(bytes, &asset, rng),
            _ => change_lane(bytes, &asset, rng),
        }
    }
}

/// An f32 a little or much smaller, or larger every fourth time; only if it stays one that may be
/// stored.
fn scale(bytes: &mut [u8], at: usize, rng: &mut Pcg64Mcg) {
    let x = get_f32(bytes, at);
    let share = 1.0 / (1_u32 << pick(&[1_u32, 3, 8, 15, 20, 22], rng)) as f32;
    let changed = match rng.random_range(0..8) {
        0 => x.next_down(),
        1 => x.next_up(),
        2 => x * (1.0 + share),
        3 => 0.0,
        _ => x * (1.0 - share),
    };
    if changed == 0.0 || changed.is_normal() {
        put(bytes, at, &changed.to_le_bytes());
    }
}

/// A coordinate of a section of vectors.
fn scale_some(bytes: &mut [u8], kind: SectionKind, rng: &mut Pcg64Mcg) {
    let place = section(bytes, kind);
    if !place.is_empty() {
        let at = place.start + 4 * rng.random_range(0..place.len() / 4);
        scale(bytes, at, rng);
    }
}

/// P, or a mode's limit, W or step scale.
fn change_header(bytes: &mut [u8], asset: &Asset<'_>, rng: &mut Pcg64Mcg) {
    let count = asset.mode_count();
    if count == 0 || rng.random_bool(0.25) {
        return scale(bytes, offset_of!(Header, position_norm_max), rng);
    }
    let record = size_of::<Header>() + rng.random_range(0..count) * size_of::<ModeRecord>();
    match rng.random_range(0..3) {
        0 => {
            let at = record + offset_of!(ModeRecord, q_limit);
            let limit = get_f32(bytes, at) * pick(&[0.5, 2.0, 0.125, 1024.0], rng);
            if limit.is_normal() {
                put(bytes, at, &limit.to_le_bytes());
            }
        }
        1 => scale(bytes, record + offset_of!(ModeRecord, field_norm_max), rng),
        _ => scale(bytes, record + offset_of!(ModeRecord, step_scale), rng),
    }
}

/// The unit of a node's mode rows.
fn change_unit(bytes: &mut [u8], asset: &Asset<'_>, rng: &mut Pcg64Mcg) {
    let node = rng.random_range(0..asset.node_count());
    let at = section(bytes, SectionKind::NODES).start
        + node * size_of::<NodeRecord>()
        + offset_of!(NodeRecord, scale_exponents)
        + rng.random_range(0..3);
    let exponent = i32::from(bytes[at] as i8) + pick(&[-7, -1, -1, 1, 7], rng);
    bytes[at] = exponent.clamp(-126, 127) as i8 as u8;
}

/// A number of some lane.
fn change_lane(bytes: &mut [u8], asset: &Asset<'_>, rng: &mut Pcg64Mcg) {
    let index = rng.random_range(0..asset.node_count());
    let node = &asset.nodes()[index];
    let used: Vec<usize> = (0..8)
        .filter(|k| (node.inner_mask | node.leaf_mask) >> k & 1 == 1)
        .collect();
    let lane = (index, used[rng.random_range(0..used.len())]);
    let modes = usize::from(node.mode_count);
    let k = rng.random_range(0..modes.max(1));
    let axis = rng.random_range(0..3);
    let number = match rng.random_range(0..if modes == 0 { 4 } else { 9 }) {
        0 => Number::Centre(axis),
        1 | 2 => Number::Radius,
        3 => Number::Step(rng.random_range(0..2)),
        4 | 5 => Number::Mean(k, axis),
        6 => Number::Growth(k),
        _ => Number::Cross(k, rng.random_range(0..2)),
    };
    let at = section(bytes, SectionKind::ROWS).start + place(asset, lane, number);
    match number {
        Number::Centre(_) | Number::Radius | Number::Step(_) => scale(bytes, at, rng),
        _ => {
            let stored = i16::from_le_bytes([bytes[at], bytes[at + 1]]);
            let by = pick(&[1, 1, 2, 16, 256, 4096], rng);
            let up = rng.random_bool(0.25);
            let changed = stored.saturating_add(if up { by } else { -by });
            put(bytes, at, &changed.to_le_bytes());
        }
    }
}
