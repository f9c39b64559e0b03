//! The bones of a pose: matrices as programs have them, turned into maps between stored coordinates.

#[cfg(test)]
mod tests;

use bdtree_format::BoneRecord;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

use crate::error::PoseError;
use crate::joint::JointMatrix;
use crate::math::{dot, norm, sqrt};
use crate::rounding::round_up;
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
        let matrices = match self {
            Self::Matrices(matrices) => matrices,
            #[cfg(feature = "alloc")]
            Self::Maps(others) => {
                for (map, other) in maps.iter_mut().zip(others) {
                    map.rows = other.rows;
                }
                let found = reach(maps, within);
                return found
                    .map(|b| slack(b, skin))
                    .map_err(|index| PoseError::MatrixRange { index });
            }
        };
        let (given, expected) = match matrices {
            BoneMatrices::Rest => (0, 0),
            BoneMatrices::Joints(joints) => (joints.len(), skin.joints.len()),
            BoneMatrices::Skinning(matrices) => (matrices.len(), skin.bones.len()),
        };
        if given != expected {
            return Err(PoseError::MatrixCount {
                expected,
                found: given,
            });
        }
        let frame = Frame {
            origin: asset.origin(),
            per_unit: 1.0 / asset.unit(),
        };
        for (bone, (record, map)) in skin.bones.iter().zip(maps.iter_mut()).enumerate() {
            map.rows = match matrices {
                BoneMatrices::Rest => record.rest.map(|row| row.map(|x| x.get())),
                BoneMatrices::Joints(joints) => {
                    // A joint that a damaged file does not have.
                    let joint = joints.get(record.joint.get() as usize);
                    let joint = joint.ok_or(PoseError::MatrixRange { index: bone })?;
                    frame.of_joint(joint, record)
                }
                BoneMatrices::Skinning(matrices) => matrices
                    .get(bone)
                    .map_or([[0.0; 4]; 3], |matrix| frame.of_skinning(matrix)),
            };
        }
        let found = reach(maps, within);
        found.map(|b| slack(b, skin)).map_err(|bone| {
            let index = match matrices {
                BoneMatrices::Joints(_) => skin.bones[bone].joint.get() as usize,
                BoneMatrices::Rest | BoneMatrices::Skinning(_) => bone,
            };
            PoseError::MatrixRange { index }
        })
    }
}

