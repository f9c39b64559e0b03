//! Mutations of text: numbers, words and lines.

use std::ops::Range;

use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Words in place of numbers.
const NUMBERS: [&str; 44] = [
    "NaN",
    "nan",
    "inf",
    "-inf",
    "Infinity",
    "1e39",
    "-1e39",
    "1e308",
    "1e309",
    "-1e309",
    "1e-320",
    "1e-400",
    "1e20",
    "1e100",
    "1e155",
    "-1e200",
    "0",
    "-0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "255",
    "65536",
    "2147483647",
    "2147483648",
    "-2147483648",
    "4294967295",
    "4294967296",
    "4294967297",
    "9223372036854775807",
    "18446744073709551615",
    "18446744073709551616",
    "99999999999999999999999999999999",
    "0x10",
    "1_000",
    ".",
    "-",
    "+1",
    "1e",
    "1/2/3",
    "٣",
    "1e999999999999",
];

/// Bytes that are not text, or that terminals obey.
const BYTES: [&[u8]; 10] = [
    b"\0",
    b"\x1b[31m",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\r",
    b"\\\n",
    b"\t",
    b"\x85",
    b"\xc2\x9b",
    b"#",
];

/// Most bytes that a file grows to.
pub(super) const SIZE_MAX: usize = 1 << 18;

/// Changes one thing. `words` are the format's own, `other` is another file of the format.
pub(super) fn change(text: &mut Vec<u8>, words: &[&str], other: &[u8], rng: &mut Pcg64Mcg) {
    match rng.random_range(0..22) {
        0..4 => replace_number(text, rng),
        4..6 => step_number(text, rng),
        6 => {
            let (Some(to), Some(from)) = (token(text, rng), token(text, rng)) else {
                return;
            };
            let word = text[from].to_vec();
            text.splice(to, word);
        }
        7 => {
            if let Some(at) = token(text, rng) {
                let mut word = text[at.clone()].to_vec();
                word.insert(0, b' ');
                text.splice(at.end..at.end, word);
            }
        }
        8 => {
            if let Some(at) = token(text, rng) {
                text.drain(at);
            }
        }
        9 => {
            let line = line(text, rng);
            let copies = [1, 1, 2, 7, 64, 1500][rng.random_range(0..6)];
            repeat(text, line, copies);
        }
        10 => {
            let line = line(text, rng);
            text.drain(line);
        }
        11 => {
            // Two lines become one.
            let end = line(text, rng).end;
            if end > 0 && text.get(end - 1) == Some(&b'\n') {
                text[end - 1] = b' ';
            }
        }
        12 => {
            let at = rng.random_range(0..=text.len());
            text.insert(at, b'\n');
        }
        13 => {
            let (a, b) = (line(text, rng), line(text, rng));
            let moved = text[a].to_vec();
            text.splice(b.start..b.start, moved);
        }
        14 | 15 => {
            if let Some(word) = pick(words, rng) {
                let at = line(text, rng).start;
                let mut line = word.as_bytes().to_vec();
                line.push(b'\n');
                text.splice(at..at, line);
            }
        }
        16 => splice(text, other, rng),
        17 => text.truncate(rng.random_range(0..=text.len())),
        18 => {
            let bytes = BYTES[rng.random_range(0..BYTES.len())];
            let at = rng.random_range(0..=text.len());
            text.splice(at..at, bytes.iter().copied());
        }
        19 => {
            if let Some(byte) = some_index(text.len(), rng) {
                text[byte] ^= 1 << rng.random_range(0..8);
            }
        }
        20 => ends(text, rng),
        _ => {
            // A block of lines once more.
            let (a, b) = (line(text, rng).start, line(text, rng).end);
            repeat(text, a.min(b)..a.max(b), 1);
        }
    }
}

fn pick<'w>(words: &[&'w str], rng: &mut Pcg64Mcg) -> Option<&'w str> {
    Some(words[some_index(words.len(), rng)?])
}

pub(super) fn some_index(count: usize, rng: &mut Pcg64Mcg) -> Option<usize> {
    (count > 0).then(|| rng.random_range(0..count))
}

