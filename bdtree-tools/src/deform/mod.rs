//! `bdtree deform`: the deformed mesh as a file.

mod obj;

use std::io::Write;
use std::path::PathBuf;

use bdtree_runtime::{Pose, TriangleId, VertexId};

pub use crate::cli::DeformArguments as Arguments;
use crate::error::ToolError;
use crate::output::{check_target, write_whole};
pub use crate::posture::PostureArguments;
use crate::posture::posture;
pub use crate::q::QText;
use crate::{AssetFile, DONE};

/// Writes origin + p' of every vertex (mesh units, f64, source order) to a file or `out`; of a frame
/// R (origin + p') + t.
///
/// # Errors
/// A file that cannot be read or breaks the format's rules, q or a frame that does not fit it, an
/// output that cannot be written.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<u8, ToolError> {
    if let Some(path) = &arguments.output {
        check_target(path, &arguments.file, &["obj", "npy"], ".obj or .npy")?;
    }
    let file = AssetFile::map(&arguments.file)?;
    let asset = file.checked_asset(!arguments.no_verify)?;
    let asked = &arguments.posture;
    let posture = posture(&file, asked)?;
    let option = match (asked.frame, &asked.clip, &asked.joints) {
        (Some(_), ..) => "--frame",
        (_, Some(_), _) => "--clip",
        (.., Some(_)) => "--joints",
        _ => "--q",
    };
    let mut memory = vec![0.0; asset.pose_len()];
    let pose = asset
        .pose_with_bones(&posture.q, posture.bones(), posture.transform, &mut memory)
        .map_err(|error| ToolError::input(option, error))?;
    let positions = deformed(&file, &pose)?;
    let is_npy = |path: &&PathBuf| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("npy"))
    };
    if let Some(path) = arguments.output.as_ref().filter(is_npy) {
        write_whole(path, |w| {
            bdtree_npy::write(&[positions.len(), 3], positions.as_flattened(), w)
        })?;
        return Ok(DONE);
    }
    let triangles = triangles(&file)?;
    match &arguments.output {
        None => obj::write(asset, &positions, &triangles, out).map_err(ToolError::Stdout)?,
        Some(path) => write_whole(path, |w| obj::write(asset, &positions, &triangles, w))?,
    }
    Ok(DONE)
}

/// The deformed positions, one per vertex of the source.
///
/// # Errors
/// An asset that is corrupt.
pub fn deformed(file: &AssetFile, pose: &Pose<'_>) -> Result<Vec<[f64; 3]>, ToolError> {
    (0..pose.asset().vertex_count() as u32)
        .map(|i| {
            let x = pose
                .deformed(VertexId(i))
                .map_err(|error| file.error(error))?;
            if x.iter().all(|c| c.is_finite()) {
                Ok(x)
            } else {
                let message = format!("vertex {i} is not finite: corrupt asset, run bdtree verify");
                Err(ToolError::input(file.path().display(), message))
            }
        })
        .collect()
}

/// The corners of every triangle, by id.
fn triangles(file: &AssetFile) -> Result<Vec<[VertexId; 3]>, ToolError> {
    let asset = file.asset();
    (0..asset.triangle_count() as u32)
        .map(|id| asset.triangle(TriangleId(id)))
        .collect::<Result<_, _>>()
        .map_err(|error| file.error(error))
}
