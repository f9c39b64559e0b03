//! `bdtree deform`: the deformed mesh as a file.

mod obj;

use std::io::Write;

use bdtree_output::{check_writable, write_whole};
use bdtree_runtime::{Pose, TriangleId, VertexId};

pub use crate::cli::DeformArguments as Arguments;
use crate::error::ToolError;
use crate::output::check_target;
pub use crate::posture::PostureArguments;
use crate::posture::posture;
pub use crate::q::QText;
use crate::q::counted;
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
    if let Some(path) = &arguments.output {
        check_writable(path)?;
    }
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
    let Some(path) = &arguments.output else {
        let triangles = triangles(&file)?;
        obj::write(asset, &positions, &triangles, out).map_err(ToolError::Stdout)?;
        return Ok(DONE);
    };
    let mut parts = vec![counted(positions.len(), "vertex")];
    let extension = path.extension().unwrap_or_default();
    if extension.eq_ignore_ascii_case("npy") {
        let shape = [positions.len(), 3];
        write_whole(path, |w| {
            bdtree_npy::write(&shape, positions.as_flattened(), w)
        })?;
    } else {
        let triangles = triangles(&file)?;
        write_whole(path, |w| obj::write(asset, &positions, &triangles, w))?;
        parts.push(counted(triangles.len(), "triangle"));
    }
    let parts = parts.join(", ");
    writeln!(out, "wrote {}: {parts}", path.display()).map_err(ToolError::Stdout)?;
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
                let message =
                    format!("vertex {i} is not finite: damaged .bdt file, run bdtree verify");
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
