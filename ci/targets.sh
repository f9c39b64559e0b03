#!/usr/bin/env bash
# What must compile, and what must not: the library for WebAssembly; runtime, builder, dynamics, command and C interface for
# Windows; the same without builder and command for macOS; everything with the oldest Rust that Cargo.toml promises; nothing
# for big-endian targets. Installs the targets and the tool chain that it needs.
set -euo pipefail
cd "$(dirname "$0")/.."
export CARGO_TARGET_DIR=$PWD/target/targets

big=s390x-unknown-linux-gnu
windows=x86_64-pc-windows-msvc
mac=aarch64-apple-darwin
rustup --quiet target add wasm32-unknown-unknown $big $windows $mac
cargo check --locked --target wasm32-unknown-unknown -p bdtree-runtime --features mint
if output=$(cargo check --locked --target $big -p bdtree-format 2>&1); then
    echo "bdtree-format compiles for $big, whose numbers are the other way round" >&2
    exit 1
elif ! grep -q 'big-endian targets are not supported' <<<"$output"; then
    echo "bdtree-format failed for another reason:" >&2
    echo "$output" >&2
    exit 1
fi

# No crate that these link compiles C code, so checking them takes no compiler of those systems. bdtree-parry, which has
# nothing of its own for a system, and what draws, whose wgpu takes minutes, are left out for their time.
core=(-p bdtree-build -p bdtree-capi -p bdtree-dynamics -p bdtree-tools --features bdtree-dynamics/threads,bdtree-runtime/mint)
cargo check --locked --target $windows "${core[@]}"
# The same code but for mapping files: what engines link is enough.
cargo check --locked --target $mac -p bdtree-capi

promised=$(grep -Po '^rust-version = "\K[^"]+' Cargo.toml)
if rustc --version | grep -q "^rustc $promised\."; then
    echo "Rust $promised is the tool chain of all other steps"
else
    rustup --quiet toolchain install "$promised" --profile minimal
    cargo "+$promised" check --locked --workspace
fi
