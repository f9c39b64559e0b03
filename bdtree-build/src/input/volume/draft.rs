//! A volume as a reader leaves it: every element with its place, nothing checked but indices.

use std::collections::BTreeMap;

use super::notes::{Notes, Tally};
use super::{RawMaterial, RawNodeSet};

/// What a reader has read.
#[derive(Default)]
pub(super) struct Draft {
    pub(super) nodes: Vec<[f64; 3]>,
    pub(super) tetrahedra: Vec<Element<4>>,
    pub(super) hexahedra: Vec<Element<8>>,
    pub(super) materials: Vec<RawMaterial>,
    pub(super) material_of: Vec<u32>,
    pub(super) node_sets: Vec<RawNodeSet>,
    pub(super) others: Others,
}

/// One element and where it was read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element<const N: usize> {
    /// Indices into the nodes.
    pub(super) corners: [u32; N],
    /// Its number as the file counts.
    pub(super) number: i64,
    /// Line or byte.
    pub(super) position: u64,
}

impl<const N: usize> Element<N> {
    /// One with no more to it than its parts.
    pub(super) fn new(corners: [u32; N], number: i64, position: u64) -> Self {
        Self {
            corners,
            number,
            position,
        }
    }
}

/// What an element's type number means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    /// Four corners.
    Tetrahedron,
    /// Eight corners, in the order of [`super::RawVolume::hexahedra`].
    Hexahedron,
    /// Eight corners, along x first, then y, then z.
    Voxel,
    /// A point, line or surface: skipped. Its name in the plural.
    Lower(&'static str),
    /// A solid that is not read. Its name in the plural.
    Solid(&'static str),
}

/// Elements that are no linear tetrahedra or hexahedra.
#[derive(Default)]
pub(super) struct Others {
    skipped: BTreeMap<&'static str, u64>,
    refused: BTreeMap<(i64, &'static str), Tally>,
}

impl Others {
    /// Points, lines and surfaces.
    pub(super) fn skip(&mut self, name: &'static str, count: u64) {
        *self.skipped.entry(name).or_default() += count;
    }

    /// Solids of another kind.
    pub(super) fn refuse(&mut self, kind: i64, name: &'static str, position: u64) {
        self.refused.entry((kind, name)).or_default().add(position);
    }

    /// Says what was refused and what was skipped.
    pub(super) fn report(&self, notes: &mut Notes<'_>) {
        for ((kind, name), tally) in &self.refused {
            let message = format!(
                "{} {name} (type {kind}); only tetrahedra of 4 nodes and hexahedra of 8 are read",
                tally.count
            );
            notes.problem(tally.first, message);
        }
        if !self.skipped.is_empty() {
            let words: Vec<String> = self
                .skipped
                .iter()
                .map(|(name, count)| format!("{count} {name}"))
                .collect();
            let message = format!("ignored what is no volume: {}", words.join(", "));
            notes.warn(0, &message);
        }
    }
}
