//! Physical groups: their names, and the nodes of their elements.

use std::collections::HashMap;

use super::super::RawNodeSet;
use super::super::source::{Source, Stop};

/// Most nodes of all groups together, as blocks of elements name them: a short file can put each
/// of many elements into each of many groups.
const MEMBERS_MAX: usize = 1 << 27;

/// The named groups, in file order.
#[derive(Default)]
pub(super) struct Groups {
    sets: Vec<RawNodeSet>,
    /// Dimension and tag to the index in `sets`.
    index: HashMap<(i64, i64), usize>,
    /// Nodes that blocks have added.
    members: usize,
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

    /// Indices of the named groups of `dimension` with these tags, for [`Groups::add_block`].
    pub(super) fn named(&self, dimension: i64, tags: &[i64]) -> Vec<usize> {
        let index = |tag: &i64| self.index.get(&(dimension, tag.saturating_abs())).copied();
        tags.iter().filter_map(index).collect()
    }

    /// A block of elements with these nodes belongs to the groups `named`.
    pub(super) fn add_block(&mut self, named: &[usize], nodes: &[u32]) -> Result<(), String> {
        let more = named.len().saturating_mul(nodes.len());
        self.members = self.members.saturating_add(more);
        if self.members > MEMBERS_MAX {
            let (groups, nodes) = (named.len(), nodes.len());
            return Err(format!(
                "with this block of {nodes} nodes in {groups} groups all groups have more than \
                 {MEMBERS_MAX} nodes"
            ));
        }
        for &set in named {
            if let Some(set) = self.sets.get_mut(set) {
                set.nodes.extend_from_slice(nodes);
            }
        }
        Ok(())
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
