//! What `--q` and `--frame` ask for.

use bdtree_runtime::Transform;

use crate::AssetFile;
use crate::error::ToolError;
use crate::frames::frame_of;
use crate::q::{QProblem, QText, checked_q};

/// q and placement: those of a frame with its rigid motion, or q where the mesh stands, zeros if
/// there is none.
///
/// # Errors
/// A frame that is not there, q that does not fit the asset: every problem.
pub fn posture(
    file: &AssetFile,
    q: Option<&QText>,
    frame: Option<u64>,
) -> Result<(Vec<f32>, Transform), ToolError> {
    let asset = file.asset();
    let name = file.path().display().to_string();
    if let Some(index) = frame {
        let frame = frame_of(asset, &name, index)
            .map_err(|message| ToolError::input("--frame", message))?;
        return Ok((frame.q().to_vec(), frame.transform()));
    }
    let q = q.map(|q| q.0.as_slice());
    let q = checked_q(q, asset, &name).map_err(|problems| {
        let line = |(mode, message): QProblem| match mode {
            Some(mode) => format!("--q: q[{mode}]: {message}"),
            None => format!("--q: {message}"),
        };
        ToolError::Input(problems.into_iter().map(line).collect())
    })?;
    Ok((q, Transform::IDENTITY))
}
