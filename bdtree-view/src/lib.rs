//! The viewer: a window on a `.bdt` file.
//!
//! [`app`] is its state without a window: posture, animation, level, probe, camera, and what is known of
//! them; plain functions. `panel` shows it as controls (egui), `picture` draws it (`bdtree-render`),
//! `window` has the window, its surface and its events (winit, wgpu). Frames are drawn when something
//! has changed or plays, else none.
#![forbid(unsafe_code)]

pub mod app;
mod cli;
mod panel;
mod picture;
mod shapes;
mod stage;
mod surface;
mod window;

pub use cli::{Arguments, ProbeText};
pub use panel::WIDTH as PANEL_WIDTH;

use std::ffi::OsString;
use std::io::Write;

use bdtree_tools::{AssetFile, BAD_INPUT, DONE, ToolError, parse, posture};

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
    match open(&arguments) {
        Ok(()) => DONE,
        Err(error) => {
            let _ = writeln!(err, "{error}");
            BAD_INPUT
        }
    }
}

fn open(arguments: &Arguments) -> Result<(), ToolError> {
    if let Some(path) = &arguments.screenshot {
        let problem = |what: &str| ToolError::Input(vec![format!("{}: {what}", path.display())]);
        if !path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("png"))
        {
            return Err(problem("unknown extension: .png can be written"));
        }
        let both = (path.canonicalize(), arguments.file.canonicalize());
        if matches!(both, (Ok(to), Ok(from)) if to == from) {
            return Err(problem("is the input: it would be overwritten"));
        }
    }
    let file = AssetFile::map(&arguments.file)?;
    let asset = file.checked_asset(!arguments.no_verify)?;
    let frame = arguments.frame.or(arguments.play.then_some(0));
    let posture = posture(&file, arguments.q.as_ref(), frame)?;
    if let Some(level) = arguments.spheres
        && level >= asset.depth()
    {
        let (levels, path) = (asset.depth(), file.path().display());
        return Err(ToolError::Input(vec![format!(
            "--spheres: {level} is out of range: asset {path} has {levels} levels, numbered from 0"
        )]));
    }
    let mut app = App::new(&file, posture)?;
    app.view.level = arguments.spheres;
    if let Some(ProbeText { center, radius }) = arguments.probe {
        app.view.has_probe = true;
        app.view.probe = Probe { center, radius };
    }
    if let Some(frame) = arguments.frame {
        // `posture` has found it.
        app.playback
            .go_to(usize::try_from(frame).unwrap_or(usize::MAX));
    }
    app.playback.is_playing = arguments.play;
    window::run(app, arguments.size.0, arguments.screenshot.as_deref())
}
