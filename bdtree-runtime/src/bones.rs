//! The bones of a pose: matrices as programs have them, turned into maps between stored coordinates.

mod eight;
mod four;
#[cfg(test)]
mod tests;

use core::borrow::Borrow;

pub(crate) use eight::columns as columns_of_eight;
pub(crate) use four::columns;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::error::PoseError;
use crate::joint::JointMatrix;
use crate::rounding::round_up;
use crate::simd::Kernel;
use crate::view::{Asset, Skin};

/// Where the bones of a pose stand.
///
/// Matrices are relative to the instance's placement: they map to *model* space, in mesh units, and the placement maps
/// from there to the world.
#[derive(Debug, Clone, Copy, Default)]
pub enum BoneMatrices<'a> {
    /// At rest, as the source shows the mesh without an animation.
    #[default]
    Rest,
    /// One matrix per joint, from the joint's space to model space, *without* inverse bind matrices; in the order of the
    /// asset's joints.
    Joints(&'a [JointMatrix]),
    /// One matrix per bone, from mesh space to model space: joint matrix times inverse bind matrix; in the order of
    /// [`Asset::bones`].
    Skinning(&'a [JointMatrix]),
}

/// Where a pose takes its bones from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum BoneSource<'a> {
    Matrices(BoneMatrices<'a>),
    /// Another pose of the same asset.
    #[cfg(feature = "alloc")]
    Maps(&'a [BoneMap]),
}

impl BoneSource<'_> {
    /// True if they are matrices that somebody gave.
    pub(crate) fn are_given(self) -> bool {
        matches!(
            self,
            Self::Matrices(BoneMatrices::Joints(_) | BoneMatrices::Skinning(_))
        )
    }
}

/// T_b of a pose: the map of a bone, from stored coordinates to stored coordinates (SPEC 5.9). See
/// [`Pose::bone_maps`](crate::Pose::bone_maps).
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[repr(C)]
pub struct BoneMap {
    /// Three rows of four.
    pub(crate) rows: [[f32; 4]; 3],
    /// σ_b, at least the spectral norm of the linear part.
    pub(crate) stretch: f32,
    /// Fills up to 64 bytes.
    pub(crate) unused: [f32; 3],
}

impl BoneMap {
    /// Three rows of four: a point y goes to A y + t, row r being (A_r0, A_r1, A_r2, t_r). Finite, none subnormal.
    pub fn rows(&self) -> &[[f32; 4]; 3] {
        &self.rows
    }

    /// σ_b, at least the spectral norm of A.
    pub fn stretch(&self) -> f32 {
        self.stretch
    }
}

/// f32 numbers of one [`BoneMap`].
pub(crate) const MAP_LEN: usize = 16;

const _: () = assert!(size_of::<BoneMap>() == MAP_LEN * size_of::<f32>());

/// What a node bound needs of a pose's bones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PosedBones<'p> {
    pub(crate) maps: &'p [BoneMap],
    pub(crate) slack: BoneSlack,
}

/// slack' (SPEC 5.9): of a node with m bones, `base` + m `per_bone` (stored units).
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoneSlack {
    pub(crate) base: f32,
    pub(crate) per_bone: f32,
}

#[cfg(feature = "alloc")]
impl BoneSlack {
    /// That of an asset without bones.
    pub(crate) const NONE: Self = Self {
        base: 0.0,
        per_bone: 0.0,
    };
}

/// Largest ρ_b: squares of what maps reach stay below 2¹²⁵.
const REACH_MAX: f64 = (1_u64 << 60) as f64;

/// How far the maps of a pose reach.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoneReach {
    /// (1 + ε) B: no vertex is farther from the origin, before rounding (stored units).
    pub(crate) reach: f64,
    /// The largest σ_b.
    pub(crate) stretch: f32,
    pub(crate) slack: BoneSlack,
    /// slack' of the node with most bones.
    pub(crate) slack_max: f32,
}

