//! Writes the header of `bdtree-capi`, or with `--check` compares it.

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let path = root.join("bdtree-capi/include/bdtree.h");
    let made = header(&root);
    if std::env::args().nth(1).as_deref() == Some("--check") {
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        if found != made {
            eprintln!(
                "bdtree-capi/include/bdtree.h is not what its sources say: cargo run --manifest-path ci/header/Cargo.toml"
            );
            return ExitCode::FAILURE;
        }
        println!("the header is what its sources say");
        return ExitCode::SUCCESS;
    }
    std::fs::write(&path, made).expect("the header can be written");
    ExitCode::SUCCESS
}

fn header(root: &Path) -> String {
    let here = root.join("ci/header");
    let config = cbindgen::Config::from_file(here.join("cbindgen.toml")).expect("settings");
    // The files in the order in which the header is read.
    const FILES: [&str; 16] = [
        "version",
        "status",
        "types",
        "answers",
        "model",
        "names",
        "instance",
        "skeleton",
        "workspace",
        "query",
        "batch",
        "pair",
        "broad",
        "world_types",
        "world",
        "body",
    ];
    // Pointers have types of their own in Rust.
    let mut builder = cbindgen::Builder::new().with_config(config);
    for file in FILES.iter().chain(&["border"]) {
        builder = builder.with_src(root.join(format!("bdtree-capi/src/{file}.rs")));
    }
    let mut bytes = Vec::new();
    builder
        .generate()
        .expect("cbindgen reads the sources")
        .write(&mut bytes);
    let text = String::from_utf8(bytes).expect("UTF-8");
    let preamble = std::fs::read_to_string(here.join("preamble.txt")).expect("preamble.txt");
    format!("{preamble}{}", plain(&text))
}

/// Plain pointers in place of the types that Rust has for them, `BDT_OK` for `BDT_STATUS_OK`, and comments of one line.
fn plain(text: &str) -> String {
    let mut kept: Vec<String> = Vec::new();
    let mut pointers: Vec<(String, String)> = Vec::new();
    for line in text.lines() {
        match pointer(line) {
            Some(pointer) => {
                pointers.push(pointer);
                // Its comment, which is about the type that goes, and the line between the two.
                while kept.pop().is_some_and(|line| !line.starts_with("/**")) {}
                kept.pop();
            }
            None => kept.push(line.to_string()),
        }
    }
    // The longest first: `In_Handle_BdtInstance` before `Handle_BdtInstance`.
    pointers.sort_by_key(|(name, _)| std::cmp::Reverse(name.len()));
    let mut text = kept.join("\n") + "\n";
    for (name, target) in &pointers {
        text = text.replace(&format!("{name} "), &format!("{target} *"));
    }
    for (name, target) in &pointers {
        // What an array of handles points to.
        text = text.replace(&format!("{name} "), &format!("{target} *"));
    }
    // An array of handles is not changed; the handles in it may be.
    let text = text.replace("* *", "**").replace(
        "const struct BdtInstance **instances",
        "struct BdtInstance *const *instances",
    );
    short_comments(&text)
        .replace("BDT_STATUS_", "BDT_")
        .replace("`_", "`BDT_ERROR_")
}

/// Name and target of `typedef TARGET *In_Name;`.
fn pointer(line: &str) -> Option<(String, String)> {
    let rest = line.strip_prefix("typedef ")?.strip_suffix(';')?;
    let (target, name) = rest.rsplit_once('*')?;
    ["In_", "Out_", "Handle_"]
        .iter()
        .find(|kind| name.starts_with(**kind))?;
    Some((name.to_string(), target.trim_end().to_string()))
}

/// `/** text */` where a comment has one line.
fn short_comments(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let mut out = String::new();
    let mut at = 0;
    while let Some(line) = lines.get(at) {
        if line.trim() == "/**"
            && let (Some(one), Some(end)) = (lines.get(at + 1), lines.get(at + 2))
            && end.trim() == "*/"
            && line.len() + one.len() < 115
        {
            let indent = &line[..line.len() - line.trim_start().len()];
            out += &format!(
                "{indent}/** {} */\n",
                one.trim_start().trim_start_matches("* ")
            );
            at += 3;
        } else {
            out += line;
            out.push('\n');
            at += 1;
        }
    }
    out
}
