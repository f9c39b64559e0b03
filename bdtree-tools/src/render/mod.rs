//! `bdtree render`: pictures of an asset.

mod arguments;
mod body;
pub mod options;
mod picture;
#[cfg(feature = "report")]
mod portrait;
mod queries;
mod report;
mod visited;

use std::io::Write;
use std::path::{Path, PathBuf};

use bdtree_output::{check_writable, write_whole};
use bdtree_render::{Level, Studio};

use crate::error::ToolError;
use crate::frames::frame_of;
use crate::info::metadata;
use crate::output::{check_target, printable, write_json};
use crate::posture::{PostureArguments, posture};
use crate::q::counted;
use crate::scene::Scene;
use crate::{AssetFile, DONE};
pub use arguments::{Arguments, UprightArguments, level};
use body::{Body, Content};
use picture::{Bounds, Frame, Painter, graphics};
#[cfg(feature = "report")]
pub use portrait::portraits;
pub use report::{Growth, Report, SphereLine};

/// Draws an asset, or a sequence of its frames, into PNG files.
///
/// # Errors
/// A file that cannot be read or breaks the format's rules, q, a frame, a level or a scene that does not
/// fit it, no graphics adapter or one that it is too large for, an output that cannot be written.
pub fn run(arguments: &Arguments, out: &mut dyn Write) -> Result<u8, ToolError> {
    let output = &arguments.output;
    check_target(output, &arguments.file, &["png"], ".png")?;
    let range = arguments.frames;
    if range.is_some_and(|range| options::numbered(output, range.first).is_none()) {
        let message = "has no place for the frame's number: write it as %d or %04d";
        return Err(ToolError::Usage(format!("{}: {message}", output.display())));
    }
    let file = AssetFile::map(&arguments.file)?;
    let asset = file.checked_asset(!arguments.no_verify)?;
    if let Some(range) = range {
        // Before paths are made for all of them.
        let name = file.path().display().to_string();
        frame_of(asset, &name, range.last).map_err(|e| ToolError::input("--frames", e))?;
    }
    let targets = targets(arguments);
    for (_, path) in &targets {
        check_target(path, &arguments.file, &["png"], ".png")?;
    }
    // All lie in one folder.
    if let Some((_, path)) = targets.first() {
        check_writable(path)?;
    }
    if let Some(level) = arguments.spheres {
        check_level(&file, level)?;
    }
    match &arguments.query {
        Some(path) => {
            let mut scene = Scene::load(path, !arguments.no_verify)?;
            let mut replaced = None;
            if arguments.posture.is_given() {
                let posture = posture(&file, &arguments.posture)?;
                visited::put(&mut scene, &file, &posture)?;
                let asked = &arguments.posture;
                let text = posture_text(&posture.q, asked.frame, None, asked, at_rest(&file)?);
                replaced = Some(text);
            }
            let make = |_| visited::shown(arguments, &file, &scene, replaced.as_deref());
            paint(arguments, &targets, make, out)?;
        }
        None => {
            let make = |number| shown(arguments, &file, number);
            paint(arguments, &targets, make, out)?;
        }
    }
    Ok(DONE)
}

/// Checks that the tree has a level.
///
/// # Errors
/// It has not; `--spheres` asked for it.
pub fn check_level(file: &AssetFile, level: usize) -> Result<(), ToolError> {
    let depth = file.asset().depth();
    if level < depth {
        return Ok(());
    }
    let (levels, path) = (counted(depth, "level"), file.path().display());
    let message = format!("{level} is out of range: asset {path} has {levels}, numbered from 0");
    Err(ToolError::input("--spheres", message))
}

/// The frame of each picture, if it is one of a sequence, and its file.
fn targets(arguments: &Arguments) -> Vec<(Option<u64>, PathBuf)> {
    let path = &arguments.output;
    let Some(range) = arguments.frames else {
        return vec![(None, path.clone())];
    };
    let target = |frame| Some((Some(frame), options::numbered(path, frame)?));
    (range.first..=range.last).filter_map(target).collect()
}

/// The asset alone, at q or a frame.
fn shown<'a>(
    arguments: &Arguments,
    file: &'a AssetFile,
    of_sequence: Option<u64>,
) -> Result<Frame<'a>, ToolError> {
    // The last frame of a sequence was looked for before.
    let number = of_sequence.or(arguments.posture.frame);
    let asked = PostureArguments {
        frame: number,
        ..arguments.posture.clone()
    };
    let posture = posture(file, &asked)?;
    let frame = |index: u64| file.asset().frame(usize::try_from(index).ok()?);
    let time_s = number.and_then(|index| frame(index)?.time_s());
    let body = Body::posed(file, &posture)?;
    let spheres = match arguments.spheres {
        Some(level) => body.spheres(|pose| Ok(Level::of(pose, level)?.spheres))?,
        None => Vec::new(),
    };
    Ok(Frame {
        about: posture_text(&posture.q, number, time_s, &asked, at_rest(file)?),
        number,
        content: vec![Content {
            body,
            spheres,
            is_file: true,
        }],
        queries: Vec::new(),
        nodes_visited: None,
    })
}

