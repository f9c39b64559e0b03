//! Commands under bad conditions: killed while they write, on a full disk, without permission.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rand::RngExt;

use crate::poses;

/// What kills left.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Killed {
    /// Runs that were killed before their end.
    pub killed: usize,
    /// Of them, those that left a temporary file: killed while it was written or put in place.
    pub left_temporary: usize,
    /// Runs that left the whole new file: killed behind its rename, or ended first.
    pub finished: usize,
}

/// Starts a command `rounds` times that writes `new` to `target` and kills it: at a random moment
/// of its time, or, every other time, up to 3 ms after its temporary file begins to grow. In turn
/// there is no file at `target` before, or an old one.
///
/// # Panics
/// When `target` then holds anything but what it held before or all of `new`, or when its folder
/// holds other new files than `.bdtree-*.tmp`, which are removed.
pub fn kill_while_writing(
    command: impl Fn() -> Command,
    target: &Path,
    new: &[u8],
    time: Duration,
    rounds: usize,
) -> Killed {
    let folder = target.parent().expect("a folder");
    let before = names(folder, target);
    let mut result = Killed::default();
    let mut rng = poses::rng(1);
    for round in 0..rounds {
        let old = (round / 2 % 2 == 0).then(|| b"an old file".to_vec());
        let _ = fs::remove_file(target);
        if let Some(old) = &old {
            fs::write(target, old).expect("an old file");
        }
        let mut child = command()
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the command starts");
        if round % 2 == 0 {
            std::thread::sleep(time.mul_f64(rng.random_range(0.0..1.1)));
        } else {
            let begin = Instant::now();
            while child.try_wait().expect("a child").is_none() && !is_growing(folder) {
                assert!(begin.elapsed().as_secs() < 60, "the command hangs");
                std::thread::sleep(Duration::from_micros(50));
            }
            std::thread::sleep(Duration::from_micros(rng.random_range(0..3000)));
        }
        let _ = child.kill();
        let status = child.wait().expect("a child");
        result.killed += usize::from(status.code().is_none());
        let found = fs::read(target).ok();
        if found.as_deref() == Some(new) {
            result.finished += 1;
        } else {
            assert_eq!(found, old, "round {round}: neither old nor new");
        }
        let left: Vec<String> = names(folder, target)
            .into_iter()
            .filter(|name| !before.contains(name))
            .collect();
        result.left_temporary += usize::from(!left.is_empty());
        for name in left {
            assert!(is_temporary(&name), "round {round} left {name}");
            fs::remove_file(folder.join(name)).expect("removed");
        }
    }
    let _ = fs::remove_file(target);
    result
}

fn is_temporary(name: &str) -> bool {
    name.starts_with(".bdtree-") && name.ends_with(".tmp")
}

/// The names in a folder but that of `target`.
fn names(folder: &Path, target: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name());
    names
        .filter(|name| target.file_name() != Some(name))
        .map(|name| name.to_string_lossy().into_owned())
        .collect()
}

fn is_growing(folder: &Path) -> bool {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    entries
        .filter(|entry| is_temporary(&entry.file_name().to_string_lossy()))
        .any(|entry| entry.metadata().is_ok_and(|meta| meta.len() > 0))
}

/// A program that can write no file longer than this: its writes fail as on a full disk.
pub fn on_full_disk(program: &str, kibibytes: u32) -> Command {
    let mut command = Command::new("bash");
    let script = format!("trap '' XFSZ; ulimit -f {kibibytes}; exec \"$0\" \"$@\"");
    command.args(["-c", &script]).arg(program);
    command
}

/// A program run as someone who is not root, who may do everything; `None`, which a printed line
/// says, when there is no way to.
#[cfg(unix)]
pub fn unprivileged(test: &str, program: &str) -> Option<Command> {
    let probe = tempfile::tempdir().expect("a folder");
    set_mode(probe.path(), 0o555);
    let is_root = fs::write(probe.path().join("x"), b"x").is_ok();
    if !is_root {
        return Some(Command::new(program));
    }
    let start = || {
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups", program]);
        command
    };
    let works = start()
        .arg("--version")
        .output()
        .is_ok_and(|out| out.status.success());
    if !works {
        println!("{test}: skipped, run as root and setpriv cannot start {program} as nobody");
    }
    works.then(start)
}

/// Sets the permissions of a file or folder.
///
/// # Panics
/// When they cannot be set.
#[cfg(unix)]
pub fn set_mode(path: &Path, mode: u32) {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("permissions");
}
