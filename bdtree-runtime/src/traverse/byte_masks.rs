//! Sets of pairs of lanes: eight bytes of eight bits, byte i and bit j for lane i of one node and lane
//! j of another.

use bdtree_format::LANES;

/// The lowest bit of each byte.
pub(super) const BYTES: u64 = 0x0101_0101_0101_0101;

/// All bits of the bytes that `lanes` names.
#[inline(always)]
pub(super) fn rows(lanes: u8) -> u64 {
    // A copy for each byte, of which it keeps its own bit.
    lowest((u64::from(lanes) * BYTES) & 0x8040_2010_0804_0201) * 0xff
}

/// The bits of `lanes` in each byte.
#[inline(always)]
pub(super) fn columns(lanes: u8) -> u64 {
    u64::from(lanes) * BYTES
}

/// The lowest bit of each byte that is not 0.
#[inline(always)]
pub(super) fn lowest(bytes: u64) -> u64 {
    let low = bytes & (0x7f * BYTES);
    (((low + 0x7f * BYTES) | bytes) >> 7) & BYTES
}

/// A bit for each byte: its lowest.
#[inline(always)]
pub(super) fn gather(bytes: u64) -> u8 {
    // The sum puts the lowest bit of byte k at bit 56 + k; no two meet.
    ((bytes & BYTES).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}

/// The bits that any byte has.
#[inline(always)]
pub(super) fn any_row(bytes: u64) -> u8 {
    let half = bytes | bytes >> 32;
    let quarter = half | half >> 16;
    (quarter | quarter >> 8) as u8
}

/// The lowest of a set of pairs of lanes.
#[inline(always)]
pub(super) fn lane_pair(pairs: u64) -> (usize, usize) {
    let bit = pairs.trailing_zeros() as usize;
    ((bit / 8) & (LANES - 1), bit & (LANES - 1))
}

#[cfg(test)]
mod tests {
    use super::{any_row, columns, gather, lowest, rows};

    #[test]
    fn byte_masks_are_what_their_bits_say() {
        for lanes in 0..=u8::MAX {
            let bit = |k: usize| lanes & (1 << k) != 0;
            for (i, byte) in rows(lanes).to_le_bytes().into_iter().enumerate() {
                assert_eq!(byte, if bit(i) { 0xff } else { 0 });
            }
            assert_eq!(columns(lanes).to_le_bytes(), [lanes; 8]);
            assert_eq!(gather(lowest(rows(lanes))), lanes);
            let bytes = [0, 1, 2, 3, 4, 5, 6, 7].map(|k| if bit(k) { 1_u8 << (k ^ 3) } else { 0 });
            let packed = u64::from_le_bytes(bytes);
            assert_eq!(gather(lowest(packed)), lanes);
            assert_eq!(
                any_row(packed),
                bytes.iter().fold(0, |all, byte| all | byte)
            );
        }
    }
}
