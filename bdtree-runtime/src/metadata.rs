//! The metadata section, read without memory (SPEC 8).

use crate::error::Datum;
use crate::view::Asset;

/// Most bytes of a text and entries of a list.
const LENGTH_MAX: u64 = 4_194_304;

impl<'a> Asset<'a> {
    /// The names of the modes, in order; `None` for one that has none. Fewer than there are modes where the
    /// section is damaged, none where it is missing.
    pub fn mode_names(&self) -> impl Iterator<Item = Option<&'a str>> + use<'a> {
        self.described().map(|(name, _)| name)
    }

    /// The weight that the source gives a morph target while nothing moves it, for each mode in order; `None` for modes
    /// that have none, such as vibration modes. As many as [`Asset::mode_names`].
    pub fn default_q(&self) -> impl Iterator<Item = Option<f64>> + use<'a> {
        self.described().map(|(_, weight)| weight)
    }

    /// Name and default weight of each mode.
    fn described(&self) -> impl Iterator<Item = (Option<&'a str>, Option<f64>)> + use<'a> {
        let mut reader = Reader::new(self.metadata);
        let count = match (reader.options(), reader.length()) {
            (Ok(()), Ok(count)) => count.min(self.modes.len() as u64),
            _ => 0,
        };
        (0..count).map_while(move |_| reader.mode().ok())
    }

    /// The name of mode `index`: what the source called a morph target or field.
    pub fn mode_name(&self, index: usize) -> Option<&'a str> {
        self.mode_names().nth(index).flatten()
    }

    /// The mode of this name, the first of several: its place in q.
    pub fn mode_index(&self, name: &str) -> Option<usize> {
        self.mode_names().position(|own| own == Some(name))
    }
}

/// What was expected, what is there.
pub(crate) type Broken = (&'static str, Datum);

pub(crate) struct Reader<'a> {
    bytes: &'a [u8],
    pub(crate) at: usize,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// All of it, for a file of so many modes and vertices.
    pub(crate) fn record(&mut self, (mode_count, vertex_count): (u64, u64)) -> Result<(), Broken> {
        self.options()?;
        let modes = self.length()?;
        if modes != mode_count {
            return Err(("one entry per mode", Datum::Integer(modes)));
        }
        for _ in 0..modes {
            self.mode()?;
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

    /// What stands before the modes.
    fn options(&mut self) -> Result<(), Broken> {
        self.text()?; // builder
        self.text()?; // source_name
        self.take(32)?; // source_hash
        self.text()?; // basis
        let mut key_before: Option<&str> = None;
        for _ in 0..self.length()? {
            let key = self.text()?;
            if key_before.is_some_and(|before| before >= key) {
                return Err(("ascending keys", Datum::Text("a key out of order")));
            }
            key_before = Some(key);
            self.text()?;
        }
        Ok(())
    }

    /// A mode's name and default weight.
    fn mode(&mut self) -> Result<(Option<&'a str>, Option<f64>), Broken> {
        let name = if self.present()? {
            Some(self.text()?)
        } else {
            None
        };
        let weight = if self.present()? {
            Some(self.number()?)
        } else {
            None
        };
        Ok((name, weight))
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

    fn text(&mut self) -> Result<&'a str, Broken> {
        let length = self.length()?;
        let text = self.take(length as usize)?;
        core::str::from_utf8(text).map_err(|_| ("UTF-8", Datum::Text("other bytes")))
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
