#!/usr/bin/env bash
# Runs all tests of the workspace. On a bare Debian machine it first installs what they need: a
# linker (gcc), python3, Mesa's software Vulkan and a virtual display, as root or through sudo; without either it prints
# the line to run.
#
# `--install` stops there. `--quick` runs the core's alone (the aim: a minute once they are compiled) and installs nothing:
# the unit tests of the runtime and the builder, every query on one small mesh beside brute force, and the bytes of all
# committed files.
set -euo pipefail
cd "$(dirname "$0")/.."

if [[ ${1:-} == --quick ]]; then
    # One set of packages, so that each is compiled with one set of features.
    core=(--locked -p bdtree-runtime -p bdtree-build -p bdtree-fixtures)
    programs=(--lib --test all --test undefined)
    start=$SECONDS
    cargo test "${core[@]}" "${programs[@]}" --no-run
    echo "compiled in $((SECONDS - start)) s"
    start=$SECONDS
    cargo test "${core[@]}" --lib
    cargo test "${core[@]}" --test all --test undefined -- \
        every_query:: manifold::overlapping broad::pairs sound_files_are_asked_everything \
        golden:: obj_fixtures::committed
    echo "quick tests passed in $((SECONDS - start)) s; scripts/test.sh runs all"
    exit
fi

missing=()
# Not in the path of every user. Read whole: a pipe that grep closes early would be an error.
libraries=$(PATH=$PATH:/usr/sbin:/sbin ldconfig -p)
command -v gcc >/dev/null || missing+=(gcc libc6-dev)
command -v python3 >/dev/null || missing+=(python3)
# Drawing and skinning are tested on the processor: lavapipe and the Vulkan loader.
compgen -G '/usr/share/vulkan/icd.d/lvp_icd*.json' >/dev/null || missing+=(mesa-vulkan-drivers)
[[ $libraries == *libvulkan.so.1* ]] || missing+=(libvulkan1)
# The viewer's window: a display in memory, and the X libraries that winit opens when it runs.
command -v Xvfb >/dev/null || missing+=(xvfb)
for library in X11:libx11-6 X11-xcb:libx11-xcb1 xcb:libxcb1 Xcursor:libxcursor1 Xi:libxi6 \
    xkbcommon:libxkbcommon0 xkbcommon-x11:libxkbcommon-x11-0; do
    [[ $libraries == *"lib${library%%:*}.so."* ]] || missing+=("${library##*:}")
done

if ((${#missing[@]})); then
    install="apt-get install -y --no-install-recommends ${missing[*]}"
    echo "missing: ${missing[*]}"
    if [[ $(id -u) == 0 ]]; then
        apt-get update && DEBIAN_FRONTEND=noninteractive $install
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
        sudo apt-get update && sudo DEBIAN_FRONTEND=noninteractive $install
    else
        echo "run as root: apt-get update && $install" >&2
        exit 1
    fi
fi
if ! command -v cargo >/dev/null; then
    echo "cargo is missing: install Rust (https://rustup.rs), version in Cargo.toml or later" >&2
    exit 1
fi

[[ ${1:-} == --install ]] || cargo test --workspace --locked "$@"
