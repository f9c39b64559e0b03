//! What is at a path after a write that succeeded, and after one that did not.

use std::io::Error;
use std::path::Path;

use bdtree_output::{OutputError, check_writable, write_whole};

fn write(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    write_whole(path, |w| w.write_all(bytes))
}

#[test]
fn files_are_written_whole_or_not_at_all() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.bdt");
    let left = || std::fs::read_dir(folder.path()).expect("a folder").count();
    write(&path, b"one").expect("written");
    write(&path, b"two").expect("written");
    let error = write_whole(&path, |w| {
        w.write_all(b"half")?;
        Err(Error::other("no more"))
    });
    let reason = error.expect_err("half a file").reason;
    assert_eq!(reason, "cannot write: no more");
    assert_eq!(std::fs::read(&path).expect("read"), b"two");
    assert_eq!(left(), 1);

    let missing = folder.path().join("missing").join("a.bdt");
    let error = write(&missing, b"x").expect_err("no folder");
    assert_eq!(error.path, missing);
    assert!(error.reason.ends_with("missing does not exist"), "{error}");
    assert_eq!(check_writable(&missing), Err(error));
    let taken = folder.path().join("taken");
    std::fs::create_dir(&taken).expect("a folder");
    let error = write(&taken, b"x").expect_err("a folder");
    assert_eq!(error.reason, "is a folder: name a file");
    assert_eq!(check_writable(&taken), Err(error));
    assert_eq!(check_writable(&path), Ok(()));
    assert_eq!(left(), 2);
}

/// A read-only golden file stays, for everybody; a file that few may read stays so.
#[cfg(unix)]
#[test]
fn permissions_are_kept() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.bdt");
    let set = |mode| {
        let mode = std::fs::Permissions::from_mode(mode);
        std::fs::set_permissions(&path, mode).expect("set");
    };
    std::fs::write(&path, b"old").expect("written");
    set(0o444);
    let error = write(&path, b"new").expect_err("protected");
    assert_eq!(error.reason, "is write-protected");
    assert_eq!(check_writable(&path), Err(error));
    assert_eq!(std::fs::read(&path).expect("read"), b"old");
    set(0o640);
    write(&path, b"new").expect("written");
    assert_eq!(std::fs::read(&path).expect("read"), b"new");
    let mode = std::fs::metadata(&path).expect("a file").permissions();
    assert_eq!(mode.mode() & 0o777, 0o640);
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_devices_stay_devices() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    let folder = tempfile::tempdir().expect("a folder");
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    std::fs::write(&file, b"old").expect("written");
    symlink(&file, &link).expect("a link");
    write(&link, b"new").expect("written");
    assert_eq!(std::fs::read(&file).expect("read"), b"new");
    let kind = std::fs::symlink_metadata(&link).expect("a link");
    assert!(kind.is_symlink());
    // A link to a device, so that a broken build of this test replaces the link and nothing else.
    let null = folder.path().join("null");
    symlink("/dev/null", &null).expect("a link");
    write(&null, b"gone").expect("written");
    let kind = std::fs::metadata(&null).expect("a device").file_type();
    assert!(kind.is_char_device());
    #[cfg(target_os = "linux")]
    {
        let full = folder.path().join("full");
        symlink("/dev/full", &full).expect("a link");
        let error = write(&full, b"x").expect_err("a full device").to_string();
        assert!(error.contains("full: cannot write: "), "{error}");
    }
}
