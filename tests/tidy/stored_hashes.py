"""The stored hashes of the library's self test are equal to the hashes of this build. tools/refresh rewrites them."""
import re
import subprocess

PAGE = "src/prove/stored_hashes.h"
HEAD = """// The hashes that self_test() compares with: of each world after each tick. tools/refresh writes this file.
#pragma once

#include <cstdint>

namespace lockstone::proofs {

// clang-format off
inline constexpr std::uint64_t stored_hashes[] = {
"""
TAIL = """};
// clang-format on

} // namespace lockstone::proofs
"""
A_LINE = 6
HASH = re.compile(r"[0-9a-f]{16}")


def printed(tree):
    """Returns the hashes that the built program prints, in order; an empty list if there is no program."""
    program = tree.build / "bin/lockstone"
    if not program.exists():
        return []
    return HASH.findall(subprocess.run([program, "self-test", "--hashes"], capture_output=True, text=True, check=True).stdout)


def page_of(hashes):
    lines = [", ".join(f"0x{h}u" for h in hashes[i:i + A_LINE]) for i in range(0, len(hashes), A_LINE)]
    return HEAD + "".join(f"    {line},\n" for line in lines) + TAIL


def check(tree):
    hashes, page = printed(tree), tree.root / PAGE
    if not hashes:
        return [f"{PAGE}:1: no program prints its hashes: {tree.build}/bin/lockstone is missing or prints none"]
    if page.exists() and page.read_text() == page_of(hashes):
        return []
    return [f"{PAGE}:1: is not what this build computes; tools/refresh rewrites it, and the commit names the behaviour that changed"]


def refresh(tree):
    """Writes the hashes of the built program into the file. Returns true if the file changed."""
    page, hashes = tree.root / PAGE, printed(tree)
    if not hashes:
        raise SystemExit(f"{PAGE}: {tree.build}/bin/lockstone is missing or prints no hashes")
    before, after = page.read_text() if page.exists() else "", page_of(hashes)
    page.write_text(after)
    return after != before


HASHES = [f"{i:016x}" for i in range(1, 9)]
PROGRAM = {"build/bin/lockstone": "#!/bin/sh\nprintf '%s\\n' " + " ".join(HASHES) + "\n"}
PLANTED = [
    ("not what, a hash of another behaviour", {**PROGRAM, PAGE: page_of([*HASHES[:-1], "f" * 16])}),
    ("not what, a world less", {**PROGRAM, PAGE: page_of(HASHES[:-1])}),
    ("not what, no file", PROGRAM),
    ("no program, none is built", {PAGE: page_of(HASHES)}),
    ("prints none, another program", {"build/bin/lockstone": "#!/bin/sh\n", PAGE: page_of(HASHES)}),
]
SAYS_WHICH = True
GOOD = [("a file of this build", {**PROGRAM, PAGE: page_of(HASHES)})]
