//! Text to logical lines: every kind of line end, continuations, byte order marks.

use crate::error::{BakeError, Place};

/// The text without its UTF-8 byte order mark, if it can be OBJ text at all.
///
/// # Errors
/// UTF-16 or UTF-32 (by mark or by zero bytes), other binary data, an empty file.
pub(super) fn check_encoding<'t>(text: &'t [u8], place: &str) -> Result<&'t [u8], BakeError> {
    let refuse = |message: &str| Err(BakeError::one("input", Place::file(place), message));
    if text.is_empty() {
        return refuse("the file is empty");
    }
    let head = &text[..text.len().min(64)];
    if head.starts_with(&[0xff, 0xfe]) || head.starts_with(&[0xfe, 0xff]) {
        return refuse("UTF-16 text (by its byte order mark); save the file as UTF-8 or ASCII");
    }
    if head.contains(&0) {
        return refuse("not OBJ text: zero bytes at the start (UTF-16 or binary data)");
    }
    Ok(text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text))
}

/// Logical lines, with the number of the first physical line of each.
///
/// `\n`, `\r\n` and a lone `\r` end a line. A backslash right before the end joins the next line,
/// as a blank; not in comments, where a path may end in one.
pub(super) struct Lines<'t> {
    rest: &'t [u8],
    number: u64,
    joined: Vec<u8>,
}

impl<'t> Lines<'t> {
    pub(super) fn new(text: &'t [u8]) -> Self {
        Self {
            rest: text,
            number: 0,
            joined: Vec::new(),
        }
    }

    /// The next logical line and its number, from 1.
    pub(super) fn next_line(&mut self) -> Option<(u64, &[u8])> {
        let line = self.physical()?;
        let number = self.number;
        let Some(begin) = line.strip_suffix(b"\\") else {
            return Some((number, line));
        };
        if line.trim_ascii_start().starts_with(b"#") {
            return Some((number, line));
        }
        self.joined.clear();
        self.joined.extend_from_slice(begin);
        while let Some(next) = self.physical() {
            self.joined.push(b' ');
            match next.strip_suffix(b"\\") {
                Some(part) => self.joined.extend_from_slice(part),
                None => {
                    self.joined.extend_from_slice(next);
                    break;
                }
            }
        }
        Some((number, &self.joined))
    }

    fn physical(&mut self) -> Option<&'t [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let rest = self.rest;
        let Some(end) = rest.iter().position(|&b| b == b'\n' || b == b'\r') else {
            self.rest = &[];
            return Some(rest);
        };
        let after = if rest[end..].starts_with(b"\r\n") {
            end + 2
        } else {
            end + 1
        };
        self.rest = &rest[after..];
        Some(&rest[..end])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(text: &[u8]) -> Vec<(u64, String)> {
        let mut lines = Lines::new(text);
        let mut all = Vec::new();
        while let Some((number, line)) = lines.next_line() {
            all.push((number, String::from_utf8_lossy(line).into_owned()));
        }
        all
    }

    #[test]
    fn every_line_end_counts_once() {
        let lines = split(b"a\nb\r\nc\rd\n\re");
        let expected = [(1, "a"), (2, "b"), (3, "c"), (4, "d"), (5, ""), (6, "e")];
        assert_eq!(lines, expected.map(|(n, s)| (n, s.to_string())));
    }

    #[test]
    fn continuations_join_with_a_blank_and_keep_the_first_number() {
        assert_eq!(
            split(b"f 1\\\n2\\\r\n3\nx"),
            [(1, "f 1 2 3".into()), (4, "x".into())]
        );
        assert_eq!(
            split(b" # C:\\\nv"),
            [(1, " # C:\\".into()), (2, "v".into())]
        );
        assert_eq!(split(b"f 1\\"), [(1, "f 1".into())]);
    }
}
