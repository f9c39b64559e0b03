#!/usr/bin/env bash
# Tests the kernels of processors that this one is not: NEON under QEMU, WebAssembly's under Node.js. Exact
# containment, all queries on small files, and, for NEON, `verify --stress`. Ten minutes and more, so not part
# of continuous integration.
#
# Needs, and installs nothing:
#   rustup target add aarch64-unknown-linux-gnu wasm32-wasip1
#   apt-get install qemu-user gcc-aarch64-linux-gnu libc6-dev-arm64-cross nodejs     (Node.js 20 or later)
set -euo pipefail
cd "$(dirname "$0")/.."
export CARGO_TARGET_DIR=$PWD/target/other CARGO_INCREMENTAL=0

neon=aarch64-unknown-linux-gnu
qemu="qemu-aarch64 -L /usr/aarch64-linux-gnu"
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER=$qemu
cargo test --locked --target $neon -p bdtree-runtime --lib --features mmap
cargo test --locked --target $neon --manifest-path ci/miri/Cargo.toml --test undefined
cargo build --locked --target $neon -p bdtree-tools --no-default-features
for file in sphere sparse animated; do
    $qemu "$CARGO_TARGET_DIR/$neon/debug/bdtree" verify fixtures/golden/$file.bdt --stress --cases 200000
done

wasm=wasm32-wasip1
export CARGO_TARGET_WASM32_WASIP1_RUNNER="node --no-warnings $PWD/ci/wasi.mjs"
export RUSTFLAGS="-C target-feature=+simd128"
cargo test --locked --target $wasm -p bdtree-runtime --lib --features std
cargo test --locked --target $wasm --manifest-path ci/miri/Cargo.toml --test undefined
