//! Recomputes every lane's bounds from the vertices below it, within SPEC 5.8.

use bdtree_format::{LANES, NodeRecord, ROW_CENTER_X, ROW_RADIUS, SectionKind, pair_row};
use core::ops::{ControlFlow, Range};

use super::spectral::at_most_square;
use super::{NORMS, Report};
use crate::contact::VertexId;
use crate::error::{Check, Datum};
use crate::math::{dot, norm, sqrt, sub};
use crate::rounding::{CHECKED_NORM, CHECKED_PRODUCT, CHECKED_RADIUS, CHECKED_SQUARE};
use crate::view::{Asset, NodeRows};

impl Asset<'_> {
    /// Recomputes every lane's bounds from the vertices below it.
    pub(super) fn bounds(&self, report: Report<'_>) -> ControlFlow<()> {
        for node in self.nodes {
            let (Ok(rows), Ok(modes)) = (self.node_rows(node), self.node_modes(node)) else {
                continue; // reported before
            };
            for lane in 0..LANES {
                let check = LaneCheck {
                    asset: self,
                    node,
                    rows: &rows,
                    modes,
                    lane,
                };
                check.norms(report)?;
                self.slots_below(node, lane, |slots| check.triangles(slots, report))?;
            }
        }
        ControlFlow::Continue(())
    }

    /// The triangle slots below a lane, none below an empty one. Needs a sound node order.
    pub(super) fn slots_below(
        &self,
        node: &NodeRecord,
        lane: usize,
        mut each: impl FnMut(Range<usize>) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let bit = 1 << lane;
        if node.leaf_mask & bit != 0 {
            let before = node.leaf_counts[..lane].iter().map(|c| usize::from(*c));
            let start = node.first_slot as usize + before.sum::<usize>();
            each(start..start + usize::from(node.leaf_counts[lane]))
        } else if node.inner_mask & bit != 0 {
            let before = (node.inner_mask & (bit - 1)).count_ones();
            self.subtree_slots((node.first_child + before) as usize, each)
        } else {
            ControlFlow::Continue(())
        }
    }

    /// The triangle slots below a node: one range per level. Needs a sound node order.
    fn subtree_slots(
        &self,
        root: usize,
        mut each: impl FnMut(Range<usize>) -> ControlFlow<()>,
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
    rows: &'c NodeRows<'a>,
    modes: &'a [u16],
    lane: usize,
}

/// A mode's Ū, ΔR, b⁺ and b⁻ in one lane, for q_j at its limit.
struct LaneMode {
    /// `q_limit`_j.
    limit: f64,
    center: [f64; 3],
    growth: f64,
    cross: [f64; 2],
}

/// Places of a mode's rows among its six.
const GROWTH: usize = 3;
const CROSS: usize = 4;

