#include "bench/instructions.h"

#include "engines/lockstone_engine.h"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>

/// What callgrind collects: its name is given on the command line, so it has to be plain, and a function.
extern "C" __attribute__((noinline)) void lockstone_bench_counted_tick(lockstone::World& world) {
    world.tick();
}

namespace lockstone::bench {
namespace {

using namespace engines;
namespace fs = std::filesystem;

constexpr int warm_ticks =
    10; ///< after a restore caches are cold, and the leaves of the broad phase all new: these are not counted

/// A folder that is gone when its owner is.
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

/// The state two ticks before the first that counts.
Status write_state(const BenchScene& scene, const Contestant& who, const fs::path& file) {
    const auto engine = make_lockstone(who, scene.scene);
    for (int tick = 0; tick < scene.counted_from - warm_ticks; ++tick) {
        if (scene.script) scene.script(*engine, tick);
        engine->advance(1);
    }
    const std::vector<std::byte> state = world_of(*engine).save_portable();
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(state.data()), static_cast<std::streamsize>(state.size()));
    if (!out) return Error{file.string() + ": cannot write"};
    return {};
}

/// The sum of callgrind's one event: its line "totals: N".
Result<double> total_of(const fs::path& file) {
    std::ifstream in(file);
    double total = -1;
    for (std::string line; std::getline(in, line);) {
        for (const char* key : {"totals: ", "summary: "})
            if (line.starts_with(key))
                total = std::max(total, std::strtod(line.c_str() + std::strlen(key), nullptr));
    }
    if (total < 0) return Error{file.string() + ": no totals in what callgrind wrote"};
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
        return Error{scene.name +
                     ": cannot count instructions: is valgrind installed? This failed: " + command};
    const Result<double> total = total_of(counts);
    if (!total) return total.error();
    return *total / counted_ticks;
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
    std::ifstream in(state_file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    const auto engine = make_lockstone(who, scene.scene);
    World& world = world_of(*engine);
    const Status restored = world.restore_portable(std::as_bytes(std::span(bytes)));
    if (!restored) return Error{state_file + ": " + restored.error().message};
    const int first = scene.counted_from;
    for (int tick = first - warm_ticks; tick < first + counted_ticks; ++tick) {
        if (scene.script) scene.script(*engine, tick);
        if (tick < first)
            world.tick();
        else
            lockstone_bench_counted_tick(world);
    }
    return {};
}

} // namespace lockstone::bench
