"""The cells of the matrix, by dimension. A cell is a build of the simulation and the conditions under which it runs. Cells with `red` have a planted
fault, and must differ from the reference."""
import shutil
from dataclasses import dataclass, field, replace


@dataclass(frozen=True)
class Build:
    cxx: str
    flags: tuple
    target: str = ""        # "": this machine; else a key of TARGETS
    patch: tuple = ()       # (file, find, put): a planted fault

    def label(self):
        return " ".join((self.cxx,) + self.flags)


@dataclass(frozen=True)
class Cell:
    name: str
    dimension: str
    build: Build
    arguments: tuple = ()
    environment: dict = field(default_factory=dict)
    ticks: int = 300        # the default reaches the last row of the golden table
    sample_ticks: int = 0   # ticks in the sample; 0: `ticks`
    state: bool = False     # writes snapshots and recordings, and reads those of the reference
    sample: bool = False
    three: bool = False     # in tests/run without options: another byte order, 32 bits with other lanes, another state of the floating-point unit
    thorough: bool = False  # runs all games, without the limit of ticks (--ticks, by default 16 in the sample)
    red: bool = False       # a planted fault: this cell has to differ
    browser: bool = False


@dataclass(frozen=True)
class Target:
    triple: str
    emulator: str           # "": the program runs without one
    endian: str = "little"
    compiler: str = ""      # "": g++ of the triple

    @property
    def cxx(self):
        return self.compiler or f"{self.triple}-g++"

    @property
    def packages(self):
        if self.emulator == "wine":
            return {"g++-mingw-w64-x86-64-posix", "wine", "wine64"}
        return {f"g++-{self.triple.replace('_', '-')}"} | ({"qemu-user"} if self.emulator else set())


TARGETS = {
    "i386": Target("i686-linux-gnu", ""),
    "arm64": Target("aarch64-linux-gnu", "qemu-aarch64"),
    "arm32": Target("arm-linux-gnueabihf", "qemu-arm"),
    "riscv64": Target("riscv64-linux-gnu", "qemu-riscv64"),
    "ppc64le": Target("powerpc64le-linux-gnu", "qemu-ppc64le"),
    "s390x": Target("s390x-linux-gnu", "qemu-s390x", "big"),
    "windows": Target("x86_64-w64-mingw32", "wine", compiler="x86_64-w64-mingw32-g++-posix"),
}
WASM_FLAGS = ("--target=wasm32-wasi", "-O2", "-DLOCKSTONE_NO_THREADS=1")
PORTABLE, NO_DOUBLE = "-DLOCKSTONE_PORTABLE_WIDE=1", "-DLOCKSTONE_NO_DOUBLE=1"
PLAIN = "-DLOCKSTONE_PLAIN_CPLUSPLUS=1"  # the code for compilers without extensions, such as MSVC's
# A fault: hashes integers in the byte order of the host, which is right on little-endian machines.
HOST_ORDER = ("src/base/hash.cpp", "store_little_endian(value, bytes);", "std::copy_n(reinterpret_cast<std::byte*>(&value), sizeof value, bytes);")
REFERENCE = Build("g++", ("-O2",))


def host(cxx, *flags):
    return Build(cxx, flags)


