#!/usr/bin/env python3
"""What every published crate is packaged with: metadata for its page and for docs.rs, a README, both licences, every file
below src/, and nothing large. Packages without compiling; `--verify` compiles what is packaged as well, which takes
minutes."""
import json
import os
import pathlib
import re
import subprocess
import sys
import tarfile

# Bevy's workspace is packaged by itself.
WORKSPACES = [".", "bdtree-bevy"]
WANTED = ["description", "license", "documentation", "readme", "keywords", "categories", "rust_version"]
LARGEST = 500_000
# What a package leaves out on purpose: tests and examples need files that are not published.
LEFT_OUT = re.compile(r"warning: ignoring (test|example) `\w+` as `(tests|examples)/[\w/]+\.rs` is not included")


def crates(folder):
    command = ["cargo", "metadata", "--locked", "--no-deps", "--format-version", "1"]
    text = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout
    return json.loads(text)["packages"]


def package(folder, published, options):
    """Packages the crates of a workspace; returns cargo's warnings."""
    command = ["cargo", "package", "--allow-dirty", *options]
    for crate in published:
        command += ["-p", crate["name"]]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if run.returncode:
        sys.exit(f"{' '.join(command)}\n{run.stderr}")
    return [line for line in run.stderr.splitlines() if line.startswith("warning") and not LEFT_OUT.match(line)]


def faults(crate, size, names):
    """What is wrong with a package of these files."""
    root = pathlib.Path(crate["manifest_path"]).parent
    for field in WANTED:
        if not crate[field]:
            yield f"no {field}"
    if len(crate["keywords"]) > 5 or len(crate["categories"]) > 5:
        yield "more than five keywords or categories"
    for dependency in crate["dependencies"]:
        if dependency.get("path") and dependency["kind"] != "dev" and dependency["req"] == "*":
            yield f"depends on {dependency['name']} without a version"
    has_library = any("lib" in target["kind"] for target in crate["targets"])
    programs = any("bin" in target["kind"] for target in crate["targets"])
    if has_library and not programs and crate["name"] not in ("bdtree-npy", "bdtree-output", "bdtree-render"):
        if not (crate["metadata"] or {}).get("docs", {}).get("rs"):
            yield "no [package.metadata.docs.rs]"
    sources = subprocess.run(["git", "ls-files", "src"], cwd=root, capture_output=True, text=True, check=True)
    needed = {"README.md", "LICENSE-MIT", "LICENSE-APACHE", "Cargo.toml", *sources.stdout.split()}
    for name in sorted(needed - names):
        yield f"{name} is not packaged"
    if size > LARGEST:
        yield f"{size} bytes, more than {LARGEST}"


def main():
    verify = sys.argv[1:] == ["--verify"]
    options = [] if verify else ["--no-verify", "--exclude-lockfile"]
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", "target"))
    wrong, count = [], 0
    for folder in WORKSPACES:
        published = [crate for crate in crates(folder) if crate["publish"] != []]
        # Until what Bevy's crate depends on is on a registry, cargo can neither lock nor compile its package.
        options_here = ["--no-verify", "--exclude-lockfile"] if folder != "." else options
        wrong += package(folder, published, options_here)
        for crate in published:
            path = target / "package" / f"{crate['name']}-{crate['version']}.crate"
            with tarfile.open(path) as archive:
                names = {name.split("/", 1)[1] for name in archive.getnames()}
            size = path.stat().st_size
            wrong += [f"{crate['name']}: {fault}" for fault in faults(crate, size, names)]
            print(f"{size:8} bytes {len(names):4} files  {crate['name']}")
            count += 1
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"{count} crates can be packaged" + ("" if verify else "; what is packaged was not compiled"))


if __name__ == "__main__":
    main()
