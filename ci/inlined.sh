#!/usr/bin/env bash
# Checks that the runtime's vector arithmetic is inlined where it is used. In a closure that is not itself inlined it is
# not: each operation becomes a call, and what the closure is part of takes several times longer, with the same answers.
# So no other check would notice.
set -euo pipefail
cd "$(dirname "$0")/.."

libraries=(target/debug/deps/libbdtree_runtime-*.rlib)
[[ -e ${libraries[0]} ]] || { echo "no library at ${libraries[0]}: build first" >&2; exit 1; }
for library in "${libraries[@]}"; do
    symbols=$(nm -C "$library" 2>/dev/null)
    grep -q 'avx8::run_avx2\|neon' <<<"$symbols" || {
        echo "nm shows no kernels in $library: the check below would prove nothing" >&2
        exit 1
    }
    # Without optimised assertions loads and stores are calls; what detects the processor's features is one anyway.
    if grep -E ' [tTwW] .*core_arch::' <<<"$symbols" | grep -vE '::_(mm[0-9]*_(load|store)|xgetbv|__cpuid)'; then
        echo "$library: vector arithmetic that is called instead of inlined (above)" >&2
        exit 1
    fi
done
echo "all vector arithmetic is inlined"
