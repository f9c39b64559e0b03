//! What every step did: a line of a table, kept as CSV, and the sums over all steps.

use std::error::Error;
use std::fmt::{self, Display, Formatter};
use std::path::Path;

use bdtree_measure::stats::{median, quantile};
use serde_json::{Value, json};

use crate::logs::file::LogFile;

/// Numbers of a step, and their names as columns of its table.
pub(crate) trait Numbers: Copy {
    const NAMES: &'static [&'static str];

    fn numbers(&self) -> Vec<f64>;

    /// As many numbers as names.
    fn from_numbers(numbers: &[f64]) -> Option<Self>;
}

/// A struct of numbers.
macro_rules! columns {
    ($(#[$about:meta])* $of:ident { $($(#[$what:meta])* $name:ident,)* }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[allow(non_snake_case, reason = "J is a unit")]
        pub(crate) struct $of { $($(#[$what])* pub(crate) $name: f64,)* }

        impl $crate::falling::log::Numbers for $of {
            const NAMES: &'static [&'static str] = &[$(stringify!($name)),*];

            fn numbers(&self) -> Vec<f64> {
                vec![$(self.$name),*]
            }

            fn from_numbers(numbers: &[f64]) -> Option<Self> {
                let mut from = numbers.iter();
                let row = Self { $($name: *from.next()?,)* };
                from.next().is_none().then_some(row)
            }
        }
    };
}
pub(crate) use columns;

columns! {
/// What a step of any scene did.
Common {
    /// Number of the step; the first is 1.
    step,
    /// Those that have begun to fall.
    bodies,
    /// Pairs of contact spheres in contact, ground included.
    events,
    /// Pairs of bodies that are near each other, ground included.
    pairs,
    /// Pairs of spheres that the trees found.
    candidates,
    nodes_visited,
    nodes_updated,
    /// Nodes whose eight spheres were updated, of all nodes of all trees.
    updated_share,
    /// The same of the nodes down to the level of the contact spheres.
    updated_share_to_level,
    /// Contacts whose springs begin at the overlap that they were found with.
    late,
    sweeps,
    /// Largest overlap.
    penetration_m,
    penetration_share,
    /// Energies at the beginning of the step.
    kinetic_J,
    modal_J,
    potential_J,
    contact_J,
    /// Pairs of bodies whose contacts were compared with brute force.
    checked,
    /// Overlaps that it found.
    overlaps,
    /// Those that the world has no contact for, and the deepest of them.
    missed,
    missed_m,
    /// Overlaps of the world that it did not find.
    extra,
    /// Of the step by the clock.
    seconds,
}
}

/// What a step did; all as the CSV file has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row<N> {
    pub(crate) common: Common,
    /// What only this scene tells.
    pub(crate) own: N,
}

/// Columns of the CSV file.
pub(crate) fn names<N: Numbers>() -> Vec<&'static str> {
    [Common::NAMES, N::NAMES].concat()
}

impl<N: Numbers> Row<N> {
    fn numbers(&self) -> Vec<f64> {
        [self.common.numbers(), self.own.numbers()].concat()
    }

    fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let (common, own) = numbers.split_at_checked(Common::NAMES.len())?;
        Some(Self {
            common: Common::from_numbers(common)?,
            own: N::from_numbers(own)?,
        })
    }
}

/// Steps that one program made on one machine: from one on, up to the next part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Part {
    pub(crate) from: u64,
    /// Commit, threads, processor.
    pub(crate) by: String,
}

impl Part {
    /// That of a line `# part: from step 1: …`.
    fn of(said: &str) -> Option<Self> {
        let (from, by) = said.strip_prefix("from step ")?.split_once(": ")?;
        let (from, by) = (from.parse().ok()?, by.to_string());
        Some(Self { from, by })
    }
}

impl Display for Part {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "from step {}: {}", self.from, self.by)
    }
}

/// All steps so far.
#[derive(Debug)]
pub(crate) struct Log<N> {
    pub(crate) parts: Vec<Part>,
    pub(crate) rows: Vec<Row<N>>,
}

