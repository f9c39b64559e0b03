#!/usr/bin/env bash
# Proves that bdtree-runtime and bdtree-dynamics without features need neither std nor an allocator: always for the
# host, and for a microcontroller (thumbv7em) when that target is or can be installed.
set -euo pipefail
cd "$(dirname "$0")/no-alloc"
export CARGO_TARGET_DIR=../../target/no-alloc

build() { cargo build --locked "$@"; }

build
library=$CARGO_TARGET_DIR/debug/libno_alloc.a
symbols=$(nm "$library" 2>/dev/null)
grep -q ' T .*rust_begin_unwind' <<<"$symbols" || {
    echo "nm does not show the panic handler of $library: the check below would prove nothing" >&2
    exit 1
}
if grep -E 'rust_alloc|rust_realloc|rdl_alloc|rg_alloc' <<<"$symbols"; then
    echo "bdtree-runtime or bdtree-dynamics refers to an allocator" >&2
    exit 1
fi
if output=$(build --features counter-example 2>&1); then
    echo "the counter-example was built: this proof cannot fail" >&2
    exit 1
elif ! grep -q 'no global memory allocator found' <<<"$output"; then
    echo "the counter-example failed for another reason:" >&2
    echo "$output" >&2
    exit 1
fi
echo "no-alloc: host build done; the counter-example is refused"

target=thumbv7em-none-eabihf
if command -v rustup >/dev/null && timeout 60 rustup target add "$target" >/dev/null 2>&1; then
    build --target "$target"
    echo "no-alloc: $target build done"
else
    echo "no-alloc: $target not available here, host build only"
fi
