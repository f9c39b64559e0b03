#!/usr/bin/env bash
# Godot's workspace: formatting, clippy, unit tests, the library and its zip file; scripts in GDScript parse and call what the
# node has. No registry has a Godot 4 to run them with. Installs a parser of GDScript into target/gdscript.
set -euo pipefail
cd "$(dirname "$0")/../bdtree-godot"
root=$(cd .. && pwd)
export CARGO_TARGET_DIR=$root/target/godot

mkdir -p "$CARGO_TARGET_DIR"
cargo fmt -- --check
# Clippy while it compiles: a run of its own would check all of Godot's classes once more, which is most of the work.
export RUSTC_WORKSPACE_WRAPPER=clippy-driver
for what in "test --lib" build; do
    # Words of a command line.
    cargo $what --locked 2>&1 | tee "$CARGO_TARGET_DIR/ci.log"
    if grep '^warning' "$CARGO_TARGET_DIR/ci.log"; then exit 1; fi
done

library=$CARGO_TARGET_DIR/debug/libbdtree_godot.so
out=$CARGO_TARGET_DIR/pack
rm -rf "$out"
for name in first second; do
    ./pack.sh "$library" "$out/$name.zip"
done
cmp "$out/first.zip" "$out/second.zip"
(cd "$out" && python3 -m zipfile -e first.zip project)
addon=$out/project/addons/bdtree
grep -Po '"res://\K[^"]+' "$addon/bdtree.gdextension" "$addon/demo/demo.tscn" -h | while read -r file; do
    [[ -e $out/project/$file ]] || { echo "$file is not in the archive" >&2; exit 1; }
done
entry=$(grep -Po '^entry_symbol = "\K[^"]+' "$addon/bdtree.gdextension")
packed=$addon/linux.x86_64/libbdtree_godot.so
nm -D --defined-only "$packed" | grep -q " T $entry\$" || { echo "the library has no $entry" >&2; exit 1; }
foreign=$(readelf -d "$packed" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' |
    grep -vE '^(libc\.so\.6|libm\.so\.6|libgcc_s\.so\.1|ld-linux.*)$' || true)
[[ -z $foreign ]] || { echo "the library needs $foreign" >&2; exit 1; }
# All that it needs of other libraries is there.
python3 -c 'import ctypes, os, sys; ctypes.CDLL(sys.argv[1], os.RTLD_NOW)' "$packed"
grep -q '^godot-core .*MPL-2.0' "$addon/LICENSES.txt"

tools=$root/target/gdscript
package=gdtoolkit==4.5.0
if [[ $(cat "$tools/package" 2>/dev/null) != "$package" ]]; then
    python3 -m pip --version >/dev/null 2>&1 || {
        as_root=()
        [[ $(id -u) == 0 ]] || as_root=(sudo)
        "${as_root[@]}" apt-get update -qq
        "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends python3-pip
    }
    rm -rf "$tools"
    python3 -m pip install --quiet --root-user-action=ignore --disable-pip-version-check --target "$tools" "$package"
    echo "$package" >"$tools/package"
fi
PYTHONPATH=$tools PYTHONDONTWRITEBYTECODE=1 python3 check_scripts.py
