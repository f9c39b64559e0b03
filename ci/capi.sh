#!/usr/bin/env bash
# The C interface from outside: the header is what its sources say and compiles as every promised standard; the library
# exports what symbols.txt lists and needs nothing but libc; golden answers are the same through C, C++ and C#; examples
# find the library through pkg-config and CMake and run under ASan, UBSan and valgrind. Installs what it needs.
#
# `--delivered` builds the library as it is delivered (profile `capi`, minutes) and compares its size as well.
set -euo pipefail
cd "$(dirname "$0")/.."

needed=()
for tool in g++:g++ clang:clang cmake:cmake make:make pkg-config:pkg-config valgrind:valgrind mcs:mono-mcs \
    mono:mono-runtime; do
    command -v "${tool%%:*}" >/dev/null || needed+=("${tool##*:}")
done
# Linq, which the C# programs use.
compgen -G '/usr/lib/mono/gac/System.Core' >/dev/null || needed+=(libmono-system-core4.0-cil)
if ((${#needed[@]})); then
    install="apt-get install -y --no-install-recommends ${needed[*]}"
    echo "missing: ${needed[*]}"
    if [[ $(id -u) == 0 ]]; then
        apt-get update -qq && DEBIAN_FRONTEND=noninteractive $install >/dev/null
    else
        sudo apt-get update -qq && sudo DEBIAN_FRONTEND=noninteractive $install >/dev/null
    fi
fi

out=$PWD/target/capi-check
rm -rf "$out"
mkdir -p "$out"
warnings=(-Wall -Wextra -Werror -pedantic)

CARGO_TARGET_DIR=target/header cargo run --quiet --locked --manifest-path ci/header/Cargo.toml -- --check

profile=${CAPI_PROFILE:-dev}
[[ ${1:-} == --delivered ]] && profile=capi
folder=target/${profile/#dev/debug}
# Alone: what other crates of the workspace ask of nalgebra would make it need libm.
cargo build --locked --profile "$profile" -p bdtree-capi
library=$folder/libbdtree_capi.so

nm -D --defined-only "$library" | awk '{ print $3 }' | LC_ALL=C sort >"$out/symbols.txt"
diff bdtree-capi/symbols.txt "$out/symbols.txt" || {
    echo "the library exports other symbols than bdtree-capi/symbols.txt lists" >&2
    exit 1
}
python3 ci/check_wrappers.py --self-test
python3 ci/check_wrappers.py
foreign=$(readelf -d "$library" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | grep -vE '^(libc\.so\.6|ld-linux.*)$' || true)
[[ -z $foreign ]] || { echo "the library needs $foreign besides libc" >&2; exit 1; }
if [[ $profile == capi ]]; then
    size=$(stat -c %s "$library")
    echo "the library has $size bytes"
    ((size <= 1500000)) || { echo "more than 1.5 MB" >&2; exit 1; }
fi

prefix=$out/prefix
bdtree-capi/install.sh "$prefix" "$folder"
# Moved: nothing in it names the folder.
mv "$prefix" "$out/moved"
prefix=$out/moved
export PKG_CONFIG_PATH=$prefix/lib/pkgconfig LD_LIBRARY_PATH=$prefix/lib
read -ra flags < <(pkg-config --cflags --libs bdtree)
[[ $(pkg-config --modversion bdtree) == "$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -n 1)" ]]

echo '#include <bdtree.h>
typedef char size[sizeof(BdtManifold) == 560 && sizeof(BdtBodyOptions) == 144 ? 1 : -1];
int main(void) { return (int)bdt_version() < 0; }' >"$out/header.c"
echo '#include <bdtree.h>
#include <bdtree.hpp>
int main() { return bdtree::World::defaults().threads == 0; }' >"$out/header.cpp"
for standard in c99 c11 c17; do
    for compiler in gcc clang; do
        $compiler -std=$standard "${warnings[@]}" -I"$prefix/include" -fsyntax-only "$out/header.c"
    done
done
for standard in c++17 c++20; do
    for compiler in g++ clang++; do
        $compiler -std=$standard "${warnings[@]}" -I"$prefix/include" -fsyntax-only "$out/header.cpp"
    done
done
echo "headers: C99, C11, C17, C++17, C++20 with gcc and clang"

checked=(-g -O1 -fsanitize=address,undefined -fno-sanitize-recover=all)
tests=bdtree-capi/tests/c
gcc -std=c99 "${warnings[@]}" "${checked[@]}" $tests/golden.c "${flags[@]}" -o "$out/golden-c-checked"
gcc -std=c99 "${warnings[@]}" -g $tests/golden.c "${flags[@]}" -o "$out/golden-c"
g++ -std=c++17 "${warnings[@]}" "${checked[@]}" $tests/golden.cpp "${flags[@]}" -o "$out/golden-cpp-checked"
mcs -langversion:7.2 -warnaserror -out:"$out/golden.exe" bdtree-capi/csharp/*.cs $tests/Golden.cs
memory=(valgrind --quiet --error-exitcode=1 --leak-check=full --show-leak-kinds=definite
    --errors-for-leak-kinds=definite)
same() {
    local file=$1
    shift
    "$@" "$file" | cmp - "${file%.bdt}.jsonl" || { echo "other answers: $*" >&2; exit 1; }
}
count=0
for file in fixtures/golden/*.bdt; do
    same "$file" "$out/golden-c-checked"
    same "$file" "$out/golden-cpp-checked"
    same "$file" mono "$out/golden.exe"
    count=$((count + 1))
done
same fixtures/golden/skinned.bdt "${memory[@]}" "$out/golden-c"
echo "$count golden files: the same answers through C, C++ and C#"

# The tests have built it; built alone it would be compiled with other features.
[[ -x target/debug/bdtree-build ]] || cargo build --locked -p bdtree-build
target/debug/bdtree-build fixtures/cube.obj --basis fixtures/cube_swells.npy -o "$out/cube.bdt" >/dev/null 2>&1
examples=bdtree-capi/examples
for example in c cpp; do
    lines=$(wc -l <$examples/example.$example)
    ((lines <= 30)) || { echo "example.$example has $lines lines" >&2; exit 1; }
done
gcc -std=c99 "${warnings[@]}" "${checked[@]}" $examples/example.c "${flags[@]}" -o "$out/example-c"
g++ -std=c++17 "${warnings[@]}" "${checked[@]}" $examples/example.cpp "${flags[@]}" -o "$out/example-cpp"
mcs -langversion:7.2 -warnaserror -out:"$out/Example.exe" bdtree-capi/csharp/*.cs $examples/Example.cs
cmake -S $examples -B "$out/cmake" -DCMAKE_PREFIX_PATH="$prefix" >"$out/cmake.log"
cmake --build "$out/cmake" >>"$out/cmake.log" || { cat "$out/cmake.log" >&2; exit 1; }
for program in "$out/example-c" "$out/example-cpp" "mono $out/Example.exe" "$out/cmake/example_c" \
    "$out/cmake/example_cpp" "$out/cmake/example_static" "${memory[*]} $out/cmake/example_c" \
    "${memory[*]} $out/cmake/example_cpp"; do
    # Words of a command line.
    answer=$($program "$out/cube.bdt")
    [[ $answer == "triangle "*" at distance "* ]] || { echo "$program: $answer" >&2; exit 1; }
    # A file that is none ends with an error.
    if $program README.md >"$out/error.txt" 2>&1; then echo "$program takes README.md" >&2; exit 1; fi
    grep -q 'not a .bdt file' "$out/error.txt" || { cat "$out/error.txt" >&2; exit 1; }
done
# Every function through C++ and C#, with a body whose modes vibrate. The programs call each of them: of the one the
# linker knows, of the other the loader, which looks each up at its first call.
target/debug/bdtree-build --tets fixtures/beam_tets.vtk --modes 3 -o "$out/beam.bdt" >/dev/null 2>&1
g++ -std=c++17 "${warnings[@]}" "${checked[@]}" -O0 $tests/wrapper.cpp "${flags[@]}" -o "$out/wrapper-cpp"
mcs -langversion:7.2 -warnaserror -out:"$out/wrapper.exe" bdtree-capi/csharp/*.cs $tests/Wrapper.cs
"$out/wrapper-cpp" fixtures/golden "$out/beam.bdt"
nm -u "$out/wrapper-cpp" | awk '/ bdt_/ { print $2 }' | LC_ALL=C sort | diff bdtree-capi/symbols.txt -
LD_DEBUG=symbols LD_DEBUG_OUTPUT=$out/lookups mono "$out/wrapper.exe" fixtures/golden "$out/beam.bdt"
cat "$out"/lookups.* | grep -o 'symbol=bdt_[a-z_0-9]*' | cut -d= -f2 | LC_ALL=C sort -u | diff bdtree-capi/symbols.txt -
# The programs of the guide.
programs() {
    python3 - "$1" "$2" "$out/guide-$2" <<'EOF'
import re, sys
page, language, folder = sys.argv[1:]
blocks = re.findall(rf"^```{language}\n(.*?)^```$", open(page, encoding="utf-8").read(), re.DOTALL | re.MULTILINE)
for number, block in enumerate(blocks):
    open(f"{folder}-{number}.{ {'csharp': 'cs'}.get(language, language) }", "w", encoding="utf-8").write(block)
print(f"{page}: {len(blocks)} programs")
assert blocks
EOF
}
programs docs/guide/c.md c
programs docs/guide/cpp.md cpp
programs docs/guide/unity.md csharp
gcc -std=c99 "${warnings[@]}" "${checked[@]}" "$out/guide-c-0.c" "${flags[@]}" -o "$out/guide-c-0"
gcc -std=c99 "${warnings[@]}" "${checked[@]}" "$out/guide-c-1.c" "${flags[@]}" -o "$out/guide-c-1"
g++ -std=c++20 "${warnings[@]}" "${checked[@]}" "$out/guide-cpp-0.cpp" "${flags[@]}" -o "$out/guide-cpp-0"
g++ -std=c++17 "${warnings[@]}" "${checked[@]}" "$out/guide-cpp-1.cpp" "${flags[@]}" -o "$out/guide-cpp-1"
mcs -langversion:7.2 -warnaserror -out:"$out/guide.exe" bdtree-capi/csharp/*.cs "$out/guide-csharp-0.cs"
says() {
    local word=$1 said
    shift
    said=$("$@" "$out/cube.bdt")
    [[ $said == *"$word"* ]] || { echo "$*: $said" >&2; exit 1; }
}
says 'triangles touched' "$out/guide-c-0"
says 'body 0 lands in step' "$out/guide-c-1"
says 'depth ' "$out/guide-cpp-0"
says 'seen triangle ' "$out/guide-cpp-1"
says 'triangles touched' mono "$out/guide.exe"
# The page of Unreal: files that begin with their name, and a program. What needs Unreal is compiled against declarations.
unreal=$out/unreal
mkdir -p "$unreal"
python3 - "$unreal" <<'EOF'
import re, sys
text = open("docs/guide/unreal.md", encoding="utf-8").read()
for block in re.findall(r"^```(?:cpp|c\+\+|csharp)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE):
    name = re.match(r"// (?:\w+/)*([\w.]+)\n", block)
    open(f"{sys.argv[1]}/{name[1] if name else 'ray.cpp'}", "w", encoding="utf-8").write(block)
EOF
g++ -std=c++17 "${warnings[@]}" "${checked[@]}" "$unreal/ray.cpp" "${flags[@]}" -o "$out/unreal-ray"
says ' cm away' "$out/unreal-ray"
g++ -std=c++17 "${warnings[@]}" "${checked[@]}" -I"$unreal" bdtree-capi/tests/unreal/axes.cpp "${flags[@]}" -o "$out/unreal-axes"
says '200 transforms' "$out/unreal-axes"
for compiler in g++ clang++; do
    $compiler -std=c++20 "${warnings[@]}" -fsyntax-only -Ibdtree-capi/tests/unreal -I"$unreal" -I"$prefix/include" \
        "$unreal/BdtreeComponent.cpp"
done
mcs -langversion:7.2 -warnaserror -target:library -out:"$out/unreal.dll" bdtree-capi/tests/unreal/BuildTool.cs \
    "$unreal/Bdtree.Build.cs" "$unreal/Game.Build.cs"
echo "examples: pkg-config, CMake, static; ASan, UBSan, valgrind: $answer"
