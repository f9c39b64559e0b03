//! Reading typed values out of JSON while collecting every problem with its place.
//!
//! Readers return `None` once the problem is noted, so that a caller goes on with the next field and a
//! scene's problems are told all at once.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::fmt::Display;

use super::json::Json;
use crate::output::one_line;

/// Largest magnitude of coordinates and lengths that queries take: 2^100.
const ARGUMENT_MAX: f64 = (1_u128 << 100) as f64;

/// Problems that are listed; of more, their number.
const PROBLEMS_MAX: usize = 100;

/// Every problem of one source: lines of the form `scene.json: queries[2].ball.radius: negative`.
#[derive(Debug)]
pub(super) struct Problems {
    source: String,
    lines: RefCell<Vec<String>>,
    /// How many there are, listed or not.
    count: Cell<usize>,
}

impl Problems {
    /// None yet, of a source with this name.
    pub(super) fn new(source: impl Into<String>) -> Self {
        Self {
            source: source.into(),
            lines: RefCell::default(),
            count: Cell::default(),
        }
    }

    /// Notes a problem at a place, a path like `queries[2].ball`; the empty one is the whole.
    fn add(&self, place: &str, message: impl Display) {
        self.count.set(self.count() + 1);
        if self.count() > PROBLEMS_MAX {
            return;
        }
        let (source, message) = (&self.source, one_line(&message.to_string()));
        self.lines.borrow_mut().push(match place {
            "" => format!("{source}: {message}"),
            _ => format!("{source}: {}: {message}", one_line(place)),
        });
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.count.get()
    }

    /// The lines, in the order in which they were found.
    pub(super) fn into_lines(self) -> Vec<String> {
        let more = self.count().saturating_sub(PROBLEMS_MAX);
        let mut lines = self.lines.into_inner();
        if more > 0 {
            lines.push(format!("{}: {more} more problems", self.source));
        }
        lines
    }
}

/// A value, its place, and where problems with it go.
#[derive(Debug, Clone)]
pub(super) struct At<'j> {
    /// The value.
    pub(super) json: &'j Json,
    /// Its path.
    pub(super) place: String,
    pub(super) problems: &'j Problems,
}

impl<'j> At<'j> {
    /// Notes a problem.
    pub(super) fn fail<T>(&self, message: impl Display) -> Option<T> {
        self.problems.add(&self.place, message);
        None
    }

    fn mismatch<T>(&self, expected: &str) -> Option<T> {
        let found = self.json.what();
        self.fail(format_args!("expected {expected}, found {found}"))
    }

    /// Notes a problem unless there is none.
    pub(super) fn ensure(&self, is_right: bool, message: impl Display) -> Option<()> {
        if is_right {
            Some(())
        } else {
            self.fail(message)
        }
    }

    /// Numbers of this list that all have to be right; the problem of the first one that is not stands at its place.
    pub(super) fn ensure_all<const N: usize>(
        &self,
        numbers: [f64; N],
        is_right: impl Fn(f64) -> bool,
        message: &str,
    ) -> Option<[f64; N]> {
        let Some(wrong) = numbers.iter().position(|x| !is_right(*x)) else {
            return Some(numbers);
        };
        self.item(wrong, self.json).fail(message)
    }

    /// An item of this list.
    pub(super) fn item(&self, index: usize, json: &'j Json) -> At<'j> {
        let place = format!("{}[{index}]", self.place);
        At {
            json,
            place,
            ..*self
        }
    }

    /// The items of a list.
    pub(super) fn items(&self) -> Option<Vec<At<'j>>> {
        let Json::List(list) = self.json else {
            return self.mismatch("a list");
        };
        let item = |(i, json)| self.item(i, json);
        Some(list.iter().enumerate().map(item).collect())
    }

    /// The items of a list, when all of them are sound.
    pub(super) fn all<T>(&self, read: impl Fn(&At<'j>) -> Option<T>) -> Option<Vec<T>> {
        let items = self.items()?;
        let sound: Vec<T> = items.iter().filter_map(read).collect();
        (sound.len() == items.len()).then_some(sound)
    }

    /// The entries of an object.
    pub(super) fn entries(&self) -> Option<&'j BTreeMap<String, Json>> {
        match self.json {
            Json::Object(object) => Some(object),
            _ => self.mismatch("an object"),
        }
    }

    /// The value of a key.
    pub(super) fn entry(&self, key: &str, json: &'j Json) -> At<'j> {
        let dot = if self.place.is_empty() { "" } else { "." };
        let place = format!("{}{dot}{key}", self.place);
        At {
            json,
            place,
            ..*self
        }
    }

    /// The fields of an object that has no other keys than `known`, names with `, ` between them.
    pub(super) fn fields(&self, known: &str) -> Option<Fields<'j>> {
        let object = self.entries()?;
        for (key, json) in object {
            let is_known = known.split(", ").any(|name| name == key);
            let message = format_args!("unknown field (known: {known})");
            self.entry(key, json).ensure(is_known, message);
        }
        let at = self.clone();
        Some(Fields { at, object })
    }

