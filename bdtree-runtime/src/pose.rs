//! A pose: q and a placement, prepared once per instance and step.

use bdtree_format::ModeRecord;
use zerocopy::{FromBytes, IntoBytes};

#[cfg(feature = "alloc")]
use crate::bones::BoneSlack;
use crate::bones::{
    BoneMap, BoneMatrices, BoneSource, MAP_LEN, PosedBones, bones_apart, hashed_maps,
    hashed_numbers,
};
use crate::bound::BoundPose;
use crate::error::{PoseError, QueryError};
use crate::motion::Motion;
use crate::placement::Placement;
use crate::quantized_q::{Given, Memory, QuantizedQ, Rounded, Rounding};
use crate::rounding::{COARSE, round_up, slack};
use crate::transform::Transform;
use crate::view::Asset;

/// An asset deformed by q and placed in the world: q and placement checked, with the rounding terms that
/// every node bound shares. Queries on it are [`Pose::query`] and [`Pose::against`].
///
/// Borrows its asset and the caller's memory; make one per instance and step with [`Asset::pose`].
/// [`Instance`](crate::Instance) does so by itself.
#[derive(Debug, Clone, Copy)]
pub struct Pose<'p> {
    pub(crate) asset: &'p Asset<'p>,
    /// q with subnormal entries set to 0 (deviation from the source's q: below 2⁻¹²⁶).
    pub(crate) q: &'p [f32],
    /// q̃, for node bounds.
    quantized: QuantizedQ<'p>,
    /// The bones, where the asset has a skin.
    bones: Option<PosedBones<'p>>,
    /// Added to every radius before bones: covers the f32 evaluation of centers, radii and vertices, and what q̃
    /// differs from q (docs/design/guarantees.md, slack; stored units).
    pub(crate) inner_slack: f32,
    /// Added to every radius, at most: the same, and with bones what they add.
    pub(crate) slack: f32,
    /// X = P + S: no vertex and no lane center is farther from the origin before bones (stored units, before rounding).
    inner_reach: f64,
    /// B: no deformed vertex and no lane center is farther from the origin; X without bones.
    pub(crate) reach: f64,
    /// The largest σ_b; 1 without bones.
    pub(crate) stretch: f32,
    pub(crate) placement: Placement,
    /// Tells poses of an asset apart by what node spheres depend on.
    fingerprint: u64,
    /// How far the instance has moved up to this pose, if that is counted.
    pub(crate) motion: Option<Motion>,
}

/// What a pose consists of besides its asset and its memory.
#[cfg(feature = "alloc")]
#[derive(Debug, Clone, Copy)]
pub(crate) struct PoseNumbers {
    inner_slack: f32,
    slack: f32,
    inner_reach: f64,
    reach: f64,
    stretch: f32,
    bone_slack: BoneSlack,
    placement: Placement,
    fingerprint: u64,
    /// λ and ρ of q̃, and how much of the memory for m and for the list of pairs is used.
    scale: f32,
    ratio: f32,
    fine_len: usize,
    active_len: usize,
}

