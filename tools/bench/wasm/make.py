#!/usr/bin/env python3
"""Builds module.cpp as the WebAssembly module that bench.mjs loads, and prints its path. Compiler and packages are those of tests/matrix;
the flags are those of tests/matrix and more.

  tools/bench/wasm/make.py [FLAG...]     FLAG: a further compiler flag, after the default flags"""
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/matrix"))
import cells as matrix  # noqa: E402
from build import WITHOUT_THREADS, Builder, BuildFailed  # noqa: E402

# The flags of a game's release: vectors, bulk memory instructions, link-time optimisation, no exceptions.
FLAGS = (*matrix.WASM_FLAGS, "-O3", "-flto", "-msimd128", "-mbulk-memory", "-fno-exceptions", "-mexec-model=reactor")
TOOLS = ("tools/engines/scene.cpp", "tools/engines/pieces.cpp", "tools/engines/human.cpp", "tools/engines/lockstone_engine.cpp", "tools/bench/scenes.cpp",
         "tools/bench/quality.cpp", *(f"tools/bench/rows/{name}.cpp" for name in ("rows", "bounds", "swept", "joined", "stacked", "played", "created", "asked")),
         "tools/bench/wasm/module.cpp")


def sources():
    engine = [path for pattern in ("src/**/*.cpp",) for path in sorted(ROOT.glob(pattern))
              if not path.is_relative_to(ROOT / "src/net")]
    return [p for p in engine if p.relative_to(ROOT).as_posix() not in WITHOUT_THREADS] + [ROOT / name for name in TOOLS]


def main():
    build = matrix.Build("clang++-19", FLAGS + tuple(sys.argv[1:]), "wasm")
    subprocess.run([ROOT / "tools/packages", *matrix.packages([matrix.Cell("", "", build)])], check=True, stdout=sys.stderr)
    folder = ROOT / "build/bench-wasm"
    folder.mkdir(parents=True, exist_ok=True)
    try:
        print(Builder(folder, int(os.environ.get("LOCKSTONE_JOBS", os.cpu_count() or 1))).link(build, "module", sources()))
    except BuildFailed as failure:
        sys.exit(f"make.py: {failure}")


if __name__ == "__main__":
    main()
