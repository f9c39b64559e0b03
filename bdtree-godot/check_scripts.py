#!/usr/bin/env python3
"""The demo and the page's scripts are GDScript, and what they call and read of a collider is what src/node.rs offers, with as
many arguments; the page's tables list all of it. Needs gdtoolkit, which parses."""
import pathlib
import re
import sys

from gdtoolkit.parser import parser

PAGE = pathlib.Path("../docs/guide/godot.md")
NODE = pathlib.Path("src/node.rs").read_text(encoding="utf-8")

# Names with their number of arguments; properties have none.
functions = {
    name: len([piece for piece in arguments.split(",") if ":" in piece])
    for name, arguments in re.findall(r"#\[func\]\s*fn (\w+)\(\s*&(?:mut )?self,?([^)]*)\)", NODE)
}
properties = set(re.findall(r"#\[export[^\n]*\n(?:\s*#\[[^\n]*\n)*\s*(\w+): ", NODE))
signals = set(re.findall(r"#\[signal\]\s*fn (\w+)", NODE))
setters = {f"set_{name}" for name in properties}
# Of Node3D and Object.
INHERITED = {"get_path_to", "global_transform"}


def arguments(text, start):
    """How many arguments a call has whose parenthesis opens at `start`."""
    depth, count, has_any = 0, 0, False
    for character in text[start:]:
        if character in "([{":
            depth += 1
        elif character in ")]}":
            depth -= 1
            if depth == 0:
                return count + has_any
        elif character == "," and depth == 1:
            count += 1
        if depth and not character.isspace() and character != "(":
            has_any = True
    raise ValueError("a call without an end")


def check(name, text):
    parser.parse(text)
    found = 0
    for use in re.finditer(r"\b(?:collider|\$BdtCollider3D)\.(\w+)(\()?", text):
        found += 1
        word, is_call = use[1], use[2]
        if word in INHERITED or (not is_call and word in properties | signals | functions.keys()):
            continue
        if not is_call or word not in functions:
            sys.exit(f"{name}: BdtCollider3D has no {word}")
        count = arguments(text, use.end() - 1)
        if count != functions[word]:
            sys.exit(f"{name}: {word} takes {functions[word]} arguments, not {count}")
    if not found:
        sys.exit(f"{name}: nothing is asked of a collider")


def main():
    page = PAGE.read_text(encoding="utf-8")
    scripts = re.findall(r"^```gdscript\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    assert scripts, PAGE
    for number, script in enumerate(scripts):
        check(f"{PAGE}, script {number}", script)
    demo = pathlib.Path("addon/demo/demo.gd")
    check(demo, demo.read_text(encoding="utf-8"))
    for word in (functions.keys() - setters) | properties | signals:
        if not re.search(rf"^\| `{word}\b", page, re.MULTILINE):
            sys.exit(f"{PAGE} has no row of {word}")
    print(f"{len(scripts) + 1} scripts are GDScript; {len(functions)} methods are known and listed")


if __name__ == "__main__":
    main()
