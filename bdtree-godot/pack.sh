#!/usr/bin/env bash
# Builds the extension and packs dist/bdtree-godot-VERSION.zip: what a Godot project needs of it, to be unpacked into its
# folder. Paths of the machine are no part of the library, and the same library gives the same bytes of the archive.
#
# `pack.sh LIBRARY ARCHIVE` packs a library that is built already.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd .. && pwd)
version=$(grep -Po '^version = "\K[^"]+' Cargo.toml)

library=${1:-}
archive=${2:-$root/dist/bdtree-godot-$version.zip}
if [[ -z $library ]]; then
    export CARGO_INCREMENTAL=0 CARGO_TARGET_DIR=$root/target/dist-godot
    export RUSTFLAGS="--remap-path-prefix=$root=bdtree --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo"
    cargo build --locked --release
    library=$CARGO_TARGET_DIR/release/libbdtree_godot.so
fi

licenses=$(mktemp)
trap 'rm -f "$licenses"' EXIT
# Of every package that is linked, or expanded by a macro into what is linked.
{
    echo "Packages that libbdtree_godot.so is made of, with their licences. Their sources, with the texts of the licences,"
    echo "are at the addresses beside them."
    echo
    cargo tree --locked --edges normal --target x86_64-unknown-linux-gnu --prefix none \
        --format '{p}|{l}' | sed 's/ (proc-macro)//; s/ (\*)$//; s/|\(.*\) (\*)$/|\1/' | grep -v ' (/' | LC_ALL=C sort -u |
        awk -F'[ |]' '{ licence = $0; sub(/^[^|]*\|/, "", licence)
            printf "%s %s: %s, https://crates.io/crates/%s/%s\n", $1, substr($2, 2), licence, $1, substr($2, 2) }'
} >"$licenses"

mkdir -p "$(dirname "$archive")"
python3 - "$library" "$archive" "$licenses" <<'EOF'
import pathlib
import sys
import zipfile

library, archive, licenses = map(pathlib.Path, sys.argv[1:])
files = {
    "bdtree.gdextension": "addon/bdtree.gdextension",
    "README.md": "addon/README.md",
    "LICENSE-MIT": "LICENSE-MIT",
    "LICENSE-APACHE": "LICENSE-APACHE",
    "LICENSES.txt": licenses,
    "linux.x86_64/libbdtree_godot.so": library,
    "demo/demo.gd": "addon/demo/demo.gd",
    "demo/demo.tscn": "addon/demo/demo.tscn",
    "demo/tube.glb": "../fixtures/skinned_tube.glb",
    "demo/tube.bdt": "../fixtures/golden/skinned.bdt",
}
with zipfile.ZipFile(archive, "w") as out:
    for name in sorted(files):
        # The least time that the format has: the archive depends on contents alone.
        entry = zipfile.ZipInfo(f"addons/bdtree/{name}", (1980, 1, 1, 0, 0, 0))
        entry.create_system = 3
        entry.external_attr = (0o100755 if name.endswith(".so") else 0o100644) << 16
        entry.compress_type = zipfile.ZIP_DEFLATED
        out.writestr(entry, pathlib.Path(files[name]).read_bytes(), compresslevel=9)
print(f"{archive.name}: {archive.stat().st_size} bytes, {len(files)} files")
EOF
