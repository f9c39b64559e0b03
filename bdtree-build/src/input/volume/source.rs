//! A file's bytes as words and numbers: text by lines, text by words, or binary.

use super::number::{ByteOrder, Kind};
use crate::input::obj::tokens::{integer, show};

/// Why reading cannot go on: line or byte (0: the file as a whole), and a message.
pub(super) type Stop = (u64, String);

/// How text is cut into records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layout {
    /// A record is a line, and its words never run into the next one.
    Lines,
    /// Line ends separate words as blanks do.
    Words,
}

/// Where the reader stands in the bytes of a file.
pub(super) struct Source<'t> {
    bytes: &'t [u8],
    at: usize,
    /// The line that `at` is on, from 1.
    line: u64,
    layout: Layout,
    /// Numbers are binary, in this order; set by a reader when the file says so.
    pub(super) binary: Option<ByteOrder>,
    /// `,` separates words and `#` begins a comment.
    commas: bool,
}

impl<'t> Source<'t> {
    /// At the first byte, behind a UTF-8 mark.
    pub(super) fn new(bytes: &'t [u8], layout: Layout) -> Self {
        Self {
            bytes: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes),
            at: 0,
            line: 1,
            layout,
            binary: None,
            commas: false,
        }
    }

    /// The same with `,` between words and `#` before comments.
    pub(super) fn with_commas(self) -> Self {
        Self {
            commas: true,
            ..self
        }
    }

    /// The line, or in binary files the byte, that stands for this place in messages.
    pub(super) fn position(&self) -> u64 {
        match self.binary {
            None => self.line,
            Some(_) => self.at as u64,
        }
    }

    /// What has not been read.
    pub(super) fn rest(&self) -> &'t [u8] {
        &self.bytes[self.at..]
    }

    /// What is left of the line, its end not included. Nothing is read.
    pub(super) fn line_rest(&self) -> &'t [u8] {
        let rest = self.rest();
        let end = rest.iter().position(|&b| b == b'\n' || b == b'\r');
        &rest[..end.unwrap_or(rest.len())]
    }

    /// Leaves the line, with its end: `\n`, `\r\n` or a lone `\r`.
    pub(super) fn skip_line(&mut self) {
        self.at += self.line_rest().len();
        self.line_end();
    }

    fn line_end(&mut self) {
        let rest = self.rest();
        let end = match rest {
            [b'\r', b'\n', ..] => 2,
            [b'\r' | b'\n', ..] => 1,
            _ => return,
        };
        self.at += end;
        self.line += 1;
    }

    /// Goes to the next line, this one included, that has a word; false at the end of the file.
    pub(super) fn next_record(&mut self) -> bool {
        loop {
            self.skip_blanks();
            match self.rest().first() {
                None => return false,
                Some(b'\r' | b'\n') => self.line_end(),
                Some(_) => return true,
            }
        }
    }

    fn skip_blanks(&mut self) {
        let rest = self.rest();
        let end = rest.iter().position(|&b| !self.is_blank(b));
        self.at += end.unwrap_or(rest.len());
        if self.commas && self.rest().starts_with(b"#") {
            self.at += self.line_rest().len();
        }
    }

    fn is_blank(&self, b: u8) -> bool {
        matches!(b, b' ' | b'\t' | 0x0b | 0x0c) || (self.commas && b == b',')
    }

    /// The next word of the line; `None` at its end.
    pub(super) fn field(&mut self) -> Option<&'t [u8]> {
        self.skip_blanks();
        let rest = self.rest();
        let end = rest
            .iter()
            .position(|&b| self.is_blank(b) || matches!(b, b'\r' | b'\n'))
            .unwrap_or(rest.len());
        self.at += end;
        (end > 0).then(|| &rest[..end])
    }

    /// The next word, on this line or a later one; `None` at the end of the file.
    pub(super) fn word(&mut self) -> Option<&'t [u8]> {
        self.next_record();
        self.field()
    }

    /// The next `count` bytes.
    pub(super) fn take(&mut self, count: usize) -> Option<&'t [u8]> {
        let taken = self.rest().get(..count)?;
        self.at += count;
        Some(taken)
    }

    /// Goes to where the next record begins: in text of [`Layout::Lines`] the next line with a word.
    pub(super) fn begin(&mut self, what: &str) -> Result<(), String> {
        let is_line = self.binary.is_none() && self.layout == Layout::Lines;
        if is_line && !self.next_record() {
            return Err(format!("the file ends before {what}"));
        }
        Ok(())
    }

    /// Leaves a record: what is left of its line is not looked at.
    pub(super) fn end(&mut self) {
        if self.binary.is_none() && self.layout == Layout::Lines {
            self.skip_line();
        }
    }

    fn text(&mut self, what: &str) -> Result<&'t [u8], String> {
        match self.layout {
            Layout::Lines => self.field().ok_or_else(|| format!("{what} is missing")),
            Layout::Words => self
                .word()
                .ok_or_else(|| format!("the file ends before {what}")),
        }
    }

    /// The bytes of a binary number.
    fn number(&mut self, what: &str, kind: Kind) -> Result<&'t [u8], String> {
        self.take(kind.bytes())
            .ok_or_else(|| format!("the file ends before {what}"))
    }

    /// An integer in text, whatever the numbers of the file are. What lies beyond i64 becomes its
    /// end, which is out of every range.
    pub(super) fn text_integer(&mut self, what: &str) -> Result<i64, String> {
        let word = self.text(what)?;
        integer(word).ok_or_else(|| format!("{what} `{}` is not an integer", show(word)))
    }

    /// An integer, as [`Source::text_integer`] or binary.
    pub(super) fn integer(&mut self, what: &str, kind: Kind) -> Result<i64, String> {
        let Some(order) = self.binary else {
            return self.text_integer(what);
        };
        kind.integer(self.number(what, kind)?, order)
            .ok_or_else(|| format!("{what} is not stored as an integer"))
    }

    /// A finite number.
    pub(super) fn real(&mut self, what: &str, kind: Kind) -> Result<f64, String> {
        let Some(order) = self.binary else {
            let word = self.text(what)?;
            let value = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
            return match value {
                Some(value) if f64::is_finite(value) => Ok(value),
                Some(_) => Err(format!("{what} `{}` is not a finite number", show(word))),
                None => Err(format!("{what} `{}` is not a number", show(word))),
            };
        };
        let value = kind.real(self.number(what, kind)?, order);
        if value.is_finite() {
            Ok(value)
        } else {
            Err(format!("{what} {value} is not a finite number"))
        }
    }

    /// A number of things that follow, each of at least `each` bytes ([`Self::fits`]).
    pub(super) fn count(&mut self, what: &str, kind: Kind, each: usize) -> Result<usize, String> {
        let count = self.integer(what, kind)?;
        self.fits(what, count, each)
    }

    /// `count` as a number of things to come that take at least `each` bytes, if the rest of the
    /// file can hold them.
    pub(super) fn fits(&self, what: &str, count: i64, each: usize) -> Result<usize, String> {
        let left = self.rest().len();
        match usize::try_from(count) {
            Ok(count) if count.checked_mul(each).is_some_and(|need| need <= left) => Ok(count),
            Ok(_) => Err(format!(
                "{what} {count} is more than the rest of the file can hold ({left} bytes)"
            )),
            Err(_) => Err(format!("{what} {count} is negative")),
        }
    }
}
