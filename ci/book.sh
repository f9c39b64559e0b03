#!/usr/bin/env bash
# Builds the book of docs/ into target/book, after checking that all links of all pages lead somewhere and that every
# page is a chapter. Installs mdBook, by source, into target/tools.
#
# `--check` builds nothing.
set -euo pipefail
cd "$(dirname "$0")/.."
python3 ci/check_links.py
python3 ci/quote_record.py --check
[[ ${1:-} == --check ]] && exit
version=0.5.4
book=target/tools/bin/mdbook
if [[ $($book --version 2>/dev/null) != "mdbook v$version" ]]; then
    # Neither optimised nor debugged: it builds one book, and optimising took half a minute of each run from nothing.
    CARGO_PROFILE_DEV_DEBUG=0 cargo install --quiet --locked --debug "mdbook@$version" --no-default-features --features search --root target/tools
fi
$book build
