//! Bones as stored: their maps at rest, the boxes of what they move, and how far fields reach there.

use bdtree_format::{BoneRecord, SkeletonNode};
use zerocopy::little_endian::F32;

use super::skeleton::{product, rest};
use super::weights::Taken;
use crate::error::{BakeError, Part};
use crate::input::{RawSkin, Rows};
use crate::vec3::norm2;
use crate::wrap::StoredShape;
use crate::wrap::round::{norm_up, round_nearest, round_up};

/// Exponent of the farthest that a pose may reach (SPEC 5.9).
const REACH_EXPONENT_MAX: i32 = 60;

/// Largest magnitude of a number of an inverse bind matrix (SPEC 7.8).
const MATRIX_MAX: f64 = (1_u128 << 80) as f64;

/// The bones of a skin, without boxes.
///
/// # Errors
/// Matrices that the file does not hold.
pub(super) fn bones(
    skin: &RawSkin,
    skeleton: &[SkeletonNode],
    shape: &StoredShape,
) -> Result<Vec<BoneRecord>, BakeError> {
    let rest = rest(skeleton);
    let mut bones = Vec::with_capacity(skin.bones.len());
    for bone in &skin.bones {
        let node = skin.joints[bone.joint as usize] as usize;
        let fail = |message: &str| {
            let place = Part::JsonPath(format!(
                "joint {} ({:?})",
                bone.joint, skin.skeleton[node].name
            ));
            Err(BakeError::one("skin", place, message))
        };
        let numbers = bone.inverse_bind.as_flattened();
        if !numbers.iter().all(|x| x.abs() <= MATRIX_MAX) {
            return fail("a number of its inverse bind matrix is not finite or beyond 2^80");
        }
        let map = in_stored_units(&product(&rest[node], &bone.inverse_bind), shape);
        let stored = map.map(|row| row.map(round_nearest));
        let most = 2.0_f32.powi(REACH_EXPONENT_MAX);
        if !stored.as_flattened().iter().all(|x| x.abs() <= most) {
            return fail("its matrix at rest is not finite or beyond what bounds hold for");
        }
        bones.push(BoneRecord {
            joint: bone.joint.into(),
            reserved: 0.into(),
            inverse_bind: bone.inverse_bind.map(|row| row.map(Into::into)),
            rest: stored.map(|row| row.map(Into::into)),
            low: [1.0.into(); 3],
            high: [(-1.0).into(); 3],
            core_low: [1.0.into(); 3],
            core_high: [(-1.0).into(); 3],
        });
    }
    Ok(bones)
}

/// y ↦ (M (o + 2^e y) − o) 2^−e.
fn in_stored_units(map: &Rows, shape: &StoredShape) -> Rows {
    let unit = 2.0_f64.powi(shape.unit_exponent);
    let [x, y, z] = shape.origin;
    std::array::from_fn(|i| {
        let [a, b, c, t] = map[i];
        let at_origin = a * x + b * y + c * z + t;
        [a, b, c, (at_origin - shape.origin[i]) / unit]
    })
}

/// Gives bones the boxes around the rest positions that they move.
pub(super) fn add_boxes(bones: &mut [BoneRecord], taken: &Taken, shape: &StoredShape) {
    for (p, influences) in shape.positions.iter().zip(taken.vertices()) {
        for influence in influences {
            let bone = &mut bones[usize::from(influence.bone)];
            hold(&mut bone.low, &mut bone.high, *p);
        }
    }
}

/// Core boxes leave out bones whose weights on a vertex sum to no more than this. On CesiumMan, the boxes of instances
/// are 1.82 times the exact ones instead of 2.34 times; shares from 0.1 to 0.35 do about as well.
const MINOR_SHARE_MAX: f64 = 0.15;

/// Gives bones their core boxes: around the rest positions that they move, without those of which this and lighter
/// bones together have a minor share. Returns the largest such share (SPEC 7.8).
pub(super) fn add_cores(bones: &mut [BoneRecord], taken: &Taken, shape: &StoredShape) -> f32 {
    let mut largest = 0.0_f64;
    let mut by_weight = Vec::new();
    for (p, influences) in shape.positions.iter().zip(taken.vertices()) {
        by_weight.clear();
        by_weight.extend_from_slice(influences);
        by_weight.sort_by(|a, b| a.weight.total_cmp(&b.weight));
        let mut share = 0.0;
        let minor = by_weight.iter().take_while(|influence| {
            let next = share + f64::from(influence.weight);
            let is_minor = next <= MINOR_SHARE_MAX;
            share = if is_minor { next } else { share };
            is_minor
        });
        let minor_count = minor.count();
        for influence in &by_weight[minor_count..] {
            let bone = &mut bones[usize::from(influence.bone)];
            hold(&mut bone.core_low, &mut bone.core_high, *p);
        }
        largest = largest.max(share);
    }
    // Sums of f64 whose terms are at least 2⁻³²: the factor is far above their rounding.
    round_up(largest * (1.0 + 1e-12))
}

/// Enlarges a box to hold a point; one from 1 to −1 is empty.
fn hold(low: &mut [F32; 3], high: &mut [F32; 3], p: [f32; 3]) {
    if low[0].get() > high[0].get() {
        (*low, *high) = (p.map(Into::into), p.map(Into::into));
        return;
    }
    for k in 0..3 {
        low[k] = low[k].get().min(p[k]).into();
        high[k] = high[k].get().max(p[k]).into();
    }
}

/// The largest norm of the displacements that each bone moves, per mode, rounded up; bone-major.
pub(super) fn fields(bone_count: usize, taken: &Taken, shape: &StoredShape) -> Vec<f32> {
    let m = shape.mode_count();
    let mut largest = vec![0.0_f32; bone_count * m];
    for (row, influences) in shape
        .displacements
        .chunks_exact(m.max(1))
        .zip(taken.vertices())
    {
        for (j, u) in row.iter().enumerate().filter(|(_, u)| **u != [0.0; 3]) {
            let norm = norm_up(norm2(u.map(f64::from)));
            for influence in influences {
                let own = &mut largest[usize::from(influence.bone) * m + j];
                *own = own.max(norm);
            }
        }
    }
    largest
}
