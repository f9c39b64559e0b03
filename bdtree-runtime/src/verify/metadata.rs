//! The metadata section, walked without memory: lengths, text, tags, nothing left over.

use bdtree_format::SectionKind;
use core::ops::ControlFlow;

use super::Report;
use crate::error::{Datum, FormatError};
use crate::view::Asset;

/// Most bytes of a text and entries of a list.
const LENGTH_MAX: u64 = 4_194_304;

impl Asset<'_> {
    pub(super) fn metadata_record(&self, report: Report<'_>) -> ControlFlow<()> {
        if !self
            .sections
            .iter()
            .any(|s| s.kind == SectionKind::METADATA)
        {
            return ControlFlow::Continue(());
        }
        let mut reader = Reader {
            bytes: self.metadata,
            at: 0,
        };
        let counts = (self.modes.len() as u64, self.positions.len() as u64);
        if let Err((expected, found)) = reader.record(counts) {
            report(FormatError {
                section: SectionKind::METADATA,
                byte: self.section_offset(SectionKind::METADATA) + reader.at as u64,
                rule: "SPEC 8: metadata is the record of layout 2",
                expected: Datum::Text(expected),
                found,
            })?;
        }
        ControlFlow::Continue(())
    }
}

/// What was expected, what is there.
type Broken = (&'static str, Datum);

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn record(&mut self, (mode_count, vertex_count): (u64, u64)) -> Result<(), Broken> {
        self.text()?; // builder
        self.text()?; // source_name
        self.take(32)?; // source_hash
        self.text()?; // basis
        let mut key_before: Option<&[u8]> = None;
        for _ in 0..self.length()? {
            let key = self.text()?;
            if key_before.is_some_and(|before| before >= key) {
                return Err(("ascending keys", Datum::Text("a key out of order")));
            }
            key_before = Some(key);
            self.text()?;
        }
        let modes = self.length()?;
        if modes != mode_count {
            return Err(("one entry per mode", Datum::Integer(modes)));
        }
        for _ in 0..modes {
            if self.present()? {
                self.text()?;
            }
            if self.present()? {
                self.number()?;
            }
        }
        if self.present()? {
            self.error(vertex_count)?;
        }
        for _ in 0..self.length()? {
            self.text()?;
        }
        match self.bytes.len() - self.at {
            0 => Ok(()),
            more => Err(("the end of the section", Datum::Integer(more as u64))),
        }
    }

    /// basis_error_rel.
    fn error(&mut self, vertex_count: u64) -> Result<(), Broken> {
        for _ in 0..2 {
            let x = self.number()?;
            if x < 0.0 {
                return Err(("an error that is not negative", Datum::Real(x)));
            }
        }
        if self.present()? {
            self.eight()?; // frame
        }
        if self.present()? {
            let vertex = u64::from_le_bytes(self.eight()?);
            if vertex >= vertex_count {
                return Err(("a vertex of the file", Datum::Integer(vertex)));
            }
        }
        Ok(())
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], Broken> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let Some(taken) = rest.get(..count) else {
            return Err(("bytes inside the section", Datum::Integer(count as u64)));
        };
        self.at += count;
        Ok(taken)
    }

    fn eight(&mut self) -> Result<[u8; 8], Broken> {
        let mut out = [0; 8];
        out.copy_from_slice(self.take(8)?);
        Ok(out)
    }

    fn length(&mut self) -> Result<u64, Broken> {
        match u64::from_le_bytes(self.eight()?) {
            length @ 0..=LENGTH_MAX => Ok(length),
            length => Err(("a length of at most 4194304", Datum::Integer(length))),
        }
    }

    fn text(&mut self) -> Result<&'a [u8], Broken> {
        let length = self.length()?;
        let text = self.take(length as usize)?;
        match core::str::from_utf8(text) {
            Ok(_) => Ok(text),
            Err(_) => Err(("UTF-8", Datum::Text("other bytes"))),
        }
    }

    fn present(&mut self) -> Result<bool, Broken> {
        match self.take(1)? {
            [0] => Ok(false),
            [1] => Ok(true),
            tag => Err(("a tag of 0 or 1", Datum::Integer(u64::from(tag[0])))),
        }
    }

    fn number(&mut self) -> Result<f64, Broken> {
        match f64::from_le_bytes(self.eight()?) {
            x if x.is_finite() => Ok(x),
            x => Err(("a finite number", Datum::Real(x))),
        }
    }
}
