#!/usr/bin/env bash
# installed.sh BUILD CXX...: installs the build into a new folder. For each compiler, projects outside of the repository find the installed
# library by find_package and by pkg-config, and build and run a program with sessions and replays; one project also links lockstone::net.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=$1
shift

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
    echo "FAILED: $1" >&2
    exit 1
}

cmake --install "$build" --prefix "$work/prefix" >"$work/log" 2>&1 || fail "cmake --install: $(tail -n 20 "$work/log")"
# Installed files must not refer to the sources or to the build.
if grep -rlF -e "$root/" "$work/prefix" --include='*.h' --include='*.cmake' --include='*.pc'; then
    fail "these installed files refer to the sources"
fi

mkdir "$work/game"
cd "$work/game"
python3 "$root/tests/newcomer/readme.py" --extract cpp 0 >world.cpp
cat >replay.cpp <<'CPP'
#include <lockstone/session.h>
#include <replay/replay.h>

#include <cstdio>

int main() {
    const auto missing = lockstone::replay::Recording::open("missing.lsr");
    std::puts(missing ? "read" : missing.error().message.c_str());
    return missing ? 1 : 0;
}
CPP
cat >net.cpp <<'CPP'
#include <lockstone/net.h>

int main() { return lockstone::parse_address("[::1]:7777") ? 0 : 1; }
CPP
cat >CMakeLists.txt <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(game CXX)
find_package(lockstone 0.1 CONFIG REQUIRED COMPONENTS core replay net)
foreach(NAME world replay net)
    add_executable(${NAME} ${NAME}.cpp)
    target_link_libraries(${NAME} PRIVATE lockstone::lockstone)
endforeach()
target_link_libraries(net PRIVATE lockstone::net)
CMAKE

for cxx in "$@"; do
    cmake -S . -B "by-$cxx" -G Ninja -DCMAKE_CXX_COMPILER="$cxx" -DCMAKE_CXX_FLAGS="-Wall -Wextra -Wpedantic -Werror" \
        -DCMAKE_PREFIX_PATH="$work/prefix" >log 2>&1 || fail "$cxx: find_package: $(tail -n 20 log)"
    ninja -C "by-$cxx" >log 2>&1 || fail "$cxx: a project with find_package does not build: $(tail -n 20 log)"
    for name in world replay net; do
        "by-$cxx/$name" >log || fail "$cxx: $name ends with status $?: $(cat log)"
    done
    pc=$(find "$work/prefix" -name lockstone.pc)
    read -ra flags <<<"$(PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --static --cflags --libs lockstone)"
    for name in world replay; do
        "$cxx" -std=c++20 -Wall -Wextra -Werror "$name.cpp" "${flags[@]}" -o "$name-by-pc" || fail "$cxx: $name does not link by pkg-config"
        "./$name-by-pc" >log || fail "$cxx: $name, linked by pkg-config, ends with status $?"
    done
done

# Planted faults: a request for another minor version, and a component that does not exist, must fail.
for request in "0.2 CONFIG REQUIRED" "0.1 CONFIG REQUIRED COMPONENTS sound"; do
    sed "s/find_package(lockstone 0.1 CONFIG REQUIRED.*/find_package(lockstone $request)/" CMakeLists.txt >other.txt
    mkdir -p other && cp other.txt other/CMakeLists.txt && cp ./*.cpp other
    if cmake -S other -B "other-build" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" >log 2>&1; then
        fail "the planted fault, find_package(lockstone $request), is not noticed"
    fi
    rm -rf other other-build
done
