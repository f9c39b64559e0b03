//! A run: wave after wave, step after step, with all that is written meanwhile.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use bdtree_dynamics::{DynamicsError, StepReport};
use bdtree_measure::machine;
use serde_json::{Value, json};

use super::log::{Common, Log, Row};
use super::progress::Progress;
use super::show::{self, Show};
use super::{Options, Scene, check, checkpoint};
use crate::film::{Frames, film_command};
use crate::report::{Report, commit};

/// Simulates up to a step, and writes what is asked for.
///
/// # Errors
/// Files that cannot be read or written, a checkpoint of another run, a step that failed, what the scene's verdict is;
/// what was logged until then is written.
pub(crate) fn run<S: Scene>(
    scene: S,
    steps: u64,
    options: Options,
) -> Result<Report, Box<dyn Error>> {
    let mut run = Run::new(scene, steps, options)?;
    let failed = run.steps().err();
    run.progress.end();
    let report = run.end(failed.as_ref().map(ToString::to_string))?;
    match failed {
        None => Ok(report),
        Some(error) => {
            if let Some(folder) = &run.options.out {
                report.write(folder)?;
            }
            Err(error)
        }
    }
}

pub(super) struct Run<S: Scene> {
    pub(super) options: Options,
    pub(super) steps: u64,
    pub(super) scene: S,
    pub(super) log: Log<S::Own>,
    pub(super) show: Option<Show>,
    frames: Option<Frames>,
    progress: Progress,
    pub(super) loads: Vec<String>,
    /// Resident set after the last step.
    pub(super) memory_bytes: Option<u64>,
}

impl<S: Scene> Run<S> {
    fn new(mut scene: S, steps: u64, options: Options) -> Result<Self, Box<dyn Error>> {
        let [width, height] = options.size[..] else {
            return Err("--size: width x height".into());
        };
        if let Some(path) = &options.resume {
            checkpoint::read(path, &mut scene)?;
        }
        crate::report::commit();
        let step = scene.world().steps();
        let mut log = Log::new();
        if let Some(folder) = &options.out {
            fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
            if step > 0 {
                log = Log::up_to(&folder.join(table_name::<S>()), step)?;
            }
        }
        // What cannot be written is better known before hours than after them.
        let own = scene.pictures();
        let files = options.checkpoint.iter().chain(&options.picture);
        for path in files.chain(&own) {
            bdtree_output::check_writable(path)?;
        }
        let draws = options.frames.is_some() || options.picture.is_some() || !own.is_empty();
        let show = match draws {
            true => Some(Show::new(&scene, [width, height])?),
            false => None,
        };
        let frames = match &options.frames {
            // That of the step of the checkpoint is drawn already, if there is one.
            Some(folder) => {
                let next = step.div_ceil(S::STEPS_PER_FRAME)
                    + u64::from(step > 0 && step.is_multiple_of(S::STEPS_PER_FRAME));
                Some(Frames::from(folder, u32::try_from(next)?)?)
            }
            None => None,
        };
        Ok(Self {
            options,
            steps,
            scene,
            log,
            show,
            frames,
            progress: Progress::new(),
            loads: vec![load()],
            memory_bytes: None,
        })
    }

    fn steps(&mut self) -> Result<(), Box<dyn Error>> {
        let resumed = self.scene.world().steps() > 0;
        self.scene.add_due()?;
        if !resumed {
            self.frame()?;
        }
        let (steps, every) = (self.steps, self.options.checkpoint_every);
        let first = self.scene.world().steps() + 1;
        if first <= steps {
            let (commit, processor) = (commit(), machine::processor());
            let by = format!(
                "commit {commit}, threads {}, {processor}",
                self.options.threads
            );
            self.log.begin(first, by);
        }
        while self.scene.world().steps() < steps {
            self.scene.add_due()?;
            self.scene.drive()?;
            let row = self.step()?;
            self.log.rows.push(row);
            let step = self.scene.world().steps();
            if step.is_multiple_of(S::STEPS_PER_FRAME) {
                self.frame()?;
            }
            if step.is_multiple_of(every) && step < steps {
                self.keep()?;
            }
            (self.progress).tell(step, steps, self.scene.fallen(), row.common.events);
        }
        self.keep()?;
        self.scene.verdict(&self.log)
    }

    /// A step, and what is checked of it.
    fn step(&mut self) -> Result<Row<S::Own>, Box<dyn Error>> {
        let scene = &mut self.scene;
        let number = scene.world().steps() + 1;
        let every = self.options.check_every;
        let is_checked = every > 0 && number.is_multiple_of(every);
        let pairs = if is_checked {
            check::pairs(scene)?
        } else {
            Vec::new()
        };
        let energy = scene.world().energy();
        let start = Instant::now();
        let report = scene.world_mut().step();
        let seconds = start.elapsed().as_secs_f64();
        let report: StepReport =
            report.map_err(|error: DynamicsError| format!("step {number}: {error}"))?;
        let found = check::compare(scene, &pairs);
        let own = scene.own()?;
        let sums = energy.mechanical() + report.contact_energy;
        if !sums.is_finite() {
            return Err(format!("step {number}: the energy is not finite").into());
        }
        let [nodes, to_level] = scene.nodes().map(|nodes| nodes as f64);
        let updated = report.nodes_updated as f64;
        let common = Common {
            step: number as f64,
            bodies: scene.fallen() as f64,
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
            checked: found.pairs as f64,
            overlaps: found.overlaps as f64,
            missed: found.missed as f64,
            missed_m: found.missed_depth,
            extra: found.extra as f64,
            seconds,
        };
        Ok(Row { common, own })
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
        if let Some(path) = &self.options.checkpoint {
            checkpoint::write(path, &self.scene)?;
            if self.options.keep_all {
                let mut kept = path.clone().into_os_string();
                kept.push(format!("-{}", self.scene.world().steps()));
                checkpoint::write(Path::new(&kept), &self.scene)?;
            }
        }
        Ok(())
    }

    fn csv(&self) -> Option<PathBuf> {
        let folder = self.options.out.as_ref()?;
        Some(folder.join(table_name::<S>()))
    }

    /// Pictures of the end and the report; after a failure the log too.
    fn end(&mut self, failure: Option<String>) -> Result<Report, Box<dyn Error>> {
        self.loads.push(load());
        // Not the peak: making the asset may take more than all steps, and so may the picture of the end.
        self.memory_bytes = machine::status_bytes("VmRSS");
        if failure.is_some()
            && let Some(path) = self.csv()
        {
            self.log.write(&path)?;
        }
        let (mut drawn, mut own) = (Value::Null, json!({}));
        if let Some(show) = &mut self.show {
            let contacts = show.contacts(&self.scene);
            if let Some(path) = &self.options.picture {
                show::write(path, &show.picture(&self.scene, &contacts)?)?;
            }
            own = self.scene.draw(show, &self.log)?;
            drawn = show.told();
        }
        if let Some(folder) = &self.options.frames {
            let film = folder.with_extension("mp4");
            println!("{}\n", film_command(folder, 0, 30, &film));
        }
        Ok(self.report(failure, drawn, own))
    }
}

fn table_name<S: Scene>() -> String {
    format!("{}-steps.csv", S::NAME)
}

/// How many programs run at once, by the system's means over 1, 5 and 15 minutes.
fn load() -> String {
    let text = fs::read_to_string("/proc/loadavg").unwrap_or_default();
    text.split_whitespace()
        .take(3)
        .collect::<Vec<_>>()
        .join(" ")
}
