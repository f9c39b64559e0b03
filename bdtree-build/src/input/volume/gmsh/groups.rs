//! Physical groups: their names, and the nodes of their elements.

use std::collections::HashMap;

use super::super::RawNodeSet;
use super::super::source::{Source, Stop};

/// The named groups, in file order.
#[derive(Default)]
pub(super) struct Groups {
    sets: Vec<RawNodeSet>,
    /// Dimension and tag to the index in `sets`.
    index: HashMap<(i64, i64), usize>,
}

impl Groups {
    /// After `$PhysicalNames`, which is text in binary files too: a count, then lines
    /// `dimension tag "name"`.
    pub(super) fn names(&mut self, source: &mut Source<'_>) -> Result<(), Stop> {
        let count = number_of_names(source).map_err(|m| (source.position(), m))?;
        for _ in 0..count {
            source.next_record();
            let position = source.position();
            let mut pair = || -> Result<(i64, i64), String> {
                let dimension = source.text_integer("the dimension of a group")?;
                Ok((dimension, source.text_integer("the tag of a group")?))
            };
            let key = pair().map_err(|message| (position, message))?;
            let name = source.line_rest().trim_ascii();
            let quoted = name.strip_prefix(b"\"").and_then(|n| n.strip_suffix(b"\""));
            let name = String::from_utf8_lossy(quoted.unwrap_or(name)).into_owned();
            self.index.insert(key, self.sets.len());
            self.sets.push(RawNodeSet {
                name,
                nodes: Vec::new(),
            });
            source.skip_line();
        }
        Ok(())
    }

    /// An element of `dimension` with these nodes belongs to the group of `tag`; the sign of a tag
    /// is an orientation.
    pub(super) fn add(&mut self, dimension: i64, tag: i64, nodes: &[u32]) {
        if let Some(&set) = self.index.get(&(dimension, tag.saturating_abs())) {
            self.sets[set].nodes.extend_from_slice(nodes);
        }
    }

    /// The nodes of every named group.
    pub(super) fn into_sets(mut self) -> Vec<RawNodeSet> {
        for set in &mut self.sets {
            set.nodes.sort_unstable();
            set.nodes.dedup();
        }
        self.sets
    }
}

fn number_of_names(source: &mut Source<'_>) -> Result<usize, String> {
    source.next_record();
    let what = "the number of names";
    let count = source.text_integer(what)?;
    source.skip_line();
    source.fits(what, count, 4)
}
