//! Recomputes every lane's bounds from the vertices below it, within SPEC 5.8.

use bdtree_format::{
    LANES, NodeRecord, ROW_CENTRE_X, ROW_RADIUS, ROWS_LEADING, ROWS_PER_MODE, Row, SectionKind,
    mode_row,
};
use core::ops::ControlFlow;

use super::{GUARD, Report};
use crate::error::{Datum, FormatError};
use crate::math::{dot, norm, sqrt, sub};
use crate::view::Asset;

/// Shares of R² and ΔR_j² by which squares may exceed them.
const GUARD_RADIUS: f64 = 1.0 / (1_u64 << 44) as f64;
/// Share of R² and ΔR_j² that is added to d and e.
const GUARD_SQUARE: f64 = 1.0 / (1_u64 << 48) as f64;
/// Share of R ΔR_j by which b± may be too small.
const GUARD_PRODUCT: f64 = 1.0 / (1_u64 << 40) as f64;
/// Share of δR² by which a vertex's norm may exceed it.
const GUARD_STEP: f64 = 1.0 / (1_u64 << 41) as f64;

impl Asset<'_> {
    /// Recomputes every lane's bounds from the vertices below it.
    pub(super) fn bounds(&self, report: Report<'_>) -> ControlFlow<()> {
        for node in self.nodes {
            let (Ok(rows), Ok(modes)) = (self.node_rows(node), self.node_modes(node)) else {
                continue; // reported before
            };
            for lane in 0..LANES {
                let bit = 1 << lane;
                let check = LaneCheck {
                    asset: self,
                    node,
                    rows,
                    modes,
                    lane,
                };
                check.norms(report)?;
                if node.leaf_mask & bit != 0 {
                    let before: usize = node.leaf_counts[..lane]
                        .iter()
                        .map(|c| usize::from(*c))
                        .sum();
                    let start = node.first_slot as usize + before;
                    let count = usize::from(node.leaf_counts[lane]);
                    check.triangles(start..start + count, report)?;
                } else if node.inner_mask & bit != 0 {
                    let before = (node.inner_mask & (bit - 1)).count_ones();
                    let child = (node.first_child + before) as usize;
                    self.subtree_slots(child, |slots| check.triangles(slots, report))?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// The triangle slots below a node: one range per level. Needs a sound node order.
    fn subtree_slots(
        &self,
        root: usize,
        mut each: impl FnMut(core::ops::Range<usize>) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut level = root..root + 1;
        while let Some(nodes) = self.nodes.get(level.clone())
            && let (Some(first), Some(last)) = (nodes.first(), nodes.last())
        {
            let count: usize = last.leaf_counts.iter().map(|c| usize::from(*c)).sum();
            each(first.first_slot as usize..last.first_slot as usize + count)?;
            let children = last.inner_mask.count_ones() as usize;
            level = first.first_child as usize..last.first_child as usize + children;
        }
        ControlFlow::Continue(())
    }
}

/// One lane whose bounds are recomputed.
struct LaneCheck<'c, 'a> {
    asset: &'c Asset<'a>,
    node: &'c NodeRecord,
    rows: &'a [Row],
    modes: &'a [u16],
    lane: usize,
}

impl LaneCheck<'_, '_> {
    fn value(&self, row: usize) -> f64 {
        f64::from(self.rows[row][self.lane])
    }

    fn vector(&self, row: usize) -> [f64; 3] {
        [self.value(row), self.value(row + 1), self.value(row + 2)]
    }

    /// The error of a row whose value is not at least `needed`.
    fn too_small(&self, row: usize, needed: f64, rule: &'static str) -> FormatError {
        FormatError {
            section: SectionKind::ROWS,
            byte: self.asset.row_byte(self.node, row, self.lane),
            rule,
            expected: Datum::Real(needed),
            found: Datum::Real(self.value(row)),
        }
    }

    /// Centres obey P and W_j; radii and growths are not negative.
    fn norms(&self, report: Report<'_>) -> ControlFlow<()> {
        let p = f64::from(self.asset.header.position_norm_max.get());
        let n = norm(self.vector(ROW_CENTRE_X));
        let mut check = |row: usize, n: f64, limit: f64| {
            if n * (1.0 - GUARD) > limit {
                return report(FormatError {
                    section: SectionKind::ROWS,
                    byte: self.asset.row_byte(self.node, row, self.lane),
                    rule: "SPEC 5.3: no norm is above position_norm_max or field_norm_max",
                    expected: Datum::Real(limit),
                    found: Datum::Real(n),
                });
            }
            ControlFlow::Continue(())
        };
        check(ROW_CENTRE_X, n, p)?;
        for (k, mode) in self.modes.iter().enumerate() {
            let w = self.asset.modes[usize::from(*mode)].field_norm_max.get();
            check(mode_row(k), norm(self.vector(mode_row(k))), f64::from(w))?;
        }
        let growths = (0..self.modes.len()).map(|k| mode_row(k) + 3);
        let steps = mode_row(self.modes.len())..self.rows.len();
        for row in [ROW_RADIUS].into_iter().chain(growths).chain(steps) {
            if self.value(row) < 0.0 {
                let rule = "SPEC 6.5: R, delta R and the step bounds are not negative";
                report(self.too_small(row, 0.0, rule))?;
            }
        }
        ControlFlow::Continue(())
    }

    fn triangles(&self, slots: core::ops::Range<usize>, report: Report<'_>) -> ControlFlow<()> {
        for triangle in self.asset.triangles.get(slots).unwrap_or_default() {
            for corner in triangle.corners {
                self.vertex(corner as usize, report)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// docs/guarantees.md, the bound, with the stored centres, radii and growths.
    fn vertex(&self, i: usize, report: Report<'_>) -> ControlFlow<()> {
        let asset = self.asset;
        let m = asset.modes.len();
        let radius = self.value(ROW_RADIUS);
        let x = sub(asset.positions[i].map(f64::from), self.vector(ROW_CENTRE_X));
        if dot(x, x) > radius * radius * (1.0 + GUARD_RADIUS) {
            let rule = "SPEC 6.6: R reaches every vertex below the lane";
            report(self.too_small(ROW_RADIUS, norm(x), rule))?;
        }
        let d = (radius * radius - dot(x, x)).max(0.0) + GUARD_SQUARE * radius * radius;
        let fields = &asset.displacements[i * m..(i + 1) * m];
        let mut listed = self.modes.iter().map(|j| usize::from(*j)).peekable();
        let mut k = 0;
        // Gram matrices U Uᵀ of the vertex's 3 × M block, plain and with scaled steps.
        let mut gram = [[0.0; 3]; 3];
        let mut gram_scaled = [[0.0; 3]; 3];
        for (j, u) in fields.iter().enumerate() {
            let u = u.map(f64::from);
            let s = f64::from(asset.modes[j].step_scale.get());
            for r in 0..3 {
                for c in 0..3 {
                    gram[r][c] += u[r] * u[c];
                    gram_scaled[r][c] += u[r] * s * (u[c] * s);
                }
            }
            if listed.peek() != Some(&j) {
                if u != [0.0; 3] {
                    report(FormatError {
                        section: SectionKind::DISPLACEMENTS,
                        byte: asset.section_offset(SectionKind::DISPLACEMENTS)
                            + 12 * (i * m + j) as u64,
                        rule: "SPEC 6.7: a mode that a node leaves out moves no vertex below it",
                        expected: Datum::Real(0.0),
                        found: Datum::Real(norm(u)),
                    })?;
                }
                continue;
            }
            listed.next();
            let row = mode_row(k);
            k += 1;
            let w = sub(u, self.vector(row));
            let growth = self.value(row + 3);
            if dot(w, w) > growth * growth * (1.0 + GUARD_RADIUS) {
                let rule = "SPEC 6.6: delta R reaches every displacement below the lane";
                report(self.too_small(row + 3, norm(w), rule))?;
            }
            let e = (growth * growth - dot(w, w)).max(0.0) + GUARD_SQUARE * growth * growth;
            let saved = sqrt(d * e) + GUARD_PRODUCT * radius * growth;
            let along = dot(x, w);
            for (row, along) in [(row + 4, along), (row + 5, -along)] {
                if self.value(row) < along - saved {
                    let rule = "SPEC 6.6: b+ and b- hold for every vertex below the lane";
                    report(self.too_small(row, along - saved, rule))?;
                }
            }
        }
        let last = ROWS_LEADING + ROWS_PER_MODE * self.modes.len();
        for (row, gram) in [(last, gram), (last + 1, gram_scaled)] {
            let found = self.value(row);
            if !at_most_square(&gram, found) {
                report(FormatError {
                    section: SectionKind::ROWS,
                    byte: asset.row_byte(self.node, row, self.lane),
                    rule: "SPEC 6.6: delta-R (plain, scaled) reaches every vertex's 3 x M norm",
                    expected: Datum::Text("at least the spectral norm"),
                    found: Datum::Real(found),
                })?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// Whether the largest eigenvalue of a symmetric positive semidefinite matrix is at most
/// `bound²`, up to the guard: whether bound² I − G has no negative pivot. Pivots are the largest
/// diagonal entries left, so that rounding stays at a few times 2⁻⁵³ of bound², and a negative
/// eigenvalue −η leaves a last pivot of −η or less.
fn at_most_square(g: &[[f64; 3]; 3], bound: f64) -> bool {
    let square = bound * bound;
    if g[0][0] + g[1][1] + g[2][2] <= square {
        return true; // the common case, and the trace bounds the largest eigenvalue
    }
    let slack = GUARD_STEP * square;
    let mut a = *g;
    for (r, row) in a.iter_mut().enumerate() {
        for (c, x) in row.iter_mut().enumerate() {
            *x = if r == c { square - *x } else { -*x };
        }
    }
    let mut left = [true; 3];
    for _ in 0..3 {
        let open = |i: &usize| left[*i];
        let Some(p) = (0..3)
            .filter(open)
            .max_by(|i, j| a[*i][*i].total_cmp(&a[*j][*j]))
        else {
            break;
        };
        let pivot = a[p][p];
        if pivot <= slack {
            // What is left has no larger diagonal: only near zero is it not negative.
            return (0..3).filter(open).all(|i| {
                a[i][i] >= -slack
                    && (0..3)
                        .filter(open)
                        .all(|j| i == j || a[i][j].abs() <= slack)
            });
        }
        left[p] = false;
        for i in 0..3 {
            for j in 0..3 {
                if left[i] && left[j] {
                    a[i][j] -= a[i][p] * a[p][j] / pivot;
                }
            }
        }
    }
    true
}
