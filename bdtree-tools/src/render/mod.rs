//! `bdtree render`: pictures of an asset.

mod arguments;
mod body;
pub mod options;
mod picture;
mod questions;
mod report;
mod visited;

use std::ffi::OsStr;
use std::io::Write;
use std::path::PathBuf;

use bdtree_render::{Level, Studio};

use crate::error::ToolError;
use crate::frames::frame_of;
use crate::output::write_whole;
use crate::posture::posture;
use crate::q::counted;
use crate::scene::Scene;
use crate::{AssetFile, DONE};
pub use arguments::Arguments;
use body::{Body, Content};
use picture::{Bounds, Frame, Painter, graphics};
pub use report::{Growth, Report, SphereLine};

/// Draws an asset, or a sequence of its frames, into PNG files.
///
/// # Errors
/// A file that cannot be read or breaks the format's rules, q, a frame, a level or a scene that does not
/// fit it, no graphics adapter or one that it is too large for, an output that cannot be written.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<u8, ToolError> {
    check_output(arguments)?;
    let file = AssetFile::map(&arguments.file)?;
    let asset = file.checked_asset(!arguments.no_verify)?;
    if let Some(range) = arguments.frames {
        // Before paths are made for all of them.
        let name = file.path().display().to_string();
        frame_of(asset, &name, range.last).map_err(|e| ToolError::input("--frames", e))?;
    }
    let targets = targets(arguments)?;
    if let Some(level) = arguments.spheres
        && level >= asset.depth()
    {
        let (levels, path) = (counted(asset.depth(), "level"), file.path().display());
        let message =
            format!("{level} is out of range: asset {path} has {levels}, numbered from 0");
        return Err(ToolError::input("--spheres", message));
    }
    match &arguments.query {
        Some(path) => {
            let mut scene = Scene::load(path, !arguments.no_verify)?;
            if arguments.q.is_some() || arguments.frame.is_some() {
                let posture = posture(&file, arguments.q.as_ref(), arguments.frame)?;
                visited::put(&mut scene, &file, &posture)?;
            }
            paint(
                arguments,
                &targets,
                |_| visited::shown(arguments, &file, &scene),
                out,
            )?;
        }
        None => {
            let frame_of = |number| shown(arguments, &file, number);
            paint(arguments, &targets, frame_of, out)?;
        }
    }
    Ok(DONE)
}

fn check_output(arguments: &Arguments) -> Result<(), ToolError> {
    let path = &arguments.output;
    let is_png = |e: &str| e.eq_ignore_ascii_case("png");
    if !path.extension().and_then(OsStr::to_str).is_some_and(is_png) {
        let message = "unknown extension: .png can be written";
        return Err(ToolError::input(path.display(), message));
    }
    match arguments.frames {
        Some(range) if options::numbered(path, range.first).is_none() => {
            Err(ToolError::input(path.display(), NO_PLACE))
        }
        _ => Ok(()),
    }
}

const NO_PLACE: &str = "has no place for the frame's number: write it as %d or %04d";

/// The frame of each picture, if it is one of a sequence, and its file.
fn targets(arguments: &Arguments) -> Result<Vec<(Option<u64>, PathBuf)>, ToolError> {
    let path = &arguments.output;
    let Some(range) = arguments.frames else {
        return Ok(vec![(None, path.clone())]);
    };
    let frames = (range.first..=range.last).map(|frame| {
        let path = options::numbered(path, frame);
        path.map(|path| (Some(frame), path))
    });
    frames
        .collect::<Option<_>>()
        .ok_or_else(|| ToolError::input(path.display(), NO_PLACE))
}

/// The asset alone, at q or a frame.
fn shown<'a>(
    arguments: &Arguments,
    file: &'a AssetFile,
    of_sequence: Option<u64>,
) -> Result<Frame<'a>, ToolError> {
    // The last frame of a sequence was looked for before.
    let number = of_sequence.or(arguments.frame);
    let (q, transform) = posture(file, arguments.q.as_ref(), number)?;
    let frame = |index: u64| file.asset().frame(usize::try_from(index).ok()?);
    let time_s = number.and_then(|index| frame(index)?.time_s());
    let body = Body::posed(file, &q, transform)?;
    let spheres = match arguments.spheres {
        Some(level) => body.spheres(|pose| Ok(Level::of(pose, level)?.spheres))?,
        None => Vec::new(),
    };
    Ok(Frame {
        about: vec![posture_text(&q, number, time_s)],
        number,
        content: vec![Content {
            body,
            spheres,
            is_file: true,
        }],
        questions: Vec::new(),
        nodes_visited: None,
    })
}

/// q or the frame in a few words.
fn posture_text(q: &[f32], frame: Option<u64>, time_s: Option<f64>) -> String {
    match (frame, time_s) {
        (Some(number), Some(time_s)) => format!("frame {number} ({time_s:.3} s)"),
        (Some(number), None) => format!("frame {number}"),
        _ if q.iter().all(|q| *q == 0.0) => "at rest".to_string(),
        _ => {
            let numbers: Vec<String> = q.iter().map(|q| format!("{q}")).collect();
            format!("q = {}", numbers.join(", "))
        }
    }
}

/// Draws frames, as `make` returns them, into their files.
fn paint<'a>(
    arguments: &Arguments,
    targets: &[(Option<u64>, PathBuf)],
    make: impl Fn(Option<u64>) -> Result<Frame<'a>, ToolError>,
    out: &mut dyn Write,
) -> Result<(), ToolError> {
    for (_, path) in targets {
        let both = (path.canonicalize(), arguments.file.canonicalize());
        if matches!(both, (Ok(to), Ok(from)) if to == from) {
            let message = "is the input: it would be overwritten";
            return Err(ToolError::input(path.display(), message));
        }
    }
    // Of a sequence one frame at a time: all of them may be too many for memory.
    let mut bounds = Bounds::default();
    let mut last = None;
    for (number, _) in targets {
        let frame = make(*number)?;
        bounds.hold(&frame);
        last = Some(frame);
    }
    let Some(frame) = &last else {
        return Ok(()); // a range of frames is not empty
    };
    let studio = Studio::open().map_err(|error| graphics(&error))?;
    let mut painter = Painter::new(arguments, studio, &bounds, frame)?;
    for (number, path) in targets {
        let frame = match (targets.len(), last.take()) {
            (1, Some(only)) => only,
            _ => make(*number)?,
        };
        let (image, growths) = painter.paint(&frame)?;
        write_whole(path, |w| image.write_png(w))?;
        if arguments.json {
            let report = Report::of(arguments, path, &frame, &growths, &painter);
            serde_json::to_writer(&mut *out, &report).map_err(|e| ToolError::Stdout(e.into()))?;
            writeln!(out).map_err(ToolError::Stdout)?;
        }
    }
    Ok(())
}
