//! `$Nodes`: positions, and which tag is which node.

use std::collections::HashMap;

use super::super::notes::Notes;
use super::super::number::Kind;
use super::super::source::{Source, Stop};
use super::{Format, Reader, Version};

/// The index of every node by its tag.
#[derive(Debug, Default)]
pub(super) struct Tags {
    index: HashMap<i64, u32>,
    count: u32,
}

impl Tags {
    /// The node called `tag`.
    pub(super) fn node(&self, tag: i64) -> Result<u32, String> {
        let node = self.index.get(&tag).copied();
        node.ok_or_else(|| format!("there is no node {tag}"))
    }

    fn add(&mut self, tag: i64, position: u64, notes: &mut Notes<'_>) {
        if self.index.insert(tag, self.count).is_some() {
            notes.problem(position, format!("a second node {tag}"));
        }
        // More nodes than u32 counts are refused when the whole is checked.
        self.count = self.count.wrapping_add(1);
    }
}

impl Reader<'_> {
    /// After `$Nodes`.
    pub(super) fn nodes(&mut self, position: u64) -> Result<(), Stop> {
        if self.tags.is_some() {
            return Err((position, "a second $Nodes section".into()));
        }
        let mut at = position;
        let mut section = Section {
            source: &mut self.source,
            notes: &mut self.notes,
            positions: &mut self.draft.nodes,
            tags: Tags::default(),
            at: &mut at,
        };
        let read = match self.format.version {
            Version::V2 => section.flat(),
            Version::V41 => section.blocks(self.format),
        };
        self.tags = Some(section.tags);
        read.map_err(|message| (at, message))
    }
}

struct Section<'s, 'a> {
    source: &'s mut Source<'a>,
    notes: &'s mut Notes<'a>,
    positions: &'s mut Vec<[f64; 3]>,
    tags: Tags,
    /// The record that is being read.
    at: &'s mut u64,
}

impl Section<'_, '_> {
    fn begin(&mut self, what: &str) -> Result<(), String> {
        let begun = self.source.begin(what);
        *self.at = self.source.position();
        begun
    }

    /// Version 2: a count in text, then `tag x y z` for each.
    fn flat(&mut self) -> Result<(), String> {
        let what = "the number of nodes";
        self.source.next_record();
        *self.at = self.source.position();
        let count = self.source.text_integer(what)?;
        self.source.skip_line();
        let each = if self.source.binary.is_some() { 28 } else { 8 };
        let count = self.source.fits(what, count, each)?;
        for _ in 0..count {
            self.begin("a node")?;
            let tag = self.source.integer("the tag of a node", Kind::I32)?;
            self.tags.add(tag, *self.at, self.notes);
            self.position(tag);
            self.source.end();
        }
        Ok(())
    }

    /// Version 4.1: blocks of tags and then positions.
    fn blocks(&mut self, format: Format) -> Result<(), String> {
        let size = format.size;
        let is_binary = self.source.binary.is_some();
        self.begin("the numbers of nodes")?;
        let blocks = self.source.count("the number of blocks", size, 8)?;
        let declared = self.source.integer("the number of nodes", size)?;
        self.source.integer("the lowest tag", size)?;
        self.source.integer("the highest tag", size)?;
        self.source.end();
        let header_at = *self.at;
        for _ in 0..blocks {
            self.begin("a block of nodes")?;
            let dimension = self.source.integer("the dimension of a block", Kind::I32)?;
            self.source.integer("the entity of a block", Kind::I32)?;
            let is_parametric = self.source.integer("the mark of parameters", Kind::I32)? != 0;
            let what = "the number of nodes of a block";
            let count = self.source.integer(what, size)?;
            self.source.end();
            let each = if is_binary { size.bytes() + 24 } else { 8 };
            let count = self.source.fits(what, count, each)?;
            let mut tags = Vec::with_capacity(count);
            for _ in 0..count {
                self.begin("the tag of a node")?;
                let tag = self.source.integer("the tag of a node", size)?;
                self.tags.add(tag, *self.at, self.notes);
                self.source.end();
                tags.push(tag);
            }
            let parameters = if is_parametric {
                dimension.clamp(0, 3) as usize
            } else {
                0
            };
            for tag in tags {
                self.begin("the position of a node")?;
                self.position(tag);
                if is_binary && self.source.take(8 * parameters).is_none() {
                    return Err("the file ends before the parameters of a node".into());
                }
                self.source.end();
            }
        }
        let found = self.positions.len();
        if i64::try_from(found) != Ok(declared) {
            let message = format!("{declared} nodes declared, {found} in the blocks");
            self.notes.problem(header_at, message);
        }
        Ok(())
    }

    /// x, y and z of node `tag`; what is wrong with them is noted.
    fn position(&mut self, tag: i64) {
        let mut position = [0.0; 3];
        for (value, axis) in position.iter_mut().zip(["x", "y", "z"]) {
            match self.source.real(axis, Kind::F64) {
                Ok(read) => *value = read,
                Err(message) => {
                    self.notes
                        .problem(*self.at, format!("node {tag}: {message}"));
                    // In text the rest of the line is left, in binary the numbers keep their places.
                    if self.source.binary.is_none() {
                        break;
                    }
                }
            }
        }
        self.positions.push(position);
    }
}
