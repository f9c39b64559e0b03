//! Sections as a whole: cut and grown together with the counts that go with them, so that the file
//! still opens; or swapped, moved, laid over each other, renamed, left out.

use std::mem::{offset_of, size_of};

use bdtree_format::{
    FrameRecord, Header, NodeRecord, Row, SectionKind, SectionRecord, TriangleRecord, VertexModes,
};
use bdtree_runtime::AlignedBytes;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{get_u32, pick, put, record, table};
use crate::sections::{Part, put_together, take_apart};

pub(super) fn change(sound: &AlignedBytes, rng: &mut Pcg64Mcg) -> Vec<u8> {
    let mut parts = take_apart(sound);
    match rng.random_range(0..10) {
        0..4 => return resize(sound, parts, rng),
        4 => {
            // Two bodies, as much of them as both hold.
            let [a, b] = two(parts.len(), rng);
            let length = parts[a].body.len().min(parts[b].body.len());
            let (first, second) = parts.split_at_mut(b);
            first[a].body[..length].swap_with_slice(&mut second[0].body[..length]);
        }
        5 => {
            // A piece of one section in another, and of another in a third.
            for _ in 0..2 {
                let [a, b] = two(parts.len(), rng);
                copy_piece(&mut parts, a, b, rng);
            }
        }
        6 => {
            for _ in 0..pick(&[1, 2, 4], rng) {
                let k = rng.random_range(0..parts.len());
                let value = pick(&[0, 1, 0x7f, 0x80, 0xff], rng);
                parts[k].body.fill(value);
            }
        }
        7 => {
            let [a, b] = two(parts.len(), rng);
            match rng.random_range(0..4) {
                0 => parts.swap(a, b),
                1 => drop(parts.remove(a)),
                2 => parts.insert(b, parts[a].clone()),
                _ => parts[a].body.clear(),
            }
        }
        8 => {
            let k = rng.random_range(0..parts.len());
            let field = pick(&[0, 4, 28], rng); // kind, layout, required
            let value = pick(
                &[*b"XTRA", *b"ROWS", [0; 4], [1, 0, 0, 0], [2, 0, 0, 0]],
                rng,
            );
            put(&mut parts[k].record, field, &value);
        }
        _ => return displaced(sound, rng),
    }
    put_together(sound, parts)
}

/// Two different indices, ascending.
fn two(count: usize, rng: &mut Pcg64Mcg) -> [usize; 2] {
    let a = rng.random_range(0..count - 1);
    [a, rng.random_range(a + 1..count)]
}

fn copy_piece(parts: &mut [Part], from: usize, to: usize, rng: &mut Pcg64Mcg) {
    let longest = parts[from].body.len().min(parts[to].body.len());
    if longest == 0 {
        return;
    }
    let length = rng.random_range(1..=longest);
    let start = rng.random_range(0..=parts[from].body.len() - length);
    let piece = parts[from].body[start..start + length].to_vec();
    let at = rng.random_range(0..=parts[to].body.len() - length);
    parts[to].body[at..at + length].copy_from_slice(&piece);
}

/// A section that says it stands elsewhere: on another, in a gap, behind the end.
fn displaced(sound: &AlignedBytes, rng: &mut Pcg64Mcg) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    let count = get_u32(&bytes, offset_of!(Header, section_count)) as usize;
    let at = |k: usize| table(&bytes) + k * size_of::<SectionRecord>();
    let [a, b] = two(count, rng).map(at);
    let offset = offset_of!(SectionRecord, offset);
    let value = match rng.random_range(0..4) {
        0 => get_u32(&bytes, b + offset),
        1 => get_u32(&bytes, a + offset).wrapping_add(64),
        2 => bytes.len() as u32,
        _ => 0,
    };
    let from = pick(&[a, b], rng);
    put(&mut bytes, from + offset, &value.to_le_bytes());
    if rng.random_bool(0.5) {
        let length = pick(&[0, 64, value, u32::MAX], rng);
        let at = from + offset_of!(SectionRecord, length);
        put(&mut bytes, at, &length.to_le_bytes());
    }
    bytes
}

