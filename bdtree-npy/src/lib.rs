//! NumPy `.npy` arrays of floating-point numbers, and of whole ones.
//!
//! Own reader: the header is one dictionary of three entries, and each size in it is checked
//! against the file before anything is allocated. `npyz`, the oracle of the tests, is not safe
//! against hostile files: it multiplies the extents unchecked (a panic where overflow is checked)
//! and parses the header as any Python literal, by recursion.

use super::number::Number;
use crate::error::{BakeError, Place};

/// An array of real numbers as it lies in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct NpyArray {
    /// Extent per axis; empty for a single number.
    pub shape: Vec<usize>,
    /// The entries in file order: as many as the product of `shape`.
    pub values: Vec<f64>,
    /// Distance in `values` between neighbours along each axis.
    pub strides: Vec<usize>,
}

impl NpyArray {
    /// The entry at `index` (one number per axis); `None` outside the array.
    pub fn get(&self, index: &[usize]) -> Option<f64> {
        let inside = index.iter().zip(&self.shape).all(|(i, n)| i < n);
        if index.len() != self.shape.len() || !inside {
            return None;
        }
        let offset = index.iter().zip(&self.strides).map(|(i, s)| i * s).sum();
        self.values.get::<usize>(offset).copied()
    }
}

/// The array in `bytes`: dtype `f4` or `f8` of either endianness, C or Fortran order, any shape.
///
/// `stage` and `place` name the reader and the file in errors.
///
/// # Errors
/// Anything that is no .npy file, another dtype, more or fewer bytes than the shape needs.
pub fn parse(bytes: &[u8], stage: &'static str, place: &str) -> Result<NpyArray, BakeError> {
    parse_bytes(bytes).map_err(|message| BakeError::one(stage, Place::file(place), message))
}

/// An array of whole numbers as it lies in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NpyIntegers {
    /// Extent per axis.
    pub shape: Vec<usize>,
    /// The entries in file order.
    pub values: Vec<i64>,
    /// Distance in `values` between neighbours along each axis.
    pub strides: Vec<usize>,
}

impl NpyIntegers {
    /// The entry at `index` (one number per axis); `None` outside the array.
    pub fn get(&self, index: &[usize]) -> Option<i64> {
        let inside = index.iter().zip(&self.shape).all(|(i, n)| i < n);
        if index.len() != self.shape.len() || !inside {
            return None;
        }
        let offset = index.iter().zip(&self.strides).map(|(i, s)| i * s).sum();
        self.values.get::<usize>(offset).copied()
    }
}

/// The array in `bytes`: integers of any size and endianness, C or Fortran order, any shape.
///
/// # Errors
/// Anything that is no .npy file, another dtype, more or fewer bytes than the shape needs, a number beyond 63 bits.
pub fn parse_integers(
    bytes: &[u8],
    stage: &'static str,
    place: &str,
) -> Result<NpyIntegers, BakeError> {
    integers(bytes).map_err(|message| BakeError::one(stage, Place::file(place), message))
}

fn integers(bytes: &[u8]) -> Result<NpyIntegers, String> {
    let (header, data) = split(bytes)?;
    let dtype = dtype(header)?;
    let is_big = dtype.starts_with('>');
    let (is_signed, size) = match dtype.trim_start_matches(['<', '>', '|', '=']) {
        "i1" => (true, 1),
        "i2" => (true, 2),
        "i4" => (true, 4),
        "i8" => (true, 8),
        "u1" => (false, 1),
        "u2" => (false, 2),
        "u4" => (false, 4),
        "u8" => (false, 8),
        _ => {
            return Err(format!(
                "dtype {}: needs whole numbers (i1 to u8)",
                shown(dtype)
            ));
        }
    };
    let shape = shape(entry(header, "shape")?)?;
    check_size(&shape, size, data.len() as u64)?;
    let number = |bytes: &[u8]| -> Option<i64> {
        let mut wide = [0; 8];
        for (k, byte) in bytes.iter().enumerate() {
            wide[if is_big { size - 1 - k } else { k }] = *byte;
        }
        let value = u64::from_le_bytes(wide);
        let unused = 64 - 8 * size as u32;
        if is_signed {
            Some((value << unused) as i64 >> unused)
        } else {
            i64::try_from(value).ok()
        }
    };
    let values: Option<Vec<i64>> = data.chunks_exact(size).map(number).collect();
    Ok(NpyIntegers {
        values: values.ok_or("a number is beyond 63 bits")?,
        strides: strides(&shape, fortran_order(header)?),
        shape,
    })
}

fn parse_bytes(bytes: &[u8]) -> Result<NpyArray, String> {
    let header = Header::parse(bytes)?;
    let data = bytes.get(header.data_offset..).unwrap_or_default();
    header.check_size(data.len() as u64)?;
    let mut values = Vec::with_capacity(data.len() / header.number.size());
    header.number.each(data, |value| values.push(value));
    let strides = strides(&header.shape, header.fortran);
    Ok(NpyArray {
        shape: header.shape,
        values,
        strides,
    })
}

/// What stands before the data.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Header {
    /// Extent per axis.
    pub(crate) shape: Vec<usize>,
    /// How the entries are stored.
    pub(crate) number: Number,
    /// The first index varies fastest in the file, not the last.
    pub(crate) fortran: bool,
    /// Byte of the file at which the data begins.
    pub(crate) data_offset: usize,
}

