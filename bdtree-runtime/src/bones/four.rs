//! The arithmetic over all bones of a pose with vectors of four f64: the elements of a row side by side, or four bones.
//!
//! Each number comes from the same operations in the same order with every kernel, one at a time or side by side, so maps
//! and stretches have the same bits everywhere.

use bdtree_format::BoneRecord;

use super::{BoneMap, Frame, REACH_MAX, eight};
use crate::joint::JointMatrix;
use crate::math::dot;
use crate::rounding::{MARGIN, U32, round_up_or_nan};
use crate::simd::{Lanes, Quad, Quad3, Work, dot3, four_of};

/// Sets the rows of `maps` for joints: y ↦ (J V (o + u y) − o) / u (SPEC 7.8). The first bone that has no joint is an
/// error.
pub(super) struct OfJoints<'a> {
    pub(super) frame: Frame,
    pub(super) joints: &'a [JointMatrix],
    pub(super) bones: &'a [BoneRecord],
    pub(super) maps: &'a mut [BoneMap],
}

impl Work for OfJoints<'_> {
    type Output = Result<(), usize>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let stored = Stored::<L::Quad>::new(&self.frame);
        for (bone, (record, map)) in self.bones.iter().zip(self.maps).enumerate() {
            // A joint that a damaged file does not have.
            let Some(joint) = self.joints.get(record.joint.get() as usize) else {
                return Err(bone);
            };
            // V (o + u y), u left out of the linear part, since it goes again in the end.
            let mut inverse_bind = [L::Quad::splat(0.0); 3];
            for r in 0..3 {
                let mut row = [0.0; 4];
                for k in 0..4 {
                    row[k] = record.inverse_bind[r][k].get();
                }
                inverse_bind[r] = stored.with_origin(&row);
            }
            let [a, b, c] = inverse_bind;
            for r in 0..3 {
                let [i, j, k, t] = joint[r];
                let [i, j, k] = [L::Quad::splat(i), L::Quad::splat(j), L::Quad::splat(k)];
                let row = i.mul(a).add(j.mul(b)).add(k.mul(c));
                // Adding −0 changes no bit.
                let row = row.add(L::Quad::splat(-0.0).with_last(t));
                map.rows[r] = stored.row(r, row);
            }
        }
        Ok(())
    }
}

/// Sets the rows of `maps` for skinning matrices, one per bone: y ↦ (K (o + u y) − o) / u.
pub(super) struct OfSkinning<'a> {
    pub(super) frame: Frame,
    pub(super) matrices: &'a [JointMatrix],
    pub(super) maps: &'a mut [BoneMap],
}

impl Work for OfSkinning<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let stored = Stored::<L::Quad>::new(&self.frame);
        for (matrix, map) in self.matrices.iter().zip(self.maps) {
            for r in 0..3 {
                map.rows[r] = stored.row(r, stored.with_origin(&matrix[r]));
            }
        }
    }
}

/// From mesh coordinates to stored ones.
struct Stored<Q> {
    origin: [f64; 3],
    /// False for most assets, of which a pose then takes a fifth less time.
    is_moved: bool,
    /// Of each row 0, 0, 0 and the origin: taking 0 off changes no bit, nor does a factor of 1.
    offsets: [Q; 3],
    factors: Q,
}

impl<Q: Quad> Stored<Q> {
    #[inline(always)]
    fn new(frame: &Frame) -> Self {
        let [x, y, z] = frame.origin;
        let zero = Q::splat(0.0);
        Self {
            origin: frame.origin,
            is_moved: frame.origin != [0.0; 3],
            offsets: [zero.with_last(x), zero.with_last(y), zero.with_last(z)],
            factors: Q::splat(1.0).with_last(frame.per_unit),
        }
    }

    /// A row of the map that moves by the origin first. No number goes through memory that a vector then waits for.
    #[inline(always)]
    fn with_origin(&self, row: &[f64; 4]) -> Q {
        if !self.is_moved {
            return Q::load(row);
        }
        let moved = row[3] + dot([row[0], row[1], row[2]], self.origin);
        Q::load(row).with_last(moved)
    }

    /// A row of a map from [`Frame::origin`] on, to mesh coordinates, as one of stored coordinates: in the nearest f32, 0
    /// where they are subnormal.
    #[inline(always)]
    fn row(&self, r: usize, row: Q) -> [f32; 4] {
        /// Halfway from the largest subnormal number to the least normal one, to which it is rounded.
        const NORMAL: f64 = f32::MIN_POSITIVE as f64 * (1.0 - U32);
        let row = row.sub(self.offsets[r]).mul(self.factors);
        // NaN is not below.
        row.cleared(Q::splat(NORMAL).above(row.abs())).narrow()
    }
}

/// Sets the stretch of each map; the largest ρ_b and σ_b. The first bone whose map is not finite or reaches too far is an
/// error.
pub(super) struct Reach<'a> {
    pub(super) maps: &'a mut [BoneMap],
    pub(super) within: f64,
}

