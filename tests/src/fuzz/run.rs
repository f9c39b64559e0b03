//! Campaigns: many cases, what became of them, and what must not have happened.

use std::any::Any;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use cpu_time::ThreadTime;

use super::follow::{End, follow};
use super::memory::measured;
use super::read::{Desk, Failed, Thing, wrong_lines};
use super::watch::Watch;
use super::written_out::written_out;
use super::{Case, Format, Limits, Seeds, mutate};

/// Most failures that are listed.
const FAILURES_MAX: usize = 20;

/// What became of the cases of a format.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Cases that ran.
    pub cases: u64,
    /// That were read.
    pub read: u64,
    /// That were refused with an error.
    pub refused: u64,
    /// Of those read: baked (scenes: answered), verified and queried beside brute force.
    pub right: u64,
    /// Of those read: refused by a later stage, with an error.
    pub refused_later: u64,
    /// Most seconds of the processor that reading took, and the case.
    pub slowest: (f64, u64),
    /// Most bytes of memory that reading took, and the case.
    pub largest: (usize, u64),
    /// What must not happen, with the arguments that repeat it; the first ones.
    pub failures: Vec<String>,
    /// All of them.
    pub failure_count: u64,
}

impl Tally {
    /// Both together.
    pub fn add(&mut self, other: Self) {
        self.cases += other.cases;
        self.read += other.read;
        self.refused += other.refused;
        self.right += other.right;
        self.refused_later += other.refused_later;
        if other.slowest.0 > self.slowest.0 {
            self.slowest = other.slowest;
        }
        self.largest = self.largest.max(other.largest);
        self.failure_count += other.failure_count;
        self.failures.extend(other.failures);
        self.failures.truncate(FAILURES_MAX);
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (seconds, slowest) = self.slowest;
        let (bytes, largest) = self.largest;
        write!(
            f,
            "{:>9} cases {:>9} read {:>9} refused {:>8} baked or answered {:>6} refused later; \
             reading at most {:.0} ms (case {slowest}), {} KiB (case {largest}); {} failures",
            self.cases,
            self.read,
            self.refused,
            self.right,
            self.refused_later,
            1e3 * seconds,
            bytes >> 10,
            self.failure_count
        )
    }
}

/// Runs cases on the thread that made it.
pub struct Campaign<'s> {
    seeds: &'s Seeds,
    desk: Desk,
    watch: Watch,
    /// One in this many files that were read goes on to a bake and queries; 0: none.
    follow_every: u64,
}

impl<'s> Campaign<'s> {
    /// One in `follow_every` files that can be read goes on to a bake and queries; 0: none.
    ///
    /// # Panics
    /// When there is no room for temporary files.
    pub fn new(seeds: &'s Seeds, follow_every: u64) -> Self {
        Self {
            seeds,
            desk: Desk::new(),
            watch: Watch::new(),
            follow_every,
        }
    }

    /// The cases with these numbers.
    pub fn run(&self, format: Format, seed: u64, numbers: impl IntoIterator<Item = u64>) -> Tally {
        let mut tally = Tally::default();
        for number in numbers {
            let case = Case {
                format,
                seed,
                number,
            };
            self.watch.begin(case);
            tally.cases += 1;
            if let Err(message) = self.one(case, &mut tally) {
                tally.failure_count += 1;
                if tally.failures.len() < FAILURES_MAX {
                    let start: String = message.chars().take(400).collect();
                    tally.failures.push(format!("{case}: {start}"));
                }
            }
            self.watch.end();
        }
        tally
    }

    /// The file of a case.
    pub fn file(&self, case: Case) -> Vec<u8> {
        mutate::file(case, self.seeds, &mut mutate::rng(case)).0
    }

    /// Reads a case, and follows it; what must not have happened is the error.
    fn one(&self, case: Case, tally: &mut Tally) -> Result<(), String> {
        let mut rng = mutate::rng(case);
        let (bytes, size) = mutate::file(case, self.seeds, &mut rng);
        let path = self.desk.put(case.format, &bytes);
        let begin = ThreadTime::now();
        let (result, peak) = measured(case, Limits::STOP_BYTES, || {
            catch_unwind(AssertUnwindSafe(|| {
                self.desk.read(case.format, &path, &mut rng)
            }))
        });
        let seconds = begin.elapsed().as_secs_f64();
        if seconds > tally.slowest.0 {
            tally.slowest = (seconds, case.number);
        }
        tally.largest = tally.largest.max((peak, case.number));
        let result = result.map_err(|payload| format!("panics: {}", text(&payload)))?;
        if seconds > Limits::read_seconds(case.format) {
            return Err(format!("{seconds:.1} s for {size} bytes"));
        }
        let limit = Limits::read_bytes(case.format)
            + Limits::read_bytes_per_byte(case.format) * size
            + Limits::BYTES_WRITTEN_OUT * written_out(case.format, &bytes);
        if peak > limit {
            return Err(format!("{peak} bytes of memory for {size} bytes"));
        }
        let thing = match result {
            Ok(thing) => thing,
            Err(Failed::Wrong(message)) => return Err(message),
            Err(Failed::Refused(lines)) => {
                tally.refused += 1;
                if lines.is_empty() {
                    return Err("refused without a problem".to_string());
                }
                return told(&lines, Some(&path));
            }
        };
        tally.read += 1;
        told(warnings(&thing), Some(&path))?;
        if self.follow_every == 0 || !tally.read.is_multiple_of(self.follow_every) {
            return Ok(());
        }
        let begin = ThreadTime::now();
        let (end, _) = measured(case, Limits::STOP_BYTES, || {
            catch_unwind(AssertUnwindSafe(|| follow(thing, &mut rng)))
        });
        let seconds = begin.elapsed().as_secs_f64();
        let end = end.map_err(|payload| format!("follow-up panics: {}", text(&payload)))?;
        if seconds > Limits::FOLLOW_SECONDS {
            return Err(format!("{seconds:.1} s for baking {size} bytes"));
        }
        match end {
            End::Right => tally.right += 1,
            End::Nothing => {}
            End::Refused(lines) => {
                tally.refused_later += 1;
                return told(&lines, None);
            }
        }
        Ok(())
    }
}

/// Warnings of a thing.
fn warnings(thing: &Thing) -> &[String] {
    match thing {
        Thing::Model(model) => &model.mesh.warnings,
        Thing::Sequence(sequence, _) => &sequence.warnings,
        Thing::Volume(volume) => &volume.warnings,
        Thing::Basis(..) | Thing::Scene(..) | Thing::Used => &[],
    }
}

/// Refusals and warnings have lines, all of them fit to be shown; those of readers name the file.
fn told(lines: &[String], path: Option<&Path>) -> Result<(), String> {
    wrong_lines(lines, path).map_or(Ok(()), Err)
}

fn text(payload: &Box<dyn Any + Send>) -> String {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    let text = text.or(payload.downcast_ref::<&str>().copied());
    text.unwrap_or("no message").to_string()
}
