#!/usr/bin/env bash
# The crates that are published can be packaged: what ci/check_packages.py asks of each, and how the interface differs from
# that of the last tag, if there is one. Nothing is compiled where there is none.
set -euo pipefail
cd "$(dirname "$0")/.."
export CARGO_TARGET_DIR=$PWD/target/packages
python3 ci/check_packages.py

if tag=$(git describe --tags --abbrev=0 --match 'v*' 2>/dev/null); then
    version=0.51.0
    tools=$PWD/target/tools
    checks=$tools/bin/cargo-semver-checks
    if [[ $($checks --version 2>/dev/null) != "cargo-semver-checks $version" ]]; then
        CARGO_PROFILE_DEV_DEBUG=0 cargo install --quiet --locked --debug "cargo-semver-checks@$version" --root "$tools"
    fi
    "$checks" semver-checks --workspace --baseline-rev "$tag" \
        --exclude bdtree-fixtures --exclude bdtree-scenes --exclude bdtree-tests
else
    echo "no tag v*: there is no released interface to compare with (cargo semver-checks did not run)"
fi
