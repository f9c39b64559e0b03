#!/usr/bin/env bash
# Builds what a release for Linux holds into dist/: one archive of the programs with man pages, completions, headers,
# libraries and licences, a bill of materials per program (CycloneDX), and their checksums. The same programs of the same
# commit give the same bytes. Paths of the machine are kept out of the programs, so that the same tool chain should make
# them alike elsewhere; no test compares that. First it checks what .ci/run has no time for.
#
# `--check` packs what `cargo build` has left in target/debug, twice, and compares the two: it tests this script and not
# the programs.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
version=$(grep -Po '^version = "\K[^"]+' Cargo.toml)
target=$(rustc -vV | grep -Po '^host: \K.*')
name=bdtree-$version-$target
export SOURCE_DATE_EPOCH LC_ALL=C TZ=UTC
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)

# The package and the features of each program.
programs=(
    "bdtree-build bdtree-build"
    "bdtree bdtree-tools report"
    "bdtree-view bdtree-view"
    "bdtree-playground bdtree-view"
)

build() {
    # Paths of this machine are no part of a program.
    export CARGO_INCREMENTAL=0 CARGO_TARGET_DIR=$root/target/dist
    export RUSTFLAGS="--remap-path-prefix=$root=bdtree --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=cargo"
    cargo build --locked --release -p bdtree-build -p bdtree-tools -p bdtree-view -p bdtree-release \
        --features bdtree-tools/report
    cargo build --locked --profile capi -p bdtree-capi
}

# What .ci/run leaves out for the time that it takes to compile.
check_more() {
    cargo clippy --locked -p bdtree-tools --features render -- -D warnings
    bash ci/bevy.sh --alone
    bash ci/book.sh
}

# pack BINARIES LIBRARIES FOLDER: the archive, the bills and the checksums, of the programs that lie in BINARIES and the
# libraries for C in LIBRARIES.
pack() {
    local binaries=$1 libraries=$2 dist=$3 files=$3/$name line
    rm -rf "$dist"
    mkdir -p "$files/bin" "$files/share/doc/bdtree"
    for line in "${programs[@]}"; do
        read -r program package features <<<"$line"
        # A check takes the programs that are there; a release has all of them.
        [[ -n $check && ! -x $binaries/$program ]] && continue
        install -m 755 "$binaries/$program" "$files/bin/$program"
        # shellcheck disable=SC2086
        python3 scripts/release/sbom.py "$package" "$target" $features >"$dist/$program-$version.cdx.json"
    done
    "$binaries/bdtree-pages" "$files/share"
    cp README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE THIRD-PARTY-NOTICES.md format-spec/SPEC.md format-spec/bdt.ksy \
        "$files/share/doc/bdtree"
    # A check takes the libraries if they are there.
    if [[ -z $check || -e $libraries/libbdtree_capi.so && -e $libraries/libbdtree_capi.a ]]; then
        bdtree-capi/install.sh "$files" "$libraries"
    fi
    if [[ -z $check ]]; then
        find "$files" -type f \( -path '*/bin/*' -o -name '*.so*' \) -exec strip --strip-unneeded {} +
    fi
    find "$files" -type d -exec chmod 755 {} + -o -type f -perm -100 -exec chmod 755 {} + -o -type f -exec chmod 644 {} +
    tar --sort=name --format=gnu --owner=0 --group=0 --numeric-owner --mtime="@$SOURCE_DATE_EPOCH" \
        -C "$dist" -cf - "$name" | gzip "-${check:-9}n" >"$dist/$name.tar.gz"
    rm -rf "$files"
    (cd "$dist" && find . -type f ! -name SHA256SUMS -printf '%P\n' | sort | xargs sha256sum >SHA256SUMS)
}

check=
if [[ ${1:-} == --check ]]; then
    check=1
    pack target/debug target/debug target/dist-check/first
    pack target/debug target/debug target/dist-check/second
    diff -r target/dist-check/first target/dist-check/second
    (cd target/dist-check/first && sha256sum --quiet -c SHA256SUMS)
    listed=$(tar -tzf "target/dist-check/first/$name.tar.gz")
    for file in bin/bdtree bin/bdtree-build share/man/man1/bdtree.1 share/man/man1/bdtree-query.1 \
        share/bash-completion/completions/bdtree share/doc/bdtree/LICENSE-MIT; do
        grep -qx "$name/$file" <<<"$listed" || { echo "$file is not in the archive" >&2; exit 1; }
    done
    echo "two archives of $(wc -l <<<"$listed") files, the same bytes"
    rm -rf target/dist-check
elif (($#)); then
    echo "scripts/release.sh takes --check or nothing, not: $*" >&2
    exit 2
else
    check_more
    build
    pack target/dist/release target/dist/capi dist
    cat dist/SHA256SUMS
fi
