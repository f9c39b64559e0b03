//! The deep check: every checksum, every padding byte, every record, every bound.
//!
//! Breadth-first order makes it possible without memory: a subtree is one contiguous range of
//! nodes, and of triangles, per level.

mod bone_rows;
mod bounds;
mod frames;
mod mass;
mod metadata;
mod mode_lists;
mod skeleton;
mod skin;
mod spectral;
mod vertex_modes;

pub(crate) use skeleton::{CHANNELS, JOINTS, KEYS, KINDS, PARENTS, TARGETS};

use bdtree_format::{
    GroupRecord, LANES, NodeRecord, PairRow, Row, SectionKind, TriangleRecord, pair_row, row_count,
};
use core::mem::{offset_of, size_of};
use core::ops::ControlFlow;

use crate::contact::VertexId;
use crate::error::{Check, Datum, FormatError, SECTION_CRC};
use crate::math::norm;
use crate::rounding::CHECKED_NORM;
use crate::view::{Asset, NodeRows};

/// Takes each broken rule; `Break` ends the check.
type Report<'r> = &'r mut dyn FnMut(FormatError) -> ControlFlow<()>;

impl Check {
    /// Reports the rule unless `ok`.
    fn tell(
        self,
        report: Report<'_>,
        ok: bool,
        expected: impl Into<Datum>,
        found: impl Into<Datum>,
    ) -> ControlFlow<()> {
        if ok {
            return ControlFlow::Continue(());
        }
        report(self.broken(expected, found))
    }
}

const FINITE: &str = "SPEC 5.1: numbers are finite and not subnormal";
const NORMS: &str = "SPEC 5.3: no norm is above position_norm_max or field_norm_max";

