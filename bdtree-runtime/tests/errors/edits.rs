//! Changes of a file's bytes, by what stands there.

use std::mem::{offset_of, size_of};

use bdtree_fixtures::mutate::{get_f32, get_u32, put, record, section};
use bdtree_format::{
    FrameRecord, Header, ModePair, NodeRecord, Row, SectionKind, VertexModes, pair_row,
};

pub(crate) type Change = Box<dyn Fn(&mut Vec<u8>)>;

pub(crate) fn node(bytes: &[u8], i: usize) -> usize {
    section(bytes, SectionKind::NODES).start + i * size_of::<NodeRecord>()
}

pub(crate) fn node_count(bytes: &[u8]) -> usize {
    get_u32(bytes, offset_of!(Header, node_count)) as usize
}

pub(crate) fn u32_at(bytes: &mut [u8], at: usize, value: u32) {
    put(bytes, at, &value.to_le_bytes());
}

/// Changes a number of a frame.
pub(crate) fn frame(bytes: &mut [u8], k: usize, offset: usize, value: f64) {
    let at = section(bytes, SectionKind::FRAMES).start + k * size_of::<FrameRecord>() + offset;
    put(bytes, at, &value.to_le_bytes());
}

/// A place of the root's rows: lane of the lowest bit set.
pub(crate) fn root_row(bytes: &[u8], row: usize) -> usize {
    let at = node(bytes, 0);
    let masks = bytes[at + offset_of!(NodeRecord, inner_mask)]
        | bytes[at + offset_of!(NodeRecord, leaf_mask)];
    section(bytes, SectionKind::ROWS).start
        + row * size_of::<Row>()
        + 4 * masks.trailing_zeros() as usize
}

pub(crate) fn field(kind: SectionKind, offset: usize, value: u32) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = record(b, kind) + offset;
        u32_at(b, at, value);
    }
}

pub(crate) fn header(offset: usize, value: u32) -> impl Fn(&mut Vec<u8>) {
    move |b| u32_at(b, offset, value)
}

pub(crate) fn of_node(i: usize, offset: usize, value: u8) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = node(b, i) + offset;
        b[at] = value;
    }
}

pub(crate) fn of_node_u32(i: usize, offset: usize, value: u32) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = node(b, i) + offset;
        u32_at(b, at, value);
    }
}

pub(crate) fn body(kind: SectionKind, offset: usize, value: u32) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = section(b, kind).start + offset;
        u32_at(b, at, value);
    }
}

/// Changes a vertex's record in VMOD.
pub(crate) fn vertex_record(vertex: usize, offset: usize, value: u32) -> impl Fn(&mut Vec<u8>) {
    body(
        SectionKind::VERTEX_MODES,
        vertex * size_of::<VertexModes>() + offset,
        value,
    )
}

/// Multiplies a bound of the root's first used lane.
pub(crate) fn root_bound(row: usize, factor: f32) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = root_row(b, row);
        let value = get_f32(b, at) * factor;
        put(b, at, &value.to_le_bytes());
    }
}

/// The same for a row of the root's k-th mode.
pub(crate) fn root_mode(bytes: &[u8], k: usize, offset: usize) -> usize {
    let first = root_row(bytes, 0);
    let lane = (first - section(bytes, SectionKind::ROWS).start) / size_of::<f32>();
    first - lane * size_of::<f32>()
        + pair_row(k / 2) * size_of::<Row>()
        + offset
        + lane * size_of::<[i16; 2]>()
        + k % 2 * size_of::<i16>()
}

/// Changes a ΔR of the root's first used lane.
pub(crate) fn root_growth(k: usize, change: impl Fn(i16) -> i16) -> impl Fn(&mut Vec<u8>) {
    move |b| {
        let at = root_mode(b, k, offset_of!(ModePair, growth));
        let value = change(i16::from_le_bytes([b[at], b[at + 1]]));
        put(b, at, &value.to_le_bytes());
    }
}
