//! A pose: q and a placement, prepared once per instance and step.

use bdtree_format::{ModeRecord, ROW_RADIUS};
use zerocopy::{FromBytes, IntoBytes};

use crate::bound::BoundPose;
use crate::error::PoseError;
use crate::math::sqrt;
use crate::placement::Placement;
use crate::quantized_q::{Given, Memory, QuantizedQ};
use crate::rounding::{COARSE, round_up, slack};
use crate::transform::Transform;
use crate::view::Asset;

/// About the radius of spheres above leaves of four triangles (stored units): the root's spheres,
/// each a piece of surface, cut into as many pieces as make leaves.
fn leaf_radius(asset: &Asset<'_>) -> f64 {
    let Some(root) = asset.nodes.first() else {
        return 0.0;
    };
    let Ok(rows) = asset.node_rows(root) else {
        return 0.0; // the first visit says so
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for (lane, radius) in rows.leading[ROW_RADIUS].iter().enumerate() {
        if (root.leaf_mask | root.inner_mask) & (1 << lane) != 0 {
            sum += f64::from(*radius);
            count += 1.0;
        }
    }
    // sum / count · √(4 count / F)
    2.0 * sum / sqrt(count * asset.triangle_count() as f64).max(1.0)
}

/// q and a placement, checked, with the rounding terms that every node bound shares.
///
/// Borrows the caller's memory for q; make one per instance and step.
#[derive(Debug, Clone, Copy)]
pub struct Pose<'p> {
    /// q with subnormal entries set to 0 (deviation from the source's q: below 2⁻¹²⁶).
    pub(crate) q: &'p [f32],
    /// q̃, for node bounds.
    quantized: QuantizedQ<'p>,
    /// Added to every radius: covers the f32 evaluation of centres, radii and vertices, and what q̃
    /// differs from q (docs/guarantees.md, slack; stored units).
    pub(crate) slack: f32,
    /// B = P + S: no deformed vertex and no lane centre is farther from the origin
    /// (stored units, before rounding).
    pub(crate) reach: f64,
    pub(crate) placement: Placement,
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
        Self::with_tolerance(asset, q, transform, 0.0, memory)
    }

    /// A pose whose node bounds leave out the modes that matter least: two by two, in the order of
    /// the asset, as long as those left out move no vertex by more than `tolerance` together (world
    /// units). Spheres become larger by what they move. Queries answer as they do for
    /// [`Pose::new`], since triangles have all modes; they visit more nodes, each of which costs
    /// less.
    ///
    /// # Errors
    /// Those of [`Pose::new`]; a tolerance that is NaN or negative.
    pub fn with_tolerance(
        asset: &Asset<'_>,
        q: &[f32],
        transform: Transform,
        tolerance: f64,
        memory: &'p mut [f32],
    ) -> Result<Self, PoseError> {
        let modes = asset.modes();
        if q.len() != modes.len() {
            return Err(PoseError::ModeCount {
                expected: modes.len(),
                found: q.len(),
            });
        }
        if !(tolerance >= 0.0) {
            return Err(PoseError::Tolerance);
        }
        let (needed, found) = (asset.pose_len(), memory.len());
        let Some((own, memory)) = memory
            .get_mut(..needed)
            .and_then(|memory| split(memory, q.len()))
        else {
            return Err(PoseError::Memory { needed, found });
        };
        // S(q) = Σ W_j |q_j|.
        let mut s = 0.0;
        for (mode, ((q, record), out)) in q.iter().zip(modes).zip(own.iter_mut()).enumerate() {
            let q = checked_q(mode, *q, record)?;
            s += f64::from(record.field_norm_max.get()) * f64::from(q.abs());
            *out = q;
        }
        let transform = transform.checked()?;
        let placement = Placement::new(asset, &transform);
        let p = f64::from(asset.header().position_norm_max.get());
        let given = Given { modes, q: own };
        let coarse = COARSE * leaf_radius(asset);
        let (shares, left_out) =
            given.round(tolerance / placement.world_per_stored(), coarse, memory);
        // q̃ may reach farther than q by what the two differ.
        let s = s + left_out;
        Ok(Self {
            q: own,
            quantized: shares,
            slack: round_up(slack(p, s, modes.len() as f64) + left_out),
            reach: p + s,
            placement,
            asset: identity(asset),
        })
    }

    /// q as the queries use it: the given one with subnormal entries set to 0.
    pub fn q(&self) -> &'p [f32] {
        self.q
    }

    /// Modes that node bounds take into account: what the others move is in [`Pose::slack`].
    pub fn active_modes(&self) -> usize {
        let pairs = self.quantized.active.iter();
        let in_pair = |k: &u32| (self.q.len() - 2 * *k as usize).min(2);
        pairs.map(in_pair).sum()
    }

    /// By how much every sphere is larger than its formula says, in world units: rounding, modes
    /// left out, and q rounded for node bounds.
    pub fn slack(&self) -> f64 {
        f64::from(self.slack) * self.placement.world_per_stored()
    }

    /// What node bounds need of it.
    #[inline(always)]
    pub(crate) fn bound(&self) -> BoundPose<'p> {
        BoundPose {
            quantized: self.quantized,
            slack: self.slack,
        }
    }

    /// A number that tells poses of an asset apart by what node spheres depend on.
    pub(crate) fn fingerprint(&self) -> u64 {
        let (address, crc) = self.asset;
        let words = [
            address as u64,
            u64::from(crc),
            u64::from(self.slack.to_bits()),
        ];
        let q = self.q.iter().map(|q| u64::from(q.to_bits()));
        hashed(words.into_iter().chain(q))
    }

    /// [`Pose::fingerprint`] of q and placement.
    pub(crate) fn placed_fingerprint(&self) -> u64 {
        let placement = self.placement.numbers().map(f64::to_bits);
        hashed(core::iter::once(self.fingerprint()).chain(placement))
    }

    /// Whether the pose was made for this asset.
    pub(crate) fn belongs_to(&self, asset: &Asset<'_>) -> bool {
        self.asset == identity(asset)
    }
}

