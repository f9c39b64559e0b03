//! From a file's bytes to its JSON text and its binary chunk.

use std::borrow::Cow;

use gltf::Glb;

use super::notes::Notes;
use super::quiet::contained;

/// Magic, version and length; then at least the head of one chunk.
const GLB_BYTES_MIN: usize = 20;

/// The two parts of a glTF file.
pub(super) struct Container<'a> {
    /// JSON text.
    pub(super) json: Cow<'a, [u8]>,
    /// The binary chunk of a `.glb` file.
    pub(super) binary: Option<Cow<'a, [u8]>>,
}

/// The parts of `bytes`: binary glTF by its magic number, else JSON text.
pub(super) fn split<'a>(bytes: &'a [u8], notes: &mut Notes) -> Option<Container<'a>> {
    let Some(header) = bytes.strip_prefix(b"glTF") else {
        return text(bytes, notes);
    };
    let word = |at: usize| {
        let word = header.get(at..)?.first_chunk::<4>()?;
        Some(u32::from_le_bytes(*word))
    };
    let (Some(version), Some(length)) = (word(0), word(4)) else {
        return notes.refuse("GLB header", "truncated: 12 bytes make a header");
    };
    if version != 2 {
        let message = format!("version {version} at byte 4; 2 is read");
        return notes.refuse("GLB header", message);
    }
    let length = length as usize;
    let found = bytes.len();
    let whole = bytes.get(..length).filter(|_| length >= GLB_BYTES_MIN);
    let Some(whole) = whole else {
        let message = format!("length {length} at byte 8, but the file has {found} bytes");
        return notes.refuse("GLB header", message);
    };
    if found > length {
        let message = format!("ignored {} bytes after its end", found - length);
        notes.warn("GLB header", message);
    }
    // The crate checks the chunks against `whole`.
    match contained(|| Glb::from_slice(whole)) {
        Ok(Ok(glb)) => Some(Container {
            json: glb.json,
            binary: glb.bin,
        }),
        Ok(Err(error)) => notes.refuse("GLB chunks", error.to_string()),
        Err(panic) => notes.refuse("GLB chunks", format!("damaged: {panic}")),
    }
}

fn text<'a>(bytes: &'a [u8], notes: &mut Notes) -> Option<Container<'a>> {
    if bytes.is_empty() {
        return notes.refuse("", "the file is empty");
    }
    let json = match bytes.strip_prefix(b"\xef\xbb\xbf") {
        Some(rest) => {
            notes.warn("", "ignored the byte order mark, which JSON does not have");
            rest
        }
        None => bytes,
    };
    Some(Container {
        json: Cow::Borrowed(json),
        binary: None,
    })
}
