//! Stretches and reaches of eight bones side by side, in f32: half the time of four in f64, where f32 has the range.

use bdtree_format::LANES;

use super::BoneMap;
use crate::rounding::{STRETCH, STRETCH_FLUSHED, round_up};
use crate::simd::Lanes;

/// Largest ρ_b, and least largest σ_b: beyond, products of four elements may leave what f32 holds, or be less than what
/// flushing takes.
const REACH_MAX: f32 = (1_u64 << 60) as f32;
const STRETCH_MIN: f32 = 1.0 / 1024.0;

/// Sets the stretch of each map; the largest ρ_b and σ_b. `None` where f32 has not the range for them, or where a map is
/// not finite: nothing is known then.
#[inline(always)]
pub(super) fn reach<L: Lanes>(maps: &mut [BoneMap], within: f64) -> Option<(f64, f32)> {
    let last = maps.len().checked_sub(1)?;
    let within = L::splat(round_up(within));
    let (up, flushed) = (L::splat(STRETCH), L::splat(STRETCH_FLUSHED));
    let limit = L::splat(REACH_MAX);
    let (mut farthest, mut largest) = (L::splat(0.0), L::splat(0.0));
    let mut first = 0;
    while first <= last {
        let mut eight = [&maps[last]; LANES];
        for k in 0..LANES {
            eight[k] = &maps[(first + k).min(last)];
        }
        let [x, y, z, t] = columns::<L>(eight);
        let stretch = stretch_square([x, y, z]).sqrt().mul(up).add(flushed);
        let offset = dot(t, t).sqrt();
        let rho = stretch.mul(within).add(offset).mul(up).add(flushed);
        // NaN is not below.
        if limit.above(rho) != u8::MAX {
            return None;
        }
        (farthest, largest) = (farthest.max(rho), largest.max(stretch));
        let stretch = stretch.store();
        for k in 0..LANES {
            maps[(first + k).min(last)].stretch = stretch[k];
        }
        first += LANES;
    }
    let farthest = farthest.store().into_iter().fold(0.0, f32::max);
    let largest = largest.store().into_iter().fold(0.0, f32::max);
    (largest >= STRETCH_MIN).then_some((farthest.into(), largest))
}

/// The columns of the maps of eight bones.
#[inline(always)]
pub(crate) fn columns<L: Lanes>([a, b, c, d, e, f, g, h]: [&BoneMap; LANES]) -> [[L; 3]; 4] {
    let mut columns = [[L::splat(0.0); 3]; 4];
    for r in 0..3 {
        // Spelled out: behind a closure it would not be compiled with the instruction set of the caller.
        let entries = L::columns([
            &a.rows[r], &b.rows[r], &c.rows[r], &d.rows[r], &e.rows[r], &f.rows[r], &g.rows[r],
            &h.rows[r],
        ]);
        for k in 0..4 {
            columns[k][r] = entries[k];
        }
    }
    columns
}

#[inline(always)]
fn dot<L: Lanes>(a: [L; 3], b: [L; 3]) -> L {
    a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]))
}

/// σ² of eight maps, as [`super::four`] has it; up to 50u less by rounding.
#[inline(always)]
fn stretch_square<L: Lanes>([x, y, z]: [[L; 3]; 3]) -> L {
    /// √⅔, from above.
    const SHARE: f32 = 0.816_496_6;
    let square = [dot(x, x), dot(y, y), dot(z, z)];
    let mixed = [dot(x, y), dot(y, z), dot(z, x)];
    let mean = square[0].add(square[1]).add(square[2]);
    let mean = mean.mul(L::splat(1.0 / 3.0));
    let off = [
        square[0].sub(mean),
        square[1].sub(mean),
        square[2].sub(mean),
    ];
    let spread = dot(off, off).add(L::splat(2.0).mul(dot(mixed, mixed)));
    mean.add(L::splat(SHARE).mul(spread.sqrt()))
}
