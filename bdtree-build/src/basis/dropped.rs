//! Fields that a basis does without, and what that costs.

use std::borrow::Cow;
use std::cmp::Reverse;

use super::tally::Tally;
use super::{Animation, Basis, BasisError};
use crate::error::{BakeError, Place};
use crate::input::RawMesh;
use crate::vec3::norm;
use crate::wrap::{self, StoredShape};

/// Which fields of a basis to keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Keep {
    /// All.
    All,
    /// The first so many; all where there are fewer, since none are lost.
    First(usize),
    /// As few as keep the error, over the box diagonal, at most at this.
    Auto {
        /// Largest distance over the box diagonal, 0 or more.
        max_error_rel: f64,
    },
}

impl Keep {
    /// What to say where more fields are asked for than there are.
    pub(crate) fn warning(self, source: &str, found: usize) -> Option<String> {
        let Self::First(wanted) = self else {
            return None;
        };
        (wanted > found)
            .then(|| format!("{source}: {found} of {wanted} modes: it has no more fields"))
    }
}

/// A basis with some fields left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// The fields that are left, in their old order, and their q over time.
    pub basis: Basis,
    /// The old number of each field, ascending.
    pub fields: Vec<usize>,
    /// How far the stored basis can be from all fields while each |q_j| stays within its range: per
    /// vertex the sum over the fields of range × distance, left-out fields counting in full.
    pub error: BasisError,
}

/// `basis` with the fields that `keep` says. The error counts rounding of the stored numbers to f32
/// too, not that of a pose's sums (docs/reference/morph-targets.md).
///
/// A field's reach is its range times its longest displacement; its range is
/// [`BasisMode::q_range`](super::BasisMode), else what moves its farthest vertex by 5 % of the
/// diagonal. `Auto` drops fields in the order of their reach, the smallest first, as many as the
/// error allows; zero fields cost nothing and go.
///
/// # Errors
/// An error limit that is no number of at least 0 or that all fields together do not keep, and what
/// [`wrap::store`] refuses.
pub fn keep_fields(mesh: &RawMesh, basis: Basis, keep: Keep) -> Result<Kept, BakeError> {
    let count = basis.mode_count();
    let fail = |message| Err(BakeError::one("basis", Place::file(&mesh.name), message));
    let whole = basis.vertex_count.checked_mul(count);
    if basis.vertex_count != mesh.positions.len() || whole != Some(basis.fields.len()) {
        let (found, vertices) = (basis.fields.len(), mesh.positions.len());
        return fail(format!(
            "{found} displacements of {count} fields for {vertices} vertices"
        ));
    }
    let source = Source::new(mesh, &basis);
    match keep {
        Keep::All => source.keep(Cow::Owned(basis), &vec![true; count]),
        Keep::First(wanted) => {
            let is_kept: Vec<bool> = (0..count).map(|j| j < wanted).collect();
            source.keep(Cow::Owned(basis), &is_kept)
        }
        Keep::Auto {
            max_error_rel: limit,
        } if !(limit >= 0.0 && limit.is_finite()) => fail(format!(
            "an error limit of {limit} is not a number of at least 0"
        )),
        Keep::Auto {
            max_error_rel: limit,
        } => {
            let (order, worst) = source.drop_order(&basis);
            let fits = |w: &f64| *w <= limit * source.diagonal;
            let mut dropped = worst.partition_point(fits).saturating_sub(1);
            loop {
                let mut is_kept = vec![true; count];
                for &j in &order[..dropped] {
                    is_kept[j] = false;
                }
                let kept = source.keep(Cow::Borrowed(&basis), &is_kept)?;
                if kept.error.max_rel <= limit {
                    return Ok(kept);
                }
                if worst[dropped] == 0.0 {
                    return fail(format!(
                        "no choice of fields keeps the error within {limit:e} of the diagonal: all of \
                         them leave {:e} at vertex {}, by rounding to f32",
                        kept.error.max_rel, kept.error.vertex
                    ));
                }
                // Rounding takes the rest: do with fewer.
                dropped = worst
                    .partition_point(|&w| w < worst[dropped])
                    .saturating_sub(1);
            }
        }
    }
}

/// [`Kept::error`] of the fields of the given numbers, ascending.
///
/// # Errors
/// What [`wrap::store`] refuses.
pub(crate) fn error_of(
    mesh: &RawMesh,
    basis: &Basis,
    fields: &[usize],
) -> Result<BasisError, BakeError> {
    let is_kept: Vec<bool> = (0..basis.mode_count())
        .map(|j| fields.contains(&j))
        .collect();
    let kept = Source::new(mesh, basis).keep(Cow::Borrowed(basis), &is_kept)?;
    Ok(kept.error)
}

