//! Damaged files: changed records under repaired checksums, so that damage reaches the code
//! behind the checks.

mod layout;
mod numbers;
mod raw;
mod records;
mod tree;

use std::mem::{offset_of, size_of};
use std::ops::Range;

use bdtree_format::{Header, ModeRecord, SectionKind, SectionRecord};
use bdtree_runtime::AlignedBytes;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// A little-endian u32; 0 beyond the end.
pub fn get_u32(bytes: &[u8], at: usize) -> u32 {
    let four = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
    u32::from_le_bytes(four.unwrap_or_default())
}

/// A little-endian f32; 0 beyond the end.
pub fn get_f32(bytes: &[u8], at: usize) -> f32 {
    f32::from_bits(get_u32(bytes, at))
}

/// Writes what fits.
pub fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    if let Some(place) = bytes.get_mut(at..at + value.len()) {
        place.copy_from_slice(value);
    }
}

/// Start of the section table.
pub fn table(bytes: &[u8]) -> usize {
    let modes = get_u32(bytes, offset_of!(Header, mode_count)) as usize;
    size_of::<Header>() + modes.min(512) * size_of::<ModeRecord>()
}

/// Start of a section's record in the table.
///
/// # Panics
/// When the file has no such section.
pub fn record(bytes: &[u8], kind: SectionKind) -> usize {
    let count = get_u32(bytes, offset_of!(Header, section_count)) as usize;
    (0..count)
        .map(|i| table(bytes) + i * size_of::<SectionRecord>())
        .find(|at| bytes[*at..*at + 4] == kind.0)
        .unwrap_or_else(|| panic!("no section {kind}"))
}

/// The bytes of a section.
///
/// # Panics
/// When the file has no such section.
pub fn section(bytes: &[u8], kind: SectionKind) -> Range<usize> {
    let (start, length) = place(bytes, record(bytes, kind));
    start..start + length
}

/// Offset and length in a section record.
fn place(bytes: &[u8], at: usize) -> (usize, usize) {
    let long = |at: usize| u64::from(get_u32(bytes, at)) | u64::from(get_u32(bytes, at + 4)) << 32;
    let start = long(at + offset_of!(SectionRecord, offset));
    let length = long(at + offset_of!(SectionRecord, length));
    (start as usize, length as usize)
}

fn crc(parts: &[&[u8]]) -> [u8; 4] {
    let mut crc = flate2::Crc::new();
    parts.iter().for_each(|p| crc.update(p));
    crc.sum().to_le_bytes()
}

/// Writes the checksums of all sections that lie inside the file, and of the header block.
pub fn repair(bytes: &mut [u8]) {
    let count = get_u32(bytes, offset_of!(Header, section_count)).min(64) as usize;
    for i in 0..count {
        let at = table(bytes) + i * size_of::<SectionRecord>();
        let (start, length) = place(bytes, at);
        if let Some(body) = bytes.get(start..start.saturating_add(length)) {
            let sum = crc(&[body]);
            put(bytes, at + offset_of!(SectionRecord, crc), &sum);
        }
    }
    let at = offset_of!(Header, header_crc);
    let end = get_u32(bytes, offset_of!(Header, header_bytes)) as usize;
    if let Some(block) = bytes.get(..end)
        && end > at + 4
    {
        let sum = crc(&[&block[..at], &[0; 4], &block[at + 4..]]);
        put(bytes, at, &sum);
    }
}

/// What is done to a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Damage {
    /// Records anywhere, set to values that hurt.
    Records,
    /// Numbers only, each to one that may stand there: whether the bounds still hold is for
    /// [`judge`](crate::judge::judge) to say.
    Numbers,
    /// Sections cut, grown with their counts, swapped, moved, laid over each other, left out.
    Layout,
    /// Another tree: chains, shared children and leaves, spheres that keep out nothing.
    Tree,
    /// Bytes: flipped, overwritten, moved, cut off.
    Raw,
    /// A tree or a layout, then records.
    Several,
}

impl Damage {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Records,
        Self::Numbers,
        Self::Layout,
        Self::Tree,
        Self::Raw,
        Self::Several,
    ];

    /// A sound file, damaged; checksums fit unless the damage is in the bytes themselves.
    pub fn done_to(self, sound: &AlignedBytes, rng: &mut Pcg64Mcg) -> Vec<u8> {
        let mut bytes = match self {
            Self::Layout => layout::change(sound, rng),
            Self::Tree => tree::change(sound, rng),
            Self::Several if rng.random_bool(0.5) => layout::change(sound, rng),
            Self::Several => tree::change(sound, rng),
            _ => sound.to_vec(),
        };
        match self {
            Self::Records | Self::Several => records::change_some(&mut bytes, rng),
            Self::Numbers => numbers::change_some(&mut bytes, sound, rng),
            Self::Raw => return raw::change(bytes, rng),
            Self::Layout | Self::Tree => {}
        }
        repair(&mut bytes);
        bytes
    }
}

fn pick<T: Copy>(choices: &[T], rng: &mut Pcg64Mcg) -> T {
    choices[rng.random_range(0..choices.len())]
}
