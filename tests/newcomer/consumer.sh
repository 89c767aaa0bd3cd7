#!/usr/bin/env bash
# consumer.sh CXX...: for each compiler, configures the README's unchanged CMakeLists.txt for a game and compiles the game's main.cpp; with
# LOCKSTONE_LONG=1 also builds and runs the game.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $1" >&2
    exit 1
}

cd "$work"
ln -s "$root" lockstone
python3 "$root/tests/newcomer/readme.py" --extract cmake 0 >CMakeLists.txt
python3 "$root/tests/newcomer/readme.py" --extract cpp 0 >main.cpp

# configured FOLDER CXX ARGUMENT...: configures FOLDER with the compiler CXX
configured() {
    local folder=$1 cxx=$2
    shift 2
    cmake -S . -B "$folder" -G Ninja -DCMAKE_CXX_COMPILER="$cxx" "$@" >log 2>&1 || fail "$cxx: the README's CMakeLists.txt does not configure: $(tail -n 20 log)"
}
# command_of DATABASE ENDING: prints the command that compiles the first file whose path ends with ENDING.
command_of() { python3 -c 'import json, sys; print(*[e["command"] for e in json.load(open(sys.argv[1])) if e["file"].endswith(sys.argv[2])][:1])' "$@"; }

for cxx in "$@"; do
    configured "build-$cxx" "$cxx" -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
    grep -q 'lockstone: no CMAKE_BUILD_TYPE is given' log || fail "$cxx: an empty build type is taken in silence"
    ours=$(command_of "build-$cxx/compile_commands.json" src/tick/tick.cpp)
    theirs=$(command_of "build-$cxx/compile_commands.json" main.cpp)
    [[ $ours == *" -O3 "* ]] || fail "$cxx: an empty build type leaves the library unoptimised: $ours"
    [[ $ours != *-Werror* && $theirs != *-Werror* ]] || fail "$cxx: -Werror in somebody else's project: $ours"
    [[ $theirs == *-std=*20* ]] || fail "$cxx: the game is not compiled as C++20: $theirs"
    [[ $theirs != *-O3* ]] || fail "$cxx: the game's own build type is changed: $theirs"
    ninja -C "build-$cxx" CMakeFiles/game.dir/main.cpp.o >log 2>&1 || fail "$cxx: the game does not compile: $(tail -n 20 log)"
    if [ "${LOCKSTONE_LONG:-0}" = 1 ]; then
        ninja -C "build-$cxx" game >log 2>&1 || fail "$cxx: the game does not build: $(tail -n 20 log)"
        "build-$cxx/game" || fail "$cxx: the game ends with status $?"
    fi
    # A build type that the user gives is kept.
    configured "debug-$cxx" "$cxx" -DCMAKE_EXPORT_COMPILE_COMMANDS=ON -DCMAKE_BUILD_TYPE=Debug
    ours=$(command_of "debug-$cxx/compile_commands.json" src/tick/tick.cpp)
    [[ $ours == *" -g "* && $ours != *-O3* ]] || fail "$cxx: the build type Debug is not kept: $ours"
done

# Planted fault: main.cpp must not compile as C++17; the library's targets require C++20.
! "$1" -std=c++17 -fsyntax-only -Ilockstone/include main.cpp 2>/dev/null || fail "the planted fault, C++17, is not noticed"
