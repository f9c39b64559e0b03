//! The playground: the viewer with dynamics. Bodies of the user's own files fall onto the ground and onto each other, and
//! are pulled, poked and thrown.
//!
//! | file | part |
//! |---|---|
//! | `kinds` | files, and what bodies of them need |
//! | `simulation` | the world, step by step, with a way back |
//! | `places` | where bodies begin |
//! | `grab` | pulling and poking at a point of the surface |
//! | `pace` | how simulated time follows the clock |
//! | `play` | the state without a window, and what hands do |
//! | `panel`, `layout`, `picture` | the state in a window |
//! | `headless` | steps without a window |
//! | `checkpoint` | the state as a file |

mod checkpoint;
mod cli;
mod grab;
mod headless;
mod kinds;
mod layout;
mod pace;
mod panel;
mod picture;
mod places;
mod play;
mod random;
mod simulation;

pub use cli::Arguments;
pub use grab::Grab;
pub use kinds::{Able, Kind};
pub use pace::Pace;
pub use places::{Throw, drop_above, fill, throw};
pub use play::{Hold, Playground, Problem, Times};
pub use simulation::{Failure, RATE, Settings, Simulation, State};

use std::ffi::OsString;
use std::io::Write;

use bdtree_output::check_writable;
use bdtree_tools::{AssetFile, BAD_INPUT, DONE, ToolError, check_target, parse};

use crate::window;

/// Runs the playground with `arguments` (the program's name first) until its window is closed, or its steps are done, and
/// returns its exit code.
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
    let mut files = Vec::new();
    for path in &arguments.files {
        if let Some(picture) = &arguments.screenshot {
            check_target(picture, path, &["png"], ".png")?;
        }
        let file = AssetFile::map(path)?;
        file.checked_asset(true)?;
        files.push(file);
    }
    for path in [&arguments.screenshot, &arguments.checkpoint] {
        path.as_ref().map_or(Ok(()), |path| check_writable(path))?;
    }
    let settings = Settings {
        step_s: 1.0 / f64::from(arguments.rate.unwrap_or(RATE)),
        threads: usize::from(arguments.threads),
        scale: arguments.scale,
        is_deformable: !arguments.rigid,
        level: arguments.level,
        seed: arguments.seed,
    };
    let failed = |error: String| ToolError::input("playground", error);
    let made = |settings| {
        let made = Simulation::new(&files, settings);
        made.map_err(|error| failed(error.to_string()))
    };
    let mut simulation = made(settings)?;
    let step_s = match (arguments.rate, &arguments.resume) {
        (Some(_), _) => settings.step_s,
        (None, Some(path)) => checkpoint::step_s(path)?,
        (None, None) => 1.0 / f64::from(simulation.fitting_rate()),
    };
    if step_s != settings.step_s {
        simulation = made(Settings { step_s, ..settings })?;
    }
    if let Some(path) = &arguments.resume {
        checkpoint::read(path, &mut simulation)?;
    }
    // What cannot fall is told in the window; without one it is an error.
    let filled = places::fill(&mut simulation, arguments.bodies as usize);
    if arguments.steps.is_some() {
        filled.map_err(failed)?;
    }
    let mut play = Playground::new(simulation);
    play.checkpoint.clone_from(&arguments.checkpoint);
    match arguments.steps {
        Some(steps) => headless::run(&mut play, arguments, steps, out)?,
        None => {
            // A copy of the window is of the beginning, in every run.
            play.pace.is_running = arguments.screenshot.is_none();
            let path = arguments.screenshot.as_deref();
            let copied = window::run(&mut play, arguments.size.0, path)?;
            if let (Some(path), Some([width, height])) = (path, copied) {
                let path = path.display();
                let written = writeln!(out, "wrote {path}: {width} x {height} pixels");
                written.map_err(ToolError::Stdout)?;
            }
        }
    }
    if let Some(path) = &arguments.checkpoint {
        checkpoint::write(path, &play.simulation)?;
        let path = path.display();
        writeln!(out, "wrote {path}").map_err(ToolError::Stdout)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
