//! NumPy `.npy` files: arrays of floating-point numbers and of whole ones are read, arrays of `f64` written.
//!
//! Our own reader, because files may be hostile: the header is one dictionary of three entries, and each size in it is
//! checked against the file before anything is allocated. `npyz`, the oracle of the tests, multiplies the extents
//! unchecked and parses the header as any Python literal, by recursion; it also brings fifteen packages, one of which
//! needs a C compiler.

mod number;

use std::io::{self, Write};

pub use number::Number;

/// Why bytes are no array of the kind asked for.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NpyError(String);

impl From<&str> for NpyError {
    fn from(message: &str) -> Self {
        Self(message.to_string())
    }
}

/// An array as it lies in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NpyArray<T> {
    /// Extent per axis; empty for a single number.
    pub shape: Vec<usize>,
    /// The entries in file order: as many as the product of `shape`.
    pub values: Vec<T>,
    /// Distance in `values` between neighbours along each axis.
    pub strides: Vec<usize>,
}

impl<T: Copy> NpyArray<T> {
    /// The entry at `index` (one number per axis); `None` outside the array.
    pub fn get(&self, index: &[usize]) -> Option<T> {
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
/// # Errors
/// Anything that is no .npy file, another dtype, more or fewer bytes than the shape needs.
pub fn parse(bytes: &[u8]) -> Result<NpyArray<f64>, NpyError> {
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

/// The array in `bytes`: integers of any size and endianness, C or Fortran order, any shape.
///
/// # Errors
/// Anything that is no .npy file, another dtype, more or fewer bytes than the shape needs, a number beyond 63 bits.
pub fn parse_integers(bytes: &[u8]) -> Result<NpyArray<i64>, NpyError> {
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
            let message = format!("dtype {}: needs whole numbers (i1 to u8)", shown(dtype));
            return Err(NpyError(message));
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
    Ok(NpyArray {
        values: values.ok_or("a number is beyond 63 bits")?,
        strides: strides(&shape, fortran_order(header)?),
        shape,
    })
}

/// Writes `values`, in C order, as an array of this shape and dtype `<f8`.
///
/// # Errors
/// Another number of values than the shape has, more axes than a header holds, what `out` returns.
pub fn write(shape: &[usize], values: &[f64], out: &mut dyn Write) -> io::Result<()> {
    let invalid = |message: String| io::Error::new(io::ErrorKind::InvalidInput, message);
    check_size(shape, size_of::<f64>(), size_of_val(values) as u64)
        .map_err(|error| invalid(error.to_string()))?;
    let extents: String = shape.iter().map(|extent| format!("{extent}, ")).collect();
    let entries = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({extents}), }}");
    // Signature, version and length take ten bytes, the line's end one; the data begins at a multiple of 64.
    let len = (10 + entries.len() + 1).next_multiple_of(64) - 10;
    let bytes = u16::try_from(len).map_err(|_| invalid("too many axes".to_string()))?;
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&bytes.to_le_bytes())?;
    writeln!(out, "{entries:width$}", width = len - 1)?;
    for value in values {
        out.write_all(&value.to_le_bytes())?;
    }
    Ok(())
}

/// What stands before the data.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    /// Extent per axis.
    pub shape: Vec<usize>,
    /// How the entries are stored.
    pub number: Number,
    /// The first index varies fastest in the file, not the last.
    pub fortran: bool,
    /// Byte of the file at which the data begins.
    pub data_offset: usize,
}

impl Header {
    /// The header at the start of `bytes`, which may end anywhere behind it.
    pub fn parse(bytes: &[u8]) -> Result<Self, NpyError> {
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
    pub fn check_size(&self, found: u64) -> Result<(), NpyError> {
        check_size(&self.shape, self.number.size(), found)
    }
}

/// Nothing, if entries of `size` bytes in this shape need exactly `found` bytes of data.
fn check_size(shape: &[usize], size: usize, found: u64) -> Result<(), NpyError> {
    let need = shape
        .iter()
        .try_fold(size, |n, &extent| n.checked_mul(extent))
        .ok_or_else(|| NpyError(format!("shape {shape:?} is larger than any memory")))?
        as u64;
    if found == need {
        return Ok(());
    }
    let odd = if found < need {
        "truncated"
    } else {
        "has bytes after its data"
    };
    Err(NpyError(format!(
        "{odd}: shape {shape:?} needs {need} bytes of data, found {found}"
    )))
}

/// The header's text and what stands behind it.
fn split(bytes: &[u8]) -> Result<(&str, &[u8]), NpyError> {
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
        other => return Err(NpyError(format!("unknown .npy version {other}"))),
    };
    let (header, data) = rest.split_at_checked(header_bytes).ok_or(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| "header is not text")?;
    Ok((header, data))
}

fn fortran_order(header: &str) -> Result<bool, NpyError> {
    match word(entry(header, "fortran_order")?) {
        "True" => Ok(true),
        "False" => Ok(false),
        _ => Err("header: fortran_order is neither True nor False".into()),
    }
}

fn dtype(header: &str) -> Result<&str, NpyError> {
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

fn number(header: &str) -> Result<Number, NpyError> {
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
            let message = format!("dtype {shown}{kind}: needs float32 or float64 (f4, f8)");
            return Err(NpyError(message));
        }
    })
}

/// What follows `'key':` in the header.
fn entry<'h>(header: &'h str, key: &str) -> Result<&'h str, NpyError> {
    ['\'', '"']
        .iter()
        .find_map(|quote| header.split_once(&format!("{quote}{key}{quote}")))
        .and_then(|(_, after)| after.trim_start().strip_prefix(':'))
        .map(str::trim_start)
        .ok_or_else(|| NpyError(format!("header has no entry {key}")))
}

fn word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_ascii_alphabetic());
    &text[..end.unwrap_or(text.len())]
}

/// `(3, 4)`, `(3,)` or `()`.
fn shape(text: &str) -> Result<Vec<usize>, NpyError> {
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
