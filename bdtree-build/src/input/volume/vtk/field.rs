//! `FIELD` and `METADATA` between the parts of a grid: skipped.

use super::super::source::{Source, Stop};
use super::{kinds, start};
use crate::input::obj::tokens::show;

/// After `FIELD`: a name and a number of arrays, then each array's name, components, tuples, type
/// and values.
pub(super) fn skip(source: &mut Source<'_>, position: u64) -> Result<(), Stop> {
    let arrays = source
        .word()
        .ok_or_else(|| "FIELD without a name".to_string())
        .and_then(|_| source.text_integer("the number of arrays"))
        .and_then(|count| source.fits("the number of arrays", count, 2))
        .map_err(|message| (position, message))?;
    for _ in 0..arrays {
        let mut name = source.word().unwrap_or_default();
        while name.eq_ignore_ascii_case(b"METADATA") {
            skip_metadata(source);
            name = source.word().unwrap_or_default();
        }
        let at = source.position();
        if name != b"NULL_ARRAY" {
            skip_array(source)
                .map_err(|message| (at, format!("FIELD array `{}`: {message}", show(name))))?;
        }
    }
    Ok(())
}

fn skip_array(source: &mut Source<'_>) -> Result<(), String> {
    let components = source.text_integer("the number of components")?;
    let tuples = source.text_integer("the number of tuples")?;
    let what = "the number of values";
    // A text value may be as short as an empty line.
    let values = components.checked_mul(tuples).unwrap_or(i64::MAX);
    let values = source.fits(what, values, 0)?;
    let word = source.word().unwrap_or_default();
    let is_string = matches!(
        word.to_ascii_lowercase().as_slice(),
        b"string" | b"utf8_string"
    );
    let is_bit = word.eq_ignore_ascii_case(b"bit");
    let kind = kinds::number(word);
    if kind.is_none() && !is_string && !is_bit {
        return Err(format!("values of type `{}`", show(word)));
    }
    start(source);
    let ends = || format!("the file ends within its {values} values");
    match (source.binary.is_some(), is_string) {
        (true, true) => (0..values).try_for_each(|_| skip_string(source).ok_or_else(ends)),
        (true, false) => {
            let bytes = match kind {
                Some(kind) => values.checked_mul(kind.bytes()),
                None => Some(values.div_ceil(8)),
            };
            let taken = bytes.and_then(|bytes| source.take(bytes));
            taken.map(|_| ()).ok_or_else(ends)
        }
        (false, true) => {
            source.skip_line();
            for _ in 0..values {
                if source.rest().is_empty() {
                    return Err(ends());
                }
                source.skip_line();
            }
            Ok(())
        }
        (false, false) => (0..values).try_for_each(|_| source.word().map(|_| ()).ok_or_else(ends)),
    }
}

/// A string behind its length, which takes 1, 2, 4 or 8 bytes as the first two bits 3, 2, 1 or 0
/// say.
fn skip_string(source: &mut Source<'_>) -> Option<()> {
    let first = source.rest().first()?;
    let bytes = source.take(8 >> (first >> 6))?;
    let length = bytes.iter().fold(0_u64, |n, &b| n << 8 | u64::from(b));
    let marks = 0b11 << (8 * bytes.len() - 2);
    source.take(usize::try_from(length & !marks).ok()?)?;
    Some(())
}

/// Lines up to a blank one.
pub(super) fn skip_metadata(source: &mut Source<'_>) {
    source.skip_line();
    while !source.line_rest().trim_ascii().is_empty() {
        source.skip_line();
    }
}
