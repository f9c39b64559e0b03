//! NumPy `.npy` arrays of floating-point numbers.
//!
//! Own reader: the header is one dictionary of three entries, and each size in it is checked
//! against the file before anything is allocated. `npyz`, the oracle of the tests, is not safe
//! against hostile files: it multiplies the extents unchecked (a panic where overflow is checked)
//! and parses the header as any Python literal, by recursion.

use crate::error::BakeError;

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
    parse_bytes(bytes).map_err(|message| BakeError::one(stage, place, message))
}

fn parse_bytes(bytes: &[u8]) -> Result<NpyArray, String> {
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

    let read = number_reader(header)?;
    let fortran = match word(entry(header, "fortran_order")?) {
        "True" => true,
        "False" => false,
        _ => return Err("header: fortran_order is neither True nor False".into()),
    };
    let shape = shape(entry(header, "shape")?)?;
    let too_large = || format!("shape {shape:?} is larger than any memory");
    let count = shape
        .iter()
        .try_fold(1_usize, |n, &extent| n.checked_mul(extent))
        .ok_or_else(too_large)?;
    let need = count.checked_mul(read.size).ok_or_else(too_large)?;
    if data.len() != need {
        let odd = if data.len() < need {
            "truncated"
        } else {
            "has bytes after its data"
        };
        let found = data.len();
        return Err(format!(
            "{odd}: shape {shape:?} needs {need} bytes of data, found {found}"
        ));
    }
    let values = data.chunks_exact(read.size).map(read.number).collect();
    let strides = strides(&shape, fortran);
    Ok(NpyArray {
        shape,
        values,
        strides,
    })
}

/// How one number is stored.
struct Number {
    size: usize,
    number: fn(&[u8]) -> f64,
}

fn number_reader(header: &str) -> Result<Number, String> {
    fn take<const N: usize>(bytes: &[u8]) -> [u8; N] {
        bytes.first_chunk().copied().unwrap_or([0; N])
    }
    let descr = entry(header, "descr")?;
    let dtype = descr
        .strip_prefix(['\'', '"'])
        .and_then(|rest| rest.split(['\'', '"']).next())
        .unwrap_or("a structure");
    let (size, number): (usize, fn(&[u8]) -> f64) = match dtype {
        "<f4" => (4, |b| f32::from_le_bytes(take(b)).into()),
        ">f4" => (4, |b| f32::from_be_bytes(take(b)).into()),
        "<f8" => (8, |b| f64::from_le_bytes(take(b))),
        ">f8" => (8, |b| f64::from_be_bytes(take(b))),
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
            let shown: String = other
                .chars()
                .take(32)
                .flat_map(char::escape_debug)
                .collect();
            return Err(format!(
                "dtype {shown}{kind}: needs float32 or float64 (f4, f8)"
            ));
        }
    };
    Ok(Number { size, number })
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
