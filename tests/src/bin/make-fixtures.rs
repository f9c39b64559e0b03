//! Writes the meshes under `fixtures/`.

use std::process::ExitCode;

use bdtree_tests::fixtures;
use clap::Parser;

/// Writes the committed fixtures; or compares them.
#[derive(Parser)]
struct Options {
    /// Write the large ones too, into fixtures/generated.
    #[arg(long)]
    large: bool,
    /// Write the sail too, 362 MB in fixtures/generated, for measuring.
    #[arg(long)]
    sail: bool,
    /// Write nothing; fail if a file differs from what would be written.
    #[arg(long)]
    check: bool,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let mut code = ExitCode::SUCCESS;
    for fixture in fixtures::all() {
        if fixture.is_large && !options.large {
            continue;
        }
        let path = fixtures::place(fixture);
        let content = fixtures::content(fixture.name);
        if options.check {
            if std::fs::read(&path).ok().as_ref() != Some(&content) {
                eprintln!("{} differs from what is made now", path.display());
                code = ExitCode::FAILURE;
            }
        } else if let Err(error) = fixtures::write(&path, &content) {
            eprintln!("{}: {error}", path.display());
            code = ExitCode::FAILURE;
        }
    }
    if options.sail
        && let Err(error) = fixtures::animation::sail()
    {
        eprintln!("sail: {error}");
        code = ExitCode::FAILURE;
    }
    code
}
