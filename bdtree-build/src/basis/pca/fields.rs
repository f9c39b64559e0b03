//! From singular values to displacement fields and their q: U = X V Σ⁻¹, made orthonormal again.

use std::ops::Range;

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};

use super::snapshots::Snapshots;
use super::tsqr::Spectrum;
use crate::elastic::solve::canonical;
use crate::error::{BakeError, Part};
use crate::progress::Progress;
use crate::vec3::bounds;

/// The first modes.
pub(super) struct Fields {
    /// Orthonormal columns, field after field: `fields[j * N + i]` is `U_ij`.
    pub(super) fields: Vec<[f64; 3]>,
    /// M × T: UᵀX, so that the error of each frame is least.
    pub(super) q: Mat<f64>,
}

/// The first `count` modes of the snapshots about `rest`, `rank` of which there are. The fields of
/// a larger count begin with those of a smaller one.
///
/// Modes whose singular values agree to 1e-6 span a space of which any basis would do; the one
/// taken depends on the space alone, so it is made of all of them also where `count` ends
/// among them.
pub(super) fn fields(
    snapshots: &Snapshots<'_>,
    rest: &[[f64; 3]],
    spectrum: &Spectrum,
    rank: usize,
    count: usize,
    progress: &dyn Progress,
) -> Result<Fields, BakeError> {
    let clusters = clusters(spectrum, rank);
    let made = made(&clusters, count);
    let mut modes = project(snapshots, rest, spectrum, made, progress)?;
    orthonormalise(&mut modes, rest.len())?;
    for cluster in clusters.iter().filter(|c| c.len() > 1 && c.end <= made) {
        turn(&mut modes, rest, cluster.start, cluster.len());
    }
    modes.fields.truncate(count * rest.len());
    let mut q = modes.q.get(..count, ..).to_owned();
    for (j, field) in modes.fields.chunks_exact_mut(rest.len()).enumerate() {
        let sign = canonical::leading_sign(field);
        // + 0.0: no negative zeros.
        field
            .as_flattened_mut()
            .iter_mut()
            .for_each(|x| *x = *x * sign + 0.0);
        q.row_mut(j).iter_mut().for_each(|x| *x = *x * sign + 0.0);
    }
    Ok(Fields {
        fields: modes.fields,
        q,
    })
}

/// Numbers of displacements per vertex that [`fields`] holds at a time: the modes that it makes,
/// and those of the largest space that it turns once more.
pub(super) fn held(spectrum: &Spectrum, rank: usize, count: usize) -> usize {
    let clusters = clusters(spectrum, rank);
    let made = made(&clusters, count);
    let turned = clusters.iter().filter(|c| c.len() > 1 && c.end <= made);
    made + turned.map(Range::len).max().unwrap_or(0)
}

/// The modes of equal singular values.
fn clusters(spectrum: &Spectrum, rank: usize) -> Vec<Range<usize>> {
    let descending: Vec<f64> = spectrum.values[..rank].iter().map(|s| -s).collect();
    canonical::clusters(&descending)
}

/// How many modes are made for the first `count`.
fn made(clusters: &[Range<usize>], count: usize) -> usize {
    let mut ends = clusters.iter().map(|c| c.end);
    ends.find(|&end| end >= count).unwrap_or(0)
}

/// X V Σ⁻¹, and its product with X.
fn project(
    snapshots: &Snapshots<'_>,
    rest: &[[f64; 3]],
    spectrum: &Spectrum,
    count: usize,
    progress: &dyn Progress,
) -> Result<Fields, BakeError> {
    let (n, frames) = (rest.len(), snapshots.sequence.frame_count());
    let scaled = Mat::from_fn(frames, count, |t, j| {
        spectrum.vectors[(t, j)] / spectrum.values[j]
    });
    let mut fields = vec![[0.0; 3]; n * count];
    let mut q = Mat::<f64>::zeros(count, frames);
    let mut values = Vec::new();
    progress.stage("fields", Some(snapshots.chunks().count() as u64));
    for vertices in snapshots.chunks() {
        let rows = 3 * vertices.len();
        snapshots.read_centered(&vertices, rest, &mut values)?;
        let x = MatRef::from_column_major_slice(&values, rows, frames);
        let all = MatMut::from_column_major_slice_mut(fields.as_flattened_mut(), 3 * n, count);
        let mut u = all.subrows_mut(3 * vertices.start, rows);
        matmul(u.as_mut(), Accum::Replace, x, &scaled, 1.0, Par::Seq);
        matmul(q.as_mut(), Accum::Add, u.transpose(), x, 1.0, Par::Seq);
        progress.advance(1);
    }
    Ok(Fields { fields, q })
}

