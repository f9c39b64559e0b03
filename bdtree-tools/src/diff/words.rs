//! Records in words: the names and values of their parts, of which only those are shown that differ.

use bdtree_format::{ModeMetadata, NodeRecord, TriangleRecord, VertexModes};
use bdtree_runtime::Group;

use crate::output::{Shortest, digits, printable};

/// A record's parts: name and value, the same names in the same order for every record of a kind. The name of the
/// only part of a plain value is empty.
pub(super) trait Words {
    /// The parts.
    fn words(&self) -> Vec<(&'static str, String)>;
}

/// A value that is its own word.
macro_rules! plain {
    ($($type:ty),+) => {
        $(impl Words for $type {
            fn words(&self) -> Vec<(&'static str, String)> {
                vec![("", self.to_string())]
            }
        })+
    };
}

plain!(u8, u16, u32);

impl Words for String {
    fn words(&self) -> Vec<(&'static str, String)> {
        vec![("", printable(self))]
    }
}

impl Words for NodeRecord {
    fn words(&self) -> Vec<(&'static str, String)> {
        let lanes = |mask: u8| list((0..8).filter(|lane| mask & (1 << lane) != 0));
        vec![
            ("first_child", self.first_child.to_string()),
            ("first_slot", self.first_slot.to_string()),
            ("row_start", self.row_start.to_string()),
            ("mode_list_start", self.mode_list_start.to_string()),
            ("mode_count", self.mode_count.to_string()),
            ("level", self.level.to_string()),
            ("inner lanes", lanes(self.inner_mask)),
            ("leaf lanes", lanes(self.leaf_mask)),
            ("triangles per leaf lane", list(self.leaf_counts)),
        ]
    }
}

impl Words for TriangleRecord {
    fn words(&self) -> Vec<(&'static str, String)> {
        let id = self.id;
        vec![
            ("triangle", id.to_string()),
            ("corners", list(self.corners)),
        ]
    }
}

impl Words for VertexModes {
    fn words(&self) -> Vec<(&'static str, String)> {
        vec![
            ("first_entry", self.first_entry.to_string()),
            ("mode_list_start", self.mode_list_start.to_string()),
        ]
    }
}

impl Words for Group<'_> {
    fn words(&self) -> Vec<(&'static str, String)> {
        vec![
            ("kind", format!("{:?}", self.kind).to_lowercase()),
            ("name", printable(self.name)),
            ("first triangle", self.first_triangle.0.to_string()),
            ("triangles", self.triangle_count.to_string()),
        ]
    }
}

impl Words for ModeMetadata {
    fn words(&self) -> Vec<(&'static str, String)> {
        let name = self.name.as_deref().map(printable);
        let weight = self.default_q.map(|q| Shortest(q).to_string());
        vec![("name", known(name)), ("default weight", known(weight))]
    }
}

/// A value, or that there is none.
pub(super) fn known(value: Option<String>) -> String {
    value.unwrap_or_else(|| "unknown".to_string())
}

/// Items with spaces between them.
fn list<T: ToString>(items: impl IntoIterator<Item = T>) -> String {
    let items: Vec<String> = items.into_iter().map(|item| item.to_string()).collect();
    match items.is_empty() {
        true => "none".to_string(),
        false => items.join(" "),
    }
}

/// What two records differ in, part by part.
pub(super) fn differences<T: Words>(a: &T, b: &T) -> String {
    let (a, b) = (a.words(), b.words());
    let differ = a.iter().zip(&b).filter(|(a, b)| a != b);
    let differ = differ.map(|((name, a), (_, b))| match *name {
        "" => format!("{a} and {b}"),
        name => format!("{name} {a} and {b}"),
    });
    differ.collect::<Vec<_>>().join("; ")
}

/// Two numbers that are not the same, with as many digits as show it.
pub(super) fn two(a: f64, b: f64) -> String {
    let few = [a, b].map(digits);
    match few[0] == few[1] {
        false => few.join(" and "),
        true => format!("{} and {}", Shortest(a), Shortest(b)),
    }
}

/// A number with at most three significant digits.
pub(super) fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    Shortest(rounded).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_or_as_many_as_differ() {
        for (x, text) in [
            (0.2, "0.2"),
            (0.012345, "0.0123"),
            (123.45, "123"),
            (2.076e-7, "2.08e-7"),
            (1234567.0, "1230000"),
        ] {
            assert_eq!(short(x), text);
        }
        assert_eq!(two(0.5, 0.25), "0.5 and 0.25");
        assert_eq!(two(1.0, 1.0 + 1e-9), "1 and 1.000000001");
        assert_eq!(two(0.0, -0.0), "0 and -0");
    }

    #[test]
    fn only_parts_that_differ_are_told() {
        let a = TriangleRecord {
            corners: [1, 2, 3],
            id: 7,
        };
        let b = TriangleRecord { id: 8, ..a };
        assert_eq!(differences(&a, &b), "triangle 7 and 8");
        let b = TriangleRecord {
            corners: [1, 2, 4],
            ..a
        };
        assert_eq!(differences(&a, &b), "corners 1 2 3 and 1 2 4");
        assert_eq!(differences(&3_u16, &4), "3 and 4");
    }
}
