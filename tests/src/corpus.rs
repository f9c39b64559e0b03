//! Real data, tested where it lies: the folder named by `BDTREE_CORPUS`.

use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::PathBuf;

/// The path of a file or folder of the corpus, for the test `test`; `None` when there is no
/// corpus, which a printed line says.
///
/// With `BDTREE_CORPUS_LOG` set, appends `corpus test: NAME` to that file, so that a script can
/// count the tests that really ran.
///
/// # Panics
/// With `BDTREE_CORPUS_REQUIRED=1`, when the corpus or the file is missing.
pub fn path(test: &str, relative: &str) -> Option<PathBuf> {
    let required = std::env::var("BDTREE_CORPUS_REQUIRED").is_ok_and(|v| v == "1");
    let Some(folder) = std::env::var_os("BDTREE_CORPUS") else {
        assert!(
            !required,
            "BDTREE_CORPUS_REQUIRED=1 but BDTREE_CORPUS is not set"
        );
        println!("{test}: skipped, BDTREE_CORPUS is not set");
        return None;
    };
    let path = PathBuf::from(folder).join(relative);
    if !path.exists() {
        assert!(!required, "{} is missing", path.display());
        println!("{test}: skipped, the corpus has no {relative}");
        return None;
    }
    if let Some(log) = std::env::var_os("BDTREE_CORPUS_LOG") {
        let line = format!("corpus test: {test}\n");
        let written = OpenOptions::new()
            .create(true)
            .append(true)
            .open(log)
            .and_then(|mut file| file.write_all(line.as_bytes()));
        assert!(
            written.is_ok(),
            "BDTREE_CORPUS_LOG cannot be written: {written:?}"
        );
    }
    Some(path)
}
