//! Reading typed fields out of JSON while collecting every problem with its place.

use std::collections::BTreeMap;
use std::fmt::Display;

use super::json::Json;
use crate::output::one_line;

/// Largest magnitude of coordinates and lengths that queries take: 2^100.
const ARGUMENT_MAX: f64 = (1_u128 << 100) as f64;

/// Every problem of one source: lines of the form `scene.json: queries[2].ball.radius: negative`.
#[derive(Debug)]
pub(super) struct Problems {
    source: String,
    lines: Vec<String>,
    /// How many there are, listed or not.
    count: usize,
}

/// Problems that are listed; of more, their number.
const PROBLEMS_MAX: usize = 100;

impl Problems {
    /// None yet, of a source with this name.
    pub(super) fn new(source: impl Into<String>) -> Self {
        Self {
            source: source.into(),
            lines: Vec::new(),
            count: 0,
        }
    }

    /// Notes a problem at a place, a path like `queries[2].ball`; the empty one is the whole.
    pub(super) fn add(&mut self, place: &str, message: impl Display) {
        self.count += 1;
        if self.count > PROBLEMS_MAX {
            return;
        }
        let (source, message) = (&self.source, message.to_string());
        let message = one_line(&message);
        self.lines.push(if place.is_empty() {
            format!("{source}: {message}")
        } else {
            format!("{source}: {}: {message}", one_line(place))
        });
    }

    /// Whether there is none.
    pub(super) fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// The lines, in the order in which they were found.
    pub(super) fn into_lines(mut self) -> Vec<String> {
        let more = self.count - self.lines.len();
        if more > 0 {
            let source = &self.source;
            self.lines.push(format!("{source}: {more} more problems"));
        }
        self.lines
    }

    fn mismatch(&mut self, place: &str, expected: impl Display, found: &Json) {
        self.add(
            place,
            format_args!("expected {expected}, found {}", found.what()),
        );
    }
}

/// A value and its place.
#[derive(Debug, Clone)]
pub(super) struct At<'j> {
    /// The value.
    pub(super) json: &'j Json,
    /// Its path.
    pub(super) place: String,
}

impl<'j> At<'j> {
    /// The whole of a text.
    pub(super) fn root(json: &'j Json) -> Self {
        Self {
            json,
            place: String::new(),
        }
    }

    /// The items of a list.
    pub(super) fn items(&self, problems: &mut Problems) -> Option<Vec<At<'j>>> {
        let Json::List(list) = self.json else {
            problems.mismatch(&self.place, "a list", self.json);
            return None;
        };
        let item = |(i, json)| At {
            json,
            place: format!("{}[{i}]", self.place),
        };
        Some(list.iter().enumerate().map(item).collect())
    }

    /// The entries of an object.
    pub(super) fn entries(&self, problems: &mut Problems) -> Option<&'j BTreeMap<String, Json>> {
        let Json::Object(object) = self.json else {
            problems.mismatch(&self.place, "an object", self.json);
            return None;
        };
        Some(object)
    }

    /// The value of a key.
    pub(super) fn entry(&self, key: &str, json: &'j Json) -> At<'j> {
        let dot = if self.place.is_empty() { "" } else { "." };
        At {
            json,
            place: format!("{}{dot}{key}", self.place),
        }
    }

    /// The fields of an object that has no other keys than `known`.
    pub(super) fn fields(&self, known: &[&str], problems: &mut Problems) -> Option<Fields<'j>> {
        let object = self.entries(problems)?;
        for (key, json) in object {
            if !known.contains(&key.as_str()) {
                let place = self.entry(key, json).place;
                problems.add(
                    &place,
                    format_args!("unknown field (known: {})", known.join(", ")),
                );
            }
        }
        Some(Fields {
            at: self.clone(),
            object,
        })
    }

    /// A number.
    pub(super) fn number(&self, problems: &mut Problems) -> Option<f64> {
        let Json::Number(x) = self.json else {
            problems.mismatch(&self.place, "a number", self.json);
            return None;
        };
        Some(*x)
    }

    /// A level of a tree, 0 for the root's; deeper than any tree counts as no limit.
    pub(super) fn level(&self, problems: &mut Problems) -> Option<usize> {
        let x = self.number(problems)?;
        if !(x >= 0.0 && x.fract() == 0.0) {
            problems.add(&self.place, "not a whole number of at least 0");
            return None;
        }
        Some(x as usize) // saturates
    }

    /// A list of numbers of any length.
    pub(super) fn numbers(&self, problems: &mut Problems) -> Option<Vec<f64>> {
        let items = self.items(problems)?;
        let numbers: Vec<f64> = items.iter().filter_map(|x| x.number(problems)).collect();
        (numbers.len() == items.len()).then_some(numbers)
    }

    /// `N` numbers.
    fn array<const N: usize>(&self, problems: &mut Problems) -> Option<[f64; N]> {
        let numbers = self.numbers(problems)?;
        <[f64; N]>::try_from(numbers)
            .map_err(|found| {
                let found = found.len();
                problems.add(
                    &self.place,
                    format_args!("expected {N} numbers, found {found}"),
                );
            })
            .ok()
    }

    /// A point: three coordinates that queries take.
    pub(super) fn point(&self, problems: &mut Problems) -> Option<[f64; 3]> {
        let point = self.array::<3>(problems)?;
        let far = point.iter().position(|x| !(x.abs() <= ARGUMENT_MAX));
        if let Some(axis) = far {
            problems.add(&format!("{}[{axis}]", self.place), "beyond 2^100");
            return None;
        }
        Some(point)
    }

    /// A vector of any length but zero.
    pub(super) fn direction(&self, problems: &mut Problems) -> Option<[f64; 3]> {
        let vector = self.array::<3>(problems)?;
        if vector == [0.0; 3] {
            problems.add(&self.place, "zero vector");
            return None;
        }
        Some(vector)
    }
}

