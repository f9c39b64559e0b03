//! What every step did: a line of a table, kept as CSV, and the sums over all steps.

use std::error::Error;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use bdtree_measure::stats::{median, quantile};
use bdtree_output::write_whole;
use serde_json::{Value, json};

/// A step's numbers, and their names as columns.
macro_rules! columns {
    ($($(#[$what:meta])* $name:ident,)*) => {
        /// What a step did; all as the CSV file has it.
        #[derive(Debug, Clone, Copy, PartialEq)]
        #[allow(non_snake_case, reason = "J is a unit")]
        pub(super) struct Row { $($(#[$what])* pub(super) $name: f64,)* }

        /// Columns of the CSV file.
        pub const COLUMNS: &[&str] = &[$(stringify!($name)),*];

        impl Row {
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

columns! {
    /// Number of the step; the first is 1.
    step,
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
    /// Of the spheres' centers of some bodies near the ground at the end; none is near it: empty.
    lowest_m,
    /// Of these centers, those that are below the ground by more than the largest radius.
    below,
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

/// All steps so far.
#[derive(Debug, Default)]
pub(super) struct Log {
    pub(super) rows: Vec<Row>,
}

impl Log {
    /// The rows up to a step of the file of an earlier run, which may have none.
    pub(super) fn up_to(path: &Path, step: u64) -> Result<Self, Box<dyn Error>> {
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(format!("{}: {error}", path.display()).into()),
        };
        let mut lines = text.lines();
        let wrong = |what: &str| format!("{}: {what}", path.display());
        if lines.next() != Some(&COLUMNS.join(",")) {
            return Err(wrong("has other columns than this program writes").into());
        }
        let number = |cell: &str| match cell {
            "" => Some(f64::NAN),
            cell => cell.parse::<f64>().ok(),
        };
        let mut rows = Vec::new();
        for line in lines {
            let numbers: Option<Vec<f64>> = line.split(',').map(number).collect();
            let row = numbers.and_then(|numbers| Row::from_numbers(&numbers));
            let row = row.ok_or_else(|| wrong("a line has no row of numbers"))?;
            if row.step <= step as f64 {
                rows.push(row);
            }
        }
        let follows = |pair: &[Row]| pair[1].step == pair[0].step + 1.0;
        let ends = rows.last().is_none_or(|row| row.step == step as f64);
        if !ends || !rows.windows(2).all(follows) {
            return Err(wrong("its steps do not lead up to the checkpoint").into());
        }
        Ok(Self { rows })
    }

    /// Writes the CSV file, whole or not at all.
    pub(super) fn write(&self, path: &Path) -> Result<(), Box<dyn Error>> {
        let text = |x: f64| {
            if x.is_nan() {
                String::new()
            } else {
                x.to_string()
            }
        };
        write_whole(path, |out| {
            writeln!(out, "{}", COLUMNS.join(","))?;
            for row in &self.rows {
                let cells: Vec<String> = row.numbers().into_iter().map(text).collect();
                writeln!(out, "{}", cells.join(","))?;
            }
            Ok(())
        })?;
        Ok(())
    }

    fn all(&self, of: impl Fn(&Row) -> f64) -> Vec<f64> {
        self.rows.iter().map(of).collect()
    }

    pub(super) fn sum(&self, of: impl Fn(&Row) -> f64) -> f64 {
        self.rows.iter().map(of).sum()
    }

    /// The largest, at least 0.
    fn most(&self, of: impl Fn(&Row) -> f64) -> f64 {
        self.rows.iter().map(of).fold(0.0, f64::max)
    }

    /// Sum, mean, median and largest of a column.
    fn about(&self, of: impl Fn(&Row) -> f64 + Copy) -> Value {
        let (sum, all) = (self.sum(of), self.all(of));
        json!({"sum": sum, "mean": sum / all.len() as f64, "median": median(&all),
            "most": self.most(of)})
    }

    /// Counts and sizes: the same in every run but for updated nodes, which depend on how threads share spheres.
    pub(super) fn totals(&self) -> Value {
        if self.rows.is_empty() {
            return json!({"steps": 0});
        }
        let lowest = self
            .rows
            .iter()
            .map(|row| row.lowest_m)
            .fold(f64::NAN, f64::min);
        json!({
            "steps": self.rows.len(), "first_step": self.rows.first().map(|row| row.step),
            "bodies": self.rows.last().map(|row| row.bodies),
            "events": self.about(|row| row.events), "pairs": self.about(|row| row.pairs),
            "candidates": self.about(|row| row.candidates), "late": self.about(|row| row.late),
            "sweeps": self.about(|row| row.sweeps),
            "nodes_visited": self.about(|row| row.nodes_visited),
            "penetration_m": self.most(|row| row.penetration_m),
            "penetration_share": self.most(|row| row.penetration_share),
            "lowest_m": lowest, "below": self.sum(|row| row.below),
            "checked": self.sum(|row| row.checked), "overlaps": self.sum(|row| row.overlaps),
            "missed": self.sum(|row| row.missed), "missed_m": self.most(|row| row.missed_m),
            "extra": self.sum(|row| row.extra),
        })
    }

    /// What depends on threads.
    pub(super) fn updates(&self) -> Value {
        if self.rows.is_empty() {
            return json!({});
        }
        json!({"nodes_updated": self.about(|row| row.nodes_updated),
            "share": self.about(|row| row.updated_share),
            "share_to_level": self.about(|row| row.updated_share_to_level)})
    }

    /// Times of steps.
    pub(super) fn times(&self) -> Value {
        if self.rows.is_empty() {
            return json!({});
        }
        let all = self.all(|row| row.seconds);
        let (sum, events) = (self.sum(|row| row.seconds), self.sum(|row| row.events));
        json!({"seconds": sum, "seconds_per_step": sum / all.len() as f64,
            "median_seconds_per_step": median(&all), "most_seconds_per_step": quantile(&all, 1.0),
            "events_per_second": events / sum, "microseconds_per_event": 1e6 * sum / events})
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(step: f64) -> Row {
        let mut numbers = vec![0.25; COLUMNS.len()];
        numbers[0] = step;
        let mut row = Row::from_numbers(&numbers).expect("all numbers");
        row.lowest_m = f64::NAN;
        row
    }

    #[test]
    fn rows_are_read_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("steps.csv");
        assert!(Log::up_to(&path, 3).expect("no file").rows.is_empty());
        let log = Log {
            rows: (3..9).map(|step| row(f64::from(step))).collect(),
        };
        log.write(&path).expect("written");
        let again = Log::up_to(&path, 6).expect("read");
        assert_eq!(again.rows.len(), 4);
        assert_eq!(again.rows[3].numbers()[..7], row(6.0).numbers()[..7]);
        assert!(again.rows[3].lowest_m.is_nan());
        Log::up_to(&path, 9).expect_err("step 9 is not there");
        fs::write(&path, "step\n1\n").expect("written");
        Log::up_to(&path, 1).expect_err("other columns");
        let text = format!("{}\n1,2\n", COLUMNS.join(","));
        fs::write(&path, text).expect("written");
        Log::up_to(&path, 1).expect_err("a short line");
    }
}
