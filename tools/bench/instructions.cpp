#include "bench/instructions.h"

#include "engines/lockstone_engine.h"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>

/// The function that callgrind counts. Its name is an argument of callgrind, so it has C linkage and is never inlined.
extern "C" __attribute__((noinline)) void
lockstone_bench_counted_tick(const lockstone::bench::BenchScene& scene, engines::Engine& engine, int tick) {
    lockstone::bench::timed_act(scene, engine, tick);
}

namespace lockstone::bench {
namespace {

using namespace engines;
namespace fs = std::filesystem;

/// A temporary folder that its destructor removes.
class Folder {
  public:
    Folder() {
        std::string pattern = (fs::temp_directory_path() / "lockstone-bench-XXXXXX").string();
        if (mkdtemp(pattern.data()) != nullptr) path = pattern;
    }
    ~Folder() {
        std::error_code ignored;
        if (!path.empty()) fs::remove_all(path, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    fs::path path;
};

/// The tick whose state goes to the process under callgrind. After a restore the caches are cold and all leaves of the
/// broad phase are new, so some warm-up ticks run before the counted ones.
int ticks_before(const BenchScene& scene) { return std::max(scene.counted_from - scene.warm, 0); }

Status write_state(const BenchScene& scene, const Contestant& who, const fs::path& file) {
    const auto engine = make_lockstone(who, scene.scene);
    for (int tick = 0; tick < ticks_before(scene); ++tick) {
        if (scene.script) scene.script(*engine, tick);
        timed_act(scene, *engine, tick);
    }
    const std::vector<std::byte> state = world_of(*engine).save_portable();
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(state.data()), static_cast<std::streamsize>(state.size()));
    if (!out) return Error{file.string() + ": cannot write"};
    return {};
}

/// The total of the only event that callgrind counts: the number in its line "totals: N" or "summary: N".
Result<double> total_of(const fs::path& file) {
    std::ifstream in(file);
    double total = -1;
    for (std::string line; std::getline(in, line);) {
        for (const char* key : {"totals: ", "summary: "})
            if (line.starts_with(key))
                total = std::max(total, std::strtod(line.c_str() + std::strlen(key), nullptr));
    }
    if (total < 0) return Error{file.string() + ": the output of callgrind has no totals"};
    return total;
}

std::string quoted(const fs::path& path) { return "'" + path.string() + "'"; }

Result<double> count(const BenchScene& scene, const Contestant& who, const fs::path& folder,
                     const std::string& keep) {
    const fs::path state = folder / "state",
                   counts = (keep.empty() ? folder : fs::path(keep)) / ("callgrind.out." + scene.name);
    if (const Status written = write_state(scene, who, state); !written) return written.error();
    const std::string command =
        "valgrind --tool=callgrind --quiet --toggle-collect=lockstone_bench_counted_tick"
        " --callgrind-out-file=" +
        quoted(counts) + " " + quoted(fs::read_symlink("/proc/self/exe")) + " bench " + scene.name +
        " --counted " + quoted(state) + " --ticks " + std::to_string(scene.counted_from) +
        (who.substeps != 0 ? " --substeps " + std::to_string(who.substeps) : std::string()) +
        (who.simd.empty() ? std::string() : " --simd " + who.simd);
    const int status = std::system(command.c_str());
    if (status != 0)
        return Error{
            scene.name +
            ": cannot count instructions; check that valgrind is installed; this command failed: " + command};
    const Result<double> total = total_of(counts);
    if (!total) return total.error();
    return *total / scene.counted;
}

} // namespace

Result<Json> count_instructions(const std::vector<BenchScene>& scenes, const Contestant& who,
                                const std::string& keep) {
    const Folder folder;
    if (folder.path.empty()) return Error{"cannot make a folder in " + fs::temp_directory_path().string()};
    std::error_code failed;
    if (!keep.empty() && (fs::create_directories(keep, failed), failed))
        return Error{"cannot make the folder " + keep + ": " + failed.message()};
    Json rows = Json::array();
    for (const BenchScene& scene : scenes) {
        const Result<double> instructions = count(scene, who, folder.path, keep);
        if (!instructions) return instructions.error();
        const double millions = *instructions / 1e6, must = scene.target.instructions_must;
        rows.push_back({{"scene", scene.name},
                        {"about", scene.about},
                        {"from_tick", scene.counted_from},
                        {"bodies", scene.scene.bodies.size()},
                        {"joints", scene.scene.joints.size()},
                        {"millions_per_tick", millions},
                        {"must", must},
                        {"goal", scene.target.instructions_goal},
                        {"good", must == 0 || millions <= must}});
    }
    return rows;
}

Result<void> run_counted(const BenchScene& scene, const Contestant& who, const std::string& state_file) {
    const auto engine = make_lockstone(who, scene.scene);
    const int begin = ticks_before(scene), first = begin + scene.warm;
    if (begin > 0) { // without ticks before it, the start of the scene is the state
        std::ifstream in(state_file, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(in), {}};
        const Status restored = world_of(*engine).restore_portable(std::as_bytes(std::span(bytes)));
        if (!restored) return Error{state_file + ": " + restored.error().message};
    }
    for (int tick = begin; tick < first + scene.counted; ++tick) {
        if (scene.script) scene.script(*engine, tick);
        if (tick < first)
            timed_act(scene, *engine, tick);
        else
            lockstone_bench_counted_tick(scene, *engine, tick);
    }
    return {};
}

} // namespace lockstone::bench