/// The fields of an object.
#[derive(Debug)]
pub(super) struct Fields<'j> {
    at: At<'j>,
    object: &'j BTreeMap<String, Json>,
}

impl<'j> Fields<'j> {
    /// A field that may be absent.
    pub(super) fn optional(&self, key: &str) -> Option<At<'j>> {
        Some(self.at.entry(key, self.object.get(key)?))
    }

    /// A field that must be there.
    pub(super) fn required(&self, key: &str, problems: &mut Problems) -> Option<At<'j>> {
        let found = self.optional(key);
        if found.is_none() {
            problems.add(&self.place(key), "missing");
        }
        found
    }

    /// The path of a field.
    pub(super) fn place(&self, key: &str) -> String {
        self.at.entry(key, &Json::Null).place
    }

    /// A string that must be there.
    pub(super) fn text(&self, key: &str, problems: &mut Problems) -> Option<&'j str> {
        let at = self.required(key, problems)?;
        let Json::Text(text) = at.json else {
            problems.mismatch(&at.place, "a string", at.json);
            return None;
        };
        Some(text)
    }

    /// `N` numbers that must be there.
    pub(super) fn array<const N: usize>(
        &self,
        key: &str,
        problems: &mut Problems,
    ) -> Option<[f64; N]> {
        self.required(key, problems)?.array(problems)
    }

    /// A point: three coordinates that queries take.
    pub(super) fn point(&self, key: &str, problems: &mut Problems) -> Option<[f64; 3]> {
        self.required(key, problems)?.point(problems)
    }

    /// A quaternion within 1e-3 of unit length.
    pub(super) fn quaternion(&self, key: &str, problems: &mut Problems) -> Option<[f64; 4]> {
        let rotation = self.array::<4>(key, problems)?;
        let norm = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !((norm - 1.0).abs() <= 1e-3) {
            let message = format_args!("a quaternion of length {norm}, not within 1e-3 of 1");
            problems.add(&self.place(key), message);
            return None;
        }
        Some(rotation)
    }

    /// Three lengths.
    pub(super) fn lengths(&self, key: &str, problems: &mut Problems) -> Option<[f64; 3]> {
        let lengths = self.point(key, problems)?;
        let negative = lengths.iter().position(|x| *x < 0.0);
        if let Some(axis) = negative {
            problems.add(&format!("{}[{axis}]", self.place(key)), "negative");
            return None;
        }
        Some(lengths)
    }

    /// A vector of any length but zero.
    pub(super) fn direction(&self, key: &str, problems: &mut Problems) -> Option<[f64; 3]> {
        self.required(key, problems)?.direction(problems)
    }

    /// A number of either sign that queries take.
    pub(super) fn offset(&self, key: &str, problems: &mut Problems) -> Option<f64> {
        let x = self.required(key, problems)?.number(problems)?;
        if !(x.abs() <= ARGUMENT_MAX) {
            problems.add(&self.place(key), "beyond 2^100");
            return None;
        }
        Some(x)
    }

    /// A length that must be there.
    pub(super) fn length(&self, key: &str, problems: &mut Problems) -> Option<f64> {
        let x = self.offset(key, problems)?;
        if x < 0.0 {
            problems.add(&self.place(key), "negative");
            return None;
        }
        Some(x)
    }

    /// Whether a field is there and true.
    pub(super) fn flag(&self, key: &str, problems: &mut Problems) -> Option<bool> {
        let Some(at) = self.optional(key) else {
            return Some(false);
        };
        let Json::Bool(flag) = at.json else {
            problems.mismatch(&at.place, "true or false", at.json);
            return None;
        };
        Some(*flag)
    }

    /// A whole number that may be absent or null: no limit.
    pub(super) fn count(&self, key: &str, problems: &mut Problems) -> Option<u64> {
        /// Above, f64 does not hold all whole numbers.
        const COUNT_MAX: f64 = (1_u64 << 53) as f64;
        let at = self.optional(key).filter(|at| *at.json != Json::Null)?;
        let x = at.number(problems)?;
        if !(0.0..=COUNT_MAX).contains(&x) || x.fract() != 0.0 {
            problems.add(&at.place, "not a whole number from 0 to 2^53");
            return None;
        }
        Some(x as u64)
    }

    /// A length that may be absent or null: no limit.
    pub(super) fn limit(&self, key: &str, problems: &mut Problems) -> Option<f64> {
        match self.optional(key) {
            None => Some(f64::INFINITY),
            Some(at) if *at.json == Json::Null => Some(f64::INFINITY),
            Some(_) => self.length(key, problems),
        }
    }
}