/// q, the frame, the clip or that joints were given, in a few words.
fn posture_text(
    q: &[f32],
    frame: Option<u64>,
    time_s: Option<f64>,
    asked: &PostureArguments,
    at_rest: &str,
) -> String {
    let numbers: Vec<String> = q.iter().map(|q| format!("{q}")).collect();
    let numbers = format!("q = {}", numbers.join(", "));
    if let Some(clip) = &asked.clip {
        let clip = format!("{} at {:.3} s", printable(clip), asked.time);
        // What the clip shows needs no numbers.
        return match asked.q {
            Some(_) => format!("{clip}, {numbers}"),
            None => clip,
        };
    }
    match (frame, time_s) {
        (Some(number), Some(time_s)) => format!("frame {number} ({time_s:.3} s)"),
        (Some(number), None) => format!("frame {number}"),
        _ => {
            let is_zero = q.iter().all(|q| *q == 0.0);
            match (is_zero, asked.joints.is_some()) {
                (true, false) => at_rest.to_string(),
                (true, true) => "joints as given".to_string(),
                (false, false) => numbers,
                (false, true) => format!("joints as given, {numbers}"),
            }
        }
    }
}

/// What q = 0 shows: of an animation that was baked about the mean of its frames, a shape that is in none of them.
///
/// # Errors
/// Metadata that are not what the format says.
fn at_rest(file: &AssetFile) -> Result<&'static str, ToolError> {
    let metadata = metadata(file)?;
    let about = metadata.as_ref().and_then(|m| m.settings.get("about"));
    Ok(match about {
        Some(about) if about == "mean" => "mean of the frames (q = 0)",
        _ => "at rest",
    })
}

/// What has been written, in a line.
fn summary(arguments: &Arguments, path: &Path, frame: &Frame<'_>) -> String {
    let [width, height] = arguments.size.0;
    let mut parts = vec![format!("{width} x {height} pixels")];
    parts.extend(frame.number.map(|number| format!("frame {number}")));
    parts.extend(
        frame
            .nodes_visited
            .map(|n| format!("{} visited", counted(n as usize, "node"))),
    );
    parts.extend(arguments.spheres.map(|level| format!("level {level}")));
    if arguments.spheres.is_some() || arguments.query.is_some() {
        parts.push(frame.sphere_count(arguments));
    }
    format!("wrote {}: {}", path.display(), parts.join(", "))
}

/// Draws frames, as `make` returns them, into their files.
fn paint<'a>(
    arguments: &Arguments,
    targets: &[(Option<u64>, PathBuf)],
    make: impl Fn(Option<u64>) -> Result<Frame<'a>, ToolError>,
    out: &mut dyn Write,
) -> Result<(), ToolError> {
    // Of a sequence one frame at a time: all of them may be too many for memory.
    let mut bounds = Bounds::new(arguments);
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
    let mut painter = Painter::new(arguments, studio, bounds, frame)?;
    for (number, path) in targets {
        let frame = match (targets.len(), last.take()) {
            (1, Some(only)) => only,
            _ => make(*number)?,
        };
        let (image, growths) = painter.paint(&frame)?;
        write_whole(path, |w| image.write_png(w))?;
        if arguments.json {
            let report = Report::of(arguments, path, &frame, &growths, &painter);
            write_json(out, &report)?;
        } else {
            let done = summary(arguments, path, &frame);
            writeln!(out, "{done}").map_err(ToolError::Stdout)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::posture_text;
    use crate::posture::PostureArguments;

    #[test]
    fn a_caption_names_what_poses_the_mesh() {
        let rest = PostureArguments::default();
        let joints = PostureArguments {
            joints: Some("joints.npy".into()),
            ..PostureArguments::default()
        };
        let clip = PostureArguments {
            clip: Some("Run".to_string()),
            time: 0.25,
            ..PostureArguments::default()
        };
        let bent = PostureArguments {
            q: Some("0.5,0".parse().expect("two numbers")),
            ..clip.clone()
        };
        for (q, frame, asked, text) in [
            ([0.0; 2], None, &rest, "at rest"),
            ([0.5, 0.0], None, &rest, "q = 0.5, 0"),
            ([0.0; 2], None, &joints, "joints as given"),
            ([0.5, 0.0], None, &joints, "joints as given, q = 0.5, 0"),
            ([0.5, 0.0], None, &clip, "Run at 0.250 s"),
            ([0.5, 0.0], None, &bent, "Run at 0.250 s, q = 0.5, 0"),
            ([0.5, 0.0], Some(3), &rest, "frame 3"),
        ] {
            assert_eq!(posture_text(&q, frame, None, asked, "at rest"), text);
        }
    }
}
