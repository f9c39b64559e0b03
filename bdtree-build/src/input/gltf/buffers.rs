//! The bytes of buffers and buffer views, loaded when first asked for.

use std::borrow::Cow;
use std::cell::OnceCell;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use gltf::json::Root;

use super::notes::Notes;
use super::uri::{self, Source};

/// The buffers of one document.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    /// The binary chunk: the bytes of buffer 0 if that has no URI.
    binary: Option<&'a [u8]>,
    /// The folder of the document.
    folder: &'a Path,
    /// Per buffer: its bytes, or `None` if its problem was noted.
    loaded: Vec<OnceCell<Option<Cow<'a, [u8]>>>>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(root: &'a Root, binary: Option<&'a [u8]>, folder: &'a Path) -> Self {
        Self {
            root,
            binary,
            folder,
            loaded: root.buffers.iter().map(|_| OnceCell::new()).collect(),
        }
    }

    /// The bytes of a buffer view and its stride, if it has one. What is wrong with the view is
    /// noted at `place`, what is wrong with its buffer once, there.
    pub(super) fn view(
        &self,
        index: usize,
        place: &str,
        notes: &mut Notes,
    ) -> Option<(&[u8], Option<usize>)> {
        let view = self.root.buffer_views.get(index)?;
        let buffer = view.buffer.value();
        let bytes = self.buffer(buffer, notes)?;
        let start = view.byte_offset.unwrap_or_default().0;
        let (length, size) = (view.byte_length.0, bytes.len());
        let range = usize::try_from(start)
            .ok()
            .zip(
                start
                    .checked_add(length)
                    .and_then(|end| usize::try_from(end).ok()),
            )
            .and_then(|(start, end)| bytes.get(start..end));
        if range.is_none() {
            let message = format!(
                "bufferViews[{index}] of {length} bytes from byte {start} ends beyond buffers[{buffer}], \
                 which has {size}"
            );
            notes.problem(place, message);
        }
        Some((range?, view.byte_stride.map(|stride| stride.0)))
    }

    fn buffer(&self, index: usize, notes: &mut Notes) -> Option<&[u8]> {
        let load = || match self.load(index) {
            Ok(bytes) => Some(bytes),
            Err(message) => notes.refuse(format!("buffers[{index}]"), message),
        };
        self.loaded.get(index)?.get_or_init(load).as_deref()
    }

    /// The first `byteLength` bytes of a buffer.
    fn load(&self, index: usize) -> Result<Cow<'a, [u8]>, String> {
        let buffer = self.root.buffers.get(index).ok_or("does not exist")?;
        let wanted = buffer.byte_length.0;
        let short = |found: u64| format!("byteLength is {wanted}, but there are {found} bytes");
        let mut bytes = match &buffer.uri {
            Some(text) => match uri::resolve(text, self.folder) {
                Ok(Source::Bytes(bytes)) => Cow::Owned(bytes),
                Ok(Source::File(path)) => {
                    let bytes = read(&path, wanted, short);
                    Cow::Owned(bytes.map_err(|message| format!("uri {text:?}: {message}"))?)
                }
                Err(message) => return Err(format!("uri {:?} {message}", shown(text))),
            },
            None if index == 0 => {
                let none = "has no uri, and the file has no binary chunk";
                Cow::Borrowed(self.binary.ok_or(none)?)
            }
            None => return Err("has no uri: its bytes may be in an extension".into()),
        };
        let length = usize::try_from(wanted).ok().filter(|&n| n <= bytes.len());
        let length = length.ok_or_else(|| short(bytes.len() as u64))?;
        match &mut bytes {
            Cow::Owned(bytes) => bytes.truncate(length),
            Cow::Borrowed(bytes) => *bytes = &bytes[..length],
        }
        Ok(bytes)
    }
}

/// The first `wanted` bytes of a file that has as many.
fn read(path: &Path, wanted: u64, short: impl Fn(u64) -> String) -> Result<Vec<u8>, String> {
    let fail = |error: std::io::Error| format!("cannot be read: {error}");
    let meta = fs::metadata(path).map_err(fail)?;
    if !meta.is_file() {
        return Err("is not a file".into());
    }
    if meta.len() < wanted {
        return Err(short(meta.len()));
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(fail)?;
    file.take(wanted).read_to_end(&mut bytes).map_err(fail)?;
    Ok(bytes)
}

/// The start of a URI: data may be long.
fn shown(uri: &str) -> String {
    uri.chars().take(64).collect()
}