/// U ← U L⁻ᵀ with UᵀU = L Lᵀ, and q likewise: each column loses what it has of those before it.
///
/// U is orthonormal up to ε σ₀ / σ_j (rounding of V), so once is enough.
fn orthonormalise(modes: &mut Fields, vertex_count: usize) -> Result<(), BakeError> {
    let count = modes.q.nrows();
    if count == 0 {
        return Ok(());
    }
    let flat = modes.fields.as_flattened_mut();
    let mut u = MatMut::from_column_major_slice_mut(flat, 3 * vertex_count, count);
    let gram = u.as_ref().transpose() * u.as_ref();
    let factor = gram.llt(Side::Lower).map_err(|_| {
        let message = "the modes cannot be told apart in double precision: ask for fewer";
        BakeError::one("basis", Part::The("animation"), message)
    })?;
    solve_lower_triangular_in_place(factor.L(), u.as_mut().transpose_mut(), Par::Seq);
    solve_lower_triangular_in_place(factor.L(), modes.q.as_mut(), Par::Seq);
    Ok(())
}

/// Turns `len` modes from `first` within the space they span.
fn turn(modes: &mut Fields, rest: &[[f64; 3]], first: usize, len: usize) {
    let rows = 3 * rest.len();
    let flat = modes.fields.as_flattened_mut();
    let mut all = MatMut::from_column_major_slice_mut(flat, rows, modes.q.nrows());
    let mut u = all.as_mut().subcols_mut(first, len);
    let turn = canonical::rotation(along_test_fields(u.as_ref(), rest));
    let turned = u.as_ref() * &turn;
    u.copy_from(turned);
    let mut q = modes.q.as_mut().subrows_mut(first, len);
    let turned = turn.transpose() * q.as_ref();
    q.copy_from(turned);
}

/// Scalar products of the columns of `u` with test fields of unit length: the monomials of the
/// rest positions up to third degree, along each axis.
fn along_test_fields(u: MatRef<'_, f64>, rest: &[[f64; 3]]) -> Mat<f64> {
    let (low, high) = bounds(rest.iter().copied());
    let reach = (0..3).map(|a| high[a] - low[a]).fold(0.0, f64::max);
    let reach = if reach > 0.0 { reach } else { 1.0 };
    let exponents: Vec<[i32; 3]> = (0..=3)
        .flat_map(|degree| (0..=degree).rev().map(move |a| (degree, a)))
        .flat_map(|(degree, a)| (0..=degree - a).rev().map(move |b| [a, b, degree - a - b]))
        .collect();
    let mut products = Mat::<f64>::zeros(u.ncols(), 3 * exponents.len());
    let mut squares = vec![0.0; exponents.len()];
    for (i, p) in rest.iter().enumerate() {
        let x: [f64; 3] = std::array::from_fn(|a| (2.0 * p[a] - low[a] - high[a]) / reach);
        for (e, exponent) in exponents.iter().enumerate() {
            let value: f64 = (0..3).map(|a| x[a].powi(exponent[a])).product();
            squares[e] += value * value;
            for axis in 0..3 {
                for j in 0..u.ncols() {
                    products[(j, 3 * e + axis)] += value * u[(3 * i + axis, j)];
                }
            }
        }
    }
    for (column, square) in (0..).zip(squares.iter().flat_map(|s| [s; 3])) {
        let length = square.sqrt().max(f64::MIN_POSITIVE);
        products
            .col_mut(column)
            .iter_mut()
            .for_each(|x| *x /= length);
    }
    products
}
