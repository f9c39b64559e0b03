//! Pictures of an asset as it is, for the report.

use bdtree_render::{Image, Studio};
use bdtree_runtime::Transform;
use clap::Parser;

use super::Arguments;
use super::at_rest;
use super::body::{Body, Content};
use super::options::UpAxis;
use super::picture::{Bounds, Frame, Painter, graphics};
use crate::AssetFile;
use crate::error::ToolError;
use crate::info::mode_name;
use crate::joints;
use crate::output::printable;
use crate::posture::Posture;

/// So that defaults stand in one place.
#[derive(Parser)]
struct Plain {
    #[command(flatten)]
    arguments: Arguments,
}

/// At rest, and moved: the middle of the first clip, the middle frame of an animation, or one mode at its q_range, with
/// an axis of the mesh upright. Each with what it shows.
///
/// # Errors
/// No graphics adapter or one that the asset is too large for, corrupt records.
pub fn portraits(file: &AssetFile, up: UpAxis) -> Result<Vec<(String, Image)>, ToolError> {
    let path = file.path().as_os_str();
    let options = ["--size", "720x540", "--no-legend", "--shadow"];
    let line = ["portrait".as_ref(), path, "-o".as_ref(), "png".as_ref()];
    let line = line.into_iter().chain(options.map(AsRef::as_ref));
    let plain = Plain::try_parse_from(line);
    let Plain { mut arguments } =
        plain.map_err(|error| ToolError::Input(vec![error.to_string()]))?;
    arguments.upright.up = up;
    let rest = Posture {
        q: vec![0.0; file.asset().mode_count()],
        joints: None,
        transform: Transform::IDENTITY,
    };
    let (first, others) = at_rest(file)?.split_at(1);
    let mut poses = vec![(first.to_uppercase() + others, rest)];
    poses.extend(moved(file)?);
    let frames = poses.into_iter().map(|(about, posture)| {
        Ok(Frame {
            about,
            number: None,
            content: vec![Content {
                body: Body::posed(file, &posture)?,
                spheres: Vec::new(),
                is_file: true,
            }],
            queries: Vec::new(),
            nodes_visited: None,
        })
    });
    let frames = frames.collect::<Result<Vec<_>, ToolError>>()?;
    let mut bounds = Bounds::new(&arguments);
    frames.iter().for_each(|frame| bounds.hold(frame));
    let Some(first) = frames.first() else {
        return Ok(Vec::new());
    };
    let studio = Studio::open().map_err(|error| graphics(&error))?;
    let mut painter = Painter::new(&arguments, studio, bounds, first)?;
    let pictures = frames.iter().map(|frame| {
        let (image, _) = painter.paint(frame)?;
        Ok((frame.about.clone(), image))
    });
    pictures.collect()
}

/// What the asset does, if it does anything.
fn moved(file: &AssetFile) -> Result<Option<(String, Posture)>, ToolError> {
    let asset = file.asset();
    if let Some(clip) = asset.skeleton().and_then(|skeleton| skeleton.clip(0)) {
        let time_s = 0.5 * clip.duration_s();
        let played = joints::played_at(file.model(), 0, time_s);
        let (q, joints) = played.map_err(|error| ToolError::input(file.path().display(), error))?;
        let posture = Posture {
            q,
            joints: Some(joints),
            transform: Transform::IDENTITY,
        };
        let about = format!("Clip {} at {time_s:.2} s", printable(clip.name()));
        return Ok(Some((about, posture)));
    }
    let middle = asset.frame_count() / 2;
    if let Some(frame) = asset.frame(middle) {
        let about = format!("Frame {middle}");
        let posture = Posture {
            q: frame.q().to_vec(),
            joints: None,
            transform: frame.transform(),
        };
        return Ok(Some((about, posture)));
    }
    let ranges = asset.modes().iter().map(|mode| mode.q_range.get());
    let Some((mode, range)) = ranges.enumerate().find(|(_, range)| *range > 0.0) else {
        return Ok(None);
    };
    let mut q = vec![0.0; asset.mode_count()];
    q[mode] = range;
    let about = format!("At q_range of {}", mode_name(file, mode)?);
    let posture = Posture {
        q,
        joints: None,
        transform: Transform::IDENTITY,
    };
    Ok(Some((about, posture)))
}
