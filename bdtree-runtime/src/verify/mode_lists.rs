//! Mode lists: each stored once, in descending order, so that a list begins wherever the entries
//! do not ascend; and nodes and vertices use all of them, whole.

use bdtree_format::{NodeRecord, SectionKind};
use core::mem::{offset_of, size_of};
use core::ops::ControlFlow;

use super::Report;
use crate::error::{Datum, FormatError};
use crate::view::Asset;

impl Asset<'_> {
    pub(super) fn mode_lists(&self, report: Report<'_>) -> ControlFlow<()> {
        self.list_order(report)?;
        for (i, node) in self.nodes.iter().enumerate() {
            let byte = self.section_offset(SectionKind::NODES)
                + (i * size_of::<NodeRecord>() + offset_of!(NodeRecord, mode_list_start)) as u64;
            let (start, count) = (node.mode_list_start, usize::from(node.mode_count));
            self.whole_list(SectionKind::NODES, byte, start, count, report)?;
        }
        self.lists_used(report)
    }

    /// Whether a list begins or ends at this place of LIST.
    fn is_list_border(&self, at: usize) -> bool {
        let before = at
            .checked_sub(1)
            .and_then(|before| self.mode_lists.get(before));
        match (before, self.mode_lists.get(at)) {
            (Some(before), Some(own)) => own <= before,
            _ => true, // the first begins, the last ends
        }
    }

    /// Modes of the asset; lists in strictly descending order, compared as words are.
    fn list_order(&self, report: Report<'_>) -> ControlFlow<()> {
        let offset = self.section_offset(SectionKind::MODE_LISTS);
        let m = self.modes.len();
        if let Some(i) = self.mode_lists.iter().position(|j| usize::from(*j) >= m) {
            report(FormatError {
                section: SectionKind::MODE_LISTS,
                byte: offset + 2 * i as u64,
                rule: "SPEC 6.7: mode lists hold indices below the mode count",
                expected: Datum::Integer(m as u64),
                found: Datum::Integer(self.mode_lists[i].into()),
            })?;
        }
        let mut before: &[u16] = &[];
        let mut rest = self.mode_lists;
        while !rest.is_empty() {
            let ascending = rest.windows(2).take_while(|w| w[0] < w[1]).count();
            let (list, behind) = rest.split_at(ascending + 1);
            if !before.is_empty() && before <= list {
                report(FormatError {
                    section: SectionKind::MODE_LISTS,
                    byte: offset + 2 * (self.mode_lists.len() - rest.len()) as u64,
                    rule: "SPEC 6.7: mode lists stand in descending order, each once",
                    expected: Datum::Text("a list below the one before"),
                    found: Datum::Text("one that is not"),
                })?;
            }
            (before, rest) = (list, behind);
        }
        ControlFlow::Continue(())
    }

    /// The list of a node or vertex is one of LIST, neither part of one nor parts of several.
    pub(super) fn whole_list(
        &self,
        section: SectionKind,
        byte: u64,
        start: u32,
        count: usize,
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let first = start as usize;
        let end = first.saturating_add(count);
        let mut broken = |rule: &'static str, expected: u64, found: u64| {
            report(FormatError {
                section,
                byte,
                rule,
                expected: Datum::Integer(expected),
                found: Datum::Integer(found),
            })
        };
        if count == 0 {
            if start != 0 {
                broken("SPEC 6.7: an empty mode list starts at 0", 0, start.into())?;
            }
            return ControlFlow::Continue(());
        }
        let Some(list) = self.mode_lists.get(first..end) else {
            let len = self.mode_lists.len() as u64;
            return broken("SPEC 6.7: mode lists lie inside LIST", len, end as u64);
        };
        let ascends = list.windows(2).all(|w| w[0] < w[1]);
        if !(ascends && self.is_list_border(first) && self.is_list_border(end)) {
            broken(
                "SPEC 6.7: nodes and vertices use whole mode lists",
                count as u64,
                start.into(),
            )?;
        }
        ControlFlow::Continue(())
    }

    /// Every list is some node's or vertex's. Without memory for all of LIST: one pass over nodes
    /// and vertices per [`WINDOW`] entries.
    fn lists_used(&self, report: Report<'_>) -> ControlFlow<()> {
        /// Entries of LIST that one pass looks at.
        const WINDOW: usize = 1 << 15;
        let vertices = self.vertex_modes.windows(2).map(|pair| {
            let used = pair[0].first_entry != pair[1].first_entry;
            used.then_some(pair[0].mode_list_start)
        });
        let nodes = self.nodes.iter().map(|node| {
            let used = node.mode_count != 0;
            used.then_some(node.mode_list_start)
        });
        let starts = nodes.chain(vertices).flatten();
        for window in (0..self.mode_lists.len()).step_by(WINDOW) {
            let mut used = [0_u64; WINDOW / 64];
            for start in starts.clone() {
                if let Some(at) = (start as usize).checked_sub(window)
                    && let Some(word) = used.get_mut(at / 64)
                {
                    *word |= 1 << (at % 64);
                }
            }
            let end = (window + WINDOW).min(self.mode_lists.len());
            let is_used = |at: &usize| used[(at - window) / 64] >> ((at - window) % 64) & 1 == 1;
            if let Some(at) = (window..end).find(|at| self.is_list_border(*at) && !is_used(at)) {
                return report(FormatError {
                    section: SectionKind::MODE_LISTS,
                    byte: self.section_offset(SectionKind::MODE_LISTS) + 2 * at as u64,
                    rule: "SPEC 6.7: every mode list is a node's or a vertex's",
                    expected: Datum::Text("a list that is used"),
                    found: Datum::Text("one that is not"),
                });
            }
        }
        ControlFlow::Continue(())
    }
}
