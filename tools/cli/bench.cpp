// lockstone bench
#include "cli/input_source.h"
#include "cli/progress.h"
#include "cli/scene_choice.h"
#include "cli/world_report.h"

#include <cstdio>

namespace lockstone::cli {
namespace {

struct Args {
    std::vector<std::string> scenes;
    SceneOptions options;
    std::uint64_t ticks = 240;
    std::uint32_t threads = 1;
    bool json = false;
};

void describe(CLI::App& command, Args& args) {
    add_texts(command, "SCENE", args.scenes, "scenes; none: all");
    describe_options(command, args.options);
    add_number(command, "--ticks", args.ticks, "to measure", 1, UINT64_MAX);
    add_threads(command, args.threads);
    add_flag(command, "--json", args.json, "for programs");
}

Result<nlohmann::ordered_json> measure(const std::string& scene, const Args& args) {
    Result<Started> started = start({scene, args.options});
    if (!started) return started.error();
    World& world = started->world;
    const std::unique_ptr<Tasks> tasks = tasks_of(args.threads);
    world.set_tasks(tasks.get());
    InputSource source = InputSource::scripted(*started->game, args.options.seed);
    std::vector<double> tick_us;
    Progress progress(scene, args.ticks);
    for (std::uint64_t tick = 0; tick < args.ticks; ++tick) {
        const std::span<const PlayerInput> inputs = source.at(tick);
        const auto before = Clock::now();
        started->game->advance(world, inputs);
        tick_us.push_back(microseconds_since(before));
        progress.at(tick + 1);
    }
    const std::size_t contacts = world.contacts().size();
    const SnapshotCost cost = measure_snapshot(world);
    return nlohmann::ordered_json{{"scene", scene},
                                  {"bodies", world.body_count()},
                                  {"contacts", contacts},
                                  {"ticks", args.ticks},
                                  {"tick_us_median", median(tick_us)},
                                  {"tick_us_p99", percentile(tick_us, 0.99)},
                                  {"snapshot_bytes", cost.bytes},
                                  {"save_us", cost.save_us},
                                  {"restore_us", cost.restore_us},
                                  {"hash_us", cost.hash_us},
                                  {"memcpy_us", cost.memcpy_us},
                                  {"save_per_memcpy", cost.save_us / cost.memcpy_us},
                                  {"save_per_tick", cost.save_us / median(tick_us)}};
}

void print_row(const nlohmann::ordered_json& row) {
    std::printf("%-16s %6u %8zu %10.1f %10.1f %9zu %8.2f %8.2f %8.2f %8.2f %6.2f\n",
                row["scene"].get<std::string>().c_str(), row["bodies"].get<unsigned>(),
                row["contacts"].get<std::size_t>(), row["tick_us_median"].get<double>(),
                row["tick_us_p99"].get<double>(), row["snapshot_bytes"].get<std::size_t>(),
                row["save_us"].get<double>(), row["restore_us"].get<double>(), row["hash_us"].get<double>(),
                row["memcpy_us"].get<double>(), row["save_per_memcpy"].get<double>());
}

Result<Exit> bench(const Args& args) {
    std::vector<std::string> names = args.scenes;
    if (names.empty())
        for (const SceneInfo& info : scenes()) names.emplace_back(info.name);
    if (!args.json)
        std::printf("%-16s %6s %8s %10s %10s %9s %8s %8s %8s %8s %6s\n", "scene", "bodies", "contacts",
                    "tick us", "p99 us", "bytes", "save us", "load us", "hash us", "copy us", "ratio");
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const std::string& name : names) {
        const Result<nlohmann::ordered_json> row = measure(name, args);
        if (!row) return row.error();
        if (!args.json) print_row(*row);
        all.push_back(*row);
    }
    if (args.json) std::printf("%s\n", all.dump(2).c_str());
    return Exit::good;
}

} // namespace

void add_bench(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "bench",
                      "Time ticks, saves, restores and hashes, beside a memcpy of the same bytes.", describe,
                      bench);
}

} // namespace lockstone::cli
