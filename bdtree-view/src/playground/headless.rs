//! Steps without a window: how long they take, and what they did.

use std::fs;
use std::io::{IsTerminal, Write, stderr};
use std::path::Path;
use std::time::{Duration, Instant};

use bdtree_output::write_whole;
use bdtree_tools::ToolError;
use serde_json::{Value, json};

use super::Arguments;
use super::picture;
use super::play::Playground;

/// What the time of simulation is told for.
const FRAMES_PER_S: f64 = 30.0;

/// What is written of every step. The last three depend on the threads and on breaks.
const COLUMNS: &str = "step,bodies,events,late,pairs,candidates,sweeps,penetration_m,penetration_share,\
                       kinetic_J,modal_J,potential_J,contact_J,nodes_visited,nodes_updated,seconds";

/// Steps, and their times.
struct Log {
    lines: Vec<String>,
    seconds: Vec<f64>,
    events: u64,
}

/// Makes the steps and writes what is asked for.
///
/// # Errors
/// A step that fails, after everything is written; files that cannot be written.
pub(super) fn run(
    play: &mut Playground,
    arguments: &Arguments,
    steps: u64,
    out: &mut dyn Write,
) -> Result<(), ToolError> {
    if let Some(folder) = &arguments.out {
        let made = fs::create_dir_all(folder);
        made.map_err(|error| ToolError::input(folder.display(), error))?;
    }
    let loads = [load()];
    let (log, failure) = make(play, steps);
    let settings = play.simulation.settings();
    let rate = (1.0 / settings.step_s).round();
    let per_frame = (rate / FRAMES_PER_S).ceil() as usize;
    let frames = Frames::of(&log.seconds, per_frame);
    let mut report = json!({
        "program": "playground",
        "settings": {"bodies": arguments.bodies, "steps": steps, "seed": arguments.seed,
            "step_s": settings.step_s, "scale": settings.scale, "rigid": arguments.rigid,
            "files": play.simulation.kinds().iter().map(|kind| kind.name.as_str()).collect::<Vec<_>>()},
        "bodies": play.simulation.of().len(), "end": play.simulation.world().steps(),
        "events": log.events, "failure": failure,
        // Of the machine and of the threads.
        "times": {"threads": settings.threads, "seconds": log.seconds.iter().sum::<f64>(),
            "steps_per_frame": per_frame, "frame_ms": frames.json(), "load": [&loads[0], &load()]},
    });
    let written = |error: std::io::Error| ToolError::Stdout(error);
    writeln!(
        out,
        "{} bodies, {} steps of 1/{} s, {} threads, {} contacts: {:.2} s",
        play.simulation.of().len(),
        log.seconds.len(),
        rate,
        settings.threads,
        log.events,
        log.seconds.iter().sum::<f64>(),
    )
    .map_err(written)?;
    if let Some([median, high, most]) = frames.figures {
        writeln!(
            out,
            "simulation per frame of {per_frame} steps: median {median:.2} ms, 95th percentile {high:.2} ms, most {most:.2} ms"
        )
        .map_err(written)?;
    }
    if let Some(path) = &arguments.screenshot {
        let drawn = picture::picture(play, arguments.size.0);
        let (image, adapter) = drawn.map_err(|error| ToolError::input(path.display(), error))?;
        write_whole(path, |out| image.write_png(out))?;
        let drawing = play.times.drawing.unwrap_or_default();
        report["times"]["drawing_ms"] = json!(drawing);
        report["times"]["adapter"] = json!(adapter);
        let [width, height] = image.size();
        let path = path.display();
        writeln!(out, "drawing {drawing:.1} ms, {adapter}").map_err(written)?;
        writeln!(out, "wrote {path}: {width} x {height} pixels").map_err(written)?;
    }
    if let Some(folder) = &arguments.out {
        write(folder, &log, &report)?;
    }
    match failure {
        Some(failure) => Err(ToolError::input("playground", failure)),
        None => Ok(()),
    }
}