impl BoneSource<'_> {
    /// The maps of all bones, put into `maps`, one per bone; `within` is X: no vertex and no lane center is farther from the
    /// origin before bones move it.
    ///
    /// # Errors
    /// Another number of matrices than the asset has joints or bones; one with elements that are not finite or too
    /// large.
    pub(crate) fn map(
        self,
        asset: &Asset<'_>,
        skin: &Skin<'_>,
        within: f64,
        maps: &mut [BoneMap],
    ) -> Result<BoneReach, PoseError> {
        let kernel = asset.kernel;
        let matrices = match self {
            Self::Matrices(matrices) => matrices,
            #[cfg(feature = "alloc")]
            Self::Maps(others) => {
                for (map, other) in maps.iter_mut().zip(others) {
                    map.rows = other.rows;
                }
                let found = kernel.run(four::Reach { maps, within });
                return found
                    .map(|b| slack(b, skin))
                    .map_err(|index| PoseError::MatrixRange { index });
            }
        };
        match matrices {
            BoneMatrices::Joints(joints) if joints.len() != skin.joints.len() => {
                return Err(PoseError::JointCount {
                    expected: skin.joints.len(),
                    found: joints.len(),
                });
            }
            BoneMatrices::Skinning(matrices) if matrices.len() != skin.bones.len() => {
                return Err(PoseError::BoneCount {
                    expected: skin.bones.len(),
                    found: matrices.len(),
                });
            }
            _ => {}
        }
        let frame = Frame {
            origin: asset.origin(),
            per_unit: 1.0 / asset.unit(),
        };
        match matrices {
            BoneMatrices::Rest => {
                for (record, map) in skin.bones.iter().zip(maps.iter_mut()) {
                    map.rows = record.rest.map(|row| row.map(|x| x.get()));
                }
            }
            BoneMatrices::Joints(joints) => {
                let work = four::OfJoints {
                    frame,
                    joints,
                    bones: skin.bones,
                    maps: &mut *maps,
                };
                let made = kernel.run(work);
                made.map_err(|bone| PoseError::MatrixRange { index: bone })?;
            }
            BoneMatrices::Skinning(matrices) => kernel.run(four::OfSkinning {
                frame,
                matrices,
                maps: &mut *maps,
            }),
        }
        let found = kernel.run(four::Reach { maps, within });
        found.map(|b| slack(b, skin)).map_err(|bone| {
            let index = match matrices {
                BoneMatrices::Joints(_) => skin.bones[bone].joint.get() as usize,
                BoneMatrices::Rest | BoneMatrices::Skinning(_) => bone,
            };
            PoseError::MatrixRange { index }
        })
    }
}

/// The slack that goes with the largest ρ_b.
fn slack((farthest, stretch): (f64, f32), skin: &Skin<'_>) -> BoneReach {
    use crate::rounding::{BONES_FLUSHED, U32};
    let record = skin.record;
    let reach = farthest * (1.0 + f64::from(record.weight_defect));
    let influences = f64::from(record.influences_max);
    let slack = BoneSlack {
        base: round_up((2.0 * influences + 48.0) * U32 * reach + BONES_FLUSHED),
        per_bone: round_up(4.0 * U32 * reach),
    };
    let most = f64::from(record.node_bones_max);
    let slack_max = round_up(f64::from(slack.base) + most * f64::from(slack.per_bone));
    BoneReach {
        reach,
        stretch,
        slack,
        slack_max,
    }
}

/// Stored coordinates beside mesh coordinates.
#[derive(Debug, Clone, Copy)]
struct Frame {
    origin: [f64; 3],
    per_unit: f64,
}

/// How far apart two poses' bones put the same point, at most, if no point is farther than `within` from the origin:
/// max_b ‖A_b − A'_b‖_F X + ‖t_b − t'_b‖ (stored units, before rounding).
pub(crate) fn bones_apart(kernel: Kernel, maps: [&[BoneMap]; 2], within: f64) -> f64 {
    kernel.run(four::Apart { maps, within })
}

/// The maps in the memory of a pose of the asset.
#[cfg(feature = "alloc")]
pub(crate) fn maps_in<'p>(asset: &Asset<'_>, memory: &'p [f32]) -> &'p [BoneMap] {
    let first = memory.len().saturating_sub(MAP_LEN * asset.bone_count());
    let maps = memory.get(first..).unwrap_or_default();
    <[BoneMap]>::ref_from_bytes(maps.as_bytes()).unwrap_or_default()
}

/// A number that tells maps apart.
pub(crate) fn hashed_maps(maps: &[BoneMap]) -> u64 {
    hashed_rows(maps.iter().map(|map| &map.rows))
}

/// A number that tells as many numbers apart.
pub(crate) fn hashed_numbers(numbers: &[f32]) -> u64 {
    let (twelves, rest) = numbers.as_chunks::<12>();
    let mut last = [0.0; 12];
    last[..rest.len()].copy_from_slice(rest);
    let all = twelves.iter().chain((!rest.is_empty()).then_some(&last));
    hashed_rows(all.map(|[a, b, c, d, e, f, g, h, i, j, k, l]| {
        [[*a, *b, *c, *d], [*e, *f, *g, *h], [*i, *j, *k, *l]]
    }))
}

/// Of each row its own chain, so that none waits for the one before.
fn hashed_rows(all: impl Iterator<Item = impl Borrow<[[f32; 4]; 3]>>) -> u64 {
    /// Numbers without a pattern: the fraction of π.
    const KEYS: [u64; 3] = [
        0x243f_6a88_85a3_08d3,
        0x1319_8a2e_0370_7344,
        0xa409_3822_299f_31d0,
    ];
    // Others than the keys: factors that start from the same number could change places.
    let mut chains = [
        0x082e_fa98_ec4e_6c89,
        0x4528_21e6_38d0_1377,
        0xbe54_66cf_34e9_0c6c,
    ];
    for rows in all {
        for (r, chain) in chains.iter_mut().enumerate() {
            let [a, b, c, d] = rows.borrow()[r].map(|x| u64::from(x.to_bits()));
            // The whole product: each of its halves alone forgets the highest bits of words, which are signs, or the lowest.
            let product = u128::from(*chain ^ (a | b << 32)) * u128::from(KEYS[r] ^ (c | d << 32));
            *chain = product as u64 ^ (product >> 64) as u64;
        }
    }
    crate::pose::hashed(chains.into_iter())
}
