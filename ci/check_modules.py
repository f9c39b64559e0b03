#!/usr/bin/env python3
"""Every Rust file is compiled, and every file of tests tests something.

A file that no `mod` line reaches is silent: its tests never run and its mistakes never show. This walks from the
targets that Cargo knows through `mod` declarations and `include!`, and fails for each file under a crate's `src/` or
`tests/` that it does not meet, and for each file under `tests/` that has no test, declares no module and is used by
no other file. `--self-test` tries that on copies of the repository's own tests with a line taken out.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

PIECES = re.compile(
    r"//[^\n]*|/\*.*?\*/|r(#*)\".*?\"\1|b?\"(?:\\.|[^\"\\])*\"|'(?:\\.[^']*|[^'\\])'", re.DOTALL
)
# A module in a file or in braces, a brace, an included file, the path of the module that follows.
TOKEN = re.compile(
    r'#\[path\s*=\s*"(?P<path>[^"]+)"\]'
    r'|\binclude!\(\s*"(?P<include>[^"]+)"\s*\)'
    r"|\bmod\s+(?:r#)?(?P<name>\w+)\s*(?P<kind>[;{])"
    r"|(?P<brace>[{}])"
)
# Not inside of a word, and not in an attribute that names a file: those strings are read.
NAMES_FILE = re.compile(r'(#\[path\s*=\s*|\binclude!\(\s*)$')


def code(text):
    """The text without comments, strings and character literals, but for strings that name source files."""

    def blank(piece):
        if piece[0].startswith('"') and NAMES_FILE.search(text, max(0, piece.start() - 80), piece.start()):
            return piece[0]
        return " "

    return PIECES.sub(blank, text)


def files_named_by(path, is_root):
    """The files that the source file `path` makes part of its crate. A crate's root and `mod.rs` look beside
    themselves, `x.rs` in the folder `x`."""
    looks_beside = is_root or path.name == "mod.rs"
    folder = path.parent if looks_beside else path.parent / path.stem
    text = code(path.read_text(encoding="utf-8"))
    blocks = []  # names of modules in braces, None for other braces
    given = None
    for token in TOKEN.finditer(text):
        inline = [name for name in blocks if name]
        if token["path"]:
            given = token["path"]
            continue
        if token["include"]:
            yield path.parent / token["include"], False
        elif token["brace"] == "{":
            blocks.append(None)
        elif token["brace"] == "}":
            blocks.pop()
        elif token["kind"] == "{":
            blocks.append(token["name"])
        elif given:
            # A path attribute counts from the file's own folder, inside of braces from the module's.
            yield (folder.joinpath(*inline) if inline else path.parent) / given, True
        else:
            place = folder.joinpath(*inline)
            yield from (
                (place / name, False)
                for name in (f"{token['name']}.rs", f"{token['name']}/mod.rs")
                if (place / name).exists()
            )
        given = None


def reached(roots):
    """All source files that compile with the target roots."""
    found = set()
    waiting = [(root, True) for root in roots]
    while waiting:
        path, is_root = waiting.pop()
        path = path.resolve()
        if path not in found and path.exists():
            found.add(path)
            # A file that a path attribute names looks for its modules beside itself, as a root does.
            waiting.extend(files_named_by(path, is_root))
    return found


def wrong(roots, folders, files):
    """What is wrong with `files`, of which those below `folders` hold tests."""
    compiled = reached(roots)
    lines = [f"{f}: no `mod` line of any target leads here" for f in files if f not in compiled]
    tests = [f for f in files if f in compiled and any(f.is_relative_to(t) for t in folders)]
    texts = {f: code(f.read_text(encoding="utf-8")) for f in files}
    for f in tests:
        text = texts[f]
        name = f.parent.name if f.name in ("mod.rs", "main.rs") else f.stem
        used = re.compile(rf"\b{name}::|\b(?:super|crate)::(?:\w+::)*(?:{name}\b|{{[^;]*\b{name}\b)")
        has_part = re.search(r"#\[test\]", text) or re.search(r"\bmod\s+\w+\s*;", text)
        if not has_part and not any(used.search(t) for other, t in texts.items() if other != f):
            lines.append(f"{f}: no test, and no other file uses it")
    return lines


def repository():
    """Roots of all targets, folders of tests, and all source files below `src/` and `tests/` of a crate."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.rs", "*Cargo.toml"],
        capture_output=True, text=True, check=True,
    ).stdout.split()
    paths = [p for name in listed if (p := pathlib.Path(name).resolve()).exists()]
    roots, crates = set(), set()
    for manifest in (p for p in paths if p.name == "Cargo.toml"):
        if manifest.parent in crates:
            continue
        command = ["cargo", "metadata", "--offline", "--no-deps", "--format-version", "1"]
        out = subprocess.run([*command, "--manifest-path", manifest], capture_output=True, text=True, check=True)
        for package in json.loads(out.stdout)["packages"]:
            crates.add(pathlib.Path(package["manifest_path"]).parent.resolve())
            roots |= {pathlib.Path(target["src_path"]).resolve() for target in package["targets"]}
    tests = {crate / "tests" for crate in crates}
    inside = tests | {crate / "src" for crate in crates}
    files = [p for p in paths if p.suffix == ".rs" and any(p.is_relative_to(f) for f in inside)]
    return roots, tests, files


