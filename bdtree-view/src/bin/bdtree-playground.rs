//! The `bdtree-playground` command.

use std::io::{stderr, stdout};
use std::process::ExitCode;

fn main() -> ExitCode {
    let code = bdtree_view::playground::run(std::env::args_os(), &mut stdout(), &mut stderr());
    ExitCode::from(code)
}
