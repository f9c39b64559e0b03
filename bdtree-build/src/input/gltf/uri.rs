//! Where a buffer's bytes are: inside the URI, or in a file beside the document.

use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

/// What a URI leads to.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Source {
    /// The bytes of a `data:` URI.
    Bytes(Vec<u8>),
    /// A file in the document's folder or below.
    File(PathBuf),
}

/// What `uri` leads to, for a document in `folder`.
///
/// Refused: other schemes (`http:`, `file:`, a drive), absolute paths, `..`, backslashes: a
/// document reads no files but those it was delivered with.
pub(super) fn resolve(uri: &str, folder: &Path) -> Result<Source, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        return data_bytes(data).map(Source::Bytes);
    }
    let has_scheme = uri.split_once(':').is_some_and(|(scheme, _)| {
        scheme.starts_with(|c: char| c.is_ascii_alphabetic())
            && scheme
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    });
    if has_scheme {
        return Err("is absolute; only data: and files beside the document are read".into());
    }
    let name = percent_decode_str(uri)
        .decode_utf8()
        .map_err(|_| "is not UTF-8 once decoded".to_string())?;
    let inside = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    let path = Path::new(name.as_ref());
    if name.contains(['\\', '\0']) || !path.components().all(inside) {
        return Err("leads out of the document's folder".into());
    }
    if path.file_name().is_none() {
        return Err("names no file".into());
    }
    Ok(Source::File(folder.join(path)))
}

/// The bytes of what follows `data:`.
fn data_bytes(data: &str) -> Result<Vec<u8>, String> {
    let (kind, payload) = data.split_once(',').ok_or("data: without a comma")?;
    let payload = percent_decode_str(payload);
    if !kind.ends_with(";base64") {
        return Ok(payload.collect());
    }
    // Some writers leave out the padding.
    let config =
        GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
    GeneralPurpose::new(&STANDARD, config)
        .decode(std::borrow::Cow::from(payload))
        .map_err(|error| format!("data: damaged base64: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(uri: &str) -> Result<PathBuf, String> {
        match resolve(uri, Path::new("/models")) {
            Ok(Source::File(path)) => Ok(path),
            Ok(Source::Bytes(bytes)) => Err(format!("{} bytes", bytes.len())),
            Err(message) => Err(message),
        }
    }

    #[test]
    fn files_lie_in_the_documents_folder_or_below() {
        for (uri, path) in [
            ("a.bin", "/models/a.bin"),
            ("sub/a.bin", "/models/sub/a.bin"),
            ("./a%20b.bin", "/models/./a b.bin"),
            ("a b.bin", "/models/a b.bin"),
            ("%E3%83%AB.bin", "/models/ル.bin"),
            ("50%.bin", "/models/50%.bin"),
        ] {
            assert_eq!(file(uri), Ok(PathBuf::from(path)), "{uri}");
        }
    }

    #[test]
    fn uris_that_lead_elsewhere_are_refused() {
        for uri in [
            "../a.bin",
            "sub/../../a.bin",
            "/etc/passwd",
            "//host/a.bin",
            "%2e%2e/a.bin",
            "%2Fetc%2Fpasswd",
            "..%2Fa.bin",
            "sub\\a.bin",
            "a%00.bin",
            "http://host/a.bin",
            "file:///a.bin",
            "file:a.bin",
            "C:/a.bin",
            "%ff.bin",
            "",
            ".",
        ] {
            assert!(file(uri).is_err(), "{uri}: {:?}", file(uri));
        }
    }

    #[test]
    fn data_uris_are_decoded() {
        let bytes = |uri: &str| resolve(uri, Path::new("."));
        let ok = |text: &str| Ok(Source::Bytes(text.into()));
        assert_eq!(bytes("data:application/octet-stream;base64,aGk="), ok("hi"));
        assert_eq!(bytes("data:;base64,aGk"), ok("hi"));
        assert_eq!(bytes("data:;base64,aGk%3D"), ok("hi"));
        assert_eq!(bytes("data:text/plain,a%20b"), ok("a b"));
        assert!(bytes("data:;base64,a*k=").is_err());
        assert!(bytes("data:;base64").is_err());
    }
}
