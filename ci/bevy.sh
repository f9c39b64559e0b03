#!/usr/bin/env bash
# Bevy's workspace: formatting, clippy, documentation, tests with all features, examples. Installs the Rust that
# bdtree-bevy/rust-toolchain.toml names.
#
# `--alone`, for releases: checks each part with those features of Bevy's crates alone that a user's build has.
set -euo pipefail
cd "$(dirname "$0")/../bdtree-bevy"
export CARGO_TARGET_DIR=$PWD/../target/bevy

channel=$(grep -Po '^channel = "\K[^"]+' rust-toolchain.toml)
rustup --quiet toolchain install "$channel" --profile minimal --component rustfmt --component clippy
# A caller's choice of tool chain must not hide the one that is promised.
export RUSTUP_TOOLCHAIN=$channel

check_parts() {
    local feature
    for feature in picking gizmos avian rapier; do
        cargo check --locked --no-default-features --features "$feature" "$@"
    done
}
if [[ ${1:-} == --alone ]]; then
    check_parts
    cargo check --locked --all-features
    exit
fi

cargo fmt -- --check
# Tests first: what they compile, the others use. Examples run as tests, so they are linked once.
cargo test --locked --all-features --lib --test all
cargo test --locked --all-features --doc
cargo clippy --locked --workspace --all-features --all-targets -- -D warnings
# With the examples: the features of tests and examples then count for Bevy's crates, as for clippy, which has compiled them so.
# Other features would compile them again, once for each part: some ten minutes of processor time.
RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps --all-features --lib --examples
check_parts --lib --examples
