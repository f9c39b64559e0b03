//! Given fields: a basis made elsewhere, as a NumPy array, with frequencies if it has them.

mod check;
mod frequencies;

use std::path::Path;

use bdtree_npy::NpyArray;

use super::{Basis, BasisMode};
use crate::error::{BakeError, Part, Place, Problems};
use crate::input::forget_folder;
use crate::input::read_file::read_file;
use crate::words::words;

/// Vertices whose entries are put in order at a time.
const VERTICES: usize = 256;

/// What the axes of a basis array mean. N vertices, M fields; k is x, y, z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// `(N, 3, M)`: vertex, axis, field.
    N3M,
    /// `(3N, M)`: row 3i + k is axis k of vertex i.
    ThreeNM,
    /// `(M, N, 3)`: field, vertex, axis.
    MN3,
}

impl Layout {
    const ALL: [Layout; 3] = [Layout::N3M, Layout::ThreeNM, Layout::MN3];

    /// The number of fields if an array of `shape` has this layout for `n` vertices.
    fn mode_count(self, shape: &[usize], n: usize) -> Option<usize> {
        match (self, shape) {
            (Layout::N3M, &[a, 3, m]) if a == n => Some(m),
            (Layout::ThreeNM, &[a, m]) if n.checked_mul(3) == Some(a) => Some(m),
            (Layout::MN3, &[m, a, 3]) if a == n => Some(m),
            _ => None,
        }
    }

    /// Where axis `k` of vertex `i` in field `j` stands in the array.
    fn entry(self, array: &NpyArray<f64>, i: usize, k: usize, j: usize) -> Option<f64> {
        match self {
            Layout::N3M => array.get(&[i, k, j]),
            Layout::ThreeNM => array.get(&[3 * i + k, j]),
            Layout::MN3 => array.get(&[j, i, k]),
        }
    }
}

words!(
    Layout,
    "is none of n3m, 3nm, mn3",
    N3M = "n3m",
    ThreeNM = "3nm",
    MN3 = "mn3"
);

/// A basis as given, and what is odd about it.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenBasis {
    /// The fields in file order; ω if frequencies were given.
    pub basis: Basis,
    /// Zero fields and fields that others already span, each with its number from 0.
    pub warnings: Vec<String>,
}

/// The basis in the `.npy` file at `path`, for a mesh of `vertex_count` vertices.
///
/// float32 or float64, either endianness and order, in one of the shapes of [`Layout`]; mesh units
/// per unit of q. `layout` settles what the shape leaves open. `frequencies`: a `.npy` or text file
/// with one number per field, in Hz. Zero and dependent fields are kept, with a warning.
///
/// # Errors
/// A file that cannot be read or is damaged, another dtype, a shape that does not fit or fits in
/// two ways, no fields, entries that are not finite (vertex, axis and field; the first 100), and
/// frequencies that are not M finite numbers of at least 0.
pub fn given_basis(
    path: &Path,
    layout: Option<Layout>,
    frequencies: Option<&Path>,
    vertex_count: usize,
) -> Result<GivenBasis, BakeError> {
    let file = Place::from(path);
    let array = array(&read(path)?, &file)?;
    let (layout, mode_count) = settle(&array, layout, vertex_count, &file)?;
    let mut basis = Basis {
        vertex_count,
        fields: vec![[0.0; 3]; mode_count * vertex_count],
        modes: vec![BasisMode::default(); mode_count],
        animation: None,
    };
    // The array may hold what belongs to a vertex together: few vertices at a time stay in the cache.
    for first in (0..vertex_count).step_by(VERTICES) {
        for j in 0..mode_count {
            for i in first..vertex_count.min(first + VERTICES) {
                let axis = |k| layout.entry(&array, i, k, j).unwrap_or(f64::NAN);
                basis.fields[j * vertex_count + i] = [axis(0), axis(1), axis(2)];
            }
        }
    }
    let mut problems = Problems::new("basis");
    check::non_finite(&basis, &file, &mut problems);
    let mut result = problems.into_result(file.clone());
    if let Some(path) = frequencies {
        match frequencies::read(path, mode_count) {
            Ok(omegas) => {
                for (mode, omega) in basis.modes.iter_mut().zip(omegas) {
                    mode.omega_rad_s = Some(omega);
                }
            }
            Err(error) => result = Err(error.after(result)),
        }
    }
    result?;
    let mut warnings = check::oddities(&basis, &file);
    forget_folder(path, &mut warnings);
    Ok(GivenBasis { basis, warnings })
}

/// The bytes of a file of this stage.
fn read(path: &Path) -> Result<Vec<u8>, BakeError> {
    read_file(path).map_err(|e| BakeError::one("basis", path, format!("cannot be read: {e}")))
}

/// The array in these bytes of a file of this stage.
fn array(bytes: &[u8], file: &Place) -> Result<NpyArray<f64>, BakeError> {
    bdtree_npy::parse(bytes).map_err(|e| BakeError::one("basis", file.clone(), e.to_string()))
}

/// The one layout that fits, and the number of fields.
fn settle(
    array: &NpyArray<f64>,
    asked: Option<Layout>,
    n: usize,
    file: &Place,
) -> Result<(Layout, usize), BakeError> {
    let shape = &array.shape;
    let fail = |message: String| {
        let place = file.clone().at(Part::The("shape"));
        Err(BakeError::one("basis", place, message))
    };
    let fits: Vec<(Layout, usize)> = Layout::ALL
        .into_iter()
        .filter(|&layout| asked.is_none_or(|a| a == layout))
        .filter_map(|layout| Some((layout, layout.mode_count(shape, n)?)))
        .collect();
    match (fits.as_slice(), asked) {
        // Without vertices an empty array fits, whatever number of fields it names.
        _ if n == 0 => fail(format!("{shape:?} for a mesh without vertices")),
        ([(_, 0)], _) => fail(format!("{shape:?} holds no fields")),
        ([fit], _) => Ok(*fit),
        ([], Some(asked)) => fail(format!(
            "{shape:?} is not of layout {asked} for a mesh of {n} vertices"
        )),
        ([], None) => fail(format!(
            "{shape:?} is none of (N, 3, M), (3N, M), (M, N, 3) for the mesh's N = {n} vertices"
        )),
        _ => fail(format!(
            "{shape:?} reads as (N, 3, M) and as (M, N, 3); say which with --basis-layout n3m or \
             --basis-layout mn3"
        )),
    }
}
