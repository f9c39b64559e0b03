//! What is wrong or odd about given fields.

use faer::MatRef;

use crate::basis::Basis;
use crate::error::{Part, Place, Problems};

/// Most multiplications for the search for dependent fields; larger bases are not searched.
const WORK_CAP: f64 = 3e10;

/// A field whose part outside the fields before it is at most this, relative to the field, is
/// called dependent. Fields rounded to f32 have errors of 6e-8; their squares, which is what the
/// search sees, are computed to about 1e-15.
const DEPENDENT_REL: f64 = 1e-6;

/// One problem per entry that is not finite, in field order.
pub(super) fn non_finite(basis: &Basis, file: &Place, problems: &mut Problems) {
    for j in 0..basis.mode_count() {
        for (i, u) in basis.field(j).iter().enumerate() {
            for (k, x) in u.iter().enumerate().filter(|(_, x)| !x.is_finite()) {
                let place = || {
                    let mode = file.clone().at(Part::Mode(j));
                    mode.at(Part::Vertex(i)).at(Part::Axis(k))
                };
                problems.add(|| (place(), format!("{x} is not finite")));
            }
        }
    }
}

/// One warning per field that is zero or a combination of the fields before it.
///
/// Every field is searched, by the Cholesky factor of `UᵀU`, unless (3N + M) M² is beyond
/// [`WORK_CAP`]: M may be far above 3N, and `UᵀU` has M² numbers.
pub(super) fn oddities(basis: &Basis, place: &Place) -> Vec<String> {
    let (n, m) = (3 * basis.vertex_count, basis.mode_count());
    let is_zero: Vec<bool> = (0..m)
        .map(|j| basis.field(j).as_flattened().iter().all(|&x| x == 0.0))
        .collect();
    let mut dependent = vec![false; m];
    if (n + m) as f64 * (m as f64) * (m as f64) <= WORK_CAP {
        let u = MatRef::from_column_major_slice(basis.fields.as_flattened(), n, m);
        let gram = u.transpose() * u;
        dependent = dependent_columns(m, |a, b| gram[(a, b)]);
    }
    (0..m)
        .filter_map(|j| {
            if is_zero[j] {
                Some(format!("{place}: mode {j} is zero everywhere"))
            } else if dependent[j] {
                Some(format!(
                    "{place}: mode {j} is a combination of the modes before it"
                ))
            } else {
                None
            }
        })
        .collect()
}

/// Which columns the ones before them span, from the scalar products of all pairs. Columns whose
/// square leaves the range of f64 are taken as independent.
fn dependent_columns(m: usize, gram: impl Fn(usize, usize) -> f64) -> Vec<bool> {
    let norm: Vec<f64> = (0..m).map(|j| gram(j, j).sqrt()).collect();
    let usable = |j: usize| norm[j].is_finite() && norm[j] > 1e-140;
    let mut dependent = vec![false; m];
    // Row j of the factor: products of column j with the orthonormal directions so far.
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(m);
    let mut directions: Vec<usize> = Vec::new();
    for j in 0..m {
        let mut row: Vec<f64> = Vec::with_capacity(directions.len() + 1);
        if usable(j) {
            for (d, &i) in directions.iter().enumerate() {
                let product = gram(i, j) / norm[i] / norm[j];
                let known: f64 = (0..d).map(|e| rows[i][e] * row[e]).sum();
                row.push((product - known) / rows[i][d]);
            }
            let rest = 1.0 - row.iter().map(|x| x * x).sum::<f64>();
            if rest <= DEPENDENT_REL * DEPENDENT_REL {
                dependent[j] = true;
            } else {
                row.push(rest.sqrt());
                directions.push(j);
            }
        }
        rows.push(row);
    }
    dependent
}