def self_test():
    """Copies of real tests, whole and with one thing wrong."""

    def complaints(change):
        with tempfile.TemporaryDirectory() as name:
            tests = pathlib.Path(name).resolve() / "tests"
            shutil.copytree("bdtree-runtime/tests", tests)
            change(tests)
            roots = {tests / "all.rs", tests / "allocation.rs", tests / "errors/main.rs", tests / "undefined.rs"}
            found = wrong(roots, {tests}, sorted(tests.rglob("*.rs")))
            return sorted(str(pathlib.Path(line.split(":")[0]).relative_to(tests)) for line in found)

    def without(file, line, instead=""):
        def change(tests):
            text = (tests / file).read_text(encoding="utf-8")
            assert text.count(line) == 1, f"{file}: {line!r}"
            (tests / file).write_text(text.replace(line, instead), encoding="utf-8")
        return change

    def nested(tests):
        # Modules in braces, in a folder beside their file, by a path attribute and by inclusion.
        with (tests / "all.rs").open("a", encoding="utf-8") as file:
            file.write('mod outer;\n#[cfg(test)]\n#[path = "else/where.rs"]\nmod by_path;\ninclude!("part.rs");\n')
        for name, text in {
            "outer.rs": "mod inline { pub fn f() -> char { '{' } mod inner; }",
            "outer/inline/inner.rs": "mod deepest;",
            "outer/inline/inner/deepest.rs": "#[test] fn t() {}",
            "else/where.rs": "mod beside;",
            "else/beside/mod.rs": "#[test] fn t() {}",
            "part.rs": "#[test] fn u() {}",
            "outer/lost.rs": "#[test] fn v() {}",
        }.items():
            (tests / name).parent.mkdir(parents=True, exist_ok=True)
            (tests / name).write_text(text, encoding="utf-8")

    def empty(tests):
        (tests / "queries.rs").write_text("// #[test]\nconst TEXT: &str = \"#[test]\";\n", encoding="utf-8")

    expected = [
        ("as it is", lambda tests: None, []),
        ("a line is missing", without("all.rs", "mod queries;\n"), ["queries.rs"]),
        ("a line is a comment", without("all.rs", "mod queries;", "// mod queries;"), ["queries.rs"]),
        ("a line is a string", without("all.rs", "mod queries;", 'const S: &str = "mod queries;";'), ["queries.rs"]),
        ("a program's line is missing", without("errors/main.rs", "mod seen;\n"), ["errors/seen.rs"]),
        ("a file without tests", empty, ["queries.rs"]),
        ("all kinds of modules", nested, ["outer/lost.rs"]),
    ]
    for name, change, wanted in expected:
        if (found := complaints(change)) != wanted:
            sys.exit(f"{name}: {found} are complained of, not {wanted}")
    print(f"{len(expected)} cases are judged as they should be")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    roots, tests, files = repository()
    here = pathlib.Path.cwd().resolve()
    if lines := wrong(roots, tests, files):
        sys.exit("\n".join(line.replace(f"{here}/", "") for line in lines))
    print(f"{len(files)} source files are compiled, from {len(roots)} targets")


if __name__ == "__main__":
    main()
