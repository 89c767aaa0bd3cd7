// bench_hash NAME TICKS: prints the hash of a scene after that many ticks. The WebAssembly module must produce the same
// hash.
#include "bench/scenes.h"
#include "engines/lockstone_engine.h"

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    const lockstone::bench::BenchScene scene = lockstone::bench::make_bench_scene(argv[1]);
    const auto engine = engines::make_lockstone({}, scene.scene);
    const int ticks = std::atoi(argv[2]);
    for (int tick = 0; tick < ticks; ++tick) {
        if (scene.script) scene.script(*engine, tick);
        engine->advance(1);
    }
    std::printf("%016llx\n", static_cast<unsigned long long>(engines::world_of(*engine).hash()));
}
