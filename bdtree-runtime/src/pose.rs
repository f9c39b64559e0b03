//! A pose: q and a placement, prepared once per instance and step.

use crate::bound::BoundPose;
use crate::error::PoseError;
use crate::frame::{Frame, rotation_matrix};
use crate::math::{add, dot, scale, sqrt};
use crate::view::Asset;

/// Unit roundoff of f32: 2⁻²⁴.
pub(crate) const U32: f64 = 1.0 / (1_u64 << 24) as f64;

/// Smaller shares of a limit than 2⁻¹⁰⁰ are left out of node bounds and their reach is added to
/// every radius instead: so no product or sum of the kernel is subnormal (docs/guarantees.md).
const SHARE_MIN: f32 = f32::from_bits((127 - 100) << 23);

/// Where an instance stands: `x = rotation · (scale · x_mesh) + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Unit quaternion (x, y, z, w); the identity is (0, 0, 0, 1).
    pub rotation: [f64; 4],
    /// World units.
    pub translation: [f64; 3],
    /// World units per mesh unit.
    pub scale: f64,
}

impl Transform {
    /// World and mesh coordinates are the same.
    pub const IDENTITY: Self = Self {
        rotation: [0.0, 0.0, 0.0, 1.0],
        translation: [0.0; 3],
        scale: 1.0,
    };

    /// The placement that does what `first` does and then what `self` does: an instance of a frame
    /// that has its own rigid motion stands at `place.after(frame.transform())`.
    ///
    /// # Errors
    /// What [`Pose::new`] refuses of a placement: of either one, or of both together.
    pub fn after(self, first: Self) -> Result<Self, PoseError> {
        let (outer, inner) = (self.checked()?, first.checked()?);
        let turned = rotation_matrix(outer.rotation).map(|row| dot(row, inner.translation));
        let ([x, y, z, w], [a, b, c, d]) = (outer.rotation, inner.rotation);
        Self {
            rotation: [
                w * a + x * d + y * c - z * b,
                w * b - x * c + y * d + z * a,
                w * c + x * b - y * a + z * d,
                w * d - x * a - y * b - z * c,
            ],
            translation: add(outer.translation, scale(turned, outer.scale)),
            scale: outer.scale * inner.scale,
        }
        .checked()
    }

    /// The transform with its quaternion normalised in f64.
    ///
    /// # Errors
    /// A quaternion whose norm is off by more than 1e-3, a translation that is not finite or
    /// beyond 2^80, a scale outside 2^-60 … 2^60.
    fn checked(self) -> Result<Self, PoseError> {
        const TRANSLATION_MAX: f64 = (1_u128 << 80) as f64;
        const SCALE_MAX: f64 = (1_u64 << 60) as f64;
        let [x, y, z, w] = self.rotation;
        let norm = sqrt(x * x + y * y + z * z + w * w);
        if !((norm - 1.0).abs() <= 1e-3) {
            return Err(PoseError::Rotation);
        }
        if !self.translation.iter().all(|t| t.abs() <= TRANSLATION_MAX) {
            return Err(PoseError::Translation);
        }
        if !(1.0 / SCALE_MAX..=SCALE_MAX).contains(&self.scale) {
            return Err(PoseError::Scale);
        }
        Ok(Self {
            rotation: self.rotation.map(|c| c / norm),
            ..self
        })
    }
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// q and a placement, checked, with the rounding terms that every node bound shares.
///
/// Borrows the caller's memory for q; make one per instance and step.
#[derive(Debug, Clone, Copy)]
pub struct Pose<'p> {
    /// q with subnormal entries set to 0 (deviation from the source's q: below 2⁻¹²⁶).
    pub(crate) q: &'p [f32],
    /// q_j over its limit, which is a power of two; those below [`SHARE_MIN`] are 0.
    pub(crate) share: &'p [f32],
    /// Added to every radius: covers the f32 evaluation of centres, radii and vertices
    /// (docs/guarantees.md, slack; stored units).
    pub(crate) slack: f32,
    /// γ' = (2M + 16) u: times T² it is added under the root (docs/guarantees.md).
    pub(crate) gamma: f32,
    /// B = P + S(q): no deformed vertex and no lane centre is farther from the origin
    /// (stored units, before rounding).
    pub(crate) reach: f64,
    pub(crate) frame: Frame,
    /// Identifies the asset: the address at which its bytes start (a number, so that poses may
    /// cross threads) and their header's checksum, since another file may come to lie there.
    asset: (usize, u32),
}

