//! What differs, counted by kind with the first places.

use std::fmt;

use serde::Serialize;

use super::effects::Effect;
use super::words::{Words, differences, short, two};

/// Places that are listed per kind.
const EXAMPLES_MAX: usize = 5;

/// Ends of the names of what is several things, but compared as one.
const PLURALS: [&str; 11] = [
    "settings",
    "warnings",
    "META: modes",
    "frame and vertex",
    " names",
    " clips",
    " of clips",
    " of bones",
    " of joints",
    " of nodes",
    " of vertices",
];

/// One kind of difference.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Difference {
    /// What differs, such as `section VERT: rest positions`.
    pub what: String,
    /// How often.
    pub count: u64,
    /// How many were compared; 0 for what is compared as a whole, such as the settings.
    pub compared: u64,
    /// Largest difference over the scale, for numbers.
    pub largest_rel: Option<f64>,
    /// The first places, with what each file holds.
    pub examples: Vec<String>,
}

/// Everything that differs between two files.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Findings {
    /// Numbers may differ by this over their scale; 0: their bits are equal.
    pub(super) tolerance_rel: f64,
    /// By kind, in file order.
    pub differences: Vec<Difference>,
    /// Largest difference over its scale among the numbers that count as equal.
    pub tolerated_rel: f64,
    /// What the differences do to the mesh.
    pub effects: Vec<Effect>,
    /// What differs but does not count, and what could not be compared.
    pub notes: Vec<String>,
}

impl Findings {
    /// Nothing that counts differs.
    pub fn is_same(&self) -> bool {
        self.differences.is_empty()
    }

    /// Compares one thing.
    pub(super) fn compare<T: PartialEq + fmt::Display>(&mut self, what: &str, [a, b]: [T; 2]) {
        if a != b {
            self.differ(what, vec![format!("{a} and {b}")]);
        }
    }

    /// Notes that one thing differs, with its parts that do, in words.
    pub(super) fn differ(&mut self, what: &str, mut examples: Vec<String>) {
        if examples.len() > EXAMPLES_MAX {
            examples.truncate(EXAMPLES_MAX);
            examples.push("…".to_string());
        }
        self.differences.push(Difference {
            what: what.to_string(),
            count: 1,
            examples,
            ..Difference::default()
        });
    }

    /// Compares records of the same meaning, one by one; their number is compared elsewhere.
    pub(super) fn compare_records<T: PartialEq + Words>(
        &mut self,
        what: &str,
        element: &str,
        [a, b]: [&[T]; 2],
    ) -> bool {
        let mut difference = Difference {
            what: what.to_string(),
            compared: a.len().min(b.len()) as u64,
            ..Difference::default()
        };
        for (i, (a, b)) in a.iter().zip(b).enumerate() {
            if a != b {
                difference.note(|| format!("{element} {i}: {}", differences(a, b)));
            }
        }
        let same = difference.count == 0;
        self.add(difference);
        same
    }

    /// Numbers to be compared, whose differences are measured against `scale`.
    pub(super) fn numbers(&self, what: impl Into<String>, scale: f64) -> Numbers {
        Numbers {
            tolerance_rel: self.tolerance_rel,
            scale,
            largest_tolerated: 0.0,
            difference: Difference {
                what: what.into(),
                ..Difference::default()
            },
        }
    }

    /// Adds a kind if it was met.
    fn add(&mut self, difference: Difference) {
        if difference.count > 0 {
            self.differences.push(difference);
        }
    }
}

impl Difference {
    fn note(&mut self, example: impl FnOnce() -> String) {
        self.count += 1;
        if self.examples.len() < EXAMPLES_MAX {
            self.examples.push(example());
        }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)?;
        match self.compared {
            0 if !self.what.contains("number of")
                && PLURALS.iter().any(|plural| self.what.ends_with(plural)) =>
            {
                f.write_str(" differ")?
            }
            0 => f.write_str(" differs")?,
            n => write!(f, ": {} of {n} differ", self.count)?,
        }
        if let Some(largest) = self.largest_rel {
            write!(f, ", by at most {} of the scale", short(largest))?;
        }
        if let (0, [only]) = (self.compared, self.examples.as_slice()) {
            return write!(f, ": {only}");
        }
        for example in &self.examples {
            write!(f, "\n    {example}")?;
        }
        if self.compared > 0 && self.count > self.examples.len() as u64 {
            f.write_str("\n    …")?;
        }
        Ok(())
    }
}

/// Compares numbers of one quantity.
#[derive(Debug)]
pub(super) struct Numbers {
    tolerance_rel: f64,
    scale: f64,
    largest_tolerated: f64,
    difference: Difference,
}

impl Numbers {
    /// Compares two numbers at a place.
    pub(super) fn compare(&mut self, a: f64, b: f64, place: impl FnOnce() -> String) {
        self.compare_rounded(a, b, 0.0, place);
    }

    /// Compares two numbers which `grid` apart may be by what writers round alone: where there is
    /// a tolerance, only what is beyond counts against it.
    pub(super) fn compare_rounded(
        &mut self,
        a: f64,
        b: f64,
        grid: f64,
        place: impl FnOnce() -> String,
    ) {
        self.difference.compared += 1;
        if a.to_bits() == b.to_bits() {
            return;
        }
        let tolerated = if self.tolerance_rel > 0.0 { grid } else { 0.0 };
        let beyond = ((a - b).abs() - tolerated).max(0.0);
        let relative = beyond / self.scale;
        // A scale of 0 is that of zeros of either sign.
        if self.tolerance_rel > 0.0 && beyond <= self.tolerance_rel * self.scale {
            if beyond > 0.0 {
                self.largest_tolerated = self.largest_tolerated.max(relative);
            }
            return;
        }
        let largest = self.difference.largest_rel.unwrap_or(0.0);
        self.difference.largest_rel = Some(largest.max(relative));
        self.difference
            .note(|| format!("{}: {}", place(), two(a, b)));
    }

    /// Hands over what was found.
    pub(super) fn finish(self, findings: &mut Findings) {
        findings.tolerated_rel = findings.tolerated_rel.max(self.largest_tolerated);
        findings.add(self.difference);
    }
}

/// The largest magnitude that is a number.
pub(super) fn largest(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers
        .into_iter()
        .filter(|x| x.is_finite())
        .fold(0.0, |largest: f64, x| largest.max(x.abs()))
}
