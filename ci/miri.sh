#!/usr/bin/env bash
# Opens, verifies and queries small files, sound and damaged, under Miri, which finds undefined behaviour:
# reads out of range, of what is not initialised or misaligned, and invalid values. First the scalar
# kernel, then that of AVX2 (its loads, stores and intrinsics). Miri maps no files.
#
# Needs the nightly toolchain with the components miri and rust-src, and installs nothing:
#   rustup toolchain install nightly --component miri,rust-src
# Arguments go to the test, e.g. a filter.
set -euo pipefail
cd "$(dirname "$0")/miri"
if ! cargo +nightly miri --version >/dev/null 2>&1; then
    echo "Miri is not there: no check for undefined behaviour. See ci/miri.sh for what to install." >&2
    [[ -n ${MIRI_OPTIONAL:-} ]] && exit 0
    exit 1
fi
run() {
    local start=$SECONDS
    cargo +nightly miri test --locked --test undefined -- --nocapture "$@"
    echo "miri: $((SECONDS - start)) s with ${RUSTFLAGS:-no target features}"
}
export CARGO_TARGET_DIR=../../target/miri
run "$@"
CARGO_TARGET_DIR=../../target/miri-avx2 \
    RUSTFLAGS="-C target-feature=+avx2,+fma,+bmi1,+bmi2,+lzcnt,+popcnt" run "$@"
