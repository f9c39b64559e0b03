//! How a .veg file numbers its vertices and elements.

use super::super::notes::Notes;

/// The numbering of vertices or elements: the number of the first one, 0 or 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Numbering {
    pub(super) base: i64,
}

/// Checks that lines are numbered one after the other from 0 or 1.
#[derive(Default)]
pub(super) struct Numbers {
    base: Option<i64>,
    /// Lines so far.
    pub(super) count: i64,
    is_broken: bool,
}

impl Numbers {
    pub(super) fn next(&mut self, number: i64, position: u64, what: &str, notes: &mut Notes<'_>) {
        let base = *self.base.get_or_insert(number.saturating_sub(self.count));
        let expected = base.saturating_add(self.count);
        self.count += 1;
        // Of a broken sequence every further line would be named.
        if self.is_broken {
            return;
        }
        if base != 0 && base != 1 {
            self.is_broken = true;
            notes.problem(
                position,
                format!("the first {what} is number {base}, neither 0 nor 1"),
            );
        } else if number != expected {
            self.is_broken = true;
            notes.problem(
                position,
                format!("expected {what} {expected}, found {number}"),
            );
        }
    }

    /// A line that could not be read.
    pub(super) fn skip(&mut self) {
        self.count += 1;
    }

    pub(super) fn numbering(&self) -> Numbering {
        Numbering {
            base: self.base.unwrap_or(1),
        }
    }
}
