#!/usr/bin/env python3
"""Every relative link in the repository's Markdown files leads to a file."""
import pathlib
import re
import subprocess
import sys

files = subprocess.run(["git", "ls-files", "*.md"], capture_output=True, text=True, check=True)
broken = []
for name in files.stdout.split():
    page = pathlib.Path(name)
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        if "://" not in target and not (page.parent / target).exists():
            broken.append(f"{page}: {target}")
sys.exit("broken links:\n" + "\n".join(broken) if broken else 0)