/// Element bytes of what is cut or grown, and where its count stands in the header.
struct Counted {
    /// Sections that have so many elements, or one more, with bytes per element.
    sections: &'static [(SectionKind, usize)],
    count: Option<usize>,
}

const COUNTED: [Counted; 8] = [
    Counted {
        sections: &[(SectionKind::NODES, size_of::<NodeRecord>())],
        count: Some(offset_of!(Header, node_count)),
    },
    Counted {
        sections: &[
            (SectionKind::TRIANGLES, size_of::<TriangleRecord>()),
            (SectionKind::TRIANGLE_SLOTS, 4),
        ],
        count: Some(offset_of!(Header, triangle_count)),
    },
    // DISP too, where it holds all modes: see `resize`.
    Counted {
        sections: &[
            (SectionKind::POSITIONS, 12),
            (SectionKind::VERTEX_MODES, size_of::<VertexModes>()),
        ],
        count: Some(offset_of!(Header, vertex_count)),
    },
    Counted {
        sections: &[(SectionKind::ROWS, size_of::<Row>())],
        count: None,
    },
    Counted {
        sections: &[(SectionKind::MODE_LISTS, 2)],
        count: None,
    },
    Counted {
        sections: &[(SectionKind::DISPLACEMENTS, 12)],
        count: None,
    },
    Counted {
        sections: &[(SectionKind::GROUP_NAMES, 1)],
        count: None,
    },
    Counted {
        sections: &[(SectionKind::METADATA, 1)],
        count: None,
    },
];

/// Cuts elements off or adds some, everywhere where they are counted.
fn resize(sound: &AlignedBytes, mut parts: Vec<Part>, rng: &mut Pcg64Mcg) -> Vec<u8> {
    let modes = get_u32(sound, offset_of!(Header, mode_count)) as usize;
    let listed = parts.iter().any(|p| p.kind() == SectionKind::VERTEX_MODES);
    let which = rng.random_range(0..COUNTED.len() + 1);
    let share = rng.random_range(0.0..1.3);
    let Some(counted) = COUNTED.get(which) else {
        // Frames: a number per mode in FRMQ for each.
        for part in &mut parts {
            let element = match part.kind() {
                SectionKind::FRAMES => size_of::<FrameRecord>(),
                SectionKind::FRAME_Q => 4 * modes,
                _ => continue,
            };
            resize_body(&mut part.body, element, share);
        }
        return put_together(sound, parts);
    };
    let mut bytes_of = counted.sections.to_vec();
    if which == 2 && !listed {
        bytes_of.push((SectionKind::DISPLACEMENTS, 12 * modes));
    }
    let count = counted.count.map(|at| (at, get_u32(sound, at)));
    for part in &mut parts {
        let Some((kind, element)) = bytes_of.iter().find(|(kind, _)| *kind == part.kind()) else {
            continue;
        };
        match count {
            Some((_, count)) => {
                let more = usize::from(*kind == SectionKind::VERTEX_MODES);
                let elements = resized(count as usize, share) + more;
                grow(&mut part.body, elements * element);
            }
            None => resize_body(&mut part.body, *element, share),
        }
    }
    let mut bytes = put_together(sound, parts);
    if let Some((at, count)) = count {
        put(
            &mut bytes,
            at,
            &(resized(count as usize, share) as u32).to_le_bytes(),
        );
    }
    debug_assert!(record(&bytes, SectionKind::NODES) > 0);
    bytes
}

fn resized(count: usize, share: f64) -> usize {
    ((count as f64 * share) as usize).max(1)
}

fn resize_body(body: &mut Vec<u8>, element: usize, share: f64) {
    if let Some(elements) = body.len().checked_div(element) {
        grow(body, resized(elements, share) * element);
    }
}

/// Cuts a body, or repeats it from the start.
fn grow(body: &mut Vec<u8>, length: usize) {
    let old = body.len();
    body.truncate(length);
    for k in body.len()..length {
        body.push(if old == 0 { 0 } else { body[k % old] });
    }
}
