//! Lanes in the order of their keys with AVX2: one network sorts eight of them.
#![allow(unsafe_code)] // intrinsics; every block has its proof

use bdtree_format::Row;
use core::arch::x86_64::{
    __m256i, _mm_loadl_epi64, _mm256_and_si256, _mm256_andnot_si256, _mm256_blend_epi32,
    _mm256_blendv_epi8, _mm256_cmpeq_epi32, _mm256_cvtepu8_epi32, _mm256_loadu_si256,
    _mm256_max_epi32, _mm256_min_epi32, _mm256_or_si256, _mm256_permute4x64_epi64,
    _mm256_permutevar8x32_epi32, _mm256_set1_epi32, _mm256_setr_epi32, _mm256_shuffle_epi32,
    _mm256_srai_epi32, _mm256_srli_epi32, _mm256_storeu_si256, _mm256_xor_si256,
};

use super::order::{LANE_BITS, Order};

/// The lanes' numbers, in the last bits of eight numbers of 32 bits. Exists only where [`super::avx8`] does its work, so wherever
/// the processor has AVX2.
#[derive(Clone, Copy)]
pub(super) struct AvxOrder(__m256i);

/// One layer of a sorting network: each number is compared with the one that `$partner` brings, and the lanes of `$less` keep
/// the lesser.
macro_rules! layer {
    ($numbers:ident, $partner:expr, $less:literal) => {
        // SAFETY: needs AVX2; see `AvxOrder`.
        let partner = unsafe { $partner };
        // SAFETY: as above.
        let greater = unsafe { _mm256_max_epi32($numbers, partner) };
        // SAFETY: as above.
        let lesser = unsafe { _mm256_min_epi32($numbers, partner) };
        // SAFETY: as above.
        $numbers = unsafe { _mm256_blend_epi32::<$less>(greater, lesser) };
    };
}

/// The numbers of a register in an order.
#[inline(always)]
fn permuted(numbers: __m256i, order: AvxOrder) -> [u32; 8] {
    // Only the last three bits of each lane's number count.
    // SAFETY: needs AVX2; see `AvxOrder`.
    let numbers = unsafe { _mm256_permutevar8x32_epi32(numbers, order.0) };
    let mut out = [0; 8];
    // SAFETY: needs AVX, see `AvxOrder`; `out` is 32 writable bytes, any alignment will do.
    unsafe { _mm256_storeu_si256(out.as_mut_ptr().cast(), numbers) };
    out
}

impl Order for AvxOrder {
    // Whole numbers that are ordered as the keys, with the lanes' numbers in their last bits, go through a bitonic network.
    #[inline(always)]
    fn new(keys: &Row, among: u8) -> Self {
        // SAFETY: needs AVX, see `AvxOrder`; a `Row` is 32 readable bytes, any alignment will do.
        let bits = unsafe { _mm256_loadu_si256(keys.as_ptr().cast()) };
        // Of a negative number larger bits are less.
        // SAFETY: needs AVX2; see `AvxOrder`.
        let negative = unsafe { _mm256_srai_epi32::<31>(bits) };
        // SAFETY: as above.
        let turned = unsafe { _mm256_srli_epi32::<1>(negative) };
        // SAFETY: as above.
        let ordered = unsafe { _mm256_xor_si256(bits, turned) };
        // SAFETY: as above.
        let lanes = unsafe { _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7) };
        // SAFETY: as above.
        let last = unsafe { _mm256_set1_epi32(LANE_BITS) };
        // SAFETY: as above.
        let rounded = unsafe { _mm256_andnot_si256(last, ordered) };
        // SAFETY: as above.
        let ranks = unsafe { _mm256_or_si256(rounded, lanes) };
        // SAFETY: as above.
        let bit = unsafe { _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128) };
        // SAFETY: as above.
        let all = unsafe { _mm256_set1_epi32(i32::from(among)) };
        // SAFETY: as above.
        let its = unsafe { _mm256_and_si256(all, bit) };
        // SAFETY: as above.
        let is_among = unsafe { _mm256_cmpeq_epi32(its, bit) };
        // SAFETY: as above.
        let least = unsafe { _mm256_set1_epi32(i32::MIN) };
        // SAFETY: as above.
        let mut numbers = unsafe { _mm256_blendv_epi8(least, ranks, is_among) };
        layer!(
            numbers,
            _mm256_shuffle_epi32::<0b10_11_00_01>(numbers),
            0xaa
        );
        layer!(
            numbers,
            _mm256_shuffle_epi32::<0b00_01_10_11>(numbers),
            0xcc
        );
        layer!(
            numbers,
            _mm256_shuffle_epi32::<0b10_11_00_01>(numbers),
            0xaa
        );
        layer!(
            numbers,
            _mm256_permute4x64_epi64::<0b01_00_11_10>(_mm256_shuffle_epi32::<0b00_01_10_11>(
                numbers
            )),
            0xf0
        );
        layer!(
            numbers,
            _mm256_shuffle_epi32::<0b01_00_11_10>(numbers),
            0xcc
        );
        layer!(
            numbers,
            _mm256_shuffle_epi32::<0b10_11_00_01>(numbers),
            0xaa
        );
        Self(numbers)
    }

    #[inline(always)]
    fn numbers(self, of: &[u32; 8]) -> [u32; 8] {
        // SAFETY: needs AVX, see `AvxOrder`; `of` is 32 readable bytes, any alignment will do.
        permuted(unsafe { _mm256_loadu_si256(of.as_ptr().cast()) }, self)
    }

    #[inline(always)]
    fn bytes(self, of: &[u8; 8]) -> [u32; 8] {
        // SAFETY: SSE2 is part of x86-64; `of` is eight readable bytes, any alignment will do.
        let bytes = unsafe { _mm_loadl_epi64(of.as_ptr().cast()) };
        // SAFETY: needs AVX2; see `AvxOrder`.
        permuted(unsafe { _mm256_cvtepu8_epi32(bytes) }, self)
    }
}
