//! Damage that knows nothing of the format.

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::{pick, repair};

/// Flips, overwrites, moves or cuts off bytes; every other time checksums are made to fit.
pub(super) fn change(mut bytes: Vec<u8>, rng: &mut Pcg64Mcg) -> Vec<u8> {
    for _ in 0..rng.random_range(1..=4) {
        if bytes.is_empty() {
            break;
        }
        let at = rng.random_range(0..bytes.len());
        let length = pick(&[1, 4, 8, 32, 64, 512], rng).min(bytes.len() - at);
        match rng.random_range(0..8) {
            0..3 => bytes[at] ^= 1 << rng.random_range(0..8),
            3 => bytes[at..at + length].fill(pick(&[0, 0x7f, 0x80, 0xff], rng)),
            4 => rng.fill(&mut bytes[at..at + length]),
            5 => {
                let from = rng.random_range(0..=bytes.len() - length);
                bytes.copy_within(from..from + length, at);
            }
            6 => drop(bytes.splice(at..at, vec![0; length])),
            _ if rng.random_bool(0.3) => bytes.truncate(at),
            _ => drop(bytes.drain(at..at + length)),
        }
    }
    if rng.random_bool(0.5) {
        repair(&mut bytes);
    }
    bytes
}
