//! Writes the golden files under `fixtures/golden`.

use std::process::ExitCode;

use bdtree_tests::golden;
use clap::Parser;

/// Writes the golden files; or compares them.
#[derive(Parser)]
struct Options {
    /// Write nothing; fail if a file differs from what would be written.
    #[arg(long)]
    check: bool,
}

fn main() -> ExitCode {
    let options = Options::parse();
    let mut code = ExitCode::SUCCESS;
    for (name, content) in golden::files() {
        let path = golden::folder().join(name);
        if options.check {
            if std::fs::read(&path).ok().as_ref() != Some(&content) {
                eprintln!("{} differs from what is made now", path.display());
                code = ExitCode::FAILURE;
            }
        } else if let Err(error) =
            std::fs::create_dir_all(golden::folder()).and_then(|()| std::fs::write(&path, &content))
        {
            eprintln!("{}: {error}", path.display());
            code = ExitCode::FAILURE;
        }
    }
    code
}
