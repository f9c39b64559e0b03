//! Mode lists: each stored once, in descending order, so that a list begins wherever the entries
//! do not ascend; and nodes and vertices use all of them, whole.

use bdtree_format::{NodeRecord, SectionKind};
use core::mem::{offset_of, size_of};
use core::ops::ControlFlow;

use super::Report;
use crate::error::{Check, Datum};
use crate::view::Asset;

impl Asset<'_> {
    pub(super) fn mode_lists(&self, report: Report<'_>) -> ControlFlow<()> {
        self.list_order(report)?;
        for (i, node) in self.nodes.iter().enumerate() {
            let start = offset_of!(NodeRecord, mode_list_start);
            let at = self.at(SectionKind::NODES, i * size_of::<NodeRecord>() + start);
            let (start, count) = (node.mode_list_start, usize::from(node.mode_count));
            self.whole_list(at, start, count, report)?;
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
        let at = |i: usize| self.at(SectionKind::MODE_LISTS, size_of::<u16>() * i);
        let m = self.modes.len();
        if let Some(i) = self.mode_lists.iter().position(|j| usize::from(*j) >= m) {
            let rule = "SPEC 6.7: mode lists hold indices below the mode count";
            report(
                at(i)
                    .rule(rule)
                    .broken(Datum::Below(m as u64), self.mode_lists[i]),
            )?;
        }
        let mut before: &[u16] = &[];
        let mut rest = self.mode_lists;
        while !rest.is_empty() {
            let ascending = rest.windows(2).take_while(|w| w[0] < w[1]).count();
            let (list, behind) = rest.split_at(ascending + 1);
            if !before.is_empty() && before <= list {
                report(
                    at(self.mode_lists.len() - rest.len())
                        .rule("SPEC 6.7: mode lists stand in descending order, each once")
                        .broken("a list below the one before", "one that is not"),
                )?;
            }
            (before, rest) = (list, behind);
        }
        ControlFlow::Continue(())
    }

    /// The list of a node or vertex is one of LIST, neither part of one nor parts of several.
    pub(super) fn whole_list(
        &self,
        at: Check,
        start: u32,
        count: usize,
        report: Report<'_>,
    ) -> ControlFlow<()> {
        let first = start as usize;
        let end = first.saturating_add(count);
        if count == 0 {
            return at.rule("SPEC 6.7: an empty mode list starts at 0").tell(
                report,
                start == 0,
                0_u32,
                start,
            );
        }
        let Some(list) = self.mode_lists.get(first..end) else {
            let rule = at.rule("SPEC 6.7: mode lists lie inside LIST");
            return report(rule.broken(Datum::at_most(self.mode_lists.len()), end));
        };
        let ascends = list.windows(2).all(|w| w[0] < w[1]);
        let whole = ascends && self.is_list_border(first) && self.is_list_border(end);
        at.rule("SPEC 6.7: nodes and vertices use whole mode lists")
            .tell(report, whole, count, start)
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
                return report(
                    self.at(SectionKind::MODE_LISTS, size_of::<u16>() * at)
                        .rule("SPEC 6.7: every mode list is a node's or a vertex's")
                        .broken("a list that is used", "one that is not"),
                );
            }
        }
        ControlFlow::Continue(())
    }
}
