"""Builds matrix_hash for a cell without CMake: every compiler gets the same few flags. For speed it compiles up to sixteen sources of a layer
as one."""
import concurrent.futures
import filecmp
import hashlib
import os
import pathlib
import platform
import shutil
import subprocess
import threading

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Sources that need threads or directories. A target without them (WebAssembly) builds the other sources.
WITHOUT_THREADS = {"src/base/worker_pool.cpp", "replay/verifier.cpp", "src/shapes/asset/load_assets.cpp"}

# Headers that most sources include. Each build precompiles them, because compilers spend much of their time on headers.
PRELUDE = ("lockstone/world.h", "world/data.h", "algorithm", "array", "functional", "map", "memory", "optional", "sstream", "string", "vector")

WITHOUT_PRELUDE = {"tools/bench/scenes.cpp"}  # defines names that lockstone/world.h also defines

# For speed, AT_ONCE sources of a folder of src/, or of replay/, are compiled as one. They do not conflict: within a layer a name means one thing.
AT_ONCE = 16
ALONE = {"kernels"}  # folders whose sources are compiled alone: each source is for one instruction set

# Flags of the kernels for each instruction set, as in CMakeLists.txt. The program chooses a kernel for its processor when it runs.
KERNELS = {"kernel_sse41.cpp": ["-msse4.1"], "kernel_avx2.cpp": ["-mavx2"], "kernel_avx512.cpp": ["-mavx512f", "-mavx512dq", "-mavx512vl"]}
GNU_FLAGS = ["-fno-delete-null-pointer-checks"]  # as in CMakeLists.txt; src/base/null_pointers.cpp gives the reason
UNALIGNED = ["-Wa,-muse-unaligned-vector-move"]  # as in CMakeLists.txt
# Flags for MSVC's cl, which needs none for intrinsics of SSE4.1. clang-cl gets the flags in KERNELS, through its option -clang:.
KERNELS_OF_CL = {"kernel_avx2.cpp": ["-arch:AVX2"], "kernel_avx512.cpp": ["-arch:AVX512"]}
# Unrolls short loops and inlines small functions of lanes: loops and calls that remain keep their values in memory. Link-time optimisation would
# ignore these flags, so -fno-lto turns it off.
KERNELS_OF_WASM = {"kernel_wasm128.cpp": ["-fno-lto", "-fno-tree-vectorize", "-fno-tree-slp-vectorize", "-mllvm", "-unroll-threshold=3000",
                                          "-mllvm", "-inline-threshold=2000"]}
FOR_THE_LINKER = ("-l", "-mexec-model=")  # only the linker gets flags that begin with one of these
X86 = ("i386", "windows") + (("",) if platform.machine().lower() in ("x86_64", "amd64", "i686") else ())  # targets; "": this machine
ON_WINDOWS = os.name == "nt"


class BuildFailed(Exception):
    pass


def together(files):
    """Returns the files in tuples. The builder compiles the files of a tuple as one source."""
    tuples, by_folder = [], {}
    for path in sorted(files):
        top, *below = path.relative_to(ROOT).parts
        if top in ("src", "replay") and path.parent.name not in ALONE:
            by_folder.setdefault((top, below[0] if len(below) > 1 and top == "src" else ""), []).append(path)
        else:
            tuples.append((path,))
    for members in by_folder.values():
        tuples += [tuple(members[i:i + AT_ONCE]) for i in range(0, len(members), AT_ONCE)]
    return sorted(tuples, key=len, reverse=True)  # the largest first, so that all cores end at about the same time


def sources(build):
    found = [p for pattern in ("src/**/*.cpp", "replay/**/*.cpp", "tools/scenes/**/*.cpp", "tests/matrix/*.cpp") for p in ROOT.glob(pattern)]
    # The sources that draw random worlds, without the sources that compare execution modes: those run only on this machine.
    found += [ROOT / f"tests/metamorphic/worlds/{name}.cpp" for name in ("assets", "draw", "draw_commands", "draw_definitions", "story")]
    found.append(ROOT / "tests/attack/worlds/values.cpp")
    # The network layer is left out: it computes no state, and needs libsodium.
    found = [p for p in found if not p.is_relative_to(ROOT / "src/net")]
    if build.target == "wasm":
        found = [p for p in found if p.relative_to(ROOT).as_posix() not in WITHOUT_THREADS]
    return found


def is_like_cl(cxx):
    """Returns true for MSVC's cl, and for clang-cl, which has the same command line. Options of both are written with a dash here, because shells for
    Windows may change words that begin with a slash."""
    return pathlib.Path(cxx).stem.lower() in ("cl", "clang-cl")


def compiler_flags(build):
    return [] if "clang" in build.cxx or is_like_cl(build.cxx) else GNU_FLAGS


def kernel_flags(build, name):
    if build.target == "wasm":
        return KERNELS_OF_WASM.get(name, [])
    if build.target not in X86:
        return []
    if is_like_cl(build.cxx):
        return [f"-clang:{flag}" for flag in KERNELS.get(name, [])] if "clang" in build.cxx else KERNELS_OF_CL.get(name, [])
    own = KERNELS.get(name, [])
    return own + UNALIGNED if own and (build.target == "windows" or ON_WINDOWS and "clang" not in build.cxx) else own


def fresh(out, *others):
    """Returns true if the object is newer than all files that it was made from. `others` has precompiled headers: compilers do not list the files
    that those were made from."""
    try:
        made = out.stat().st_mtime_ns
        if any(made <= other.stat().st_mtime_ns for other in others):
            return False
        _, _, names = pathlib.Path(f"{out}.d").read_text().replace("\\\n", " ").partition(": ")
        return made > max(os.stat(name).st_mtime_ns for name in names.split())
    except (OSError, ValueError):
        return False


