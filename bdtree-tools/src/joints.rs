//! Joints as people give them: a clip at a time, or matrices in a file.

use std::fs;
use std::path::Path;

use bdtree_runtime::{Asset, JointMatrix, Model, SkeletonError, SkeletonPose};
use npyz::NpyFile;

use crate::q::counted;

/// Most bytes of the header of a file of joints: numpy writes 128.
const HEADER_MAX: usize = 1024;

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
        fs::read(path).map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    let wrong = |what: &str| Err(format!("{}: {what}", path.display()));
    // The reader multiplies extents unchecked and parses by recursion, so headers that no array of joints has stay out.
    let header = &bytes[..bytes.len().min(HEADER_MAX)];
    let Some(end) = header.iter().position(|b| *b == b'\n') else {
        return wrong("not a .npy file of joint matrices: no header of at most 1024 bytes");
    };
    let is_long = |run: &[u8]| run.len() > 6;
    let text = header.get(10..end).unwrap_or_default();
    let mut runs = text
        .split(|b| !b.is_ascii_digit())
        .filter(|run| !run.is_empty());
    if runs.clone().any(is_long) || runs.by_ref().count() > 6 {
        return wrong("expected an array of shape (joints, 3, 4)");
    }
    let file = match NpyFile::new(bytes.as_slice()) {
        Ok(file) => file,
        Err(error) => return wrong(&format!("not a .npy file: {error}")),
    };
    let &[count, 3, 4] = file.shape() else {
        let found = format!(
            "expected an array of shape (joints, 3, 4), found {:?}",
            file.shape()
        );
        return wrong(&found);
    };
    if file.order() != npyz::Order::C {
        return wrong("expected numbers in C order, found Fortran order");
    }
    let numbers: Result<Vec<f64>, _> = match file.try_data::<f64>() {
        Ok(data) => data.collect(),
        Err(file) => match file.try_data::<f32>() {
            Ok(data) => data.map(|x| x.map(f64::from)).collect(),
            Err(_) => return wrong("expected numbers of type <f8 or <f4"),
        },
    };
    let numbers = match numbers {
        Ok(numbers) => numbers,
        Err(error) => return wrong(&error.to_string()),
    };
    let (rows, _) = numbers.as_chunks::<4>();
    let (matrices, _) = rows.as_chunks::<3>();
    if matrices.len() as u64 != count {
        return wrong("the file is shorter than its header says");
    }
    Ok(matrices.to_vec())
}
