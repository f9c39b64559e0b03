//! Frames of an asset's animation, as people number them.

use bdtree_runtime::{AnimationFrame, Asset};

use crate::q::counted;

/// The number of a frame as people write it.
pub(crate) fn frame_number(text: &str) -> Result<u64, String> {
    let number = text.trim().parse::<u64>();
    number.map_err(|_| "not a whole number, 0 or more".to_string())
}

/// A frame, counted from 0.
///
/// # Errors
/// What is wrong with the number.
pub(crate) fn frame_of<'a>(
    asset: &Asset<'a>,
    asset_name: &str,
    index: u64,
) -> Result<AnimationFrame<'a>, String> {
    let count = asset.frame_count();
    let frame = usize::try_from(index).ok().and_then(|i| asset.frame(i));
    frame.ok_or_else(|| match count {
        0 => format!("asset {asset_name} has no animation"),
        _ => format!(
            "{index} is out of range: asset {asset_name} has {}, numbered from 0",
            counted(count, "frame")
        ),
    })
}

/// Seconds from the first frame to the last, if the file says when they are shown.
pub(crate) fn duration_s(asset: &Asset<'_>) -> Option<f64> {
    let first = asset.frame(0)?.time_s()?;
    let last = asset.frame(asset.frame_count() - 1)?.time_s()?;
    Some(last - first)
}
