#!/usr/bin/env bash
# Installs headers, libraries, the pkg-config file and the CMake package into a folder:
#   bdtree-capi/install.sh PREFIX [FOLDER]
# FOLDER has libbdtree_capi.so and .a: target/release (`cargo build --release -p bdtree-capi`) unless another is named.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
prefix=${1:?PREFIX}
from=${2:-$here/../target/release}
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' "$here/../Cargo.toml" | head -n 1)

install -d "$prefix"/{include,lib/pkgconfig,lib/cmake/bdtree,share/bdtree}
install -m 644 "$here"/include/bdtree.h "$here"/include/bdtree.hpp "$prefix/include"
install -m 644 "$here"/csharp/*.cs "$prefix/share/bdtree"
install -m 755 "$from/libbdtree_capi.so" "$prefix/lib/libbdtree.so.$version"
ln -sf "libbdtree.so.$version" "$prefix/lib/libbdtree.so.${version%.*}"
ln -sf "libbdtree.so.${version%.*}" "$prefix/lib/libbdtree.so"
install -m 644 "$from/libbdtree_capi.a" "$prefix/lib/libbdtree.a"
sed "s/@VERSION@/$version/" "$here/pkgconfig/bdtree.pc.in" >"$prefix/lib/pkgconfig/bdtree.pc"
install -m 644 "$here/cmake/bdtree-config.cmake" "$prefix/lib/cmake/bdtree"
sed "s/@VERSION@/$version/" "$here/cmake/bdtree-config-version.cmake.in" \
    >"$prefix/lib/cmake/bdtree/bdtree-config-version.cmake"