impl<N: Numbers> Log<N> {
    pub(super) fn new() -> Self {
        Self {
            parts: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// Steps from one on are made by `by`; those before may have been made by something else.
    pub(super) fn begin(&mut self, from: u64, by: String) {
        if let (Some(first), true) = (self.rows.first(), self.parts.is_empty()) {
            self.parts.push(Part {
                from: first.common.step as u64,
                by: "not known".to_string(),
            });
        }
        if self.parts.last().is_none_or(|last| last.by != by) {
            self.parts.push(Part { from, by });
        }
    }

    /// The rows up to a step of the file of an earlier run, which may have none.
    pub(super) fn up_to(path: &Path, step: u64) -> Result<Self, Box<dyn Error>> {
        let wrong = |what: &str| format!("{}: {what}", path.display());
        match path.try_exists() {
            Ok(true) => {}
            Ok(false) => return Ok(Self::new()),
            Err(error) => return Err(wrong(&error.to_string()).into()),
        }
        let file = LogFile::read(path)?;
        // In any order.
        let names = names::<N>();
        let place = |name: &&str| file.columns.iter().position(|own| own == name);
        let places: Option<Vec<usize>> = names.iter().map(place).collect();
        let Some(places) = places.filter(|places| places.len() == file.columns.len()) else {
            return Err(wrong("has other columns than this program writes").into());
        };
        let parts = file.said("part").map(Part::of).collect::<Option<Vec<_>>>();
        let mut parts = parts.ok_or_else(|| wrong("a part does not begin with `from step N: `"))?;
        parts.retain(|part| part.from <= step);
        let mut rows = Vec::new();
        for row in &file.rows {
            let numbers: Vec<f64> = places.iter().map(|place| row[*place]).collect();
            let row = Row::<N>::from_numbers(&numbers);
            let row = row.ok_or_else(|| wrong("has other columns than this program writes"))?;
            if row.common.step <= step as f64 {
                rows.push(row);
            }
        }
        let follows = |pair: &[Row<N>]| pair[1].common.step == pair[0].common.step + 1.0;
        let ends = rows.last().is_none_or(|row| row.common.step == step as f64);
        if !ends || !rows.windows(2).all(follows) {
            return Err(wrong("its steps do not lead up to the checkpoint").into());
        }
        Ok(Self { parts, rows })
    }

    /// Writes the CSV file, whole or not at all.
    pub(super) fn write(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        let parts = self.parts.iter();
        let file = LogFile {
            about: parts
                .map(|part| ("part".to_string(), part.to_string()))
                .collect(),
            columns: names::<N>().into_iter().map(str::to_string).collect(),
            rows: self.rows.iter().map(Row::numbers).collect(),
        };
        file.write(path)
    }

    fn all(&self, of: impl Fn(&Row<N>) -> f64) -> Vec<f64> {
        self.rows.iter().map(of).collect()
    }

    pub(crate) fn sum(&self, of: impl Fn(&Row<N>) -> f64) -> f64 {
        self.rows.iter().map(of).sum()
    }

    /// The largest, at least 0.
    pub(crate) fn most(&self, of: impl Fn(&Row<N>) -> f64) -> f64 {
        self.rows.iter().map(of).fold(0.0, f64::max)
    }

    /// Sum, mean, median and largest of a column.
    pub(crate) fn about(&self, of: impl Fn(&Row<N>) -> f64 + Copy) -> Value {
        let (sum, all) = (self.sum(of), self.all(of));
        json!({"sum": sum, "mean": sum / all.len() as f64, "median": median(&all),
            "most": self.most(of)})
    }

    /// Counts and sizes: the same in every run.
    pub(super) fn totals(&self) -> Value {
        if self.rows.is_empty() {
            return json!({"steps": 0});
        }
        json!({
            "steps": self.rows.len(), "first_step": self.rows.first().map(|row| row.common.step),
            "bodies": self.rows.last().map(|row| row.common.bodies),
            "events": self.about(|row| row.common.events), "pairs": self.about(|row| row.common.pairs),
            "candidates": self.about(|row| row.common.candidates), "late": self.about(|row| row.common.late),
            "sweeps": self.about(|row| row.common.sweeps),
            "penetration_m": self.most(|row| row.common.penetration_m),
            "penetration_share": self.most(|row| row.common.penetration_share),
            "checked": self.sum(|row| row.common.checked), "overlaps": self.sum(|row| row.common.overlaps),
            "missed": self.sum(|row| row.common.missed), "missed_m": self.most(|row| row.common.missed_m),
            "extra": self.sum(|row| row.common.extra),
        })
    }

    /// Nodes of trees, which depend on threads, that do not share spheres, and on breaks: the step after one asks the
    /// trees of all pairs again.
    pub(super) fn updates(&self) -> Value {
        if self.rows.is_empty() {
            return json!({});
        }
        json!({"nodes_visited": self.about(|row| row.common.nodes_visited),
            "nodes_updated": self.about(|row| row.common.nodes_updated),
            "share": self.about(|row| row.common.updated_share),
            "share_to_level": self.about(|row| row.common.updated_share_to_level)})
    }

    /// Times of steps.
    pub(super) fn times(&self) -> Value {
        if self.rows.is_empty() {
            return json!({});
        }
        let all = self.all(|row| row.common.seconds);
        let (sum, events) = (
            self.sum(|row| row.common.seconds),
            self.sum(|row| row.common.events),
        );
        let parts: Vec<String> = self.parts.iter().map(Part::to_string).collect();
        json!({"parts": parts, "seconds": sum, "seconds_per_step": sum / all.len() as f64,
            "median_seconds_per_step": median(&all), "most_seconds_per_step": quantile(&all, 1.0),
            "events_per_second": events / sum, "microseconds_per_event": 1e6 * sum / events})
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    columns! {
    /// A column that may be empty.
    Own {
        lowest_m,
    }
    }

    fn row(step: f64) -> Row<Own> {
        let mut numbers = vec![0.25; Common::NAMES.len()];
        numbers[0] = step;
        Row {
            common: Common::from_numbers(&numbers).expect("all numbers"),
            own: Own { lowest_m: f64::NAN },
        }
    }

    #[test]
    fn rows_are_read_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("steps.csv");
        let read = |step: u64| Log::<Own>::up_to(&path, step);
        assert!(read(3).expect("no file").rows.is_empty());
        let mut log = Log::new();
        log.begin(3, "this".to_string());
        log.rows = (3..9).map(|step| row(f64::from(step))).collect();
        log.write(&path).expect("written");
        let again = read(6).expect("read");
        assert_eq!(again.rows.len(), 4);
        assert_eq!(again.rows[3].common, row(6.0).common);
        assert!(again.rows[3].own.lowest_m.is_nan());
        read(9).expect_err("step 9 is not there");
        // Columns in another order are the same table.
        let text = fs::read_to_string(&path).expect("the table");
        let turned: Vec<String> = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(',').rev().collect::<Vec<_>>().join(","))
            .collect();
        fs::write(&path, turned.join("\n")).expect("written");
        assert_eq!(read(6).expect("read").rows[3].common, row(6.0).common);
        fs::write(&path, "step\n1\n").expect("written");
        read(1).expect_err("other columns");
        let text = format!("{}\n1,2\n", names::<Own>().join(","));
        fs::write(&path, text).expect("written");
        read(1).expect_err("a short line");
    }

    /// Steps before a break keep what is said of them; whoever goes on in the same way is no other part.
    #[test]
    fn parts_are_told_apart() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("steps.csv");
        let mut log = Log::<Own>::new();
        log.rows = (1..5).map(|step| row(f64::from(step))).collect();
        log.begin(5, "commit a, threads 2".to_string());
        log.begin(5, "commit a, threads 2".to_string());
        log.rows.push(row(5.0));
        log.begin(6, "commit b".to_string());
        log.rows.push(row(6.0));
        let texts =
            |log: &Log<Own>| -> Vec<String> { log.parts.iter().map(Part::to_string).collect() };
        let all = [
            "from step 1: not known",
            "from step 5: commit a, threads 2",
            "from step 6: commit b",
        ];
        assert_eq!(texts(&log), all);
        log.write(&path).expect("written");
        for (step, parts) in [(6, 3), (5, 2), (4, 1)] {
            let again = Log::<Own>::up_to(&path, step).expect("read");
            assert_eq!(texts(&again), all[..parts]);
            assert_eq!(again.rows.len(), step as usize);
        }
        let text = fs::read_to_string(&path).expect("the table");
        fs::write(&path, text.replace("step 6:", "step x:")).expect("written");
        Log::<Own>::up_to(&path, 6).expect_err("a part that begins nowhere");
    }
}
