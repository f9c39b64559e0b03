//! The `bdtree-build` command.

mod cli;

use clap::{CommandFactory, FromArgMatches};
use std::process::ExitCode;

fn main() -> ExitCode {
    // An option that is given `-1` refuses it in its own words; clap would call it an unexpected argument.
    let command = cli::Arguments::command().mut_args(|option| {
        let is_option = option.get_action().takes_values() && !option.is_positional();
        if is_option {
            option.allow_negative_numbers(true)
        } else {
            option
        }
    });
    match cli::Arguments::from_arg_matches(&command.get_matches()) {
        Ok(arguments) => cli::run(&arguments),
        Err(error) => error.exit(),
    }
}