impl Work for Reach<'_> {
    type Output = Result<(f64, f32), usize>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let maps = self.maps;
        if let Some(found) = eight::reach::<L>(maps, self.within) {
            return Ok(found);
        }
        let (within, limit) = (L::Quad::splat(self.within), L::Quad::splat(REACH_MAX));
        let (mut farthest, mut largest) = (L::Quad::splat(0.0), [0.0_f32; 4]);
        let mut first = 0;
        while let Some(four) = four_of(maps.len(), first) {
            let [x, y, z, t] = columns::<L::Quad>(maps, four);
            let unrounded = stretch_square([x, y, z]).sqrt().store();
            let mut stretch = [0.0; 4];
            for k in 0..4 {
                stretch[k] = round_up_or_nan(unrounded[k]);
            }
            let offset = dot3(t, t).sqrt();
            let rho = L::Quad::widen(&stretch).mul(within).add(offset);
            // NaN is not below.
            let sound = L::Quad::bits(limit.at_least(rho));
            if sound != 0b1111 {
                return Err(four[sound.trailing_ones() as usize]);
            }
            farthest = rho.max(farthest);
            for k in 0..4 {
                maps[four[k]].stretch = stretch[k];
                largest[k] = if stretch[k] > largest[k] {
                    stretch[k]
                } else {
                    largest[k]
                };
            }
            first += 4;
        }
        let largest = largest.into_iter().fold(0.0, f32::max);
        Ok((farthest.store().into_iter().fold(0.0, f64::max), largest))
    }
}

/// The columns of the maps of four bones.
#[inline(always)]
pub(crate) fn columns<Q: Quad>(maps: &[BoneMap], four: [usize; 4]) -> [Quad3<Q>; 4] {
    let four = [
        &maps[four[0]],
        &maps[four[1]],
        &maps[four[2]],
        &maps[four[3]],
    ];
    let mut columns = [[Q::splat(0.0); 3]; 4];
    for r in 0..3 {
        let [i, j, k, l] = four;
        let entries = Q::transposed([
            Q::widen(&i.rows[r]),
            Q::widen(&j.rows[r]),
            Q::widen(&k.rows[r]),
            Q::widen(&l.rows[r]),
        ]);
        for c in 0..4 {
            columns[c][r] = entries[c];
        }
    }
    columns
}

/// σ² ≥ ‖A‖₂² of four maps, without an eigenvalue: with s² = tr(AᵀA)/3, σ² = s² + √⅔ ‖AᵀA − s²I‖_F, exact for similarities
/// and for a scale along one axis.
#[inline(always)]
fn stretch_square<Q: Quad>([x, y, z]: [Quad3<Q>; 3]) -> Q {
    /// √⅔, from above.
    const SHARE: f64 = 0.816_496_580_928;
    let square = [dot3(x, x), dot3(y, y), dot3(z, z)];
    let mixed = [dot3(x, y), dot3(y, z), dot3(z, x)];
    // A product is off by 2⁻⁵² of what a quotient is; `MARGIN` is more.
    let mean = square[0].add(square[1]).add(square[2]);
    let mean = mean.mul(Q::splat(1.0 / 3.0));
    let off = [
        square[0].sub(mean),
        square[1].sub(mean),
        square[2].sub(mean),
    ];
    let spread = dot3(off, off).add(Q::splat(2.0).mul(dot3(mixed, mixed)));
    mean.add(Q::splat(SHARE).mul(spread.sqrt()))
        .mul(Q::splat(1.0 + MARGIN))
}

/// How far apart the bones of two poses put the same point, at most, if no point is farther than `within` from the origin:
/// max_b ‖A_b − A'_b‖_F X + ‖t_b − t'_b‖ (stored units, before rounding).
pub(super) struct Apart<'a> {
    pub(super) maps: [&'a [BoneMap]; 2],
    pub(super) within: f64,
}

impl Work for Apart<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let [a, b] = self.maps;
        let within = L::Quad::splat(self.within);
        let mut farthest = L::Quad::splat(0.0);
        let mut first = 0;
        while let Some(four) = four_of(a.len().min(b.len()), first) {
            let [x, y, z, t] = L::Quad::transposed([
                squares(&a[four[0]], &b[four[0]]),
                squares(&a[four[1]], &b[four[1]]),
                squares(&a[four[2]], &b[four[2]]),
                squares(&a[four[3]], &b[four[3]]),
            ]);
            let linear = x.add(y).add(z).sqrt().mul(within);
            farthest = linear.add(t.sqrt()).max(farthest);
            first += 4;
        }
        farthest.store().into_iter().fold(0.0, f64::max)
    }
}

/// The square of the length of each column of the difference of two maps.
#[inline(always)]
fn squares<Q: Quad>(a: &BoneMap, b: &BoneMap) -> Q {
    let mut rows = [Q::splat(0.0); 3];
    // Spelled out: behind a closure it would not be compiled with the instruction set of the caller.
    for r in 0..3 {
        let row = Q::widen(&a.rows[r]).sub(Q::widen(&b.rows[r]));
        rows[r] = row.mul(row);
    }
    rows[0].add(rows[1]).add(rows[2])
}