/// Whether the format has such a number (SPEC 5.1).
fn is_stored(x: f32) -> bool {
    x.is_normal() || x == 0.0
}

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
    /// Cost: a pass over the file and, per tree level, one over the triangles' corners, their
    /// modes and bones; per 2¹⁵ entries of the mode lists, one over the records of nodes and vertices. Bounds
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
            self.skin_order(&mut note)?;
        }
        self.mass_numbers(report)?;
        self.frame_numbers(report)?;
        self.skeleton_and_clips(report)?;
        self.metadata_record(report)?;
        if sound {
            self.bounds(report)?;
            self.bone_bounds(report)?;
        }
        ControlFlow::Continue(())
    }

    fn checksums(&self, report: Report<'_>) -> ControlFlow<()> {
        for section in self.sections {
            let start = section.offset.get() as usize;
            let end = start.saturating_add(section.length.get() as usize);
            let crc = crc32fast::hash(self.bytes.get(start..end).unwrap_or_default());
            let stored = section.crc.get();
            Check::at(section.kind, section.offset.get())
                .rule(SECTION_CRC)
                .tell(report, crc == stored, stored, crc)?;
        }
        ControlFlow::Continue(())
    }

    fn padding(&self, report: Report<'_>) -> ControlFlow<()> {
        let mut end = self.header.header_bytes.get() as usize;
        for section in self.sections {
            let start = section.offset.get() as usize;
            let gap = self.bytes.get(end..start).unwrap_or_default();
            if let Some(i) = gap.iter().position(|b| *b != 0) {
                let place = Check::at(section.kind, (end + i) as u64);
                let rule = place.rule("SPEC 3.3: padding is zero");
                report(rule.broken(0_u32, gap[i]))?;
            }
            end = start.saturating_add(section.length.get() as usize);
        }
        ControlFlow::Continue(())
    }

    /// Every f32 is finite and not subnormal; rest positions and displacements obey P and W_j.
    fn numbers(&self, report: Report<'_>) -> ControlFlow<()> {
        for (section, vectors) in [
            (SectionKind::POSITIONS, self.positions),
            (SectionKind::DISPLACEMENTS, self.displacements),
        ] {
            let numbers = vectors.as_flattened();
            if let Some(i) = numbers.iter().position(|x| !is_stored(*x)) {
                let place = self.at(section, size_of::<f32>() * i).rule(FINITE);
                report(place.broken("a normal number or zero", numbers[i]))?;
            }
        }
        self.row_numbers(report)?;
        let mut at_most = |section, index: usize, x: [f32; 3], limit: f64| {
            let n = norm(x.map(f64::from));
            if n * (1.0 - CHECKED_NORM) > limit {
                let place = self.at(section, size_of::<[f32; 3]>() * index);
                return report(place.rule(NORMS).broken(Datum::AtMost(limit), n));
            }
            ControlFlow::Continue(())
        };
        let p = f64::from(self.header.position_norm_max.get());
        for (i, x) in self.positions.iter().enumerate() {
            at_most(SectionKind::POSITIONS, i, *x, p)?;
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
                at_most(SectionKind::DISPLACEMENTS, first + k, u, w)?;
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
                if let Some(lane) = row.iter().position(|x| !is_stored(*x)) {
                    let place = self.row_place(node, r, lane).rule(FINITE);
                    return report(place.broken("a normal number or zero", row[lane]));
                }
            }
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
        let leaf_max = self.header.leaf_triangles_max.get();
        for (i, node) in self.nodes.iter().enumerate() {
            let at = self.at(SectionKind::NODES, i * size_of::<NodeRecord>());
            if let Some(e) = node.scale_exponents.iter().find(|e| **e < EXPONENT_MIN) {
                let rule = at.rule("SPEC 6.1: exponents of units are at least -126");
                report(rule.broken(Datum::at_least(EXPONENT_MIN), *e))?;
            }
            if i as u64 == level_end {
                level += 1;
                level_end = next_child;
            }
            at.rule("SPEC 6.4: a node's level is its distance from the root")
                .tell(report, level == node.level.into(), level, node.level)?;
            for (rule, expected, found) in [
                (
                    "SPEC 6.3: first_child is the running count of inner lanes",
                    next_child,
                    node.first_child,
                ),
                (
                    "SPEC 6.3: first_slot is the running count of triangles",
                    next_slot,
                    node.first_slot,
                ),
                (
                    "SPEC 6.3: row_start is the running count of rows",
                    next_row,
                    node.row_start,
                ),
            ] {
                at.rule(rule)
                    .tell(report, expected == found.into(), expected, found)?;
            }
            let behind = i as u64 + 1;
            at.rule("SPEC 6.3: a node's children stand behind it")
                .tell(
                    report,
                    next_child >= behind,
                    Datum::at_least(behind),
                    next_child,
                )?;
            let (inner, leaves) = (node.inner_mask, node.leaf_mask);
            let ok = inner & leaves == 0 && inner | leaves != 0;
            at.rule("SPEC 6.2: a lane is empty, inner or leaf, and a node has one at least")
                .tell(report, ok, inner, leaves)?;
            for (lane, count) in node.leaf_counts.iter().enumerate() {
                let leaf = leaves & (1 << lane) != 0;
                let ok = leaf == (*count > 0) && u32::from(*count) <= leaf_max;
                at.rule(
                    "SPEC 6.2: leaf lanes, and no others, hold 1 to leaf_triangles_max triangles",
                )
                .tell(
                    report,
                    ok,
                    if leaf {
                        Datum::Within(1.0, leaf_max.into())
                    } else {
                        Datum::Integer(0)
                    },
                    *count,
                )?;
            }
            let count = usize::from(node.mode_count);
            at.rule("SPEC 6.1: a node has at most all modes").tell(
                report,
                count <= m,
                Datum::at_most(m),
                count,
            )?;
            match self.node_rows(node) {
                Ok(rows) => self.empty_lanes(node, &rows, report)?,
                Err(error) => report(error)?,
            }
            next_child += u64::from(node.inner_mask.count_ones());
            next_slot += node.leaf_counts.iter().map(|c| u64::from(*c)).sum::<u64>();
            next_row += row_count(usize::from(node.mode_count)) as u64;
        }
        let (nodes, triangles) = (self.nodes.len() as u64, self.triangles.len() as u64);
        let (rows, depth) = (self.rows.len() as u64, self.depth() as u64);
        let of_nodes = self.at(SectionKind::NODES, 0);
        of_nodes
            .rule("SPEC 6.3: every node but the root is a child")
            .tell(report, next_child == nodes, next_child, nodes)?;
        self.at(SectionKind::TRIANGLES, 0)
            .rule("SPEC 6.3: every triangle is in one leaf lane")
            .tell(report, next_slot == triangles, next_slot, triangles)?;
        self.at(SectionKind::ROWS, 0)
            .rule("SPEC 6.3: every row is a node's")
            .tell(report, next_row == rows, next_row, rows)?;
        of_nodes
            .rule("SPEC 6.4: the header's depth is the number of node levels")
            .tell(report, level + 1 == depth, level + 1, depth)
    }

    fn empty_lanes(
        &self,
        node: &NodeRecord,
        rows: &NodeRows<'_>,
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let used = node.inner_mask | node.leaf_mask;
        let rule = "SPEC 6.5: rows are zero in empty lanes and where a pair has no second mode";
        for (r, row) in plain_rows(rows) {
            for lane in (0..LANES).filter(|lane| used & (1 << lane) == 0) {
                if row[lane] != 0.0 {
                    let place = self.row_place(node, r, lane).rule(rule);
                    report(place.broken(0_u32, row[lane]))?;
                }
            }
        }
        for k in 0..2 * rows.pairs.len() {
            // The last pair's second place is nobody's where the modes are odd in number.
            let of_mode = k < usize::from(node.mode_count);
            for lane in (0..LANES).filter(|lane| !of_mode || used & (1 << lane) == 0) {
                for (which, n) in rows.numbers(k, lane).into_iter().enumerate() {
                    if n != 0 {
                        let place = self.mode_place(node, k, which, lane).rule(rule);
                        report(place.broken(0_u32, f64::from(n)))?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Where a number of a node's f32 row stands in the file.
    fn row_place(&self, node: &NodeRecord, row: usize, lane: usize) -> Check {
        let row = node.row_start as usize + row;
        self.at(
            SectionKind::ROWS,
            row * size_of::<Row>() + size_of::<f32>() * lane,
        )
    }

    /// Where a number of a node's k-th active mode stands in the file: `which` counts Ū_x, Ū_y,
    /// Ū_z, ΔR, b⁺ and b⁻.
    fn mode_place(&self, node: &NodeRecord, k: usize, which: usize, lane: usize) -> Check {
        let row = node.row_start as usize + pair_row(k / 2);
        let place = size_of::<PairRow>() * which + size_of::<[i16; 2]>() * lane;
        let second = size_of::<i16>() * (k % 2);
        self.at(SectionKind::ROWS, row * size_of::<Row>() + place + second)
    }

    /// Corners are vertices, and slots are the inverse of the triangles' ids.
    fn triangle_order(&self, report: Report<'_>) -> ControlFlow<()> {
        let count = self.positions.len();
        for (slot, triangle) in self.triangles.iter().enumerate() {
            let start = slot * size_of::<TriangleRecord>();
            let outside = |v: &&u32| **v as usize >= count;
            if let Some(v) = triangle.corners.iter().find(outside) {
                report(self.no_corner(slot, *v))?;
            }
            let back = self.triangle_slots.get(triangle.id as usize);
            if back.map(|s| *s as usize) != Some(slot) {
                let found = back.map_or(Datum::Text("no such id"), |s| (*s).into());
                let id = start + offset_of!(TriangleRecord, id);
                let rule = "SPEC 7.2: SLOT gives each triangle id its place in TRIS";
                report(
                    self.at(SectionKind::TRIANGLES, id)
                        .rule(rule)
                        .broken(slot, found),
                )?;
            }
        }
        ControlFlow::Continue(())
    }

    fn group_ranges(&self, report: Report<'_>) -> ControlFlow<()> {
        let mut first_before = 0;
        for (i, group) in self.groups.iter().enumerate() {
            let at = self.at(SectionKind::GROUPS, i * size_of::<GroupRecord>());
            let first = group.first_triangle;
            at.rule("SPEC 7.4: groups stand in the order of their triangles")
                .tell(
                    report,
                    first >= first_before,
                    Datum::at_least(first_before),
                    first,
                )?;
            first_before = first;
            let end = u64::from(first) + u64::from(group.triangle_count);
            let start = group.name_start as usize;
            let name = self
                .group_names
                .get(start..start.saturating_add(group.name_bytes as usize));
            let named = name.is_some_and(|n| core::str::from_utf8(n).is_ok());
            let count = self.triangles.len();
            at.rule("SPEC 7.4: a group's triangles exist and its name is UTF-8 in GNAM")
                .tell(
                    report,
                    end <= count as u64 && named,
                    if end > count as u64 {
                        Datum::at_most(count)
                    } else {
                        "a name of UTF-8".into()
                    },
                    end,
                )?;
        }
        ControlFlow::Continue(())
    }
}