def compiled_header(build, folder):
    return folder / ("prelude.h.pch" if "clang" in build.cxx else "prelude.h.gch")


class Builder:
    def __init__(self, folder, jobs):
        self.folder = folder
        self.pool = concurrent.futures.ThreadPoolExecutor(jobs)
        self.guard, self.locks = threading.Lock(), {}
        self.includes = folder / "include"
        self.includes.mkdir(parents=True, exist_ok=True)
        # The only header of another project. It is copied, because a cross compiler must not see the other headers of /usr/include.
        header = self.includes / "xxhash.h"
        found = pathlib.Path(os.environ.get("LOCKSTONE_XXHASH", "/usr/include")) / "xxhash.h"
        if not header.exists() or not filecmp.cmp(found, header, shallow=False):
            shutil.copyfile(found, header)

    def program(self, build):
        """Builds the program and returns its path. Raises BuildFailed with the compiler's output."""
        return self.link(build, "matrix_hash", sources(build))

    def link(self, build, name, files):
        """Builds the program `name` from these files and returns its path. A file that several programs share is compiled once."""
        of_kernels = [kernel_flags(build, name) for name in (*KERNELS, *KERNELS_OF_WASM)]
        key = hashlib.sha256(repr((build.cxx, build.flags, compiler_flags(build), of_kernels)).encode()).hexdigest()[:12]
        folder = self.folder / f"{build.target or 'host'}-{key}"
        folder.mkdir(parents=True, exist_ok=True)
        include = [ROOT / name for name in ("include", "src", "", "tools", "tests/matrix", "tests")]
        own = ["-DNDEBUG", *compiler_flags(build), *[f for f in build.flags if not f.startswith(FOR_THE_LINKER)], *[f"-I{p}" for p in include]]
        if is_like_cl(build.cxx):
            flags = ["-nologo", "-std:c++20", *own, f"-I{self.includes}"]
        else:
            flags = ["-std=c++20", *own, "-isystem", str(self.includes)]
            flags += ["-include", self.prelude(build, flags, folder)]
        # A build with a planted fault compiles one object, and shares the other objects with the build without the fault.
        objects = self.objects(build, flags, folder, files)
        ending = {"wasm": ".wasm", "windows": ".exe"}.get(build.target, ".exe" if ON_WINDOWS else "")
        program = folder / (name + ("_planted" if build.patch else "") + ending)
        if is_like_cl(build.cxx):
            run([build.cxx, *flags, f"-Fe{program}", *objects])
            return program
        threads = [] if build.target == "wasm" or "--target=x86_64-pc-windows-msvc" in build.flags else ["-pthread"]
        linked = [f for f in build.flags if f.startswith(FOR_THE_LINKER)]
        run([build.cxx, *flags, *threads, "-o", program, *objects, *linked])
        return program

    def objects(self, build, flags, folder, files):
        return list(self.pool.map(lambda paths: self.object(build, flags, folder, paths), together(files)))

    def object(self, build, flags, folder, paths):
        path, sources_now = paths[0], [self.patched(build, folder, p) for p in paths]
        name = path.relative_to(ROOT).as_posix().replace("/", "-")
        planted = "" if sources_now == list(paths) else "-planted"
        out = folder / f"{name}{f'-and-{len(paths) - 1}' if len(paths) > 1 else ''}{planted}{'.obj' if is_like_cl(build.cxx) else '.o'}"
        source = sources_now[0] if len(paths) == 1 else self.joined(out.with_suffix(".cpp"), sources_now)
        with self.lock_of(out):  # two threads may build the object at the same time
            if not fresh(out, compiled_header(build, folder)):
                own = kernel_flags(build, path.name)
                if is_like_cl(build.cxx):
                    run([build.cxx, *flags, *own, "-c", f"-Tp{source}", f"-Fo{out}"])
                    return out
                # The precompiled prelude does not fit flags for other instruction sets, and the sources of WITHOUT_PRELUDE must not include it.
                if own or path.relative_to(ROOT).as_posix() in WITHOUT_PRELUDE:
                    flags = flags[:flags.index("-include")]
                run([build.cxx, *flags, *own, "-MMD", "-MF", f"{out}.d", "-c", source, "-o", out])
        return out

    def prelude(self, build, flags, folder):
        """Returns a header with its precompiled form in the same folder, which the compiler reads instead."""
        header = folder / "prelude.h"
        out = compiled_header(build, folder)
        with self.lock_of(out):
            if not fresh(out):
                header.write_text("#pragma once\n" + "".join(f"#include <{name}>\n" for name in PRELUDE))
                run([build.cxx, *flags, "-MMD", "-MF", f"{out}.d", "-x", "c++-header", header, "-o", out])
        return header

    def joined(self, path, members):
        text = "".join(f'#include "{member}"\n' for member in members)
        with self.lock_of(path):
            if not path.exists() or path.read_text() != text:
                path.write_text(text)
        return path

    def lock_of(self, path):
        with self.guard:
            return self.locks.setdefault(path, threading.Lock())

    def patched(self, build, folder, path):
        if not build.patch or path != ROOT / build.patch[0]:
            return path
        text = path.read_text()
        if build.patch[1] not in text:
            raise BuildFailed(f"{build.patch[0]} does not hold what the planted fault replaces: {build.patch[1]}")
        copy = folder / path.name
        copy.write_text("#include <algorithm>\n" + text.replace(build.patch[1], build.patch[2]))
        return copy


def run(command):
    command = [str(c) for c in command]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "LC_ALL": "C"})
    if done.returncode != 0:
        raise BuildFailed(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