def all_cells(cpu_flags):
    cells = [Cell("reference", "compiler", REFERENCE, state=True, sample=True, thorough=True)]
    in_sample = dict(sample=True, thorough=True)

    def built(dimension, build, **more):
        cells.append(Cell(build.label(), dimension, build, **more))

    for level in ("-O0", "-O1", "-O3", "-Os"):
        # The sample has -Os, because g++ then keeps functions that it otherwise inlines, and optimises by the properties of those functions.
        built("optimisation", host("g++", level), **(dict(in_sample, sample_ticks=64) if level == "-Os" else {}))
    # For the sample: one build instead of three builds, each with one of these flags, that --all has.
    built("optimisation", host("g++", "-O0", PLAIN, NO_DOUBLE), **in_sample, sample_ticks=20)
    built("optimisation", host("g++", "-O2", "-flto"))
    built("optimisation", host("clang++-19", "-O2", "-flto=thin"))
    for cxx in ("clang++-14", "clang++-19"):
        built("compiler", host(cxx, "-O2"), **(in_sample if cxx == "clang++-14" else {}))
        built("compiler", host(cxx, "-O0"))
    for flags in (("-O3", "-march=native"), ("-O3", "-ffast-math"), ("-O3", "-march=native", "-ffast-math"), ("-O2", "-fno-strict-aliasing"),
                  ("-O2", "-fstrict-aliasing"), ("-O2", "-march=native", "-ffp-contract=fast"), ("-O2", "-march=native", "-ffp-contract=off")):
        built("flags", host("g++", *flags))
    built("flags", host("clang++-19", "-O3", "-march=native", "-ffast-math"))
    built("sanitizers", host("g++", "-O1", "-fsanitize=address", "-DLOCKSTONE_OWN_ALLOCATOR=1"))
    built("sanitizers", host("clang++-14", "-O1", "-fsanitize=undefined", "-fno-sanitize-recover=all"))
    cells.append(Cell("g++ -O1 -fsanitize=thread, 4 workers", "sanitizers", host("g++", "-O1", "-fsanitize=thread", "-DLOCKSTONE_OWN_ALLOCATOR=1"),
                      arguments=("--workers", "4"), ticks=60))
    for level, needed in (("x86-64", ()), ("x86-64-v2", ("sse4_1",)), ("x86-64-v3", ("avx2", "fma")), ("x86-64-v4", ("avx512f", "avx512bw"))):
        if set(needed) <= cpu_flags:
            built("SIMD", host("g++", "-O2", f"-march={level}"))
    built("SIMD", host("g++", "-O2", "-fno-tree-vectorize", "-fno-tree-slp-vectorize"))
    for flags in ((PORTABLE,), (NO_DOUBLE,), (PORTABLE, NO_DOUBLE), (PLAIN,)):
        built("arithmetic", host("g++", "-O2", *flags))
    built("arithmetic", host("clang++-14", "-O2", PLAIN))

    def run(name, dimension, arguments=(), environment=None, sample=False, three=False):
        cells.append(Cell(name, dimension, REFERENCE, tuple(arguments), environment or {}, sample=sample, three=three, thorough=True))

    for workers in (1, 2, 3, 4, 6, 8, 12, 16):
        run(f"{workers} workers", "workers", ("--workers", str(workers)), sample=workers == 3)
    for seed in (1, 2, 3):
        run(f"tasks in random order {seed}", "workers", ("--shuffle", str(seed)), sample=seed == 1)
    run("rounding, flushing and precision change before each tick", "floating-point unit", ("--fpu",), sample=True, three=True)
    for byte in ("0x00", "0xa5", "0xff"):
        run(f"memory poisoned with {byte}", "memory", ("--poison", byte), sample=byte == "0xa5")
    for seed in (1, 2, 3):
        run(f"other addresses {seed}", "memory", ("--move", str(seed)), sample=seed == 1)
    run("LANG, LC_ALL, TZ, HOME, MALLOC_PERTURB_ changed", "environment", environment={
        "LANG": "tr_TR.UTF-8", "LC_ALL": "de_DE.UTF-8", "TZ": "Pacific/Chatham", "HOME": "/", "MALLOC_PERTURB_": "91",
        "MALLOC_ARENA_MAX": "1"}, sample=True)

    for name, target in TARGETS.items():
        cxx = target.cxx
        static = ("-static",) + (("-latomic",) if name in ("arm32", "riscv64") else ())
        for level in ("-O1", "-O2", "-O3"):
            # arm64 runs more ticks, because it has NEON lanes: a difference in them appears where bodies turn fast, after some ticks.
            cells.append(Cell(f"{name} {level}", "architecture", Build(cxx, (level,) + static, name), sample_ticks=64 if name == "arm64" else 8, state=level == "-O1",
                              three=level == "-O1" and name == "s390x", sample=level == "-O1" and name in ("s390x", "arm64"), thorough=level == "-O1" and name == "arm64"))
        at_o1 = Build(cxx, ("-O1",) + static, name)
        cells.append(Cell(f"{name} -O1, rounding and flushing change", "floating-point unit", at_o1, ("--fpu",)))
        cells.append(Cell(f"{name} -O1, 3 workers", "workers", at_o1, ("--workers", "3")))
        for flags in ((PORTABLE,), (NO_DOUBLE,)):
            cells.append(Cell(f"{name} -O1 {flags[0]}", "arithmetic", Build(cxx, ("-O1",) + flags + static, name)))
        if target.endian == "big":
            cells.append(Cell(f"planted: integers hashed in host order, {name}", "planted", replace(at_o1, patch=HOST_ORDER), ticks=1, sample=True,
                              red=True))
    cells.append(Cell("planted: integers hashed in host order, here: right all the same", "planted", replace(host("clang++-14", "-O2"), patch=HOST_ORDER), ticks=4,
                      sample=True))
    for name, flags in (("wasm32", ()), ("wasm32 SIMD", ("-msimd128",))):
        build = Build("clang++-19", WASM_FLAGS + flags, "wasm")
        # Lanes of WebAssembly's SIMD have other high halves than lanes of x86: a fault that reads them as numbers appears after some ticks.
        cells.append(Cell(f"{name}, Node", "architecture", build, state=True, sample=True, thorough=bool(flags),
                          sample_ticks=128 if flags else 16, three=bool(flags)))
        cells.append(Cell(f"{name}, Chromium", "architecture", build, browser=True))
    return cells


def packages(cells):
    """Returns the Debian packages that the cells need."""
    names = {"g++", "libxxhash-dev"}
    for cell in cells:
        if cell.build.cxx == "clang++-14":
            names |= {"clang-14", "libclang-rt-14-dev"}
        if cell.build.cxx == "clang++-19":
            names |= {"clang-19", "lld-19"}
        if cell.build.target == "wasm":
            names |= {"wasi-libc", "libc++-19-dev-wasm32", "libc++abi-19-dev-wasm32", "libclang-rt-19-dev-wasm32"}
            names |= {"chromium"} if cell.browser else set()
            names |= set() if shutil.which("node") else {"nodejs", "npm"}  # any installed node is enough; the benchmark needs npm
        elif cell.build.target:
            target = TARGETS[cell.build.target]
            names |= target.packages
    return sorted(names)
