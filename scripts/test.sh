#!/usr/bin/env bash
# Runs all tests of the workspace. On a bare Debian machine it first installs what they need: a
# linker (gcc), python3, Mesa's software Vulkan and a virtual display, as root or through sudo; without either it prints
# the line to run.
set -euo pipefail
cd "$(dirname "$0")/.."

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

cargo test --workspace --locked "$@"
