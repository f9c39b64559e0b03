//! Whole files in memory.

use std::fs::{self, File};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Larger files are not read whole: meshes of a hundred million triangles are smaller.
const BYTES_MAX: u64 = 4 << 30;

/// The bytes of a plain file: a pipe would be waited for, and a device may have no end.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>> {
    let meta = fs::metadata(path)?;
    let refuse = |why: String| Err(Error::new(ErrorKind::InvalidInput, why));
    if meta.is_dir() {
        return refuse("it is a folder".into());
    }
    if !meta.is_file() {
        return refuse("it is not a plain file".into());
    }
    if meta.len() > BYTES_MAX {
        let bytes = meta.len();
        return refuse(format!("it has {bytes} bytes, more than {BYTES_MAX}"));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(meta.len() as usize)?;
    // It may have grown.
    File::open(path)?.take(BYTES_MAX).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::read_file;

    #[test]
    fn what_is_no_plain_file_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let error = read_file(folder.path()).expect_err("a folder");
        assert_eq!(error.to_string(), "it is a folder");
        #[cfg(unix)]
        {
            let error = read_file("/dev/zero".as_ref()).expect_err("a device");
            assert_eq!(error.to_string(), "it is not a plain file");
        }
        let large = folder.path().join("large");
        let file = std::fs::File::create(&large).expect("create");
        file.set_len(1 << 33).expect("a sparse file");
        let error = read_file(&large).expect_err("too large");
        assert!(
            error
                .to_string()
                .starts_with("it has 8589934592 bytes, more than")
        );
        std::fs::write(&large, b"abc").expect("write");
        assert_eq!(read_file(&large).expect("a file"), b"abc");
    }
}
