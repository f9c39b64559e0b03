//! `bdtree view`: starts the viewer, which is a program of its own.

use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

pub use crate::cli::ViewArguments as Arguments;
use crate::error::ToolError;

/// The program.
const PROGRAM: &str = "bdtree-view";

/// Runs `bdtree-view`, from the folder of this program or one of PATH, and returns its exit code.
///
/// # Errors
/// It is not installed, cannot be started or was killed.
pub fn run(arguments: &Arguments) -> Result<u8, ToolError> {
    let beside = std::env::current_exe().ok();
    let beside = beside.as_deref().and_then(Path::parent);
    let program = program(beside);
    let problem = |text: String| ToolError::Input(vec![format!("{PROGRAM}: {text}")]);
    let missing = || {
        let text = "not installed, neither beside bdtree nor on PATH; install with: cargo install --locked --path \
                    bdtree-view";
        ToolError::Usage(format!("{PROGRAM}: {text}"))
    };
    let status = Command::new(&program).args(&arguments.arguments).status();
    let status = status.map_err(|error| match error.kind() {
        ErrorKind::NotFound => missing(),
        _ => problem(format!("cannot be started: {error}")),
    })?;
    let code = status.code().ok_or_else(|| problem(status.to_string()))?;
    Ok(u8::try_from(code).unwrap_or(crate::BAD_INPUT))
}

/// The program in a folder, or its bare name, for PATH.
fn program(folder: Option<&Path>) -> PathBuf {
    let mut name = OsString::from(PROGRAM);
    name.push(std::env::consts::EXE_SUFFIX);
    let beside = folder.map(|folder| folder.join(&name));
    beside
        .filter(|path| path.is_file())
        .unwrap_or_else(|| PathBuf::from(name))
}
