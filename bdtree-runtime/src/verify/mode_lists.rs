//! Mode lists: ascending, each stored once, in the order in which nodes first use them.

use bdtree_format::{NodeRecord, SectionKind};
use core::mem::{offset_of, size_of};
use core::ops::ControlFlow;

use super::Report;
use crate::error::{Datum, FormatError};
use crate::view::Asset;

impl Asset<'_> {
    pub(super) fn mode_lists(&self, report: Report<'_>) -> ControlFlow<()> {
        let mut end = 0_u64;
        for (i, node) in self.nodes.iter().enumerate() {
            let byte = self.section_offset(SectionKind::NODES)
                + (i * size_of::<NodeRecord>() + offset_of!(NodeRecord, mode_list_start)) as u64;
            let start = u64::from(node.mode_list_start);
            let mut broken = |rule: &'static str, expected: u64, found: u64| {
                report(FormatError {
                    section: SectionKind::NODES,
                    byte,
                    rule,
                    expected: Datum::Integer(expected),
                    found: Datum::Integer(found),
                })
            };
            let list = match self.node_modes(node) {
                Ok([]) if start == 0 => continue,
                Ok([]) => {
                    broken("SPEC 6.7: an empty mode list starts at 0", 0, start)?;
                    continue;
                }
                Ok(list) => list,
                Err(error) => {
                    report(error)?;
                    continue;
                }
            };
            self.ascending(node, list, &mut broken)?;
            let earlier = self.nodes.get(..i).unwrap_or_default();
            if start == end {
                end += list.len() as u64;
                if let Some(first) = self.same_list(earlier, node, list) {
                    broken(
                        "SPEC 6.7: each distinct mode list is stored once",
                        u64::from(first.mode_list_start),
                        start,
                    )?;
                }
            } else if start > end {
                broken(
                    "SPEC 6.7: mode lists stand without a gap, in the order of first use",
                    end,
                    start,
                )?;
                end = start + list.len() as u64;
            } else if !shares_whole_list(earlier, node) {
                broken("SPEC 6.7: nodes share whole mode lists only", end, start)?;
            }
        }
        if end != self.mode_lists.len() as u64 {
            report(FormatError {
                section: SectionKind::MODE_LISTS,
                byte: self.section_offset(SectionKind::MODE_LISTS),
                rule: "SPEC 6.7: the mode lists hold what nodes use and nothing else",
                expected: Datum::Integer(end),
                found: Datum::Integer(self.mode_lists.len() as u64),
            })?;
        }
        ControlFlow::Continue(())
    }

    /// Strictly ascending, and below M.
    fn ascending(
        &self,
        node: &NodeRecord,
        list: &[u16],
        broken: &mut impl FnMut(&'static str, u64, u64) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let m = self.modes.len() as u64;
        let last = list.last().map_or(0, |j| u64::from(*j));
        if !list.windows(2).all(|w| w[0] < w[1]) || last >= m {
            broken(
                "SPEC 6.7: a mode list ascends, its indices are below the mode count",
                m,
                u64::from(node.mode_list_start),
            )?;
        }
        ControlFlow::Continue(())
    }

    /// An earlier node that uses an equal list that stands elsewhere.
    fn same_list(
        &self,
        earlier: &[NodeRecord],
        node: &NodeRecord,
        list: &[u16],
    ) -> Option<NodeRecord> {
        earlier
            .iter()
            .find(|other| {
                other.mode_count == node.mode_count
                    && other.mode_list_start != node.mode_list_start
                    && self.node_modes(other).is_ok_and(|l| l == list)
            })
            .copied()
    }
}

/// Whether the last earlier node that starts where this one does has as many modes: neighbours
/// mostly share, so the search is mostly short.
fn shares_whole_list(earlier: &[NodeRecord], node: &NodeRecord) -> bool {
    earlier
        .iter()
        .rev()
        .find(|other| other.mode_list_start == node.mode_list_start && other.mode_count > 0)
        .is_some_and(|other| other.mode_count == node.mode_count)
}
