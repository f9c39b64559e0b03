//! Mutations of what wraps text around binary data: GLB and NPY files, taken apart, changed and put
//! together again with sizes that fit, or do not.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;
use serde_json::Value;

use super::binary::{self, Endian};
use super::{json, text};
use bdtree_fixtures::models::gltf::{pack, unpack};

/// Words of NumPy headers.
const NPY_WORDS: [&str; 12] = [
    "'shape': (0, 3, 1000000000000000000), ",
    "'shape': (1, 3, 100000), ",
    "'shape': (18446744073709551615, 18446744073709551615, 2), ",
    "'shape': (), ",
    "'shape': (3,), ",
    "'shape': (1, 2, 3, 4, 5, 6, 7, 8, 9), ",
    "'descr': '>f8', ",
    "'descr': '<f4', ",
    "'descr': '|O', ",
    "'descr': [('x', '<f4')], ",
    "'fortran_order': True, ",
    "'fortran_order': False, ",
];

/// Changes a GLB file; `other` is another one. Both are sound.
pub(super) fn glb(bytes: &[u8], other: &[u8], changes: usize, rng: &mut Pcg64Mcg) -> Vec<u8> {
    let (mut document, mut binary) = unpack(bytes);
    if rng.random_range(0..4) > 0 {
        let (spare, spare_binary) = unpack(other);
        for _ in 0..changes {
            match rng.random_range(0..4) {
                0 => binary::change(&mut binary, &[], Endian::Little, &spare_binary, rng),
                _ => json::change(&mut document, &spare, rng),
            }
        }
    }
    let mut text = json_text(&document, rng);
    if rng.random_range(0..8) == 0 {
        text::change(&mut text, &[], other, rng);
    }
    let mut bytes = pack(&text, &binary);
    if rng.random_range(0..4) == 0 {
        let second = 20 + text.len().next_multiple_of(4);
        let fields = [0, 4, 8, 12, 16, second, second + 4];
        binary::change(&mut bytes, &fields, Endian::Little, other, rng);
    }
    bytes
}

/// The text of a document, sometimes with blanks.
pub(super) fn json_text(document: &Value, rng: &mut Pcg64Mcg) -> Vec<u8> {
    match rng.random_range(0..8) {
        0 => serde_json::to_vec_pretty(document).unwrap_or_default(),
        _ => serde_json::to_vec(document).unwrap_or_default(),
    }
}

/// Changes a sound NPY file of version 1; `other` is another one.
pub(super) fn npy(bytes: &[u8], other: &[u8], changes: usize, rng: &mut Pcg64Mcg) -> Vec<u8> {
    let split = |bytes: &[u8]| {
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        (
            bytes[10..10 + length].to_vec(),
            bytes[10 + length..].to_vec(),
        )
    };
    let (mut header, mut data) = split(bytes);
    let (spare_header, spare) = split(other);
    for _ in 0..changes {
        match rng.random_range(0..4) {
            0 => binary::change(&mut data, &[], Endian::Little, &spare, rng),
            1 => {
                // Before the entry that the file has: the first one counts.
                let word = NPY_WORDS[rng.random_range(0..NPY_WORDS.len())];
                let at = header.len().min(1);
                header.splice(at..at, word.bytes());
            }
            2 => {
                header.truncate(header.len().saturating_sub(60));
                text::change(&mut header, &NPY_WORDS, &spare_header, rng);
            }
            _ => text::change(&mut header, &NPY_WORDS, &spare_header, rng),
        }
    }
    let mut file = b"\x93NUMPY".to_vec();
    match rng.random_range(0..8) {
        0 => {
            file.extend([2, 0]);
            file.extend((header.len() as u32).to_le_bytes());
        }
        1 => {
            file.extend([3, 0]);
            file.extend([u32::MAX, 1 << 31, 7][rng.random_range(0..3)].to_le_bytes());
        }
        _ => {
            file.extend([1, 0]);
            file.extend((header.len().min(0xffff) as u16).to_le_bytes());
        }
    }
    file.extend(header);
    file.extend(data);
    if rng.random_range(0..8) == 0 {
        binary::change(&mut file, &[4, 6, 8], Endian::Little, other, rng);
    }
    file
}
