#!/usr/bin/env bash
# The readers that format-spec/bdt.ksy gives in Python and JavaScript, held against each other, against SPEC.md and
# against `bdtree info`, on every golden file (tests/kaitai/check.py). Installs the compiler and both runtime libraries into
# target/kaitai; where Node.js, npm or pip is missing, from Debian's packages, as root or through sudo.
set -euo pipefail
cd "$(dirname "$0")/.."

missing=()
command -v npm >/dev/null || missing+=(nodejs npm)
command -v python3 >/dev/null || missing+=(python3)
python3 -m pip --version >/dev/null 2>&1 || missing+=(python3-pip)
if ((${#missing[@]})); then
    echo "missing: ${missing[*]}"
    root=()
    [[ $(id -u) == 0 ]] || root=(sudo)
    "${root[@]}" apt-get update
    "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"
fi

tools=$PWD/target/kaitai
packages="kaitai-struct-compiler@0.11.0 kaitai-struct@0.11.0 js-yaml@4.1.0 kaitaistruct==0.11"
if [[ $(cat "$tools/packages" 2>/dev/null) != "$packages" ]]; then
    rm -rf "$tools"
    mkdir -p "$tools/python" "$tools/readers"
    # shellcheck disable=SC2086
    npm install --prefix "$tools" --no-package-lock --no-audit --no-fund --silent ${packages% *}
    python3 -m pip install --quiet --disable-pip-version-check --target "$tools/python" "${packages##* }"
    echo "$packages" >"$tools/packages"
fi
export NODE_PATH=$tools/node_modules PYTHONPATH=$tools/python PYTHONDONTWRITEBYTECODE=1
node tests/kaitai/compile.js format-spec/bdt.ksy "$tools/readers" python javascript

# The tests have built it; built alone it would be compiled with other features.
[[ -x target/debug/bdtree ]] || cargo build --locked -p bdtree-tools --bin bdtree
python3 tests/kaitai/check.py "$tools/readers" target/debug/bdtree
