//! The `bdtree-view` command.

use std::io::{stderr, stdout};
use std::process::ExitCode;

fn main() -> ExitCode {
    let code = bdtree_view::run(std::env::args_os(), &mut stdout(), &mut stderr());
    ExitCode::from(code)
}
