//! The metadata section: lengths, text, tags, nothing left over.

use bdtree_format::SectionKind;
use core::ops::ControlFlow;

use super::Report;
use crate::metadata::Reader;
use crate::view::Asset;

impl Asset<'_> {
    pub(super) fn metadata_record(&self, report: Report<'_>) -> ControlFlow<()> {
        if !self
            .sections
            .iter()
            .any(|s| s.kind == SectionKind::METADATA)
        {
            return ControlFlow::Continue(());
        }
        let mut reader = Reader::new(self.metadata);
        let counts = (self.modes.len() as u64, self.positions.len() as u64);
        if let Err((expected, found)) = reader.record(counts) {
            let rule = "SPEC 8: metadata is the record of layout 2";
            let place = self.at(SectionKind::METADATA, reader.at);
            report(place.rule(rule).broken(expected, found))?;
        }
        ControlFlow::Continue(())
    }
}
