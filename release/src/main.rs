//! Writes the man pages and the shell completions of `bdtree` and `bdtree-build`: `bdtree-pages FOLDER`.
//!
//! They lie as Linux's packages have them: `man/man1`, `bash-completion/completions`, `zsh/site-functions`,
//! `fish/vendor_completions.d`.

use std::ffi::OsString;
use std::fs;
use std::io::{Error, ErrorKind};
use std::path::Path;
use std::process::ExitCode;

use clap::{Command, CommandFactory};
use clap_complete::{Shell, generate_to};

// The options of a program, which is no library's.
#[allow(dead_code, reason = "of the options only their description is read")]
#[path = "../../bdtree-build/src/cli/arguments.rs"]
mod arguments;

/// The commands that have pages.
fn commands() -> [Command; 2] {
    [bdtree_tools::command(), arguments::Arguments::command()]
}

/// Writes all pages below `share`.
///
/// # Errors
/// A folder or a file that cannot be written.
fn write(share: &Path) -> Result<(), Error> {
    let folder = |name: &str| -> Result<_, Error> {
        let folder = share.join(name);
        fs::create_dir_all(&folder)?;
        Ok(folder)
    };
    for command in commands() {
        let name = command.get_name().to_string();
        clap_mangen::generate_to(command.clone(), folder("man/man1")?)?;
        for (shell, place) in [
            (Shell::Bash, "bash-completion/completions"),
            (Shell::Zsh, "zsh/site-functions"),
            (Shell::Fish, "fish/vendor_completions.d"),
        ] {
            let written = generate_to(shell, &mut command.clone(), &name, folder(place)?)?;
            if shell == Shell::Bash {
                // The file that bash-completion looks for has the command's name alone.
                fs::rename(&written, written.with_file_name(&name))?;
            }
        }
    }
    Ok(())
}

fn run(arguments: &[OsString]) -> Result<(), Error> {
    let [_, folder] = arguments else {
        return Err(Error::new(
            ErrorKind::InvalidInput,
            "usage: bdtree-pages FOLDER",
        ));
    };
    write(Path::new(folder))
}

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("bdtree-pages: {error}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every option and every subcommand stands in a page and in the completions of each shell.
    #[test]
    fn pages_have_every_option() {
        let folder = tempfile::tempdir().expect("a folder");
        write(folder.path()).expect("pages");
        let read = |path: String| fs::read_to_string(folder.path().join(path)).expect("a page");
        for command in commands() {
            let name = command.get_name().to_string();
            let completions = [
                read(format!("bash-completion/completions/{name}")),
                read(format!("zsh/site-functions/_{name}")),
                read(format!("fish/vendor_completions.d/{name}.fish")),
            ];
            let own = read(format!("man/man1/{name}.1"));
            let mut count = 0;
            let pages = command.get_subcommands().map(|below| {
                let page = read(format!("man/man1/{name}-{}.1", below.get_name()));
                (page, below)
            });
            for (page, command) in pages.chain([(own, &command)]) {
                let shown = command
                    .get_arguments()
                    .filter(|option| !option.is_hide_set());
                for option in shown.filter_map(|option| option.get_long()) {
                    // troff writes a hyphen as \-.
                    let escaped = option.replace('-', r"\-");
                    assert!(
                        page.contains(&format!(r"\-\-{escaped}")),
                        "{name} --{option}"
                    );
                    for text in &completions {
                        assert!(text.contains(option), "{name} --{option}");
                    }
                    count += 1;
                }
            }
            assert!(count > 10, "{name}: {count} options");
        }
    }
}
