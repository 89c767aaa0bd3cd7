#!/usr/bin/env bash
# orders.sh: demo/run and tests/run give the same configuration in either order, also in a folder that another compiler has configured.
# A folder that is configured again keeps its compiled objects.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $1" >&2
    exit 1
}

as_demo() { configure -DLOCKSTONE_BUILD_TESTS=OFF; }
as_tests() { configure -DLOCKSTONE_BUILD_TESTS=ON; }
configure() { LOCKSTONE_BUILD_ROOT=$work tools/configure release "$@" >"$work/log" 2>&1 || fail "tools/configure $*: $(tail -n 20 "$work/log")"; }
by_another_compiler() {
    cmake --preset release -B "$work/release" -DCMAKE_CXX_COMPILER=clang++ -DLOCKSTONE_BUILD_TESTS=OFF -DLOCKSTONE_BUILD_DEMO=OFF >"$work/log" 2>&1 ||
        fail "clang++: $(tail -n 20 "$work/log")"
}

# commands FOLDER: prints the compile commands of the engine and of the tools, and the build type.
commands() {
    python3 - "$1/compile_commands.json" "$PWD" <<'PYTHON'
import json, sys
for entry in json.load(open(sys.argv[1])):
    name = entry["file"].removeprefix(sys.argv[2] + "/")
    if name.startswith(("src/", "replay/", "tools/")) or "/Unity/" in name:
        print(name, entry["command"])
PYTHON
    grep '^CMAKE_BUILD_TYPE:' "$1/CMakeCache.txt"
}
same() { cmp -s "$work/expected" "$1"; }

as_tests
commands "$work/release" >"$work/expected"
grep -q -- '^src/.* -O3 ' "$work/expected" || fail "the engine is not compiled with -O3"
grep -q 'BUILD_TYPE.*=Release' "$work/expected" || fail "the build type is not Release"
as_demo
commands "$work/release" >"$work/found"
same "$work/found" || fail "tests then demo: $(diff "$work/expected" "$work/found" | head -n 4)"

rm -rf "$work/release"
as_demo
as_tests
commands "$work/release" >"$work/found"
same "$work/found" || fail "demo then tests: $(diff "$work/expected" "$work/found" | head -n 4)"

# Repeated configuration of a folder keeps its objects; a change of the compiler removes them.
object=$work/release/CMakeFiles/lockstone_base.dir/kept.o
mkdir -p "$(dirname "$object")" && touch "$object"
for again in second third fourth; do
    as_tests
    [ -e "$object" ] || fail "a $again configuration threw away what was compiled"
done
sed -i 's|^\(CMAKE_CXX_COMPILER:[A-Z]*=\).*|\1clang++|' "$work/release/CMakeCache.txt"
as_tests
[ ! -e "$object" ] || fail "the planted fault, a cache of another compiler, keeps its objects"

rm -rf "$work/release"
by_another_compiler
commands "$work/release" >"$work/found"
! same "$work/found" || fail "the planted fault, another compiler's commands, is not noticed"
as_tests
commands "$work/release" >"$work/found"
same "$work/found" || fail "after another compiler: $(diff "$work/expected" "$work/found" | head -n 4)"

# Planted fault: the commands of a folder that lost its build type, as CMake does if the compiler of a configured folder is changed.
sed 's/ -O3 -DNDEBUG//; s/=Release$/=/' "$work/expected" >"$work/found"
! same "$work/found" || fail "the planted fault, commands without optimisation, is not noticed"
echo "$(wc -l <"$work/expected") lines are the same in each order"
