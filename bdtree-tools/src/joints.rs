//! Joints as people give them: a clip at a time, or matrices in a file.

use std::fs;
use std::path::Path;

use bdtree_runtime::{Asset, JointMatrix, Model, SkeletonError, SkeletonPose};

use crate::q::counted;

/// What a clip shows at a time: one number per mode, and the matrices of the joints.
///
/// # Errors
/// An asset without clips, a name that none has, a time that is not finite.
pub(crate) fn played(
    model: &Model,
    asset_name: &str,
    clip: &str,
    time_s: f64,
) -> Result<(Vec<f32>, Vec<JointMatrix>), String> {
    let skeleton = model.asset().skeleton();
    let names: Vec<&str> = skeleton
        .iter()
        .flat_map(|skeleton| skeleton.clips().map(|clip| clip.name()))
        .collect();
    let Some(index) = names.iter().position(|name| *name == clip) else {
        return Err(match names.as_slice() {
            [] => format!("asset {asset_name} has no clips"),
            _ => format!("asset {asset_name} has no clip {clip:?}; its clips are {names:?}"),
        });
    };
    played_at(model, index, time_s).map_err(|error| error.to_string())
}

/// The same of a clip by its number, from 0.
///
/// # Errors
/// No such clip, a time that is not finite, a file that breaks the format's rules.
pub(crate) fn played_at(
    model: &Model,
    clip: usize,
    time_s: f64,
) -> Result<(Vec<f32>, Vec<JointMatrix>), SkeletonError> {
    let mut pose = SkeletonPose::new(model)?;
    pose.play(clip, time_s)?;
    Ok((pose.q().to_vec(), pose.joints().to_vec()))
}

/// Refuses another number of matrices than the asset has joints.
///
/// # Errors
/// That.
pub(crate) fn check_count(asset: &Asset<'_>, asset_name: &str, found: usize) -> Result<(), String> {
    let expected = asset.joint_count();
    if expected == 0 {
        return Err(format!("asset {asset_name} has no skin"));
    }
    if found != expected {
        let (found, expected) = (counted(found, "matrix"), counted(expected, "joint"));
        return Err(format!("{found}, but asset {asset_name} has {expected}"));
    }
    Ok(())
}

/// Joint matrices of a `.npy` file of shape (B, 3, 4), numbers of 4 or 8 bytes.
///
/// # Errors
/// A file that cannot be read, another shape or type.
pub(crate) fn read(path: &Path) -> Result<Vec<JointMatrix>, String> {
    let bytes =
        fs::read(path).map_err(|error| format!("{}: cannot be read: {error}", path.display()))?;
    let wrong = |what: &str| format!("{}: {what}", path.display());
    let array = bdtree_npy::parse(&bytes).map_err(|error| wrong(&error.to_string()))?;
    let &[count, 3, 4] = array.shape.as_slice() else {
        let found = format!(
            "expected an array of shape (joints, 3, 4), found {:?}",
            array.shape
        );
        return Err(wrong(&found));
    };
    let number = |b, i, k| array.get(&[b, i, k]).unwrap_or(f64::NAN);
    let matrix = |b| std::array::from_fn(|i| std::array::from_fn(|k| number(b, i, k)));
    Ok((0..count).map(matrix).collect())
}
