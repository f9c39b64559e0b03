#!/usr/bin/env python3
"""Every relative link in the repository's Markdown files leads to a file, and to a heading of it where it names one;
every page of docs/ is a chapter of the book."""
import pathlib
import re
import subprocess
import sys

LINK = re.compile(r"\]\(([^)\s]+)\)")


def headings(page):
    """The anchors of a page's headings, as GitHub and mdBook form them."""
    anchors, counts, is_code = set(), {}, False
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.lstrip().startswith("```"):
            is_code = not is_code
        match = re.match(r"#{1,6}\s+(.*?)\s*#*$", line)
        if is_code or not match:
            continue
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", match.group(1)).lower()
        anchor = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
        count = counts.get(anchor, 0)
        counts[anchor] = count + 1
        anchors.add(f"{anchor}-{count}" if count else anchor)
    return anchors


def without_code(text):
    text = re.sub(r"```.*?```", "", text, flags=re.S)
    return re.sub(r"`[^`\n]*`", "", text)


listed = subprocess.run(["git", "ls-files", "*.md"], capture_output=True, text=True, check=True)
pages = [pathlib.Path(name) for name in listed.stdout.split()]
broken = []
for page in pages:
    for link in LINK.findall(without_code(page.read_text(encoding="utf-8"))):
        if "://" in link or link.startswith("mailto:"):
            continue
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        if not target.exists():
            broken.append(f"{page}: no file {link}")
        elif anchor and target.suffix == ".md" and anchor not in headings(target):
            broken.append(f"{page}: no heading {link}")
summary = pathlib.Path("docs/SUMMARY.md")
chapters = {(summary.parent / link).resolve() for link in LINK.findall(summary.read_text(encoding="utf-8"))}
for page in pages:
    if page.parts[0] == "docs" and page != summary and page.resolve() not in chapters:
        broken.append(f"{page}: no chapter of {summary}")
sys.exit("\n".join(broken) if broken else 0)
