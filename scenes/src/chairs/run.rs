//! A run: wave after wave, step after step, with all that is written meanwhile.

use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use bdtree_dynamics::{DynamicsError, StepReport};
use bdtree_measure::machine;
use bdtree_runtime::Model;
use serde_json::{Value, json};

use super::log::{Log, Row};
use super::progress::Progress;
use super::scene::Scene;
use super::show::{self, Show};
use super::updated::updated;
use super::{Arguments, check, checkpoint};
use crate::film::{Frames, film_command};
use crate::report::{Report, table};
use crate::{row, tables};

/// Steps from a film's picture to the next, of which 30 are a second.
const STEPS_PER_FRAME: u64 = 5;

/// Simulates, and writes what is asked for.
///
/// # Errors
/// Files that cannot be read or written, a checkpoint of another run, a step that failed, something below the ground; what
/// was logged until then is written.
pub fn run(arguments: Arguments) -> Result<Report, Box<dyn Error>> {
    let model = match &arguments.asset {
        Some(path) => Model::read(path)?,
        None => tables::chair()?,
    };
    let scene = Scene::new(&arguments, model)?;
    let mut run = Run::new(arguments, scene)?;
    let failed = run.steps().err();
    run.progress.end();
    let report = run.end(failed.as_ref().map(ToString::to_string))?;
    match failed {
        None => Ok(report),
        Some(error) => {
            if let Some(folder) = &run.arguments.out {
                report.write(folder)?;
            }
            Err(error)
        }
    }
}

struct Run {
    arguments: Arguments,
    scene: Scene,
    log: Log,
    show: Option<Show>,
    frames: Option<Frames>,
    progress: Progress,
    loads: Vec<String>,
}

impl Run {
    fn new(arguments: Arguments, mut scene: Scene) -> Result<Self, Box<dyn Error>> {
        let [width, height] = arguments.size[..] else {
            return Err("--size: width x height".into());
        };
        if let Some(path) = &arguments.resume {
            checkpoint::read(path, &arguments, &mut scene)?;
        }
        let step = scene.world.steps();
        // What cannot be written is better known before hours than after them.
        let files = [
            &arguments.checkpoint,
            &arguments.picture,
            &arguments.updated,
        ];
        for path in files.into_iter().flatten() {
            bdtree_output::check_writable(path)?;
        }
        let mut log = Log::default();
        if let Some(folder) = &arguments.out {
            fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
            if step > 0 {
                log = Log::up_to(&folder.join("chairs-steps.csv"), step)?;
            }
        }
        let draws = [&arguments.frames, &arguments.picture, &arguments.updated];
        let show = match draws.iter().any(|path| path.is_some()) {
            true => Some(Show::new(&scene, [width, height])?),
            false => None,
        };
        let frames = match &arguments.frames {
            // That of the step of the checkpoint is drawn already, if there is one.
            Some(folder) => {
                let next = step.div_ceil(STEPS_PER_FRAME)
                    + u64::from(step > 0 && step.is_multiple_of(STEPS_PER_FRAME));
                Some(Frames::from(folder, u32::try_from(next)?)?)
            }
            None => None,
        };
        Ok(Self {
            arguments,
            scene,
            log,
            show,
            frames,
            progress: Progress::new(),
            loads: vec![load()],
        })
    }

    fn steps(&mut self) -> Result<(), Box<dyn Error>> {
        let resumed = self.scene.world.steps() > 0;
        self.scene.add_wave()?;
        if !resumed {
            self.frame()?;
        }
        let (steps, every) = (self.arguments.steps, self.arguments.checkpoint_every);
        while self.scene.world.steps() < steps {
            self.scene.add_wave()?;
            let row = self.step()?;
            self.log.rows.push(row);
            let step = self.scene.world.steps();
            if step.is_multiple_of(STEPS_PER_FRAME) {
                self.frame()?;
            }
            if step.is_multiple_of(every) && step < steps {
                self.keep()?;
            }
            self.progress
                .tell(step, steps, self.scene.world.len(), row.events);
        }
        self.keep()?;
        let below = self.log.sum(|row| row.below);
        if below > 0.0 {
            return Err(format!("{below} contact spheres were below the ground").into());
        }
        Ok(())
    }