impl Header {
    /// The header at the start of `bytes`, which may end anywhere behind it.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, String> {
        let (header, data) = split(bytes)?;
        let fortran = fortran_order(header)?;
        Ok(Self {
            number: number(header)?,
            shape: shape(entry(header, "shape")?)?,
            fortran,
            data_offset: bytes.len() - data.len(),
        })
    }

    /// Nothing, if the shape needs exactly `found` bytes of data.
    pub(crate) fn check_size(&self, found: u64) -> Result<(), String> {
        check_size(&self.shape, self.number.size(), found)
    }
}

/// Nothing, if entries of `size` bytes in this shape need exactly `found` bytes of data.
fn check_size(shape: &[usize], size: usize, found: u64) -> Result<(), String> {
    let need = shape
        .iter()
        .try_fold(size, |n, &extent| n.checked_mul(extent))
        .ok_or_else(|| format!("shape {shape:?} is larger than any memory"))? as u64;
    if found == need {
        return Ok(());
    }
    let odd = if found < need {
        "truncated"
    } else {
        "has bytes after its data"
    };
    Err(format!(
        "{odd}: shape {shape:?} needs {need} bytes of data, found {found}"
    ))
}

/// The header's text and what stands behind it.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    let rest = bytes
        .strip_prefix(b"\x93NUMPY")
        .ok_or("is not a .npy file (no NumPy signature)")?;
    let cut = "truncated in the header";
    let (&[major, _minor], rest) = rest.split_first_chunk::<2>().ok_or(cut)?;
    let (header_bytes, rest) = match major {
        1 => {
            let (size, rest) = rest.split_first_chunk::<2>().ok_or(cut)?;
            (usize::from(u16::from_le_bytes(*size)), rest)
        }
        2 | 3 => {
            let (size, rest) = rest.split_first_chunk::<4>().ok_or(cut)?;
            (u32::from_le_bytes(*size) as usize, rest)
        }
        other => return Err(format!("unknown .npy version {other}")),
    };
    let (header, data) = rest.split_at_checked(header_bytes).ok_or(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| "header is not text")?;
    Ok((header, data))
}

fn fortran_order(header: &str) -> Result<bool, String> {
    match word(entry(header, "fortran_order")?) {
        "True" => Ok(true),
        "False" => Ok(false),
        _ => Err("header: fortran_order is neither True nor False".into()),
    }
}

fn dtype(header: &str) -> Result<&str, String> {
    let descr = entry(header, "descr")?;
    Ok(descr
        .strip_prefix(['\'', '"'])
        .and_then(|rest| rest.split(['\'', '"']).next())
        .unwrap_or("a structure"))
}

/// Text of a header, fit to be shown.
fn shown(dtype: &str) -> String {
    dtype
        .chars()
        .take(32)
        .flat_map(char::escape_debug)
        .collect()
}

fn number(header: &str) -> Result<Number, String> {
    let dtype = dtype(header)?;
    Ok(match dtype {
        "<f4" => Number::F4Le,
        ">f4" => Number::F4Be,
        "<f8" => Number::F8Le,
        ">f8" => Number::F8Be,
        other => {
            let kind = match other
                .trim_start_matches(['<', '>', '|', '='])
                .chars()
                .next()
            {
                Some('i' | 'u') => " (integer)",
                Some('c') => " (complex)",
                Some('b') => " (boolean)",
                Some('f') => " (other precision)",
                Some('O') => " (Python objects)",
                _ => "",
            };
            let shown = shown(other);
            return Err(format!(
                "dtype {shown}{kind}: needs float32 or float64 (f4, f8)"
            ));
        }
    })
}

/// What follows `'key':` in the header.
fn entry<'h>(header: &'h str, key: &str) -> Result<&'h str, String> {
    ['\'', '"']
        .iter()
        .find_map(|quote| header.split_once(&format!("{quote}{key}{quote}")))
        .and_then(|(_, after)| after.trim_start().strip_prefix(':'))
        .map(str::trim_start)
        .ok_or_else(|| format!("header has no entry {key}"))
}

fn word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_ascii_alphabetic());
    &text[..end.unwrap_or(text.len())]
}

/// `(3, 4)`, `(3,)` or `()`.
fn shape(text: &str) -> Result<Vec<usize>, String> {
    let inner = text
        .strip_prefix('(')
        .and_then(|rest| rest.split_once(')'))
        .ok_or("header: shape is not a tuple")?
        .0;
    let mut extents: Vec<&str> = inner.split(',').map(str::trim).collect();
    if extents.last().is_some_and(|last| last.is_empty()) {
        extents.pop();
    }
    if extents.len() > 8 {
        return Err("header: shape has more than 8 axes".into());
    }
    extents
        .into_iter()
        // Python 2 wrote long integers with an L.
        .map(|extent| extent.trim_end_matches('L').parse().ok())
        .collect::<Option<Vec<usize>>>()
        .ok_or_else(|| "header: shape is not a tuple of sizes".into())
}

/// No overflow: called only when the product of the extents fits, or one of them is 0.
fn strides(shape: &[usize], fortran: bool) -> Vec<usize> {
    let mut strides = vec![0; shape.len()];
    let mut step = 1_usize;
    let mut put = |axis: usize| {
        strides[axis] = step;
        step = step.saturating_mul(shape[axis]);
    };
    if fortran {
        (0..shape.len()).for_each(&mut put);
    } else {
        (0..shape.len()).rev().for_each(&mut put);
    }
    strides
}