/// FNV-1a over words of 64 bits.
fn hashed(words: impl Iterator<Item = u64>) -> u64 {
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| {
        (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// An entry of q as a pose has it: 0 where it is subnormal.
///
/// # Errors
/// NaN, infinite, or over the mode's hard limit.
#[inline(always)]
pub(crate) fn checked_q(mode: usize, q: f32, record: &ModeRecord) -> Result<f32, PoseError> {
    if !q.is_finite() {
        return Err(PoseError::NotFinite { mode });
    }
    let limit = record.q_limit.get();
    if q.abs() > limit {
        let found = q.abs();
        return Err(PoseError::OverLimit { mode, found, limit });
    }
    Ok(if q.abs() < f32::MIN_POSITIVE { 0.0 } else { q })
}

/// What tells an asset from others: where its bytes start, and its header's checksum.
pub(crate) fn identity(asset: &Asset<'_>) -> (usize, u32) {
    let address = asset.bytes().as_ptr() as usize;
    (address, asset.header().header_crc.get())
}

/// The memory of q and that of its shares.
fn split(memory: &mut [f32], mode_count: usize) -> Option<(&mut [f32], Memory<'_>)> {
    let (q, rest) = memory.split_at_mut_checked(mode_count)?;
    let pairs = rest.len() / 3;
    let (coarse, rest) = rest.split_at_mut_checked(pairs)?;
    let (fine, active) = rest.split_at_mut_checked(pairs)?;
    let shares = Memory {
        coarse: <[[i16; 2]]>::mut_from_bytes(coarse.as_mut_bytes()).ok()?,
        fine: <[[i16; 2]]>::mut_from_bytes(fine.as_mut_bytes()).ok()?,
        active: <[u32]>::mut_from_bytes(active.as_mut_bytes()).ok()?,
    };
    Some((q, shares))
}