impl Asset<'_> {
    /// The asset at q and a placement, its bones at rest. `memory` needs [`Asset::pose_len`] numbers, of any value.
    ///
    /// # Errors
    /// q of another length than the asset has modes, NaN, infinite or over the asset's hard
    /// limit; memory too short; a placement that [`Transform`] does not allow.
    pub fn pose<'p>(
        &'p self,
        q: &[f32],
        at: impl Into<Transform>,
        memory: &'p mut [f32],
    ) -> Result<Pose<'p>, PoseError> {
        let rest = BoneSource::Matrices(BoneMatrices::Rest);
        self.pose_within(q, rest, at.into(), 0.0, memory)
    }

    /// The asset at q, with its bones where `bones` puts them, and a placement: `p' = Σ_b w_b T_b (p + U q)`.
    ///
    /// # Errors
    /// Those of [`Asset::pose`]; matrices for an asset without a skin, another number of them than it has joints or bones,
    /// one with an element that is not finite or that moves vertices beyond 2⁶⁰ stored units.
    pub fn pose_with_bones<'p>(
        &'p self,
        q: &[f32],
        bones: BoneMatrices<'_>,
        at: impl Into<Transform>,
        memory: &'p mut [f32],
    ) -> Result<Pose<'p>, PoseError> {
        self.pose_within(q, BoneSource::Matrices(bones), at.into(), 0.0, memory)
    }

    /// A pose whose node bounds leave out modes that move no vertex by more than `tolerance` together
    /// (see [`crate::studies::pose_within`]).
    pub(crate) fn pose_within<'p>(
        &'p self,
        q: &[f32],
        bones: BoneSource<'_>,
        at: Transform,
        tolerance: f64,
        memory: &'p mut [f32],
    ) -> Result<Pose<'p>, PoseError> {
        let modes = self.modes();
        if q.len() != modes.len() {
            return Err(PoseError::ModeCount {
                expected: modes.len(),
                found: q.len(),
            });
        }
        if !(tolerance >= 0.0) {
            return Err(PoseError::Tolerance);
        }
        let (needed, found) = (self.pose_len(), memory.len());
        let Some((own, memory, maps)) = memory
            .get_mut(..needed)
            .and_then(|memory| split_mut(memory, q.len(), self.bone_count()))
        else {
            return Err(PoseError::Memory { needed, found });
        };
        for (mode, ((q, record), out)) in q.iter().zip(modes).zip(own.iter_mut()).enumerate() {
            *out = checked_q(mode, *q, record)?;
        }
        let placement = Placement::new(self, &at.checked()?);
        let p = f64::from(self.header().position_norm_max.get());
        let given = Given { modes, q: own };
        // Without modes nothing is rounded.
        let coarse = if modes.is_empty() {
            0.0
        } else {
            COARSE * self.leaf_radius
        };
        let rounding = Rounding {
            given,
            tolerance: tolerance / placement.world_per_stored(),
            coarse,
            memory,
        };
        let Rounded {
            quantized,
            off,
            reach,
        } = self.kernel.run(rounding);
        // S(q) = Σ W_j |q_j|; q̃ may reach farther than q by what the two differ.
        let s = reach + off;
        let inner_slack = round_up(slack(p, s, modes.len() as f64) + off);
        let mut pose = Pose {
            asset: self,
            q: own,
            quantized,
            bones: None,
            inner_slack,
            slack: inner_slack,
            inner_reach: p + s,
            reach: p + s,
            stretch: 1.0,
            placement,
            fingerprint: fingerprint(self, inner_slack, own),
            motion: None,
        };
        if let Some(skin) = &self.skin {
            let within = pose.inner_reach + f64::from(inner_slack);
            let found = bones.map(self, skin, within, maps)?;
            (pose.slack, pose.reach, pose.stretch) = (found.slack_max, found.reach, found.stretch);
            pose.fingerprint = hashed([pose.fingerprint, hashed_maps(maps)].into_iter());
            let slack = found.slack;
            pose.bones = Some(PosedBones { maps, slack });
        } else if bones.are_given() {
            return Err(PoseError::NoSkin);
        }
        Ok(pose)
    }
}

impl<'p> Pose<'p> {
    /// What [`Pose::again`] needs to make it again.
    #[cfg(feature = "alloc")]
    pub(crate) fn numbers(&self) -> PoseNumbers {
        PoseNumbers {
            inner_slack: self.inner_slack,
            slack: self.slack,
            inner_reach: self.inner_reach,
            reach: self.reach,
            stretch: self.stretch,
            bone_slack: self.bones.map_or(BoneSlack::NONE, |bones| bones.slack),
            placement: self.placement,
            fingerprint: self.fingerprint,
            scale: self.quantized.scale,
            ratio: self.quantized.ratio,
            fine_len: self.quantized.fine.len(),
            active_len: self.quantized.active.len(),
        }
    }

    /// The pose of an asset that was made in this memory and had these numbers.
    #[cfg(feature = "alloc")]
    #[inline]
    pub(crate) fn again(
        asset: &'p Asset<'p>,
        numbers: &PoseNumbers,
        memory: &'p [f32],
        motion: Motion,
    ) -> Self {
        let (q, [coarse, fine, active], maps) =
            split(memory, asset.mode_count(), asset.bone_count());
        let bones = asset.skin.as_ref().map(|_| PosedBones {
            maps: <[BoneMap]>::ref_from_bytes(maps.as_bytes()).unwrap_or_default(),
            slack: numbers.bone_slack,
        });
        let fine = fine.get(..numbers.fine_len).unwrap_or_default();
        let active = active.get(..numbers.active_len).unwrap_or_default();
        // The casts between numbers of four bytes cannot fail.
        Self {
            asset,
            q,
            quantized: QuantizedQ {
                coarse: <[[i16; 2]]>::ref_from_bytes(coarse.as_bytes()).unwrap_or_default(),
                fine: <[[i16; 2]]>::ref_from_bytes(fine.as_bytes()).unwrap_or_default(),
                active: <[u32]>::ref_from_bytes(active.as_bytes()).unwrap_or_default(),
                scale: numbers.scale,
                ratio: numbers.ratio,
                mode_count: asset.mode_count(),
            },
            bones,
            inner_slack: numbers.inner_slack,
            slack: numbers.slack,
            inner_reach: numbers.inner_reach,
            reach: numbers.reach,
            stretch: numbers.stretch,
            placement: numbers.placement,
            fingerprint: numbers.fingerprint,
            motion: Some(motion),
        }
    }

    /// Returns this deformation at another placement, without a `Motion`.
    ///
    /// # Errors
    /// A placement that [`Transform`] does not allow.
    pub fn placed(self, at: impl Into<Transform>) -> Result<Self, PoseError> {
        Ok(Self {
            placement: Placement::new(self.asset, &at.into().checked()?),
            motion: None,
            ..self
        })
    }

