//! The `bdtree` command.

use std::io::{BufWriter, stderr, stdout};
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut out = BufWriter::new(stdout().lock());
    let code = bdtree_tools::run(std::env::args_os(), &mut out, &mut stderr());
    // What a closed pipe left in the buffer has no reader: do not try again.
    let _ = out.into_parts();
    ExitCode::from(code)
}
