//! Mutations of binary files: whole numbers and floats at known and random places, blocks.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::text::{SIZE_MAX, some_index, splice};

/// Which end of a number comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Endian {
    Little,
    Big,
}

impl Endian {
    fn put(self, bytes: &mut [u8], at: usize, value: u32) {
        let value = match self {
            Self::Little => value.to_le_bytes(),
            Self::Big => value.to_be_bytes(),
        };
        if let Some(place) = bytes.get_mut(at..at + 4) {
            place.copy_from_slice(&value);
        }
    }

    fn get(self, bytes: &[u8], at: usize) -> u32 {
        let four: [u8; 4] = bytes
            .get(at..at + 4)
            .and_then(|b| b.try_into().ok())
            .unwrap_or_default();
        match self {
            Self::Little => u32::from_le_bytes(four),
            Self::Big => u32::from_be_bytes(four),
        }
    }
}

/// A whole number that hurts: extreme, or near `own`.
fn whole(own: u32, rng: &mut Pcg64Mcg) -> u32 {
    let choices = [
        0,
        1,
        2,
        3,
        own.wrapping_add(1),
        own.wrapping_sub(1),
        own.wrapping_mul(2),
        own / 2,
        own.swap_bytes(),
        0x10000,
        0x5555_5556,
        i32::MAX as u32,
        1 << 31,
        (1 << 31) + 1,
        u32::MAX - 1,
        u32::MAX,
    ];
    choices[rng.random_range(0..choices.len())]
}

/// A float that hurts, as bits.
fn float(rng: &mut Pcg64Mcg) -> u32 {
    let choices = [
        0.0,
        -0.0,
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        f32::MIN_POSITIVE,
        f32::from_bits(1),
        1e-20,
        1e20,
        1e30,
        1.0,
    ];
    choices[rng.random_range(0..choices.len())].to_bits()
}

/// Changes one thing; `fields` are the places of the header's numbers.
pub(super) fn change(
    bytes: &mut Vec<u8>,
    fields: &[usize],
    endian: Endian,
    other: &[u8],
    rng: &mut Pcg64Mcg,
) {
    match rng.random_range(0..20) {
        0..3 => {
            if let Some(k) = some_index(fields.len(), rng) {
                let value = whole(endian.get(bytes, fields[k]), rng);
                endian.put(bytes, fields[k], value);
            }
        }
        3 => {
            // Two counts exchanged, or one doubled and another halved: the size stays right.
            let (Some(a), Some(b)) = (some_index(fields.len(), rng), some_index(fields.len(), rng))
            else {
                return;
            };
            let (a, b) = (fields[a], fields[b]);
            let (x, y) = (endian.get(bytes, a), endian.get(bytes, b));
            if rng.random_range(0..2) == 0 {
                endian.put(bytes, a, y);
                endian.put(bytes, b, x);
            } else {
                endian.put(bytes, a, x.wrapping_mul(2));
                endian.put(bytes, b, y / 2);
            }
        }
        4..12 => {
            // One float, or a run of them.
            let count = bytes.len() / 4;
            if let Some(k) = some_index(count, rng) {
                let value = float(rng);
                for i in k..(k + [1, 1, 3, 64][rng.random_range(0..4)]).min(count) {
                    endian.put(bytes, 4 * i, value);
                }
            }
        }
        12..15 => {
            if let Some(k) = some_index(bytes.len(), rng) {
                bytes[k] ^= 1 << rng.random_range(0..8);
            }
        }
        15 => bytes.truncate(rng.random_range(0..=bytes.len())),
        16 => {
            let more = rng.random_range(1..=64);
            bytes.resize(bytes.len() + more, [0, 0xff][rng.random_range(0..2)]);
        }
        17 => splice(bytes, other, rng),
        18 => {
            let from = rng.random_range(0..=bytes.len());
            let to = rng.random_range(from..=bytes.len());
            if bytes.len() < SIZE_MAX / 2 {
                let part = bytes[from..to].to_vec();
                bytes.splice(from..from, part);
            }
        }
        _ => {
            let from = rng.random_range(0..=bytes.len());
            let to = rng.random_range(from..=bytes.len().min(from + 64));
            bytes.drain(from..to);
        }
    }
}