    /// A step, and what is checked of it.
    fn step(&mut self) -> Result<Row, Box<dyn Error>> {
        let scene = &mut self.scene;
        let number = scene.world.steps() + 1;
        let every = self.arguments.check_every;
        let is_checked = every > 0 && number.is_multiple_of(every);
        let pairs = if is_checked {
            check::pairs(scene)?
        } else {
            Vec::new()
        };
        let energy = scene.world.energy();
        let start = Instant::now();
        let report = scene.world.step();
        let seconds = start.elapsed().as_secs_f64();
        let report: StepReport =
            report.map_err(|error: DynamicsError| format!("step {number}: {error}"))?;
        let found = check::compare(scene, &pairs);
        let (lowest_m, below) = check::ground(scene)?;
        let sums = energy.mechanical() + report.contact_energy;
        if !sums.is_finite() {
            return Err(format!("step {number}: the energy is not finite").into());
        }
        let bodies = scene.world.len() as f64;
        let [nodes, to_level] = scene.nodes().map(|nodes| bodies * nodes as f64);
        let updated = report.nodes_updated as f64;
        Ok(Row {
            step: number as f64,
            bodies,
            events: report.events as f64,
            pairs: report.pairs as f64,
            candidates: report.candidates as f64,
            nodes_visited: report.nodes_visited as f64,
            nodes_updated: updated,
            updated_share: updated / nodes,
            updated_share_to_level: updated / to_level,
            late: report.late as f64,
            sweeps: report.sweeps as f64,
            penetration_m: report.penetration,
            penetration_share: report.penetration_rel,
            kinetic_J: energy.kinetic,
            modal_J: energy.modal,
            potential_J: energy.potential,
            contact_J: report.contact_energy,
            lowest_m,
            below: below as f64,
            checked: found.pairs as f64,
            overlaps: found.overlaps as f64,
            missed: found.missed as f64,
            missed_m: found.missed_depth,
            extra: found.extra as f64,
            seconds,
        })
    }

    /// A picture for the film.
    fn frame(&mut self) -> Result<(), Box<dyn Error>> {
        if let (Some(frames), Some(show)) = (&mut self.frames, &mut self.show) {
            let contacts = show.contacts(&self.scene);
            frames.write(&show.picture(&self.scene, &contacts)?)?;
        }
        Ok(())
    }

    /// The log first: a checkpoint without the steps before it would be refused.
    fn keep(&self) -> Result<(), Box<dyn Error>> {
        if let Some(path) = self.csv() {
            self.log.write(&path)?;
        }
        if let Some(path) = &self.arguments.checkpoint {
            checkpoint::write(path, &self.arguments, &self.scene)?;
        }
        Ok(())
    }

    fn csv(&self) -> Option<PathBuf> {
        let folder = self.arguments.out.as_ref()?;
        Some(folder.join("chairs-steps.csv"))
    }

    /// Pictures of the end and the report; after a failure the log too.
    fn end(&mut self, failure: Option<String>) -> Result<Report, Box<dyn Error>> {
        self.loads.push(load());
        if failure.is_some()
            && let Some(path) = self.csv()
        {
            self.log.write(&path)?;
        }
        let mut drawn = Value::Null;
        if let Some(show) = &mut self.show {
            let contacts = show.contacts(&self.scene);
            if let Some(path) = &self.arguments.picture {
                show::write(path, &show.picture(&self.scene, &contacts)?)?;
            }
            if let Some(path) = &self.arguments.updated {
                let updated = updated(&self.scene)?;
                show::write(path, &show.picture(&self.scene, &updated.spheres)?)?;
                drawn = json!({"nodes": updated.nodes, "spheres_shown": updated.spheres.len(),
                    "counted_by_the_step": self.log.rows.last().map(|row| row.nodes_updated),
                    "nodes_of_all_trees": self.scene.world.len() * self.scene.nodes()[0]});
            }
        }
        if let Some(folder) = &self.arguments.frames {
            let film = folder.with_extension("mp4");
            println!("{}\n", film_command(folder, 0, 30, &film));
        }
        Ok(self.report(failure, &drawn))
    }

