//! Gmsh's `.msh` files: versions 2 and 4.1, text or binary.

mod elements;
mod entities;
mod groups;
mod kinds;
mod nodes;

use super::RawVolume;
use super::check::finish;
use super::draft::Draft;
use super::notes::Notes;
use super::number::{ByteOrder, Kind};
use super::source::{Layout, Source, Stop};
use crate::error::BakeError;
use crate::input::obj::tokens::show;
use entities::Entities;
use groups::Groups;
use nodes::Tags;

/// Sections that say nothing of nodes, elements or groups.
const SKIPPED: [&str; 11] = [
    "Comments",
    "Periodic",
    "GhostElements",
    "Parametrizations",
    "NodeData",
    "ElementData",
    "ElementNodeData",
    "InterpolationScheme",
    "MeshVersion",
    "Domain",
    "PartitionData",
];

/// The volume in the bytes of a .msh file; `file` is its name in messages.
pub(super) fn parse(bytes: &[u8], file: &str) -> Result<RawVolume, BakeError> {
    let mut reader = Reader {
        source: Source::new(bytes, Layout::Lines),
        notes: Notes::new(file),
        draft: Draft::default(),
        format: Format::default(),
        groups: Groups::default(),
        entities: Entities::default(),
        tags: None,
        has_elements: false,
    };
    if let Err((position, message)) = reader.sections() {
        reader.notes.problem(position, message);
    }
    reader.draft.node_sets = reader.groups.into_sets();
    finish(reader.draft, reader.notes)
}

/// What `$MeshFormat` says.
#[derive(Debug, Clone, Copy)]
struct Format {
    version: Version,
    /// How the file stores counts and, in version 4, tags.
    size: Kind,
}

impl Default for Format {
    fn default() -> Self {
        Self {
            version: Version::V2,
            size: Kind::U64,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    V2,
    V41,
}

struct Reader<'a> {
    source: Source<'a>,
    notes: Notes<'a>,
    draft: Draft,
    format: Format,
    groups: Groups,
    entities: Entities,
    /// Set when the nodes have been read.
    tags: Option<Tags>,
    has_elements: bool,
}

impl Reader<'_> {
    fn sections(&mut self) -> Result<(), Stop> {
        self.source.next_record();
        let first = self.source.field().unwrap_or_default();
        match first {
            b"$MeshFormat" => {}
            b"$NOD" => return Err((1, "MSH version 1; versions 2 and 4.1 are read".into())),
            _ => return Err((1, format!("no .msh file: it begins with `{}`", show(first)))),
        }
        self.source.skip_line();
        self.format().map_err(|message| (2, message))?;
        self.notes.is_binary = self.source.binary.is_some();
        self.leave("MeshFormat")?;
        while self.source.next_record() {
            let position = self.source.position();
            let word = self.source.field().unwrap_or_default();
            let Some(name) = word.strip_prefix(b"$") else {
                return Err((
                    position,
                    format!("expected a section, found `{}`", show(word)),
                ));
            };
            self.source.skip_line();
            let version = self.format.version;
            match name {
                b"PhysicalNames" => self.groups.names(&mut self.source)?,
                b"Entities" if version == Version::V41 => self.entities(false)?,
                b"PartitionedEntities" if version == Version::V41 => self.entities(true)?,
                b"Nodes" => self.nodes(position)?,
                b"ParametricNodes" => {
                    let message = "$ParametricNodes is not read; save without parameters";
                    return Err((position, message.into()));
                }
                b"Elements" => self.elements(position)?,
                _ => {
                    let name = String::from_utf8_lossy(name);
                    self.skip(&name, position)?;
                    continue;
                }
            }
            self.leave(&String::from_utf8_lossy(name))?;
        }
        let missing = match (&self.tags, self.has_elements) {
            (None, _) => "no $Nodes section",
            (_, false) => "no $Elements section",
            _ => return Ok(()),
        };
        Err((0, missing.into()))
    }

    /// `version binary size`, then in binary files the number 1.
    fn format(&mut self) -> Result<(), String> {
        self.source.begin("the format")?;
        let version = self.source.real("the version", Kind::F64)?;
        self.format.version = if (2.0..2.3).contains(&version) {
            Version::V2
        } else if version == 4.1 {
            Version::V41
        } else {
            return Err(format!(
                "MSH version {version}; versions 2 and 4.1 are read"
            ));
        };
        let is_binary = self.source.text_integer("the file type")?;
        let size = self.source.text_integer("the data size")?;
        self.format.size = match size {
            4 => Kind::U32,
            8 => Kind::U64,
            _ => return Err(format!("data size {size} is neither 4 nor 8")),
        };
        self.source.skip_line();
        match is_binary {
            0 => Ok(()),
            1 => {
                self.source.binary = Some(match self.source.take(4) {
                    Some([1, 0, 0, 0]) => ByteOrder::Little,
                    Some([0, 0, 0, 1]) => ByteOrder::Big,
                    _ => return Err("the byte order is not marked by the number 1".into()),
                });
                Ok(())
            }
            other => Err(format!(
                "file type {other} is neither 0 (text) nor 1 (binary)"
            )),
        }
    }

    /// Checks that section `name` ends here.
    fn leave(&mut self, name: &str) -> Result<(), Stop> {
        let found = self.source.next_record();
        let position = self.source.position();
        let word = self.source.field().unwrap_or_default();
        if word.strip_prefix(b"$End") == Some(name.as_bytes()) {
            self.source.skip_line();
            Ok(())
        } else if found {
            Err((
                position,
                format!("expected $End{name}, found `{}`", show(word)),
            ))
        } else {
            Err((position, format!("the file ends before $End{name}")))
        }
    }

    /// Goes behind the end of section `name`.
    fn skip(&mut self, name: &str, position: u64) -> Result<(), Stop> {
        if !SKIPPED.contains(&name) {
            let shown = show(name.as_bytes());
            self.notes
                .warn(position, &format!("ignored unknown section ${shown}"));
        }
        let end = format!("$End{name}");
        loop {
            if self
                .source
                .line_rest()
                .trim_ascii_end()
                .ends_with(end.as_bytes())
            {
                self.source.skip_line();
                return Ok(());
            }
            if self.source.rest().is_empty() {
                return Err((
                    position,
                    format!("the file ends before {}", show(end.as_bytes())),
                ));
            }
            self.source.skip_line();
        }
    }
}