impl<'p> Pose<'p> {
    /// Prepares q for an asset at a placement. `memory` needs [`Asset::pose_len`] numbers.
    ///
    /// # Errors
    /// q of another length than the asset has modes, NaN, infinite or over the asset's hard
    /// limit; memory too short; a placement that [`Transform`] does not allow.
    pub fn new(
        asset: &Asset<'_>,
        q: &[f32],
        transform: Transform,
        memory: &'p mut [f32],
    ) -> Result<Self, PoseError> {
        let modes = asset.modes();
        if q.len() != modes.len() {
            return Err(PoseError::ModeCount {
                expected: modes.len(),
                found: q.len(),
            });
        }
        let (needed, found) = (asset.pose_len(), memory.len());
        let Some((memory, share)) = memory
            .get_mut(..needed)
            .and_then(|memory| memory.split_at_mut_checked(q.len()))
        else {
            return Err(PoseError::Memory { needed, found });
        };
        // S(q) = Σ W_j |q_j|, and what of it the modes have that nodes leave out.
        let (mut s, mut left_out) = (0.0, 0.0);
        let out = memory.iter_mut().zip(share.iter_mut());
        for (mode, ((q, record), (out, share))) in q.iter().zip(modes).zip(out).enumerate() {
            if !q.is_finite() {
                return Err(PoseError::NotFinite { mode });
            }
            let limit = record.q_limit.get();
            if q.abs() > limit {
                return Err(PoseError::OverLimit {
                    mode,
                    found: q.abs(),
                    limit,
                });
            }
            let q = if q.abs() < f32::MIN_POSITIVE { 0.0 } else { *q };
            let reach = f64::from(record.field_norm_max.get()) * f64::from(q.abs());
            s += reach;
            // Both are exact: limits are powers of two.
            let of_limit = q * (1.0 / limit);
            let small = of_limit.abs() < SHARE_MIN;
            left_out += if small { reach } else { 0.0 };
            *share = if small { 0.0 } else { of_limit };
            *out = q;
        }
        let transform = transform.checked()?;
        let p = f64::from(asset.header().position_norm_max.get());
        let mode_count = modes.len() as f64;
        Ok(Self {
            q: memory,
            share,
            slack: round_up(slack(p, s, mode_count) + left_out),
            gamma: round_up((2.0 * mode_count + 16.0) * U32),
            reach: p + s,
            frame: Frame::new(asset, &transform),
            asset: identity(asset),
        })
    }

    /// q as the queries use it: the given one with subnormal entries set to 0.
    pub fn q(&self) -> &'p [f32] {
        self.q
    }

    /// What node bounds need of it.
    #[inline(always)]
    pub(crate) fn bound(&self) -> BoundPose<'p> {
        BoundPose {
            share: self.share,
            gamma: self.gamma,
            slack: self.slack,
        }
    }

    /// Whether the pose was made for this asset.
    pub(crate) fn belongs_to(&self, asset: &Asset<'_>) -> bool {
        self.asset == identity(asset)
    }
}

fn identity(asset: &Asset<'_>) -> (usize, u32) {
    let address = asset.bytes().as_ptr() as usize;
    (address, asset.header().header_crc.get())
}

/// `slack(q) = 8u P + (2M + 8) u S + 2⁻⁵⁴` (docs/guarantees.md 3).
fn slack(p: f64, s: f64, mode_count: f64) -> f64 {
    const ABSOLUTE: f64 = 1.0 / (1_u64 << 54) as f64;
    8.0 * U32 * p + (2.0 * mode_count + 8.0) * U32 * s + ABSOLUTE
}

/// An f32 not below `x`, which is not negative and below 2¹²⁰: rounding to nearest loses at
/// most u x, flushing at most 2⁻¹²⁶.
pub(crate) fn round_up(x: f64) -> f32 {
    let up = x * (1.0 + 4.0 * U32);
    (up as f32).max(f32::MIN_POSITIVE)
}
