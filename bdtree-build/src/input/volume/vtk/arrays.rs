//! The named arrays of integers that version 5 keeps cells in.

use super::super::source::{Source, Stop};
use super::{ends_early, kind};
use crate::input::obj::tokens::show;

/// `NAME type`, then `count` integers; each with its line or byte.
pub(super) fn integers(
    source: &mut Source<'_>,
    name: &[u8],
    count: i64,
) -> Result<(Vec<i64>, Vec<u64>), Stop> {
    let word = source.word().unwrap_or_default();
    let position = source.position();
    if !word.eq_ignore_ascii_case(name) {
        return Err((
            position,
            format!("expected {}, found `{}`", show(name), show(word)),
        ));
    }
    let at = |message| (position, message);
    let kind = kind(source).map_err(at)?;
    let each = if source.binary.is_some() {
        kind.bytes()
    } else {
        2
    };
    let name = show(name);
    let count = source
        .fits(&format!("the length of {name}"), count, each)
        .map_err(at)?;
    let mut values = Vec::with_capacity(count);
    let mut positions = Vec::with_capacity(count);
    for entry in 0..count {
        if ends_early(source) {
            return Err((
                position,
                format!("{name} needs {count} numbers, {entry} found"),
            ));
        }
        let here = source.position();
        let value = source.integer("a number", kind);
        values.push(value.map_err(|m| (here, format!("{name}, entry {entry}: {m}")))?);
        positions.push(here);
    }
    Ok((values, positions))
}
