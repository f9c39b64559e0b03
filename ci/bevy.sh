#!/usr/bin/env bash
# Bevy's workspace: formatting, clippy, documentation, tests with all features, examples. Installs the Rust that
# bdtree-bevy/rust-toolchain.toml names.
set -euo pipefail
cd "$(dirname "$0")/../bdtree-bevy"
export CARGO_TARGET_DIR=$PWD/../target/bevy

channel=$(grep -Po '^channel = "\K[^"]+' rust-toolchain.toml)
rustup --quiet toolchain install "$channel" --profile minimal --component rustfmt --component clippy
# A caller's choice of tool chain must not hide the one that is promised.
export RUSTUP_TOOLCHAIN=$channel

cargo fmt -- --check
# Tests first: what they compile, the others use. Examples run as tests, so they are linked once.
cargo test --locked --all-features --lib --test all
cargo test --locked --all-features --doc
cargo clippy --locked --workspace --all-features --all-targets -- -D warnings
RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps --all-features
# Each part by itself.
for feature in picking gizmos avian rapier; do
    cargo check --locked --no-default-features --features "$feature"
done
