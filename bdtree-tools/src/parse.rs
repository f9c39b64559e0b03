//! Arguments of a command, or the answer where they are none that it can run.

use std::ffi::OsString;
use std::io::Write;

use clap::{Arg, Command, Parser};

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
    let matches = negative_numbers(P::command()).try_get_matches_from(arguments);
    matches
        .and_then(|matches| P::from_arg_matches(&matches))
        .map_err(|answer| {
            let (stream, code): (&mut dyn Write, u8) = match answer.use_stderr() {
                true => (err, USAGE),
                false => (out, DONE),
            };
            let _ = write!(stream, "{}", answer.render());
            let _ = stream.flush();
            code
        })
}

/// The command with options that take `-1` as a number, which they may refuse with their own words. clap would call it
/// an unexpected argument.
fn negative_numbers(command: Command) -> Command {
    let of_option =
        |option: Arg| match option.get_action().takes_values() && !option.is_positional() {
            true => option.allow_negative_numbers(true),
            false => option,
        };
    command
        .mut_args(of_option)
        .mut_subcommands(negative_numbers)
}