/// All fields, with what their errors are measured by.
struct Source<'a> {
    mesh: &'a RawMesh,
    /// Diagonal of the box around the rest positions; 1 for a point.
    diagonal: f64,
    /// Range of |q_j| per field; 0 for zero fields without one.
    ranges: Vec<f64>,
}

impl<'a> Source<'a> {
    fn new(mesh: &'a RawMesh, basis: &Basis) -> Self {
        let diagonal = match mesh.diagonal() {
            0.0 => 1.0,
            diagonal => diagonal,
        };
        let ranges = (0..basis.mode_count()).map(|j| basis.range(j, diagonal));
        Self {
            mesh,
            diagonal,
            ranges: ranges.collect(),
        }
    }

    /// The fields by ascending reach (of equal ones the last first), and after each count of
    /// dropped ones how far a vertex can be off.
    fn drop_order(&self, basis: &Basis) -> (Vec<usize>, Vec<f64>) {
        let reach = |j: usize| self.ranges[j] * basis.longest(j);
        let mut order: Vec<(f64, Reverse<usize>)> = (0..basis.mode_count())
            .map(|j| (reach(j), Reverse(j)))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let order: Vec<usize> = order.into_iter().map(|(_, Reverse(j))| j).collect();
        let mut off = vec![0.0; basis.vertex_count];
        let mut worst = vec![0.0];
        for &j in &order {
            for (off, &u) in off.iter_mut().zip(basis.field(j)) {
                *off += self.ranges[j] * norm(u);
            }
            worst.push(off.iter().copied().fold(0.0, f64::max));
        }
        (order, worst)
    }

    /// The basis without the fields that are not kept, and its error.
    fn keep(&self, basis: Cow<'_, Basis>, is_kept: &[bool]) -> Result<Kept, BakeError> {
        let mut off = vec![0.0; basis.vertex_count];
        for (j, _) in is_kept.iter().enumerate().filter(|(_, kept)| !**kept) {
            for (off, &u) in off.iter_mut().zip(basis.field(j)) {
                *off += self.ranges[j] * norm(u);
            }
        }
        let fields: Vec<usize> = (0..is_kept.len()).filter(|&j| is_kept[j]).collect();
        let basis = if fields.len() == is_kept.len() {
            basis.into_owned()
        } else {
            select(&basis, &fields)
        };
        // The bake stores again and says what is odd.
        let stored = wrap::store(self.mesh, &basis, &mut Vec::new())?;
        self.add_rounding(&stored, &basis, &fields, &mut off);
        let mut tally = Tally::default();
        for (vertex, off) in off.iter().enumerate() {
            tally.add(off * off, None, vertex);
        }
        let error = tally.error(off.len().max(1), self.diagonal);
        Ok(Kept {
            basis,
            fields,
            error,
        })
    }

    /// Adds what rounding to f32 costs each vertex.
    fn add_rounding(&self, stored: &StoredShape, basis: &Basis, fields: &[usize], off: &mut [f64]) {
        let unit = 2.0_f64.powi(stored.unit_exponent);
        let back = |x: [f32; 3]| x.map(|x| f64::from(x) * unit);
        for (i, off) in off.iter_mut().enumerate() {
            let (p, s) = (self.mesh.positions[i], back(stored.positions[i]));
            *off += norm(std::array::from_fn(|k| p[k] - stored.origin[k] - s[k]));
            for (j, &old) in fields.iter().enumerate() {
                let u = basis.field(j)[i];
                let s = back(stored.displacements[i * fields.len() + j]);
                *off += self.ranges[old] * norm(std::array::from_fn(|k| u[k] - s[k]));
            }
        }
    }
}

/// The fields of the given numbers (ascending), and their q.
pub(crate) fn select(basis: &Basis, fields: &[usize]) -> Basis {
    let fields_of = |j: &usize| basis.field(*j).iter().copied();
    Basis {
        vertex_count: basis.vertex_count,
        fields: fields.iter().flat_map(fields_of).collect(),
        modes: fields.iter().map(|&j| basis.modes[j].clone()).collect(),
        animation: basis.animation.as_ref().map(|animation| {
            let frames = animation.q.chunks_exact(basis.mode_count().max(1));
            Animation {
                frame_count: animation.frame_count,
                times_s: animation.times_s.clone(),
                q: frames
                    .flat_map(|q| fields.iter().map(move |&j| q[j]))
                    .collect(),
                motions: animation.motions.clone(),
            }
        }),
    }
}
