//! `$Entities` and `$PartitionedEntities` of version 4.1: which physical groups the points, curves,
//! surfaces and volumes of the geometry belong to.

use std::collections::HashMap;

use super::super::number::Kind;
use super::super::source::{Source, Stop};
use super::{Format, Reader};

/// Physical tags, ascending, each once, by dimension and tag of an entity.
#[derive(Default)]
pub(super) struct Entities {
    physical: HashMap<(i64, i64), Vec<i64>>,
}

impl Entities {
    /// The physical tags of an entity.
    pub(super) fn physical(&self, dimension: i64, tag: i64) -> &[i64] {
        self.physical
            .get(&(dimension, tag))
            .map(Vec::as_slice)
            .unwrap_or_default()
    }
}

impl Reader<'_> {
    /// After the section's first line.
    pub(super) fn entities(&mut self, is_partitioned: bool) -> Result<(), Stop> {
        let (source, format) = (&mut self.source, self.format);
        let mut at = source.position();
        read(source, format, is_partitioned, &mut at, &mut self.entities)
            .map_err(|message| (at, message))
    }
}

/// The section; `at` follows the records.
fn read(
    source: &mut Source<'_>,
    format: Format,
    is_partitioned: bool,
    at: &mut u64,
    entities: &mut Entities,
) -> Result<(), String> {
    let mut begin = |source: &mut Source<'_>, what| {
        let begun = source.begin(what);
        *at = source.position();
        begun
    };
    if is_partitioned {
        begin(source, "the number of partitions")?;
        source.integer("the number of partitions", format.size)?;
        source.end();
        begin(source, "the ghost entities")?;
        let what = "the number of ghost entities";
        let ghosts = source.count(what, format.size, 4)?;
        source.end();
        for _ in 0..ghosts {
            begin(source, "a ghost entity")?;
            source.integer("the tag of a ghost entity", Kind::I32)?;
            source.integer("a partition", Kind::I32)?;
            source.end();
        }
    }
    begin(source, "the numbers of entities")?;
    let mut counts = [0; 4];
    for count in &mut counts {
        let what = "the number of entities";
        *count = source.count(what, format.size, 4)?;
    }
    source.end();
    for (dimension, count) in counts.into_iter().enumerate() {
        for _ in 0..count {
            begin(source, "an entity")?;
            let tag = source.integer("the tag of an entity", Kind::I32)?;
            if is_partitioned {
                source.integer("the parent's dimension", Kind::I32)?;
                source.integer("the parent's tag", Kind::I32)?;
                skip(source, format, "the number of partitions")?;
            }
            // A point's position, or the corners of a box.
            for _ in 0..if dimension == 0 { 3 } else { 6 } {
                source.real("a coordinate", Kind::F64)?;
            }
            let what = "the number of physical tags";
            let tags = source.count(what, format.size, 2)?;
            let mut physical = Vec::with_capacity(tags);
            for _ in 0..tags {
                // The sign of a tag is an orientation.
                let tag = source.integer("a physical tag", Kind::I32)?;
                physical.push(tag.saturating_abs());
            }
            physical.sort_unstable();
            physical.dedup();
            if dimension > 0 {
                skip(source, format, "the number of bounding entities")?;
            }
            source.end();
            if !physical.is_empty() {
                entities.physical.insert((dimension as i64, tag), physical);
            }
        }
    }
    Ok(())
}

/// A count, and as many tags.
fn skip(source: &mut Source<'_>, format: Format, what: &str) -> Result<(), String> {
    for _ in 0..source.count(what, format.size, 2)? {
        source.integer("a tag", Kind::I32)?;
    }
    Ok(())
}