/// The largest ρ_b and σ_b, with the stretch of each map set.
///
/// # Errors
/// The first bone whose map is not finite or reaches too far.
fn reach(maps: &mut [BoneMap], within: f64) -> Result<(f64, f32), usize> {
    let (mut farthest, mut largest) = (0.0_f64, 0.0_f32);
    for (bone, map) in maps.iter_mut().enumerate() {
        map.stretch = stretch(&map.rows);
        let offset = norm([0, 1, 2].map(|r| f64::from(map.rows[r][3])));
        let rho = f64::from(map.stretch) * within + offset;
        // NaN is not below.
        if !(rho <= REACH_MAX) {
            return Err(bone);
        }
        farthest = farthest.max(rho);
        largest = largest.max(map.stretch);
    }
    Ok((farthest, largest))
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

/// σ ≥ ‖A‖₂ of the linear part of a map, without an eigenvalue: with s² = tr(AᵀA)/3,
/// σ² ≤ s² + √⅔ ‖AᵀA − s²I‖_F, exact for similarities and for a scale along one axis.
fn stretch(rows: &[[f32; 4]; 3]) -> f32 {
    let column = |c: usize| [0, 1, 2].map(|r| f64::from(rows[r][c]));
    let [x, y, z] = [column(0), column(1), column(2)];
    let square = [dot(x, x), dot(y, y), dot(z, z)];
    let mixed = [dot(x, y), dot(y, z), dot(z, x)];
    let mean = (square[0] + square[1] + square[2]) / 3.0;
    let off = square.map(|s| s - mean);
    let spread = dot(off, off) + 2.0 * dot(mixed, mixed);
    /// √⅔, from above.
    const SHARE: f64 = 0.816_496_580_928;
    round_up(sqrt(
        (mean + SHARE * sqrt(spread)) * (1.0 + crate::rounding::MARGIN),
    ))
}

/// Stored coordinates beside mesh coordinates.
struct Frame {
    origin: [f64; 3],
    per_unit: f64,
}

impl Frame {
    /// y ↦ (J V (o + u y) − o) / u (SPEC 7.8).
    fn of_joint(&self, joint: &JointMatrix, record: &BoneRecord) -> [[f32; 4]; 3] {
        // V (o + u y), u left out of the linear part, since it goes again in the end.
        let bind = record.inverse_bind.map(|row| row.map(|x| x.get()));
        let bind = bind.map(|[x, y, z, t]| [x, y, z, dot([x, y, z], self.origin) + t]);
        let [a, b, c] = bind;
        self.stored(core::array::from_fn(|r| {
            let [i, j, k, t] = joint[r];
            let mut row: [f64; 4] = core::array::from_fn(|n| i * a[n] + j * b[n] + k * c[n]);
            row[3] += t;
            row
        }))
    }

    /// y ↦ (K (o + u y) − o) / u.
    fn of_skinning(&self, matrix: &JointMatrix) -> [[f32; 4]; 3] {
        self.stored(matrix.map(|[x, y, z, t]| [x, y, z, dot([x, y, z], self.origin) + t]))
    }

    /// A map of y from [`Frame::origin`] on, to mesh coordinates, in f32.
    fn stored(&self, rows: JointMatrix) -> [[f32; 4]; 3] {
        core::array::from_fn(|r| {
            let [x, y, z, t] = rows[r];
            [x, y, z, (t - self.origin[r]) * self.per_unit].map(rounded)
        })
    }
}

/// The nearest f32, 0 where it is subnormal.
fn rounded(x: f64) -> f32 {
    let x = x as f32;
    if x.abs() < f32::MIN_POSITIVE { 0.0 } else { x }
}

/// How far apart two poses' bones put the same point, at most, if no point is farther than `within` from the origin:
/// max_b ‖A_b − A'_b‖_F X + ‖t_b − t'_b‖ (stored units, before rounding).
pub(crate) fn bones_apart(a: &[BoneMap], b: &[BoneMap], within: f64) -> f64 {
    let apart = |(a, b): (&BoneMap, &BoneMap)| {
        let (mut linear, mut offset) = (0.0, 0.0);
        for (a, b) in a.rows.iter().zip(&b.rows) {
            let difference = |c: usize| f64::from(a[c]) - f64::from(b[c]);
            let row = [difference(0), difference(1), difference(2)];
            linear += dot(row, row);
            offset += difference(3) * difference(3);
        }
        sqrt(linear) * within + sqrt(offset)
    };
    a.iter().zip(b).map(apart).fold(0.0, f64::max)
}

/// The maps in the memory of a pose of the asset.
#[cfg(feature = "alloc")]
pub(crate) fn maps_in<'p>(asset: &Asset<'_>, memory: &'p [f32]) -> &'p [BoneMap] {
    let first = memory.len().saturating_sub(MAP_LEN * asset.bone_count());
    let maps = memory.get(first..).unwrap_or_default();
    <[BoneMap]>::ref_from_bytes(maps.as_bytes()).unwrap_or_default()
}

/// A number that tells maps apart: a chain for each row, so that none waits for the one before.
pub(crate) fn hashed_maps(maps: &[BoneMap]) -> u64 {
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
    for map in maps {
        for (r, chain) in chains.iter_mut().enumerate() {
            let [a, b, c, d] = map.rows[r].map(|x| u64::from(x.to_bits()));
            // The whole product: each of its halves alone forgets the highest bits of words, which are signs, or the lowest.
            let product = u128::from(*chain ^ (a | b << 32)) * u128::from(KEYS[r] ^ (c | d << 32));
            *chain = product as u64 ^ (product >> 64) as u64;
        }
    }
    crate::pose::hashed(chains.into_iter())
}