/// A word in place of a number.
pub(super) fn hostile_number(rng: &mut Pcg64Mcg) -> &'static str {
    NUMBERS[rng.random_range(0..NUMBERS.len())]
}

fn is_blank(byte: u8) -> bool {
    byte.is_ascii_whitespace() || b",:;()[]{}\"'".contains(&byte)
}

/// A random word.
fn token(text: &[u8], rng: &mut Pcg64Mcg) -> Option<Range<usize>> {
    let at = some_index(text.len(), rng)?;
    let start = at + text[at..].iter().position(|b| !is_blank(*b))?;
    let before = text[..start].iter().rev().take_while(|b| !is_blank(**b));
    let start = start - before.count();
    let length = text[start..].iter().take_while(|b| !is_blank(**b)).count();
    Some(start..start + length)
}

/// A random word that begins like a number.
fn number(text: &[u8], rng: &mut Pcg64Mcg) -> Option<Range<usize>> {
    let digit = |b: u8| b.is_ascii_digit() || b == b'-' || b == b'.';
    (0..8)
        .filter_map(|_| token(text, rng))
        .find(|at| digit(text[at.start]))
}

fn replace_number(text: &mut Vec<u8>, rng: &mut Pcg64Mcg) {
    if let Some(at) = number(text, rng) {
        text.splice(at, hostile_number(rng).bytes());
    }
}

/// A whole number becomes a neighbour, its double, its negative; others get another exponent.
fn step_number(text: &mut Vec<u8>, rng: &mut Pcg64Mcg) {
    let Some(at) = number(text, rng) else {
        return;
    };
    let word = String::from_utf8_lossy(&text[at.clone()]).into_owned();
    let new = match word.parse::<i64>() {
        Ok(n) => match rng.random_range(0..6) {
            0 => n.saturating_add(1),
            1 => n.saturating_sub(1),
            2 => n.saturating_mul(2),
            3 => n.saturating_neg(),
            4 => n / 2,
            _ => n.saturating_add(1000),
        }
        .to_string(),
        Err(_) => format!("{word}e{}", rng.random_range(-320..320)),
    };
    text.splice(at, new.into_bytes());
}

/// A random line with its end.
fn line(text: &[u8], rng: &mut Pcg64Mcg) -> Range<usize> {
    let Some(at) = some_index(text.len(), rng) else {
        return 0..0;
    };
    let start = text[..at].iter().rposition(|b| *b == b'\n');
    let end = text[at..].iter().position(|b| *b == b'\n');
    start.map_or(0, |n| n + 1)..end.map_or(text.len(), |n| at + n + 1)
}

fn repeat(text: &mut Vec<u8>, part: Range<usize>, copies: usize) {
    let room = SIZE_MAX.saturating_sub(text.len());
    let copies = copies.min(room / part.len().max(1));
    let more = text[part.clone()].repeat(copies);
    text.splice(part.end..part.end, more);
}

/// A part of another file somewhere in this one, or from there on.
pub(super) fn splice(bytes: &mut Vec<u8>, other: &[u8], rng: &mut Pcg64Mcg) {
    let from = rng.random_range(0..=other.len());
    let to = rng.random_range(from..=other.len());
    let at = rng.random_range(0..=bytes.len());
    let end = match rng.random_range(0..3) {
        0 => at,
        1 => bytes.len(),
        _ => (at + to - from).min(bytes.len()),
    };
    if bytes.len() < SIZE_MAX {
        bytes.splice(at..end, other[from..to].iter().copied());
    }
}

/// Other line ends, or none at the end.
fn ends(text: &mut Vec<u8>, rng: &mut Pcg64Mcg) {
    match rng.random_range(0..3) {
        0 => {
            while text.last().is_some_and(u8::is_ascii_whitespace) {
                text.pop();
            }
        }
        1 => text
            .iter_mut()
            .filter(|b| **b == b'\n')
            .for_each(|b| *b = b'\r'),
        _ => {
            let lines = text.split(|b| *b == b'\n');
            *text = lines.collect::<Vec<_>>().join(&b"\r\n"[..]);
        }
    }
}