    fn report(&self, failure: Option<String>, drawn: &Value) -> Report {
        let Arguments {
            bodies,
            steps,
            seed,
            threads,
            rigid,
            redundant_updates,
            ..
        } = self.arguments;
        let scene = &self.scene;
        let radii = scene.spheres.radii();
        let mean = radii.iter().sum::<f64>() / radii.len() as f64;
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let [nodes, to_level] = scene.nodes();
        let (totals, updates, times) = (self.log.totals(), self.log.updates(), self.log.times());
        let number =
            |of: &Value, at: &str| of.pointer(at).and_then(Value::as_f64).unwrap_or(f64::NAN);
        let kind = match (rigid, redundant_updates) {
            (false, _) => "deformable",
            (true, false) => "rigid",
            (true, true) => "rigid, redundant updates",
        };
        let about = row! {
            "bodies" => kind, "number" => scene.world.len(), "steps" => scene.world.steps(),
            "threads" => usize::from(threads), "level" => scene.spheres.level,
            "contact spheres each" => radii.len(), "mean radius, m" => mean, "largest, m" => largest,
        };
        let found = row! {
            "events" => number(&totals, "/events/sum"), "per step" => number(&totals, "/events/mean"),
            "updated of all spheres, mean" => number(&updates, "/share/mean"),
            "most" => number(&updates, "/share/most"),
            "deepest, of the radius" => number(&totals, "/penetration_share"),
            "overlaps checked" => number(&totals, "/overlaps"), "missed" => number(&totals, "/missed"),
            "extra" => number(&totals, "/extra"),
        };
        let took = row! {
            "s per step, mean" => number(&times, "/seconds_per_step"),
            "median" => number(&times, "/median_seconds_per_step"),
            "most" => number(&times, "/most_seconds_per_step"),
            "all, s" => number(&times, "/seconds"),
            "events per s" => number(&times, "/events_per_second"),
            "µs per event" => number(&times, "/microseconds_per_event"),
        };
        let value = json!({
            "settings": {"bodies": bodies, "steps": steps, "seed": seed, "rigid": rigid,
                "redundant_updates": redundant_updates, "step_s": scene.world.options().step_s,
                "stiffness": scene.world.options().law.stiffness,
                "damping_ratio": scene.world.options().law.damping_ratio,
                "friction": scene.world.options().law.friction},
            "spheres": {"level": scene.spheres.level, "count": radii.len(), "mean_radius_m": mean,
                "largest_radius_m": largest, "nodes": nodes, "nodes_to_level": to_level,
                "modes": scene.spheres.mode_count()},
            "end": scene.world.steps(), "failure": failure, "totals": totals, "updated_picture": drawn,
            // Of the machine and of the threads.
            "times": {"threads": threads, "steps": times, "updates": updates, "load": self.loads,
                "peak_memory_bytes": machine::status_bytes("VmHWM")},
        });
        Report {
            name: "chairs",
            value,
            tables: vec![
                table("bodies", "Bodies", &[about]),
                table("contacts", "Contacts", &[found]),
                table("times", "Times", &[took]),
            ],
            pictures: Vec::new(),
        }
    }
}

/// How many programs run at once, by the system's means over 1, 5 and 15 minutes.
fn load() -> String {
    let text = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split_whitespace()
        .take(3)
        .collect::<Vec<_>>()
        .join(" ")
}
