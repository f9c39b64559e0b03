//! Where the bytes of buffers come from.

use std::path::Path;

use bdtree_build::input::gltf::read_gltf;
use serde_json::json;

use crate::support::parts;

/// Writes the sound file as text into `folder`, its buffer's URI `uri`.
fn with_uri(folder: &Path, uri: &str) -> Result<usize, String> {
    let (mut document, _) = parts();
    document["buffers"][0]["uri"] = json!(uri);
    let path = folder.join("face.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    match read_gltf(&path, None) {
        Ok(model) => Ok(model.mesh.positions.len()),
        Err(error) => {
            let text = error.to_string();
            let place = format!("{}: buffers[0]: ", path.display());
            Err(text.strip_prefix(&place).unwrap_or(&text).to_string())
        }
    }
}

#[test]
fn files_beside_the_document_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::create_dir(folder.join("deeper")).unwrap();
    let (_, binary) = parts();
    for name in ["b.bin", "deeper/a b.bin", "größe.bin"] {
        std::fs::write(folder.join(name), &binary).unwrap();
    }
    for uri in [
        "b.bin",
        "./b.bin",
        "deeper/a%20b.bin",
        "deeper/a b.bin",
        "größe.bin",
        "gr%C3%B6%C3%9Fe.bin",
    ] {
        assert_eq!(with_uri(folder, uri), Ok(52), "{uri}");
    }
}

#[test]
fn other_places_are_refused() {
    let outer = tempfile::tempdir().unwrap();
    let folder = outer.path().join("inner");
    std::fs::create_dir_all(folder.join("deeper")).unwrap();
    let (_, binary) = parts();
    std::fs::write(outer.path().join("b.bin"), &binary).unwrap();
    std::fs::write(folder.join("short.bin"), &binary[..binary.len() - 4]).unwrap();
    let absolute = outer.path().join("b.bin");
    let is_absolute = "is absolute; only data: and files beside the document are read";
    let leads_out = "leads out of the document's folder";
    let (need, found) = (binary.len(), binary.len() - 4);
    for (uri, message) in [
        ("../b.bin", leads_out.to_string()),
        ("deeper/../../b.bin", leads_out.to_string()),
        ("%2e%2e/b.bin", leads_out.to_string()),
        (absolute.to_str().unwrap(), leads_out.to_string()),
        ("file:///b.bin", is_absolute.to_string()),
        ("https://example.org/b.bin", is_absolute.to_string()),
    ] {
        assert_eq!(
            with_uri(&folder, uri),
            Err(format!("uri {uri:?} {message}")),
            "{uri}"
        );
    }
    for (uri, message) in [
        ("missing.bin", "cannot be read: "),
        ("deeper", "is not a file"),
        (
            "short.bin",
            &format!("byteLength is {need}, but there are {found} bytes"),
        ),
    ] {
        let error = with_uri(&folder, uri).expect_err(uri);
        assert!(
            error.starts_with(&format!("uri {uri:?}: {message}")),
            "{error}"
        );
    }
    let error = with_uri(&folder, "data:;base64,AAAA").expect_err("short");
    assert_eq!(
        error,
        format!("byteLength is {need}, but there are 3 bytes")
    );
    let error = with_uri(&folder, "data:;base64,A*AA").expect_err("damaged");
    assert!(
        error.starts_with("uri \"data:;base64,A*AA\" data: damaged base64"),
        "{error}"
    );
}
