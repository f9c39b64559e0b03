//! `$Elements`: tetrahedra, hexahedra, and the elements of groups.

use std::collections::HashMap;

use super::super::draft::{Element, Shape};
use super::super::number::Kind;
use super::super::source::Stop;
use super::nodes::Tags;
use super::{Reader, Version, kinds};

impl Reader<'_> {
    /// After `$Elements`.
    pub(super) fn elements(&mut self, position: u64) -> Result<(), Stop> {
        if std::mem::replace(&mut self.has_elements, true) {
            return Err((position, "a second $Elements section".into()));
        }
        let Some(tags) = self.tags.take() else {
            return Err((position, "$Elements before $Nodes".into()));
        };
        let mut at = position;
        let is_binary = self.source.binary.is_some();
        let read = match (self.format.version, is_binary) {
            (Version::V41, _) => self.blocks(&tags, &mut at),
            (Version::V2, true) => self.binary_lists(&tags, &mut at),
            (Version::V2, false) => self.lines(&tags, &mut at),
        };
        self.tags = Some(tags);
        read.map_err(|message| (at, message))
    }

    fn begin(&mut self, what: &str, at: &mut u64) -> Result<(), String> {
        let begun = self.source.begin(what);
        *at = self.source.position();
        begun
    }

    /// The count of version 2, which is text in binary files too.
    fn text_count(&mut self, at: &mut u64) -> Result<usize, String> {
        self.source.next_record();
        *at = self.source.position();
        let what = "the number of elements";
        let count = self.source.text_integer(what)?;
        self.source.skip_line();
        self.source.fits(what, count, 6)
    }

    /// Version 2, text: `number type count tags… nodes…`; the first tag is the physical group.
    fn lines(&mut self, nodes: &Tags, at: &mut u64) -> Result<(), String> {
        for _ in 0..self.text_count(at)? {
            self.begin("an element", at)?;
            let number = self.source.text_integer("the number of the element")?;
            let kind = self.source.text_integer("the type of the element")?;
            let tags = self.source.text_integer("the number of tags")?;
            let tags = self.source.fits("the number of tags", tags, 2)?;
            let mut group = self.first_tag(tags)?;
            self.element(nodes, number, kind, &mut group, *at)?;
            self.source.end();
        }
        Ok(())
    }

    /// Version 2, binary: lists of one type, each behind `type count tags`.
    fn binary_lists(&mut self, nodes: &Tags, at: &mut u64) -> Result<(), String> {
        let mut left = self.text_count(at)?;
        while left > 0 {
            *at = self.source.position();
            let kind = self.source.integer("the type of a list", Kind::I32)?;
            let count = self.source.count("the length of a list", Kind::I32, 4)?;
            let tags = self.source.count("the number of tags", Kind::I32, 4)?;
            if count == 0 || count > left {
                return Err(format!("a list of {count} elements where {left} are left"));
            }
            left -= count;
            for _ in 0..count {
                *at = self.source.position();
                let number = self
                    .source
                    .integer("the number of the element", Kind::I32)?;
                let mut group = self.first_tag(tags)?;
                self.element(nodes, number, kind, &mut group, *at)?;
            }
        }
        Ok(())
    }

    /// Reads `count` tags; the first is the physical group.
    fn first_tag(&mut self, count: usize) -> Result<Membership, String> {
        let mut first = None;
        for _ in 0..count {
            let tag = self.source.integer("a tag", Kind::I32)?;
            first = first.or(Some(tag));
        }
        Ok(Membership::Tag(first))
    }

    /// Version 4.1: blocks of one type and entity.
    fn blocks(&mut self, nodes: &Tags, at: &mut u64) -> Result<(), String> {
        let size = self.format.size;
        self.begin("the numbers of elements", at)?;
        let blocks = self.source.count("the number of blocks", size, 8)?;
        let declared = self.source.integer("the number of elements", size)?;
        self.source.integer("the lowest number", size)?;
        self.source.integer("the highest number", size)?;
        self.source.end();
        let header_at = *at;
        let mut found = 0;
        let mut named: HashMap<(i64, i64), Vec<usize>> = HashMap::new();
        for _ in 0..blocks {
            self.begin("a block of elements", at)?;
            let block_at = *at;
            let dimension = self.source.integer("the dimension of a block", Kind::I32)?;
            let tag = self.source.integer("the entity of a block", Kind::I32)?;
            let kind = self.source.integer("the type of a block", Kind::I32)?;
            let what = "the number of elements of a block";
            let count = self.source.integer(what, size)?;
            self.source.end();
            let count = self.source.fits(what, count, 4)?;
            let named = named.entry((dimension, tag)).or_insert_with(|| {
                let tags = self.entities.physical(dimension, tag);
                self.groups.named(dimension, tags)
            });
            let mut group = match named.as_slice() {
                [] => Membership::Tag(None),
                _ => Membership::Block(Vec::new()),
            };
            for _ in 0..count {
                self.begin("an element", at)?;
                let number = self.source.integer("the number of the element", size)?;
                self.element(nodes, number, kind, &mut group, *at)?;
                self.source.end();
            }
            if let Membership::Block(mut nodes) = group {
                nodes.sort_unstable();
                nodes.dedup();
                let added = self.groups.add_block(named, &nodes);
                added.inspect_err(|_| *at = block_at)?;
            }
            found += count as i64;
        }
        if found != declared {
            let message = format!("{declared} elements declared, {found} in the blocks");
            self.notes.problem(header_at, message);
        }
        Ok(())
    }

    /// Reads the nodes of an element and files it. An error stops the reading; a node that is not
    /// there does not.
    fn element(
        &mut self,
        tags: &Tags,
        number: i64,
        kind: i64,
        group: &mut Membership,
        position: u64,
    ) -> Result<(), String> {
        let is_binary = self.source.binary.is_some();
        let Some((shape, dimension, count)) = kinds::element(kind) else {
            let name = "elements of unknown type";
            self.draft.others.refuse(kind, name, position);
            // In text its line is left; in binary its length is not known.
            return if is_binary {
                Err(format!("{name} {kind}"))
            } else {
                Ok(())
            };
        };
        // Version 4 stores node tags as sizes.
        let stored = match self.format.version {
            Version::V2 => Kind::I32,
            Version::V41 => self.format.size,
        };
        let mut nodes = [0; kinds::MOST_NODES];
        let nodes = &mut nodes[..count];
        let mut wrong = None;
        for node in nodes.iter_mut() {
            let read = self.source.integer("a node", stored);
            if let (Err(message), true) = (&read, is_binary) {
                return Err(message.clone());
            }
            match read.and_then(|tag| tags.node(tag)) {
                Ok(index) => *node = index,
                Err(message) => wrong = wrong.or(Some(message)),
            }
        }
        if let Some(message) = wrong {
            self.notes
                .problem(position, format!("element {number}: {message}"));
            return Ok(());
        }
        match group {
            Membership::Tag(Some(tag)) => self.groups.add(dimension, *tag, nodes),
            Membership::Tag(None) => {}
            Membership::Block(of_block) => of_block.extend_from_slice(nodes),
        }
        match (shape, &*nodes) {
            (Shape::Tetrahedron, &[a, b, c, d]) => {
                let corners = [a, b, c, d];
                self.draft
                    .tetrahedra
                    .push(Element::new(corners, number, position));
            }
            (Shape::Hexahedron, &[a, b, c, d, e, f, g, h]) => {
                let corners = [a, b, c, d, e, f, g, h];
                self.draft
                    .hexahedra
                    .push(Element::new(corners, number, position));
            }
            (Shape::Lower(name), _) => self.draft.others.skip(name, 1),
            (Shape::Solid(name), _) => self.draft.others.refuse(kind, name, position),
            // Not among Gmsh's types.
            _ => {}
        }
        Ok(())
    }
}

/// How an element belongs to groups.
enum Membership {
    /// To the one with the tag.
    Tag(Option<i64>),
    /// To those of its block, whose nodes so far these are.
    Block(Vec<u32>),
}
