//! The `bdtree` command as a library: `info`, `verify`, `diff`, `deform`, `query`, `report`,
//! `render`, `view`.
//!
//! [`run`] is the whole command with its streams as arguments; each subcommand is one module with
//! one public `run`. Exit codes: 0 done, 1 bad input (every problem is one line on the error
//! stream, with its place), 2 usage, which is also a subcommand that is not installed; `diff` has
//! its own (0 same, 1 differ, 2 unreadable).
//!
//! Files are mapped, not read, except by `verify`, which is meant for files of others: a file
//! must not change while it is mapped.
#![forbid(unsafe_code)]

mod asset_file;
mod bar;
mod cli;
pub mod deform;
pub mod diff;
mod error;
mod frames;
pub mod info;
mod joints;
mod output;
mod parse;
mod posture;
mod q;
pub mod query;
#[cfg(feature = "render")]
pub mod render;
#[cfg(feature = "report")]
pub mod report;
pub mod scene;
pub mod stress;
pub mod verify;
pub mod view;

pub use asset_file::AssetFile;
pub use error::ToolError;
pub use output::{check_target, printable};
pub use parse::parse;
pub use posture::{Posture, PostureArguments, posture};

use std::ffi::OsString;
use std::io::Write;

use cli::{Cli, Command};

/// Exit code: done.
pub const DONE: u8 = 0;
/// Exit code: bad input.
pub const BAD_INPUT: u8 = 1;
/// Exit code: usage.
pub const USAGE: u8 = 2;

/// The command line of `bdtree`, for those who make man pages and completions of it.
pub fn command() -> clap::Command {
    <Cli as clap::CommandFactory>::command()
}

/// Runs the command with `arguments` (the program's name first) and returns its exit code. A
/// reader that closes `out` early is no error.
pub fn run(
    arguments: impl IntoIterator<Item = OsString>,
    out: &mut dyn Write,
    err: &mut dyn Write,
) -> u8 {
    let cli = match parse::<Cli>(arguments, out, err) {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    let out = &mut output::QuietPipe::new(out);
    let unreadable = match &cli.command {
        Command::Diff(_) => USAGE,
        _ => BAD_INPUT,
    };
    let result = match cli.command {
        Command::Info(arguments) => info::run(&arguments, out),
        Command::Verify(arguments) => verify::run(&arguments, out, err),
        Command::Diff(arguments) => diff::run(&arguments, out),
        Command::Deform(arguments) => deform::run(&arguments, out),
        Command::Query(arguments) => query::run(&arguments, out),
        #[cfg(feature = "report")]
        Command::Report(arguments) => report::run(&arguments, out, err),
        #[cfg(not(feature = "report"))]
        Command::Report(_) => Err(left_out("report")),
        #[cfg(feature = "render")]
        Command::Render(arguments) => render::run(&arguments, out),
        #[cfg(not(feature = "render"))]
        Command::Render(_) => Err(left_out("render")),
        Command::View(arguments) => view::run(&arguments),
    };
    // What was answered before an error stays answered.
    let flushed = out.flush().map_err(ToolError::Stdout);
    let result = result.and_then(|code| flushed.map(|()| code));
    match result {
        Ok(code) => code,
        Err(error) => {
            let _ = writeln!(err, "{error}");
            error.code(unreadable)
        }
    }
}

/// Why a subcommand does nothing, in the words of `bdtree --help`.
#[cfg(any(test, not(all(feature = "render", feature = "report"))))]
fn left_out(feature: &str) -> ToolError {
    ToolError::Usage(format!(
        "bdtree {feature}: not compiled into this program; install with: \
         cargo install --locked --path bdtree-tools --features {feature}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Help, error and README name the same command, each for its own feature.
    #[test]
    fn what_is_left_out_says_how_to_get_it() {
        let (help, readme) = (include_str!("cli.rs"), include_str!("../../README.md"));
        for feature in ["report", "render"] {
            let install =
                format!("cargo install --locked --path bdtree-tools --features {feature}");
            let words = format!("ot compiled into this program; install with: {install}");
            let error = left_out(feature);
            assert!(matches!(error, ToolError::Usage(_)), "exit code 2");
            assert_eq!(error.to_string(), format!("bdtree {feature}: n{words}"));
            assert!(help.contains(&format!("/// N{words}\n")), "{feature}");
            assert!(readme.contains(&install), "{feature}");
        }
    }
}
