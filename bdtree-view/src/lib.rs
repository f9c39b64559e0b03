//! The viewer: a window on a `.bdt` file.
//!
//! [`app`] is its state without a window: posture, animation, level, probe, camera, and what is known of
//! them; plain functions. `panel` shows it as controls (egui), `layout` has these and the picture side by side, with what mouse and
//! keyboard do, `picture` draws it (`bdtree-render`),
//! `window` has the window and its events (winit), `stage` what draws in it (wgpu); both show any `content`. Frames are drawn when something
//! has changed or plays, else none.
//!
//! [`playground`] is another program with the same window: bodies that fall.
#![forbid(unsafe_code)]

pub mod app;
mod cli;
mod content;
mod layout;
mod orbit;
mod panel;
#[cfg(test)]
mod person;
mod picture;
pub mod playground;
mod shapes;
mod stage;
mod surface;
mod viewer;
mod window;

pub use cli::{Arguments, ProbeText};
pub use panel::WIDTH as PANEL_WIDTH;

use std::ffi::OsString;
use std::io::Write;

use bdtree_output::check_writable;
use bdtree_tools::render::check_level;
use bdtree_tools::{AssetFile, BAD_INPUT, DONE, ToolError, check_target, parse, posture};

use app::{App, Probe};

/// Runs the viewer with `arguments` (the program's name first) until its window is closed and returns
/// its exit code.
pub fn run(
    arguments: impl IntoIterator<Item = OsString>,
    out: &mut dyn Write,
    err: &mut dyn Write,
) -> u8 {
    let arguments = match parse::<Arguments>(arguments, out, err) {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    match open(&arguments, out) {
        Ok(()) => DONE,
        Err(error) => {
            let _ = writeln!(err, "{error}");
            error.code(BAD_INPUT)
        }
    }
}

fn open(arguments: &Arguments, out: &mut dyn Write) -> Result<(), ToolError> {
    if let Some(path) = &arguments.screenshot {
        check_target(path, &arguments.file, &["png"], ".png")?;
    }
    let file = AssetFile::map(&arguments.file)?;
    if let Some(path) = &arguments.screenshot {
        check_writable(path)?;
    }
    file.checked_asset(!arguments.no_verify)?;
    let mut asked = arguments.posture.clone();
    if arguments.play && asked.clip.is_none() {
        if file.asset().frame_count() == 0 {
            let name = arguments.file.display();
            let has_clips = file.asset().skeleton().is_some_and(|s| s.clip_count() > 0);
            let hint = match has_clips {
                true => "; choose a clip with --clip",
                false => "",
            };
            let message = format!("asset {name} has no animation{hint}");
            return Err(ToolError::input("--play", message));
        }
        asked.frame = asked.frame.or(Some(0));
    }
    let mut app = App::new(&file, posture(&file, &asked)?)?;
    app.up = arguments.upright.up.direction();
    if let Some(level) = arguments.spheres {
        check_level(&file, level)?;
    }
    app.view.level = arguments.spheres;
    if let Some(ProbeText { center, radius }) = arguments.probe {
        app.view.has_probe = true;
        app.view.probe = Probe { center, radius };
    }
    if let Some(frame) = arguments.posture.frame {
        // `posture` has found it.
        app.playback
            .go_to(usize::try_from(frame).unwrap_or(usize::MAX));
    }
    if let Some(name) = &asked.clip {
        // `posture` has found it, too.
        let skeleton = file.asset().skeleton();
        let clip = skeleton.and_then(|s| s.clip_index(name));
        app.begin_clip(clip.unwrap_or_default(), asked.time, arguments.play);
    } else {
        app.playback.clock.is_playing = arguments.play;
    }
    let copied = window::run(&mut app, arguments.size.0, arguments.screenshot.as_deref())?;
    if let (Some(path), Some([width, height])) = (&arguments.screenshot, copied) {
        let path = path.display();
        writeln!(out, "wrote {path}: {width} x {height} pixels").map_err(ToolError::Stdout)?;
    }
    Ok(())
}
