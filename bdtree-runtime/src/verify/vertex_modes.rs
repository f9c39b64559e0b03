//! The modes of vertices: entries without a gap, whole lists.

use bdtree_format::{SectionKind, VertexModes};
use core::mem::size_of;
use core::ops::ControlFlow;

use super::Report;
use crate::error::{Datum, FormatError};
use crate::view::Asset;

impl Asset<'_> {
    /// The entries of vertices stand without a gap, those of each follow a whole list.
    pub(super) fn vertex_modes_order(&self, report: Report<'_>) -> ControlFlow<()> {
        let Some((last, _)) = self.vertex_modes.split_last() else {
            return ControlFlow::Continue(());
        };
        let offset = self.section_offset(SectionKind::VERTEX_MODES);
        let byte = |i: usize| offset + (i * size_of::<VertexModes>()) as u64;
        let count = self.vertex_modes.len() - 1;
        for (i, pair) in self.vertex_modes.windows(2).enumerate() {
            let [own, next] = [pair[0], pair[1]];
            match next.first_entry.checked_sub(own.first_entry) {
                Some(entries) if entries as usize <= self.modes.len() => {
                    let (section, entries) = (SectionKind::VERTEX_MODES, entries as usize);
                    self.whole_list(section, byte(i), own.mode_list_start, entries, report)?;
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
            if expected != found {
                report(FormatError {
                    section: SectionKind::VERTEX_MODES,
                    byte: byte(i),
                    rule: "SPEC 7.6: the first record begins at 0, the last ends DISP with list 0",
                    expected: Datum::Integer(expected as u64),
                    found: Datum::Integer(found as u64),
                })?;
            }
        }
        ControlFlow::Continue(())
    }
}
