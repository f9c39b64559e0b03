//! The deep check: every checksum, every padding byte, every record, every bound.
//!
//! Breadth-first order makes it possible without memory: a subtree is one contiguous range of
//! nodes, and of triangles, per level.

mod bounds;
mod frames;
mod metadata;
mod mode_lists;
mod spectral;
mod vertex_modes;

use bdtree_format::{
    GroupRecord, LANES, NodeRecord, PairRow, Row, SectionKind, TriangleRecord, pair_row, row_count,
};
use core::mem::size_of;
use core::ops::ControlFlow;

use crate::contact::VertexId;
use crate::error::{Datum, FormatError};
use crate::math::norm;
use crate::rounding::CHECKED_NORM;
use crate::view::{Asset, NodeRows};

/// Takes each broken rule; `Break` ends the check.
type Report<'r> = &'r mut dyn FnMut(FormatError) -> ControlFlow<()>;

/// Least exponent of a unit that 16-bit rows count: the unit is a normal number (SPEC 6.1).
const EXPONENT_MIN: i8 = -126;

/// The f32 rows of a node with their places among its rows.
fn plain_rows<'r>(rows: &NodeRows<'r>) -> impl Iterator<Item = (usize, &'r Row)> + use<'r> {
    let behind = pair_row(rows.pairs.len());
    let (leading, steps) = (rows.leading, rows.steps);
    leading
        .iter()
        .enumerate()
        .chain((behind..).zip(steps.iter()))
}

impl<'a> Asset<'a> {
    /// Checks everything that [`Asset::open`] does not read: checksums, padding, the canonical
    /// order of nodes, every index, every number, and that every stored bound holds for the
    /// vertices below it. `report` takes each broken rule and may end the check. True when no
    /// rule is broken.
    ///
    /// Cost: a pass over the file and, per tree level, one over the triangles' corners and their
    /// modes; per 2¹⁵ entries of the mode lists, one over the records of nodes and vertices. Bounds
    /// are checked only when everything they rest on is sound.
    pub fn verify(&self, report: &mut dyn FnMut(FormatError) -> ControlFlow<()>) -> bool {
        let mut sound = true;
        let mut report = |error| {
            sound = false;
            report(error)
        };
        let _ = self.verify_all(&mut report);
        sound
    }

    /// Checks the sections' checksums only: what programs do before they trust a file.
    ///
    /// # Errors
    /// The first section whose bytes do not match its checksum.
    pub fn verify_checksums(&self) -> Result<(), FormatError> {
        let mut first = Ok(());
        let _ = self.checksums(&mut |error| {
            first = Err(error);
            ControlFlow::Break(())
        });
        first
    }

    fn verify_all(&self, report: Report<'_>) -> ControlFlow<()> {
        self.checksums(report)?;
        self.padding(report)?;
        let mut sound = true;
        {
            let mut note = |error| {
                sound = false;
                report(error)
            };
            self.numbers(&mut note)?;
            self.node_order(&mut note)?;
            self.triangle_order(&mut note)?;
            self.vertex_modes_order(&mut note)?;
            self.mode_lists(&mut note)?;
            self.group_ranges(&mut note)?;
        }
        self.frame_numbers(report)?;
        self.metadata_record(report)?;
        if sound {
            self.bounds(report)?;
        }
        ControlFlow::Continue(())
    }

    fn checksums(&self, report: Report<'_>) -> ControlFlow<()> {
        for section in self.sections {
            let start = section.offset.get() as usize;
            let end = start.saturating_add(section.length.get() as usize);
            let crc = crc32fast::hash(self.bytes.get(start..end).unwrap_or_default());
            if crc != section.crc.get() {
                report(FormatError {
                    section: section.kind,
                    byte: section.offset.get(),
                    rule: "SPEC 4.1: a section's bytes have its checksum",
                    expected: Datum::Integer(u64::from(section.crc.get())),
                    found: Datum::Integer(u64::from(crc)),
                })?;
            }
        }
        ControlFlow::Continue(())
    }

    fn padding(&self, report: Report<'_>) -> ControlFlow<()> {
        let mut end = self.header.header_bytes.get() as usize;
        for section in self.sections {
            let start = section.offset.get() as usize;
            let gap = self.bytes.get(end..start).unwrap_or_default();
            if let Some(i) = gap.iter().position(|b| *b != 0) {
                report(FormatError {
                    section: section.kind,
                    byte: (end + i) as u64,
                    rule: "SPEC 3.3: padding is zero",
                    expected: Datum::Integer(0),
                    found: Datum::Integer(u64::from(gap[i])),
                })?;
            }
            end = start.saturating_add(section.length.get() as usize);
        }
        ControlFlow::Continue(())
    }

    /// Every f32 is finite and not subnormal; rest positions and displacements obey P and W_j.
    fn numbers(&self, report: Report<'_>) -> ControlFlow<()> {
        let sections = [
            (SectionKind::POSITIONS, self.positions.as_flattened()),
            (
                SectionKind::DISPLACEMENTS,
                self.displacements.as_flattened(),
            ),
        ];
        for (section, numbers) in sections {
            if let Some(i) = numbers.iter().position(|x| !(x.is_normal() || *x == 0.0)) {
                report(FormatError {
                    section,
                    byte: self.section_offset(section) + 4 * i as u64,
                    rule: "SPEC 5.1: numbers are finite and not subnormal",
                    expected: Datum::Text("a normal number or zero"),
                    found: Datum::Real(f64::from(numbers[i])),
                })?;
            }
        }
        self.row_numbers(report)?;
        let p = f64::from(self.header.position_norm_max.get());
        for (i, x) in self.positions.iter().enumerate() {
            self.norm_at_most(SectionKind::POSITIONS, i, *x, p, report)?;
        }
        for i in 0..self.positions.len() as u32 {
            let Ok(own) = self.displacements(VertexId(i)) else {
                continue; // reported with its record
            };
            let first = self.first_displacement(i);
            for (k, (mode, u)) in own.iter().enumerate() {
                let Some(record) = self.modes.get(mode) else {
                    continue; // reported with its list
                };
                let w = f64::from(record.field_norm_max.get());
                self.norm_at_most(SectionKind::DISPLACEMENTS, first + k, u, w, report)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// The first number of the nodes' f32 rows that is none.
    fn row_numbers(&self, report: Report<'_>) -> ControlFlow<()> {
        for node in self.nodes {
            let Ok(rows) = self.node_rows(node) else {
                continue; // reported with the node
            };
            for (r, row) in plain_rows(&rows) {
                let bad = |x: &f32| !(x.is_normal() || *x == 0.0);
                if let Some(lane) = row.iter().position(bad) {
                    return report(FormatError {
                        section: SectionKind::ROWS,
                        byte: self.row_byte(node, r, lane),
                        rule: "SPEC 5.1: numbers are finite and not subnormal",
                        expected: Datum::Text("a normal number or zero"),
                        found: Datum::Real(f64::from(row[lane])),
                    });
                }
            }
        }
        ControlFlow::Continue(())
    }

    fn norm_at_most(
        &self,
        section: SectionKind,
        index: usize,
        x: [f32; 3],
        limit: f64,
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let n = norm(x.map(f64::from));
        if n * (1.0 - CHECKED_NORM) > limit {
            report(FormatError {
                section,
                byte: self.section_offset(section) + 12 * index as u64,
                rule: "SPEC 5.3: no norm is above position_norm_max or field_norm_max",
                expected: Datum::Real(limit),
                found: Datum::Real(n),
            })?;
        }
        ControlFlow::Continue(())
    }

    /// Canonical order: every start is the running count of what stands before it.
    fn node_order(&self, report: Report<'_>) -> ControlFlow<()> {
        let mut next_child = 1_u64;
        let mut next_slot = 0_u64;
        let mut next_row = 0_u64;
        let mut level_end = 1_u64;
        let mut level = 0_u64;
        let m = self.modes.len();
        for (i, node) in self.nodes.iter().enumerate() {
            let at = self.section_offset(SectionKind::NODES) + (i * size_of::<NodeRecord>()) as u64;
            let mut broken = |rule: &'static str, expected: Datum, found: Datum| {
                report(FormatError {
                    section: SectionKind::NODES,
                    byte: at,
                    rule,
                    expected,
                    found,
                })
            };
            if let Some(e) = node.scale_exponents.iter().find(|e| **e < EXPONENT_MIN) {
                broken(
                    "SPEC 6.1: exponents of units are at least -126",
                    Datum::Signed(EXPONENT_MIN.into()),
                    Datum::Signed((*e).into()),
                )?;
            }
            let mut rule = |ok: bool, rule: &'static str, expected: u64, found: u64| {
                if ok {
                    return ControlFlow::Continue(());
                }
                broken(rule, Datum::Integer(expected), Datum::Integer(found))
            };
            if i as u64 == level_end {
                level += 1;
                level_end = next_child;
            }
            rule(
                u64::from(node.level) == level,
                "SPEC 6.4: a node's level is its distance from the root",
                level,
                u64::from(node.level),
            )?;
            for (expected, found) in [
                (next_child, node.first_child),
                (next_slot, node.first_slot),
                (next_row, node.row_start),
            ] {
                rule(
                    expected == u64::from(found),
                    "SPEC 6.3: first_child, first_slot and row_start are running counts",
                    expected,
                    u64::from(found),
                )?;
            }
            rule(
                next_child > i as u64,
                "SPEC 6.3: a node's children stand behind it",
                i as u64 + 1,
                next_child,
            )?;
            rule(
                node.inner_mask & node.leaf_mask == 0 && node.inner_mask | node.leaf_mask != 0,
                "SPEC 6.2: a lane is empty, inner or leaf, and a node has one at least",
                u64::from(node.inner_mask),
                u64::from(node.leaf_mask),
            )?;
            let leaf_max = self.header.leaf_triangles_max.get();
            for (lane, count) in node.leaf_counts.iter().enumerate() {
                let leaf = node.leaf_mask & (1 << lane) != 0;
                rule(
                    leaf == (*count > 0) && u32::from(*count) <= leaf_max,
                    "SPEC 6.2: leaf lanes, and no others, hold 1 to leaf_triangles_max triangles",
                    u64::from(leaf_max),
                    u64::from(*count),
                )?;
            }
            rule(
                usize::from(node.mode_count) <= m,
                "SPEC 6.1: a node has at most all modes",
                m as u64,
                u64::from(node.mode_count),
            )?;
            match self.node_rows(node) {
                Ok(rows) => self.empty_lanes(node, &rows, report)?,
                Err(error) => report(error)?,
            }
            next_child += u64::from(node.inner_mask.count_ones());
            next_slot += node.leaf_counts.iter().map(|c| u64::from(*c)).sum::<u64>();
            next_row += row_count(usize::from(node.mode_count)) as u64;
        }
        let totals = [
            (
                SectionKind::NODES,
                next_child,
                self.nodes.len(),
                "SPEC 6.3: every node but the root is a child",
            ),
            (
                SectionKind::TRIANGLES,
                next_slot,
                self.triangles.len(),
                "SPEC 6.3: every triangle is in one leaf lane",
            ),
            (
                SectionKind::ROWS,
                next_row,
                self.rows.len(),
                "SPEC 6.3: every row is a node's",
            ),
            (
                SectionKind::NODES,
                level + 1,
                self.depth(),
                "SPEC 6.4: the header's depth is the number of node levels",
            ),
        ];
        for (section, expected, found, rule) in totals {
            if expected != found as u64 {
                report(FormatError {
                    section,
                    byte: self.section_offset(section),
                    rule,
                    expected: Datum::Integer(expected),
                    found: Datum::Integer(found as u64),
                })?;
            }
        }
        ControlFlow::Continue(())
    }

    fn empty_lanes(
        &self,
        node: &NodeRecord,
        rows: &NodeRows<'_>,
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let used = node.inner_mask | node.leaf_mask;
        for (r, row) in plain_rows(rows) {
            for (lane, x) in row.iter().enumerate() {
                if used & (1 << lane) == 0 && *x != 0.0 {
                    report(self.not_zero(self.row_byte(node, r, lane), f64::from(*x)))?;
                }
            }
        }
        for k in 0..2 * rows.pairs.len() {
            // The last pair's second place is nobody's where the modes are odd in number.
            let of_mode = k < usize::from(node.mode_count);
            for lane in 0..LANES {
                if of_mode && used & (1 << lane) != 0 {
                    continue;
                }
                for (which, n) in rows.numbers(k, lane).into_iter().enumerate() {
                    if n != 0 {
                        report(self.not_zero(self.mode_byte(node, k, which, lane), n.into()))?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    fn not_zero(&self, byte: u64, found: f64) -> FormatError {
        FormatError {
            section: SectionKind::ROWS,
            byte,
            rule: "SPEC 6.5: rows are zero in empty lanes and where a pair has no second mode",
            expected: Datum::Integer(0),
            found: Datum::Real(found),
        }
    }

    /// Where a number of a node's f32 row stands in the file.
    fn row_byte(&self, node: &NodeRecord, row: usize, lane: usize) -> u64 {
        let row = u64::from(node.row_start) + row as u64;
        self.section_offset(SectionKind::ROWS) + row * size_of::<Row>() as u64 + 4 * lane as u64
    }

    /// Where a number of a node's k-th active mode stands in the file: `which` counts Ū_x, Ū_y,
    /// Ū_z, ΔR, b⁺ and b⁻.
    fn mode_byte(&self, node: &NodeRecord, k: usize, which: usize, lane: usize) -> u64 {
        let place = size_of::<PairRow>() * which + 4 * lane + 2 * (k % 2);
        self.row_byte(node, pair_row(k / 2), 0) + place as u64
    }

    /// Corners are vertices, and slots are the inverse of the triangles' ids.
    fn triangle_order(&self, report: Report<'_>) -> ControlFlow<()> {
        for (slot, triangle) in self.triangles.iter().enumerate() {
            let at = self.section_offset(SectionKind::TRIANGLES)
                + (slot * size_of::<TriangleRecord>()) as u64;
            let count = self.positions.len() as u64;
            if let Some(v) = triangle.corners.iter().find(|v| u64::from(**v) >= count) {
                report(FormatError {
                    section: SectionKind::TRIANGLES,
                    byte: at,
                    rule: "SPEC 7.1: corners are vertex indices",
                    expected: Datum::Integer(count),
                    found: Datum::Integer(u64::from(*v)),
                })?;
            }
            let back = self.triangle_slots.get(triangle.id as usize);
            if back.map(|s| *s as usize) != Some(slot) {
                report(FormatError {
                    section: SectionKind::TRIANGLES,
                    byte: at + 12,
                    rule: "SPEC 7.2: SLOT gives each triangle id its place in TRIS",
                    expected: Datum::Integer(slot as u64),
                    found: back
                        .map_or(Datum::Text("no such id"), |s| Datum::Integer(u64::from(*s))),
                })?;
            }
        }
        ControlFlow::Continue(())
    }

    fn group_ranges(&self, report: Report<'_>) -> ControlFlow<()> {
        let mut first_before = 0;
        for (i, group) in self.groups.iter().enumerate() {
            let byte =
                self.section_offset(SectionKind::GROUPS) + (i * size_of::<GroupRecord>()) as u64;
            if group.first_triangle < first_before {
                report(FormatError {
                    section: SectionKind::GROUPS,
                    byte,
                    rule: "SPEC 7.4: groups stand in the order of their triangles",
                    expected: Datum::Integer(u64::from(first_before)),
                    found: Datum::Integer(u64::from(group.first_triangle)),
                })?;
            }
            first_before = group.first_triangle;
            let end = u64::from(group.first_triangle) + u64::from(group.triangle_count);
            let start = group.name_start as usize;
            let name = self
                .group_names
                .get(start..start.saturating_add(group.name_bytes as usize));
            let named = name.is_some_and(|n| core::str::from_utf8(n).is_ok());
            if end > self.triangles.len() as u64 || !named {
                report(FormatError {
                    section: SectionKind::GROUPS,
                    byte,
                    rule: "SPEC 7.4: a group's triangles exist and its name is UTF-8 in GNAM",
                    expected: Datum::Integer(self.triangles.len() as u64),
                    found: Datum::Integer(end),
                })?;
            }
        }
        ControlFlow::Continue(())
    }
}
