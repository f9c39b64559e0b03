#!/usr/bin/env bash
# The plots of docs/guide/settings.md: bakes four assets of different kinds, measures each with `bdtree report` and
# `bdtree-build --advise`, and draws docs/images/guide-*.svg. Real meshes come from the folder BDTREE_CORPUS.
set -euo pipefail
cd "$(dirname "$0")/.."
corpus=${BDTREE_CORPUS:?the folder of the test data}
out=target/guide
mkdir -p "$out"
# Not bdtree-tools/report: that is the feature of its own tests' dependency on it, and turns on nothing.
cargo build --release --locked -p bdtree-build -p bdtree-tools -p bdtree-scenes --bins --features report
bin=target/release

measure() {
    local name=$1
    shift
    echo "=== $name"
    "$bin/bdtree-build" "$@" -o "$out/$name.bdt"
    "$bin/bdtree" report "$out/$name.bdt" -o "$out/$name.html" --json >"$out/$name.report.json"
    "$bin/bdtree-build" "$@" --advise --json >"$out/$name.advice.json"
}

measure curtain "$corpus/animations/curtain_large/curtain_large_rest.obj" \
    --animation "$corpus/animations/curtain_large/curtain_large.pc2" --modes 12
measure koala "$corpus/meshes/koala.obj.gz" --modes 10
measure robot "$corpus/characters/RobotExpressive.glb"
measure chair fixtures/chair.obj --modes 10
files() {
    printf "$out/%s.$1.json\n" curtain koala robot chair
}
# shellcheck disable=SC2046 # names without spaces
"$bin/guide" --report $(files report) --advice $(files advice) --out "$out"
cp "$out"/guide-*.svg docs/images/
