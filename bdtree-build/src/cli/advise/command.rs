//! The command line that follows advice: the one that was given, with other modes and leaves.

use std::ffi::{OsStr, OsString};

use bdtree_build::advise::Advice;

/// Options of the command that was given which the advised one sets anew, with whether a value follows.
/// `--json` is how advice is told, not what is baked.
const REPLACED: [(&str, bool); 4] = [
    ("--advise", false),
    ("--json", false),
    ("--modes", true),
    ("--max-error-rel", true),
];

/// The arguments that follow `advice`, program first: `given` without what is replaced, the new options
/// behind it (before a `--`).
pub(super) fn recommended(
    given: impl IntoIterator<Item = OsString>,
    advice: &Advice,
) -> Vec<OsString> {
    let mut options: Vec<OsString> = if advice.takes_first {
        let count = advice.chosen.modes.len().to_string();
        vec!["--modes".into(), count.into()]
    } else {
        let error = advice.max_error_rel.to_string();
        vec!["--max-error-rel".into(), error.into()]
    };
    if advice.chosen.leaf_size != advice.default_leaf_size {
        let size = advice.chosen.leaf_size.to_string();
        options.extend(["--leaf-size".into(), size.into()]);
    }
    with_options(given, options)
}

fn with_options(
    given: impl IntoIterator<Item = OsString>,
    options: Vec<OsString>,
) -> Vec<OsString> {
    let mut given = given.into_iter();
    given.next();
    let mut command: Vec<OsString> = vec!["bdtree-build".into()];
    let mut rest = Vec::new();
    while let Some(part) = given.next() {
        if part == "--" {
            rest.push(part);
            rest.extend(given.by_ref());
        } else if let Some(has_value) = replaced(&part) {
            if has_value {
                given.next();
            }
        } else {
            command.push(part);
        }
    }
    command.extend(options);
    command.extend(rest);
    command
}

/// Whether an argument is an option that is set anew; then whether its value is the next argument.
fn replaced(part: &OsStr) -> Option<bool> {
    let bytes = part.as_encoded_bytes();
    REPLACED.iter().find_map(|(name, has_value)| {
        let behind = bytes.strip_prefix(name.as_bytes())?;
        match behind {
            [] => Some(*has_value),
            [b'=', ..] => Some(false),
            _ => None,
        }
    })
}

/// The arguments as one line that a shell (POSIX, but for names with control characters or what is not UTF-8,
/// which need bash) reads back as they are.
pub(super) fn shell(arguments: &[OsString]) -> String {
    let parts: Vec<String> = arguments.iter().map(|part| quoted(part)).collect();
    parts.join(" ")
}

fn quoted(part: &OsStr) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    match part.to_str() {
        Some(text) if !text.is_empty() && text.chars().all(is_plain) => text.to_string(),
        Some(text) if !text.chars().any(char::is_control) => {
            format!("'{}'", text.replace('\'', r"'\''"))
        }
        _ => {
            let escaped = part.as_encoded_bytes().iter().map(|byte| match byte {
                b'\'' | b'\\' => format!("\\{}", char::from(*byte)),
                b' '..=b'~' => char::from(*byte).to_string(),
                _ => format!("\\x{byte:02x}"),
            });
            format!("$'{}'", escaped.collect::<String>())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(given: &[&str]) -> String {
        let given = given.iter().map(OsString::from);
        shell(&with_options(given, vec!["--modes".into(), "3".into()]))
    }

    #[test]
    fn what_was_given_stays() {
        for (given, expected) in [
            (
                &["x", "a.obj", "--advise", "--json"][..],
                "bdtree-build a.obj --modes 3",
            ),
            (
                &[
                    "x",
                    "--advise",
                    "--modes",
                    "9",
                    "a b.obj",
                    "--max-error-rel=0.1",
                    "-o",
                    "it's.bdt",
                ],
                r"bdtree-build 'a b.obj' -o 'it'\''s.bdt' --modes 3",
            ),
            (
                &[
                    "x",
                    "--modes=4",
                    "--leaf-size",
                    "2",
                    "--advise",
                    "--",
                    "--advise",
                ],
                "bdtree-build --leaf-size 2 --modes 3 -- --advise",
            ),
            (
                &[
                    "x",
                    "--advise",
                    "--poisson",
                    "-0.2",
                    "a.obj",
                    "--fix",
                    "xyz:0,0,0,1,1,1",
                ],
                "bdtree-build --poisson -0.2 a.obj --fix xyz:0,0,0,1,1,1 --modes 3",
            ),
            (
                &["x", "--advise", "a\n.obj", ""],
                r"bdtree-build $'a\x0a.obj' '' --modes 3",
            ),
        ] {
            assert_eq!(changed(given), expected);
        }
    }
}
