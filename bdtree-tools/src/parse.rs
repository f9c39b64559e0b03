//! Arguments of a command, or the answer where they are none that it can run.

use std::ffi::OsString;
use std::io::Write;

use clap::Parser;

use crate::{DONE, USAGE};

/// Parses `arguments` (the program's name first) of a command.
///
/// # Errors
/// The exit code, once the answer is written: help and version to `out`, everything else is a mistake
/// of usage and goes to `err`.
pub fn parse<P: Parser>(
    arguments: impl IntoIterator<Item = OsString>,
    out: &mut dyn Write,
    err: &mut dyn Write,
) -> Result<P, u8> {
    P::try_parse_from(arguments).map_err(|answer| {
        let (stream, code): (&mut dyn Write, u8) = match answer.use_stderr() {
            true => (err, USAGE),
            false => (out, DONE),
        };
        let _ = write!(stream, "{}", answer.render());
        let _ = stream.flush();
        code
    })
}
