//! Many cases, on several threads, with a watchdog; what is wrong is told with the command that repeats
//! it.

use std::collections::BTreeMap;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use super::{Case, Examined, Sources, Watchdog};
use crate::judge::Judgement;

/// Cases to examine.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    /// Of the random numbers.
    pub seed: u64,
    /// The first case.
    pub first: u64,
    /// How many.
    pub cases: u64,
    /// Threads that examine them; at least one.
    pub threads: usize,
    /// Longest time for one case.
    pub limit: Duration,
}

/// What became of the cases.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    /// Files that were made.
    pub files: u64,
    /// Opened.
    pub opened: u64,
    /// Opened and refused by `verify`.
    pub refused: u64,
    /// Files passed by `verify` and compared with brute force.
    pub compared: u64,
    /// Queries that gave an answer.
    pub answers: u64,
    /// Queries that said that the file is corrupt.
    pub corrupt: u64,
    /// Changed numbers: files whose bounds do not hold, all of them refused.
    pub broken: u64,
    /// Changed numbers: files whose bounds hold, none of them refused.
    pub holding: u64,
    /// Changed numbers: too close to call.
    pub unclear: u64,
    /// The case that took longest.
    pub longest: (Duration, u64),
    /// Files by damage: made, opened, refused.
    pub by_damage: BTreeMap<String, [u64; 3]>,
    /// Cases that panicked, and what they said, at most 20.
    pub failures: Vec<(u64, String)>,
}

impl Summary {
    fn add(&mut self, number: u64, case: &Examined) {
        self.files += 1;
        self.opened += u64::from(case.opened);
        self.refused += u64::from(case.refused);
        self.compared += u64::from(case.compared);
        self.answers += case.answers.given;
        self.corrupt += case.answers.corrupt;
        match &case.judgement {
            Some(Judgement::Broken(_)) => self.broken += 1,
            Some(Judgement::Holds) => self.holding += 1,
            Some(Judgement::Unclear) => self.unclear += 1,
            None => {}
        }
        self.longest = self.longest.max((case.took, number));
        let counts = self
            .by_damage
            .entry(format!("{:?}", case.damage))
            .or_default();
        let flags = [true, case.opened, case.refused];
        for (count, flag) in counts.iter_mut().zip(flags) {
            *count += u64::from(flag);
        }
    }

    fn merge(&mut self, other: Self) {
        self.files += other.files;
        self.opened += other.opened;
        self.refused += other.refused;
        self.compared += other.compared;
        self.answers += other.answers;
        self.corrupt += other.corrupt;
        self.broken += other.broken;
        self.holding += other.holding;
        self.unclear += other.unclear;
        self.longest = self.longest.max(other.longest);
        for (damage, counts) in other.by_damage {
            let own = self.by_damage.entry(damage).or_default();
            own.iter_mut().zip(counts).for_each(|(a, b)| *a += b);
        }
        self.failures.extend(other.failures);
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} files: {} opened, {} of them refused by verify; {} passed and compared with brute force",
            self.files, self.opened, self.refused, self.compared
        )?;
        writeln!(
            f,
            "numbers changed: {} files with a bound that does not hold, all refused; {} whose bounds \
             hold, none refused; {} too close to call",
            self.broken, self.holding, self.unclear
        )?;
        writeln!(
            f,
            "{} answers, {} of the form 'corrupt asset'; longest case {:?} (case {})",
            self.answers, self.corrupt, self.longest.0, self.longest.1
        )?;
        for (damage, [files, opened, refused]) in &self.by_damage {
            writeln!(
                f,
                "  {damage:9} {files:8} files {opened:8} opened {refused:8} refused"
            )?;
        }
        for (case, what) in &self.failures {
            writeln!(f, "case {case}: {what}")?;
        }
        Ok(())
    }
}

impl Run {
    /// Examines all cases. A panic of one is a failure and the others go on; `tell` is told now and then
    /// how many are done.
    ///
    /// # Panics
    /// When a sound file cannot be made.
    pub fn go(self, sources: &Sources, tell: impl Fn(u64, Duration) + Sync) -> Summary {
        let begin = Instant::now();
        let threads = self.threads.max(1);
        let watchdog = Watchdog::set(threads, self.limit);
        let next = AtomicU64::new(0);
        let total = Mutex::new(Summary::default());
        std::thread::scope(|scope| {
            for worker in 0..threads {
                let (watchdog, next, total, tell) = (&watchdog, &next, &total, &tell);
                scope.spawn(move || {
                    let mut summary = Summary::default();
                    loop {
                        let done = next.fetch_add(1, Ordering::Relaxed);
                        if done >= self.cases {
                            break;
                        }
                        let number = self.first + done;
                        watchdog.begin(worker, number);
                        let seed = self.seed;
                        let case = Case { seed, number };
                        match catch_unwind(AssertUnwindSafe(|| case.examine(sources))) {
                            Ok(examined) => summary.add(number, &examined),
                            Err(panic) => {
                                summary.files += 1;
                                if summary.failures.len() < 20 {
                                    summary.failures.push((number, words(&*panic)));
                                }
                            }
                        }
                        watchdog.end(worker);
                        if done > 0 && done.is_multiple_of(20_000) {
                            tell(done, begin.elapsed());
                        }
                    }
                    if let Ok(mut total) = total.lock() {
                        total.merge(summary);
                    }
                });
            }
        });
        total
            .into_inner()
            .expect("no worker panics while it holds it")
    }
}

/// What a panic said.
fn words(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    let text = text.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
    text.unwrap_or_else(|| "a panic without words".to_string())
}
