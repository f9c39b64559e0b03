#!/usr/bin/env python3
"""docs/design/unsafe.md lists every file with `unsafe` and how often the word stands in its code, no others.

A new unsafe block, function, trait or attribute fails here until the page says why it is sound.
"""
import pathlib
import re
import subprocess
import sys

PAGE = pathlib.Path("docs/design/unsafe.md")
# The row of a file: | `path` | count | proof |
ROW = re.compile(r"^\| `([^`]+\.rs)` \| (\d+) \| \S.*\|$")


def code(text):
    """The text without comments, strings and character literals."""
    pieces = re.compile(
        r"//[^\n]*|/\*.*?\*/|r(#*)\".*?\"\1|\"(?:\\.|[^\"\\])*\"|'(?:\\.[^']*|[^'\\])'", re.DOTALL
    )
    return pieces.sub(" ", text)


def counted():
    names = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.rs"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    found = {}
    for name in names:
        path = pathlib.Path(name)
        if path.exists():
            count = len(re.findall(r"\bunsafe\b", code(path.read_text(encoding="utf-8"))))
            if count:
                found[name] = count
    return found


def main():
    found = counted()
    listed = {}
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if row := ROW.match(line):
            name, count = row[1], int(row[2])
            if name in listed:
                sys.exit(f"{PAGE}: {name} stands twice")
            listed[name] = count
    wrong = [
        f"{name}: {found.get(name, 0)} in the source, {listed.get(name, 0)} in the page"
        for name in sorted(found.keys() | listed.keys())
        if found.get(name, 0) != listed.get(name, 0)
    ]
    if wrong:
        sys.exit(f"{PAGE} does not list what is unsafe:\n" + "\n".join(wrong))
    print(f"{sum(found.values())} uses of unsafe in {len(found)} files, all listed")


if __name__ == "__main__":
    main()
