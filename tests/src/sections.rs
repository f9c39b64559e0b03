//! A file taken apart into its sections and put together again; the same asset in the other layout
//! of displacements.

use std::collections::BTreeMap;
use std::mem::{offset_of, size_of};

use bdtree_format::{Header, LAYOUT_1, NodeRecord, SECTION_ALIGNMENT, SectionKind, SectionRecord};
use bdtree_runtime::{AlignedBytes, Asset, VertexId};

use crate::mutate::{get_u32, put, repair, section, table};

/// One section: its record in the table and its bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Offset, length and checksum are written when the file is put together.
    pub record: Vec<u8>,
    /// Without padding.
    pub body: Vec<u8>,
}

impl Part {
    /// What the section holds.
    pub fn kind(&self) -> SectionKind {
        let letters = self.record.first_chunk();
        SectionKind(letters.copied().unwrap_or_default())
    }
}

/// The sections of a sound file.
pub fn take_apart(bytes: &[u8]) -> Vec<Part> {
    let count = get_u32(bytes, offset_of!(Header, section_count)) as usize;
    let records = bytes[table(bytes)..].chunks(size_of::<SectionRecord>());
    let part = |record: &[u8]| {
        let kind = SectionKind(*record.first_chunk().expect("four letters"));
        Part {
            record: record.to_vec(),
            body: bytes[section(bytes, kind)].to_vec(),
        }
    };
    records.take(count).map(part).collect()
}

/// A file of these sections, with the header and the mode table of `source`.
pub fn put_together(source: &[u8], parts: Vec<Part>) -> Vec<u8> {
    let table = table(source);
    let mut bytes = source[..table].to_vec();
    let records = size_of::<SectionRecord>() * parts.len();
    let header_bytes = (table + records).next_multiple_of(SECTION_ALIGNMENT);
    bytes.resize(header_bytes, 0);
    let count = parts.len() as u32;
    for (i, Part { mut record, body }) in parts.into_iter().enumerate() {
        bytes.resize(bytes.len().next_multiple_of(SECTION_ALIGNMENT), 0);
        let (offset, length) = (bytes.len() as u64, body.len() as u64);
        put(
            &mut record,
            offset_of!(SectionRecord, offset),
            &offset.to_le_bytes(),
        );
        put(
            &mut record,
            offset_of!(SectionRecord, length),
            &length.to_le_bytes(),
        );
        bytes.extend(body);
        put(&mut bytes, table + i * record.len(), &record);
    }
    let file_bytes = (bytes.len() as u64).to_le_bytes();
    let header_bytes = (header_bytes as u32).to_le_bytes();
    for (at, value) in [
        (offset_of!(Header, section_count), &count.to_le_bytes()[..]),
        (offset_of!(Header, header_bytes), &header_bytes),
        (offset_of!(Header, file_bytes), &file_bytes),
    ] {
        put(&mut bytes, at, value);
    }
    repair(&mut bytes);
    bytes
}

/// The same asset with the displacements of all modes for all vertices (layout 1 of DISP).
///
/// # Panics
/// When the file is broken.
pub fn with_all_displacements(bytes: &AlignedBytes) -> AlignedBytes {
    let asset = Asset::open(bytes).expect("open");
    let mut parts = take_apart(bytes);
    parts.retain(|part| part.kind() != SectionKind::VERTEX_MODES);
    // The lists of nodes, in the order in which they stand; where each begins now.
    let mut starts: BTreeMap<u32, usize> = BTreeMap::new();
    let mut lists: BTreeMap<u32, &[u16]> = BTreeMap::new();
    for node in asset.nodes().iter().filter(|node| node.mode_count > 0) {
        lists.insert(
            node.mode_list_start,
            asset.node_modes(node).expect("a list"),
        );
    }
    let mut end = 0;
    for (start, list) in &lists {
        starts.insert(*start, end);
        end += list.len();
    }
    for part in &mut parts {
        match part.kind() {
            SectionKind::MODE_LISTS => {
                let entries = lists.values().copied().flatten();
                part.body = entries.flat_map(|j| j.to_le_bytes()).collect();
            }
            SectionKind::NODES => {
                for record in part.body.chunks_mut(size_of::<NodeRecord>()) {
                    let at = offset_of!(NodeRecord, mode_list_start);
                    let start = starts.get(&get_u32(record, at)).copied().unwrap_or(0);
                    put(record, at, &(start as u32).to_le_bytes());
                }
            }
            SectionKind::DISPLACEMENTS => {
                let layout = offset_of!(SectionRecord, layout);
                put(&mut part.record, layout, &LAYOUT_1.to_le_bytes());
                part.body.clear();
                for i in 0..asset.vertex_count() as u32 {
                    let own = asset.displacements(VertexId(i)).expect("a vertex");
                    for u in (0..asset.mode_count()).flat_map(|j| own.of(j)) {
                        part.body.extend(u.to_le_bytes());
                    }
                }
            }
            _ => {}
        }
    }
    AlignedBytes::copy_of(&put_together(bytes, parts))
}