impl LaneCheck<'_, '_> {
    fn center(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| f64::from(self.rows.leading[ROW_CENTER_X + axis][self.lane]))
    }

    fn radius(&self) -> f64 {
        f64::from(self.rows.leading[ROW_RADIUS][self.lane])
    }

    /// The numbers of the k-th active mode, exact.
    fn mode(&self, k: usize) -> LaneMode {
        let [x, y, z, r, plus, minus] = self.rows.numbers(k, self.lane).map(f64::from);
        let [center, growth, cross] = self.rows.units.map(f64::from);
        let mode = usize::from(self.modes[k]);
        LaneMode {
            limit: f64::from(self.asset.modes[mode].q_limit.get()),
            center: [x * center, y * center, z * center],
            growth: r * growth,
            cross: [plus * cross, minus * cross],
        }
    }

    /// The place of an f32 row's number.
    fn row(&self, row: usize) -> Check {
        self.asset.row_place(self.node, row, self.lane)
    }

    /// The place of number `which` of the k-th active mode.
    fn number(&self, k: usize, which: usize) -> Check {
        self.asset.mode_place(self.node, k, which, self.lane)
    }

    /// Centers obey P and W_j; radii are not negative.
    fn norms(&self, report: Report<'_>) -> ControlFlow<()> {
        let mut check = |place: Check, n: f64, limit: f64| {
            let ok = n * (1.0 - CHECKED_NORM) <= limit;
            place.rule(NORMS).tell(report, ok, Datum::AtMost(limit), n)
        };
        let p = f64::from(self.asset.header.position_norm_max.get());
        check(self.row(ROW_CENTER_X), norm(self.center()), p)?;
        for (k, mode) in self.modes.iter().enumerate() {
            let LaneMode { limit, center, .. } = self.mode(k);
            let w = self.asset.modes[usize::from(*mode)].field_norm_max.get();
            check(self.number(k, 0), norm(center) / limit, f64::from(w))?;
        }
        let mut not_negative = |place: Check, found: f64| {
            place
                .rule("SPEC 6.5: R, delta R and the step bounds are not negative")
                .tell(report, found >= 0.0, Datum::AtLeast(0.0), found)
        };
        for k in 0..self.modes.len() {
            not_negative(self.number(k, GROWTH), self.mode(k).growth)?;
        }
        not_negative(self.row(ROW_RADIUS), self.radius())?;
        for (row, values) in (pair_row(self.rows.pairs.len())..).zip(self.rows.steps) {
            not_negative(self.row(row), values[self.lane].into())?;
        }
        ControlFlow::Continue(())
    }

    fn triangles(&self, slots: Range<usize>, report: Report<'_>) -> ControlFlow<()> {
        for triangle in self.asset.triangles.get(slots).unwrap_or_default() {
            for corner in triangle.corners {
                self.vertex(corner, report)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// docs/design/guarantees.md, the bound, with the stored centers, radii and growths.
    fn vertex(&self, vertex: u32, report: Report<'_>) -> ControlFlow<()> {
        let asset = self.asset;
        let Ok(own) = asset.displacements(VertexId(vertex)) else {
            return ControlFlow::Continue(()); // reported before
        };
        let radius = self.radius();
        let x = sub(
            asset.positions[vertex as usize].map(f64::from),
            self.center(),
        );
        if dot(x, x) > radius * radius * (1.0 + CHECKED_RADIUS) {
            let rule = "SPEC 6.6: R reaches every vertex below the lane";
            report(
                self.row(ROW_RADIUS)
                    .rule(rule)
                    .broken(Datum::AtLeast(norm(x)), radius),
            )?;
        }
        // Gram matrices U Uᵀ of the vertex's 3 × M block, plain and with scaled steps.
        let mut gram = [[0.0; 3]; 3];
        let mut gram_scaled = [[0.0; 3]; 3];
        // The node's modes before the k-th are done.
        let mut k = 0;
        let node_mode = |k: usize| self.modes.get(k).map(|j| usize::from(*j));
        for (entry, (j, u)) in own.iter().enumerate() {
            let u = u.map(f64::from);
            let s = f64::from(asset.modes[j].step_scale.get());
            for r in 0..3 {
                for c in 0..3 {
                    gram[r][c] += u[r] * u[c];
                    gram_scaled[r][c] += u[r] * s * (u[c] * s);
                }
            }
            // Modes that are not stored for the vertex do not move it.
            while node_mode(k).is_some_and(|mode| mode < j) {
                self.mode_bounds(k, x, [0.0; 3], report)?;
                k += 1;
            }
            if node_mode(k) == Some(j) {
                self.mode_bounds(k, x, u, report)?;
                k += 1;
            } else if u != [0.0; 3] {
                let index = asset.first_displacement(vertex) + entry;
                let place = asset.at(SectionKind::DISPLACEMENTS, size_of::<[f32; 3]>() * index);
                let rule = "SPEC 6.7: a mode that a node leaves out moves no vertex below it";
                report(place.rule(rule).broken(0.0, norm(u)))?;
            }
        }
        for k in k..self.modes.len() {
            self.mode_bounds(k, x, [0.0; 3], report)?;
        }
        let behind = pair_row(self.rows.pairs.len());
        let [step, scaled] = self.rows.steps;
        for (row, values, gram) in [(behind, step, gram), (behind + 1, scaled, gram_scaled)] {
            let found = f64::from(values[self.lane]);
            if !at_most_square(&gram, found) {
                let rule = "SPEC 6.6: delta-R (plain, scaled) reaches every vertex's 3 x M norm";
                let place = self.row(row).rule(rule);
                report(place.broken("at least the spectral norm", found))?;
            }
        }
        ControlFlow::Continue(())
    }

    /// ΔR, b⁺ and b⁻ of the node's k-th active mode, which moves a vertex at `x` from the center
    /// by `u` per unit of q.
    fn mode_bounds(
        &self,
        k: usize,
        x: [f64; 3],
        u: [f64; 3],
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let radius = self.radius();
        let d = (radius * radius - dot(x, x)).max(0.0) + CHECKED_SQUARE * radius * radius;
        // At the mode's limit: exact, since limits are powers of two.
        let LaneMode {
            limit,
            center,
            growth,
            cross,
        } = self.mode(k);
        let w = sub(u.map(|x| x * limit), center);
        if dot(w, w) > growth * growth * (1.0 + CHECKED_RADIUS) {
            let rule = "SPEC 6.6: delta R reaches every displacement below the lane";
            report(
                self.number(k, GROWTH)
                    .rule(rule)
                    .broken(Datum::AtLeast(norm(w)), growth),
            )?;
        }
        let e = (growth * growth - dot(w, w)).max(0.0) + CHECKED_SQUARE * growth * growth;
        let saved = sqrt(d * e) + CHECKED_PRODUCT * radius * growth;
        let along = dot(x, w);
        for (which, along) in [along, -along].into_iter().enumerate() {
            if cross[which] < along - saved {
                let rule = "SPEC 6.6: b+ and b- hold for every vertex below the lane";
                let place = self.number(k, CROSS + which).rule(rule);
                report(place.broken(Datum::AtLeast(along - saved), cross[which]))?;
            }
        }
        ControlFlow::Continue(())
    }
}