/// The steps, one by one, with the time left on stderr. Stops at the first that fails.
fn make(play: &mut Playground, steps: u64) -> (Log, Option<String>) {
    let mut log = Log {
        lines: Vec::new(),
        seconds: Vec::new(),
        events: 0,
    };
    let begin = Instant::now();
    let mut told = begin;
    let every = match stderr().is_terminal() {
        true => Duration::from_millis(200),
        false => Duration::from_secs(30),
    };
    for step in 0..steps {
        let energy = play.simulation.world().energy();
        let start = Instant::now();
        let stepped = play.simulation.steps(1, None);
        let seconds = start.elapsed().as_secs_f64();
        if let Err(failure) = stepped {
            end_line();
            return (log, Some(failure.to_string()));
        }
        let report = play.simulation.report();
        log.events += report.events;
        log.seconds.push(seconds);
        log.lines.push(format!(
            "{},{},{},{},{},{},{},{:e},{:e},{:e},{:e},{:e},{:e},{},{},{:e}",
            play.simulation.world().steps(),
            play.simulation.of().len(),
            report.events,
            report.late,
            report.pairs,
            report.candidates,
            report.sweeps,
            report.penetration,
            report.penetration_rel,
            energy.kinetic,
            energy.modal,
            energy.potential,
            report.contact_energy,
            report.nodes_visited,
            report.nodes_updated,
            seconds,
        ));
        if told.elapsed() >= every {
            told = Instant::now();
            let done = step + 1;
            let left = begin.elapsed().as_secs_f64() / done as f64 * (steps - done) as f64;
            let line = format!("step {done} of {steps}, {left:.0} s left");
            // Whoever closed stderr does not want to know.
            let _ = match stderr().is_terminal() {
                true => write!(stderr(), "\r\x1b[K{line}"),
                false => writeln!(stderr(), "{line}"),
            };
        }
    }
    end_line();
    (log, None)
}

/// Removes the line of progress from a terminal.
fn end_line() {
    if stderr().is_terminal() {
        let _ = write!(stderr(), "\r\x1b[K");
    }
}

/// Milliseconds of simulation per frame.
struct Frames {
    /// Median, 95th percentile, most; of no frames nothing.
    figures: Option<[f64; 3]>,
}

impl Frames {
    fn of(seconds: &[f64], per_frame: usize) -> Self {
        let frames = seconds.chunks_exact(per_frame.max(1));
        let mut all: Vec<f64> = frames
            .map(|frame| 1e3 * frame.iter().sum::<f64>())
            .collect();
        all.sort_by(f64::total_cmp);
        let at = |share: f64| all.get(((all.len() as f64 - 1.0) * share).round() as usize);
        let figures = match (at(0.5), at(0.95), all.last()) {
            (Some(median), Some(high), Some(most)) => Some([*median, *high, *most]),
            _ => None,
        };
        Self { figures }
    }

    fn json(&self) -> Value {
        match self.figures {
            Some([median, high, most]) => json!({"median": median, "p95": high, "most": most}),
            None => Value::Null,
        }
    }
}

fn write(folder: &Path, log: &Log, report: &Value) -> Result<(), ToolError> {
    write_whole(&folder.join("playground-steps.csv"), |out| {
        writeln!(out, "{COLUMNS}")?;
        log.lines
            .iter()
            .try_for_each(|line| writeln!(out, "{line}"))
    })?;
    write_whole(&folder.join("playground.json"), |out| {
        writeln!(out, "{report:#}")
    })?;
    Ok(())
}

/// How many programs run at once, by the system's means over 1, 5 and 15 minutes.
fn load() -> String {
    let text = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let words: Vec<&str> = text.split_whitespace().take(3).collect();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::Frames;

    #[test]
    fn frames_are_whole_and_sorted() {
        let seconds: Vec<f64> = (0..103).map(|k| 1e-3 * f64::from(k / 5)).collect();
        let figures = Frames::of(&seconds, 5).figures.expect("frames");
        for (found, expected) in figures.iter().zip([50.0, 90.0, 95.0]) {
            assert!((found - expected).abs() < 1e-9, "{figures:?}");
        }
        assert!(Frames::of(&seconds[..4], 5).figures.is_none());
    }
}
