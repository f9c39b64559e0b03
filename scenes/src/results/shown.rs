//! What shows a row, and whether it is there.

use std::fs;
use std::path::Path;

/// What shows a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shown {
    /// A test: file, function.
    Test(&'static str, &'static str),
    /// One of our programs, by its name.
    Program(&'static str),
    /// A page with method and figures.
    Page(&'static str),
}

impl Shown {
    /// For the table, which lies in `docs/`.
    pub(super) fn markdown(self) -> String {
        match self {
            Self::Test(file, name) => format!("[`{name}`](../{file})"),
            Self::Program(name) => format!("`{name}`"),
            Self::Page(path) => {
                let path = path
                    .strip_prefix("docs/")
                    .map_or(format!("../{path}"), String::from);
                let name = path
                    .trim_end_matches(".md")
                    .rsplit('/')
                    .next()
                    .unwrap_or(&path);
                format!("[{name}]({path})")
            }
        }
    }

    /// What is wrong, if the repository at `root` does not have it.
    pub(super) fn fault(self, root: &Path) -> Option<String> {
        match self {
            Self::Test(file, name) => {
                let Ok(text) = fs::read_to_string(root.join(file)) else {
                    return Some(format!("{file}: cannot be read"));
                };
                (!is_test(&text, name)).then(|| format!("{file}: has no test {name}"))
            }
            Self::Program(name) => {
                let main = format!("scenes/src/bin/{name}/main.rs");
                (!root.join(&main).is_file()).then(|| format!("{main}: is not there"))
            }
            Self::Page(path) => {
                (!root.join(path).is_file()).then(|| format!("{path}: is not there"))
            }
        }
    }
}

/// Whether a function of that name stands right behind an attribute `#[test]`, other attributes between.
fn is_test(text: &str, name: &str) -> bool {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let head = format!("fn {name}(");
    let Some(at) = lines.iter().position(|line| line.starts_with(&head)) else {
        return false;
    };
    let above = lines[..at].iter().rev();
    above
        .take_while(|line| line.starts_with("#["))
        .any(|line| *line == "#[test]")
}

#[cfg(test)]
mod tests {
    use super::is_test;

    #[test]
    fn tests_are_told_from_other_functions() {
        let text = "#[test]\n#[ignore]\nfn one() {}\nfn two() {}\n    #[test]\n    fn three() {}\n";
        assert!(is_test(text, "one") && is_test(text, "three"));
        assert!(!is_test(text, "two") && !is_test(text, "on") && !is_test(text, "four"));
    }
}
