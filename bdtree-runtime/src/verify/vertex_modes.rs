//! The modes of vertices: entries without a gap, whole lists.

use bdtree_format::{SectionKind, VertexModes};
use core::mem::size_of;
use core::ops::ControlFlow;

use super::Report;
use crate::view::Asset;

impl Asset<'_> {
    /// The entries of vertices stand without a gap, those of each follow a whole list.
    pub(super) fn vertex_modes_order(&self, report: Report<'_>) -> ControlFlow<()> {
        let Some((last, _)) = self.vertex_modes.split_last() else {
            return ControlFlow::Continue(());
        };
        let at = |i: usize| self.at(SectionKind::VERTEX_MODES, i * size_of::<VertexModes>());
        let count = self.vertex_modes.len() - 1;
        for (i, pair) in self.vertex_modes.windows(2).enumerate() {
            let [own, next] = [pair[0], pair[1]];
            match next.first_entry.checked_sub(own.first_entry) {
                Some(entries) if entries as usize <= self.modes.len() => {
                    self.whole_list(at(i), own.mode_list_start, entries as usize, report)?;
                }
                _ => {
                    let (start, end) = (own.first_entry as usize, next.first_entry as usize);
                    report(self.broken_entries(i, start, end))?;
                }
            }
        }
        let first = self.vertex_modes.first().map_or(0, |own| own.first_entry);
        for (i, expected, found) in [
            (0, 0, first as usize),
            (count, self.displacements.len(), last.first_entry as usize),
            (count, 0, last.mode_list_start as usize),
        ] {
            at(i)
                .rule("SPEC 7.6: the first record begins at 0, the last ends DISP with list 0")
                .tell(report, expected == found, expected, found)?;
        }
        ControlFlow::Continue(())
    }
}
