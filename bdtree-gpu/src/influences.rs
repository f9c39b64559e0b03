//! Which bones carry the vertices, for the shaders.

use std::ops::Range;

use bdtree_format::InfluenceRecord;
use bdtree_runtime::Asset;
use zerocopy::IntoBytes;

/// The influences of all vertices as they lie in the file (SPEC 7.7). Shaders follow them, so
/// [`Asset::check_mesh`] comes first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Influences<'a> {
    pub(crate) bone_count: usize,
    /// One per vertex, and one that ends the last.
    starts: &'a [u32],
    entries: &'a [InfluenceRecord],
}

impl<'a> Influences<'a> {
    /// Those of an asset with a skin.
    pub(crate) fn of(asset: &Asset<'a>) -> Option<Self> {
        let (starts, entries) = asset.all_influences();
        asset.has_skin().then_some(Self {
            bone_count: asset.bone_count(),
            starts,
            entries,
        })
    }

    /// What a range of vertices has on the device: its starts as in the file, so that the first is what the others
    /// are counted from, then two words per influence, weight and bone.
    pub(crate) fn runs(&self, vertices: &Range<usize>) -> [&'a [u8]; 2] {
        let entries = self.entries_of(vertices);
        let starts = &self.starts[vertices.start..=vertices.end];
        [starts.as_bytes(), self.entries[entries].as_bytes()]
    }

    /// Bytes of [`Influences::runs`].
    pub(crate) fn bytes(&self, vertices: &Range<usize>) -> usize {
        4 * (vertices.len() + 1) + size_of::<InfluenceRecord>() * self.entries_of(vertices).len()
    }

    fn entries_of(&self, vertices: &Range<usize>) -> Range<usize> {
        self.starts[vertices.start] as usize..self.starts[vertices.end] as usize
    }
}
