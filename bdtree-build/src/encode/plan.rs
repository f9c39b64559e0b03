//! Where everything goes.

use bdtree_format::{Header, ModeRecord, SECTION_ALIGNMENT, SectionRecord};

/// Offsets of a file's parts, in bytes from its start.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Plan {
    /// Length of header, mode table and section table with padding.
    pub(super) header_bytes: usize,
    /// First byte of each section.
    pub(super) offsets: Vec<usize>,
    /// End of the last section, without padding.
    pub(super) file_bytes: usize,
}

impl Plan {
    /// A plan for sections of these lengths, in this order.
    pub(super) fn new(mode_count: usize, lengths: &[usize]) -> Self {
        let header_bytes = (size_of::<Header>()
            + mode_count * size_of::<ModeRecord>()
            + lengths.len() * size_of::<SectionRecord>())
        .next_multiple_of(SECTION_ALIGNMENT);
        let mut end = header_bytes;
        let mut offsets = Vec::with_capacity(lengths.len());
        for length in lengths {
            let offset = end.next_multiple_of(SECTION_ALIGNMENT);
            offsets.push(offset);
            end = offset + length;
        }
        Self {
            header_bytes,
            offsets,
            file_bytes: end,
        }
    }
}