    /// The same pose with the motion of its instance up to this pose, which
    /// [`PairQuery::front`](crate::PairQuery::front) needs.
    ///
    /// # Errors
    /// [`QueryError::Motion`] if the motion was last advanced to another pose.
    pub fn moving(mut self, motion: &Motion) -> Result<Self, QueryError> {
        if !motion.is_at(&self) {
            return Err(QueryError::Motion);
        }
        self.motion = Some(*motion);
        Ok(self)
    }

    /// The asset.
    pub fn asset(&self) -> &'p Asset<'p> {
        self.asset
    }

    /// q as the queries use it: the given one with subnormal entries set to 0.
    pub fn q(&self) -> &'p [f32] {
        self.q
    }

    /// The bones, where the asset has a skin.
    #[inline(always)]
    pub(crate) fn bones(&self) -> Option<&PosedBones<'p>> {
        self.bones.as_ref()
    }

    /// How much farther apart the bones of another pose of the same asset put any point, at most (stored units).
    pub(crate) fn bones_apart(&self, other: &Pose<'_>) -> f64 {
        let (Some(own), Some(others)) = (&self.bones, &other.bones) else {
            return 0.0;
        };
        bones_apart(
            self.asset.kernel,
            [own.maps, others.maps],
            self.inner_reach + f64::from(self.inner_slack),
        )
    }

    /// Modes that node bounds take into account: all but those that are 0, or were left out.
    pub fn active_modes(&self) -> usize {
        let pairs = self.quantized.active.iter();
        let in_pair = |k: &u32| (self.q.len() - 2 * *k as usize).min(2);
        pairs.map(in_pair).sum()
    }

    /// True if no mode enters node bounds.
    pub(crate) fn bounds_at_rest(&self) -> bool {
        self.quantized.active.is_empty()
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
            slack: self.inner_slack,
        }
    }

    /// A number that tells poses of an asset apart by what node spheres depend on.
    #[inline]
    pub(crate) fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// [`Pose::fingerprint`] of q and placement.
    pub(crate) fn placed_fingerprint(&self) -> u64 {
        hashed([self.fingerprint, self.placement.fingerprint()].into_iter())
    }

    /// Whether the pose was made for this asset.
    pub(crate) fn belongs_to(&self, asset: &Asset<'_>) -> bool {
        identity(self.asset) == identity(asset)
    }
}

/// A number that tells what node spheres depend on from others.
fn fingerprint(asset: &Asset<'_>, slack: f32, q: &[f32]) -> u64 {
    let (address, crc) = identity(asset);
    let words = [address as u64, u64::from(crc), u64::from(slack.to_bits())];
    hashed(words.into_iter().chain([hashed_numbers(q)]))
}

/// FNV-1a over words of 64 bits.
pub(crate) fn hashed(words: impl Iterator<Item = u64>) -> u64 {
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
        let found = q;
        return Err(PoseError::OverLimit { mode, found, limit });
    }
    Ok(if q.abs() < f32::MIN_POSITIVE { 0.0 } else { q })
}

/// What tells an asset from others: where its bytes start, and its header's checksum.
pub(crate) fn identity(asset: &Asset<'_>) -> (usize, u32) {
    let address = asset.bytes().as_ptr() as usize;
    (address, asset.header().header_crc.get())
}

/// The memory of q, that of its shares, and that of the bones' maps.
fn split_mut(
    memory: &mut [f32],
    mode_count: usize,
    bone_count: usize,
) -> Option<(&mut [f32], Memory<'_>, &mut [BoneMap])> {
    let (q, rest) = memory.split_at_mut_checked(mode_count)?;
    let shares = rest.len().checked_sub(MAP_LEN * bone_count)?;
    let (rest, maps) = rest.split_at_mut_checked(shares)?;
    let pairs = rest.len() / 3;
    let (coarse, rest) = rest.split_at_mut_checked(pairs)?;
    let (fine, active) = rest.split_at_mut_checked(pairs)?;
    let shares = Memory {
        coarse: <[[i16; 2]]>::mut_from_bytes(coarse.as_mut_bytes()).ok()?,
        fine: <[[i16; 2]]>::mut_from_bytes(fine.as_mut_bytes()).ok()?,
        active: <[u32]>::mut_from_bytes(active.as_mut_bytes()).ok()?,
    };
    let maps = <[BoneMap]>::mut_from_bytes(maps.as_mut_bytes()).ok()?;
    Some((q, shares, maps))
}

/// [`split_mut`] of memory that holds a pose.
#[cfg(feature = "alloc")]
fn split(memory: &[f32], mode_count: usize, bone_count: usize) -> (&[f32], [&[f32]; 3], &[f32]) {
    let (q, rest) = memory.split_at_checked(mode_count).unwrap_or_default();
    let shares = rest.len().saturating_sub(MAP_LEN * bone_count);
    let (rest, maps) = rest.split_at_checked(shares).unwrap_or_default();
    let pairs = rest.len() / 3;
    let (coarse, rest) = rest.split_at_checked(pairs).unwrap_or_default();
    let (fine, active) = rest.split_at_checked(pairs).unwrap_or_default();
    (q, [coarse, fine, active], maps)
}
