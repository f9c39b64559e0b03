#!/usr/bin/env python3
"""Licences and origins of what is linked: every dependency has an allowed licence and comes from
crates.io, what is published depends on nothing of ours that is not, and every Cargo.lock is committed,
complete and current. Needs no network and no other tool."""
import json
import pathlib
import re
import subprocess
import sys
import tomllib

CRATES_IO = "registry+https://github.com/rust-lang/crates.io-index"
# The same licences stand in deny.toml.
ALLOWED = {"MIT", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "ISC", "Unicode-3.0", "Zlib"}
# Workspaces of their own: fuzzer, Miri, the proof that nothing allocates, what writes the C header. Nothing of them is
# delivered.
TOOL_WORKSPACES = ["fuzz", "ci/miri", "ci/no-alloc", "ci/header"]
# Workspaces of their own that need another Rust. What they link, programs of Bevy link anyway.
ENGINE_WORKSPACES = ["bdtree-bevy"]
# The extension for Godot, a workspace of its own: nothing else links its binding, which is under the MPL.
GODOT_WORKSPACES = ["bdtree-godot"]
ALLOWED_GODOT = {"MPL-2.0"}
# Of encase, which Bevy's renderer has, and of notify, with which examples and tests watch files.
ALLOWED_ENGINES = {"MIT-0", "CC0-1.0"}
# libFuzzer; cbindgen.
ALLOWED_TOOLS = {"NCSA", "MPL-2.0"}
# Fonts are linked as data; the viewer alone has them (THIRD-PARTY-NOTICES.md).
FONTS = {"epaint_default_fonts": {"OFL-1.1", "Ubuntu-font-1.0"}}
# The library itself links nothing but these; macros run when it is built.
LIBRARY = {"bdtree-runtime", "bdtree-format"}
ALLOWED_LIBRARY = {"MIT", "Apache-2.0"}


def satisfied(expression, allowed):
    """Whether an SPDX expression can be met with the allowed licences."""
    tokens = re.findall(r"\(|\)|[^\s()]+", expression.replace("/", " OR "))
    at = 0

    def either():
        nonlocal at
        result = both()
        while at < len(tokens) and tokens[at].upper() == "OR":
            at += 1
            result = both() or result
        return result

    def both():
        nonlocal at
        result = one()
        while at < len(tokens) and tokens[at].upper() == "AND":
            at += 1
            result = one() and result
        return result

    def one():
        nonlocal at
        if at >= len(tokens):
            raise ValueError(f"not an SPDX expression: {expression}")
        token = tokens[at]
        at += 1
        if token == "(":
            result = either()
            if at >= len(tokens) or tokens[at] != ")":
                raise ValueError(f"not an SPDX expression: {expression}")
            at += 1
            return result
        if at + 1 < len(tokens) and tokens[at].upper() == "WITH":
            token = f"{token} WITH {tokens[at + 1]}"
            at += 2
        return token in allowed

    result = either()
    if at != len(tokens):
        raise ValueError(f"not an SPDX expression: {expression}")
    return result


def reached(nodes, roots, kinds, leave_out=frozenset()):
    """Ids of all packages that the roots depend on, whatever the features and targets."""
    found, left = set(), list(roots)
    while left:
        package = left.pop()
        if package in found or package in leave_out:
            continue
        found.add(package)
        for dependency in nodes[package]["deps"]:
            if any(kind["kind"] in kinds for kind in dependency["dep_kinds"]):
                left.append(dependency["pkg"])
    return found


def read(folder, wrong):
    """What cargo says of the workspace in a folder, all features on; faults of its Cargo.lock."""
    lock_file = pathlib.Path(folder) / "Cargo.lock"
    tracked = subprocess.run(
        ["git", "ls-files", lock_file], capture_output=True, text=True, check=True
    )
    if not tracked.stdout.strip():
        wrong.append(f"{lock_file} is not committed")
    # --locked: fails where Cargo.lock is not what the manifests ask for.
    metadata = subprocess.run(
        ["cargo", "metadata", "--locked", "--all-features", "--format-version", "1"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    if metadata.returncode:
        sys.exit(f"cargo metadata --locked, in {folder}:\n{metadata.stderr}")
    lock = tomllib.loads(lock_file.read_text(encoding="utf-8"))
    for entry in lock["package"]:
        if "source" in entry and "checksum" not in entry:
            wrong.append(f"{lock_file}: {entry['name']} {entry['version']} has no checksum")
    return json.loads(metadata.stdout)


def check(package, allowed, wrong):
    """Origin and licence of one package."""
    name = f"{package['name']} {package['version']}"
    if package["source"] != CRATES_IO:
        wrong.append(f"{name}: from {package['source'] or 'a path'}, not from crates.io")
    licence = package["license"]
    if not licence:
        wrong.append(f"{name}: states no licence")
    elif not satisfied(licence, allowed):
        wrong.append(f"{name}: licence {licence} is not one of those allowed")


def published(packages, nodes, members, wrong):
    """Names of our crates without `publish = false`; faults of those that need one with it, tests aside."""
    names = {name for name, id in members.items() if packages[id]["publish"] != []}
    for name in sorted(names):
        needed = reached(nodes, [members[name]], {None, "build"}) & set(members.values())
        for other in sorted({packages[id]["name"] for id in needed} - names):
            wrong.append(f"{name} is published and depends on {other}, which is not")
    return names


def main():
    wrong = []
    metadata = read(".", wrong)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    members = {packages[id]["name"]: id for id in metadata["workspace_members"]}
    macros = {
        id
        for id, package in packages.items()
        if any("proc-macro" in target["kind"] for target in package["targets"])
    }
    ours = published(packages, nodes, members, wrong)
    shipped = reached(nodes, [members[name] for name in ours], {None, "build"})
    library = reached(nodes, [members[name] for name in LIBRARY], {None}, macros)
    foreign = set(packages) - set(metadata["workspace_members"])
    for id in foreign:
        package = packages[id]
        fonts = FONTS.get(package["name"], set())
        check(package, ALLOWED_LIBRARY if id in library else ALLOWED | fonts, wrong)

    def others(folders, allowed):
        """Packages of workspaces of their own."""
        found = set()
        for folder in folders:
            for package in read(folder, wrong)["packages"]:
                # Without a source: ours, in another workspace.
                if package["source"] is not None:
                    check(package, allowed, wrong)
                    found.add(package["id"])
        return found - foreign

    tools = others(TOOL_WORKSPACES, ALLOWED | ALLOWED_TOOLS)
    engines = others(ENGINE_WORKSPACES, ALLOWED | ALLOWED_ENGINES)
    godot = others(GODOT_WORKSPACES, ALLOWED | ALLOWED_GODOT)
    if wrong:
        sys.exit("\n".join(wrong))
    print(
        f"{len(foreign)} packages, {len(foreign & shipped)} of them in what is delivered and "
        f"{len(foreign & library)} in the library, {len(tools)} more in tools, {len(engines)} in Bevy's workspace, {len(godot)} in Godot's: "
        f"licences allowed, all from crates.io; {len(ours)} crates of ours can be published; every Cargo.lock is current"
    )


if __name__ == "__main__":
    main()
