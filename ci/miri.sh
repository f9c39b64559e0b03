#!/usr/bin/env bash
# Opens, verifies and queries small files, sound and damaged, under Miri, which finds undefined behavior: reads out of
# range, of what is not initialized or misaligned, and invalid values. Installs the tool chain that it needs.
#
# First the scalar kernel, then, unless MIRI_KERNELS=scalar, that of AVX2 (its loads, stores and intrinsics). Miri maps
# no files. Arguments go to the test, e.g. a filter.
set -euo pipefail
cd "$(dirname "$0")/miri"
# A day on which all components were built: not every nightly has Miri.
chain=nightly-2026-10-30
rustup --quiet toolchain install $chain --profile minimal --component miri,rust-src
run() {
    local start=$SECONDS miri=(cargo +$chain miri test --locked --test undefined) names name jobs=()
    # An interpreter runs one thread at a time, so each test gets one of its own.
    names=$("${miri[@]}" -- --list --format terse "$@" | sed -n 's/: test$//p')
    [[ -n $names ]] || { echo "miri: no test of that name" >&2; return 1; }
    for name in $names; do
        "${miri[@]}" --quiet -- --nocapture --exact "$name" &
        jobs+=($!)
    done
    for name in "${jobs[@]}"; do wait "$name"; done
    echo "miri: $((SECONDS - start)) s with ${RUSTFLAGS:-no target features}:" $names
}
export CARGO_TARGET_DIR=../../target/miri
run "$@"
if [[ ${MIRI_KERNELS:-all} != scalar ]]; then
    CARGO_TARGET_DIR=../../target/miri-avx2 \
        RUSTFLAGS="-C target-feature=+avx2,+fma,+bmi1,+bmi2,+lzcnt,+popcnt" run "$@"
fi