    /// A string.
    pub(super) fn text(&self) -> Option<&'j str> {
        match self.json {
            Json::Text(text) => Some(text),
            _ => self.mismatch("a string"),
        }
    }

    /// `true` or `false`.
    pub(super) fn flag(&self) -> Option<bool> {
        match self.json {
            Json::Bool(flag) => Some(*flag),
            _ => self.mismatch("true or false"),
        }
    }

    /// A number.
    pub(super) fn number(&self) -> Option<f64> {
        match self.json {
            Json::Number(x) => Some(*x),
            _ => self.mismatch("a number"),
        }
    }

    /// A whole number from 0 to `max`.
    pub(super) fn whole(&self, max: f64, message: &str) -> Option<f64> {
        let x = self.number()?;
        self.ensure(x.fract() == 0.0 && (0.0..=max).contains(&x), message)?;
        Some(x)
    }

    /// A number of either sign that queries take.
    pub(super) fn offset(&self) -> Option<f64> {
        let x = self.number()?;
        self.ensure(x.abs() <= ARGUMENT_MAX, "beyond 2^100")?;
        Some(x)
    }

    /// A length that queries take.
    pub(super) fn length(&self) -> Option<f64> {
        let x = self.offset()?;
        self.ensure(x >= 0.0, "negative")?;
        Some(x)
    }

    /// `N` numbers.
    pub(super) fn array<const N: usize>(&self) -> Option<[f64; N]> {
        let numbers = self.all(At::number)?;
        let expected = |found: Vec<f64>| {
            let found = found.len();
            self.fail::<()>(format_args!("expected {N} numbers, found {found}"))
        };
        <[f64; N]>::try_from(numbers).map_err(expected).ok()
    }

    /// A point: three coordinates that queries take.
    pub(super) fn point(&self) -> Option<[f64; 3]> {
        let point = self.array()?;
        self.ensure_all(point, |x| x.abs() <= ARGUMENT_MAX, "beyond 2^100")
    }

    /// Three lengths.
    pub(super) fn lengths(&self) -> Option<[f64; 3]> {
        let lengths = self.point()?;
        self.ensure_all(lengths, |x| x >= 0.0, "negative")
    }

    /// A vector of any length but zero.
    pub(super) fn direction(&self) -> Option<[f64; 3]> {
        let vector = self.array()?;
        self.ensure(vector != [0.0; 3], "zero vector")?;
        Some(vector)
    }

    /// A quaternion within 1e-3 of unit length.
    pub(super) fn quaternion(&self) -> Option<[f64; 4]> {
        let rotation = self.array::<4>()?;
        let norm = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
        let message = format_args!("a quaternion of length {norm}, not within 1e-3 of 1");
        self.ensure((norm - 1.0).abs() <= 1e-3, message)?;
        Some(rotation)
    }
}

/// The fields of an object.
#[derive(Debug)]
pub(super) struct Fields<'j> {
    at: At<'j>,
    object: &'j BTreeMap<String, Json>,
}

impl<'j> Fields<'j> {
    /// A field, null where it is absent.
    pub(super) fn at(&self, key: &str) -> At<'j> {
        self.at
            .entry(key, self.object.get(key).unwrap_or(&Json::Null))
    }

    /// A field that may be absent.
    pub(super) fn optional(&self, key: &str) -> Option<At<'j>> {
        self.object.contains_key(key).then(|| self.at(key))
    }

    /// A field that may be absent or null.
    pub(super) fn nullable(&self, key: &str) -> Option<At<'j>> {
        Some(self.at(key)).filter(|at| *at.json != Json::Null)
    }

    /// The value of a field that must be there.
    pub(super) fn get<T>(&self, key: &str, read: impl FnOnce(&At<'j>) -> Option<T>) -> Option<T> {
        let at = self.at(key);
        at.ensure(self.object.contains_key(key), "missing")?;
        read(&at)
    }

    /// The value of a field that may be absent.
    pub(super) fn get_or<T>(
        &self,
        key: &str,
        absent: T,
        read: impl FnOnce(&At<'j>) -> Option<T>,
    ) -> Option<T> {
        self.optional(key).map_or(Some(absent), |at| read(&at))
    }

    /// A length; absent or null: no limit.
    pub(super) fn limit(&self, key: &str) -> Option<f64> {
        self.nullable(key).map_or(Some(f64::INFINITY), |at| {
            let x = at.number()?;
            at.ensure(x >= 0.0, "negative")?;
            Some(x)
        })
    }
}
