#include "bench/parts.h"

#include "bench/games.h"
#include "bench/state_costs.h"
#include "scenes/scenes.h"

#include <algorithm>
#include <fstream>

#include <stdlib.h>

namespace lockstone::bench {
namespace {

using namespace engines;
using Done = std::function<void(const std::string& key, const Json& row)>;

constexpr const char* extra_parts[] = {"state", "awake", "scaling", "verify", "arena", "threads", "front"};
constexpr const char* not_by_default[] = {"threads", "front"};
constexpr const char* threaded_scenes[] = {"S1", "S2", "S3", "S4", "grid"};
constexpr const char* state_scenes[] = {"S1", "S2", "S4", "S6"};
constexpr const char* front_scenes[] = {"S1", "S2", "S3", "S4", "S5", "S6"};

bool is_scene(const std::string& name) {
    const std::vector<std::string> names = scene_names();
    return std::ranges::find(names, name) != names.end();
}

Size size_of(const Plan& plan) { return plan.quick ? Size::quick : Size::full; }
ContestPlan contest_plan(const Plan& plan) {
    return {.ticks = plan.quick ? 3 : plan.ticks, .runs = plan.quick ? 1 : plan.runs};
}

/// What was measured where: without it a figure says nothing.
Json settings(const Plan& plan) {
    std::string cpu = "unknown";
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name")) {
            cpu = line.substr(line.find(':') + 2);
            break;
        }
    double load[1] = {0};
    getloadavg(load, 1);
    return {{"cpu", cpu},
            {"load", load[0]},
            {"compiler", __VERSION__},
            {"quick", plan.quick},
            {"runs", plan.runs},
            {"rate", 60},
            {"sleeping", false},
            {"threads", 1},
            {"bullet", is_built(Product::bullet)},
            {"ode", is_built(Product::ode)}};
}

Json scaling_row(int count, const Plan& plan) {
    const BenchScene scene = resting_boxes(count);
    ContestPlan how = contest_plan(plan);
    how.is_judged = false;
    std::vector<Contestant> who = chosen_contestants(plan);
    const std::vector<Run> runs = contest(scene, who, how);
    Json row{{"bodies", count}};
    for (const Run& run : runs)
        row[run.who.name] = {{"us_per_body", percentile(run.tick_us, 0.5) / count},
                             {"heap_bytes_per_body", 1e6 * run.heap_mb / count}};
    return row;
}

/// Boxes at rest, from few to very many: what a body costs must not depend on how many there are.
Json scaling(const Plan& plan, const Done& done) {
    Json rows = Json::array();
    for (const int count : {100, 1000, 10000, 50000}) {
        if (plan.quick && count > 100) break;
        rows.push_back(scaling_row(count, plan));
        done("scaling", rows.back());
    }
    return rows;
}

/// One and two workers in turn, by the wall.
Json threads(const Plan& plan, const Done& done) {
    Json rows = Json::array();
    for (const char* name : threaded_scenes) {
        const BenchScene scene = make_bench_scene(name, size_of(plan));
        ContestPlan how = contest_plan(plan);
        how.is_judged = false;
        const std::vector<Contestant> who{{.name = "1", .by_wall = true},
                                          {.name = "2", .threads = 2, .by_wall = true}};
        const std::vector<Run> runs = contest(scene, who, how);
        rows.push_back({{"scene", name},
                        {"one_ms", mean(runs[0].tick_us) / 1e3},
                        {"two_ms", mean(runs[1].tick_us) / 1e3},
                        {"times_faster", mean(runs[0].tick_us) / mean(runs[1].tick_us)},
                        {"must", 1.5}});
        done("threads", rows.back());
    }
    return rows;
}

/// Cost against quality: Lockstone at several substeps, Bullet at several iterations.
Json front(const Plan& plan, const Done& done) {
    Json rows = Json::array();
    std::vector<Contestant> who;
    for (const int substeps : plan.substeps.empty() ? std::vector{2, 4, 8, 16} : plan.substeps)
        who.push_back({.name = "Lockstone " + std::to_string(substeps), .substeps = substeps});
    if (is_built(Product::bullet))
        for (const int iterations : {5, 10, 20, 40})
            who.push_back({.name = "Bullet " + std::to_string(iterations),
                           .product = Product::bullet,
                           .iterations = iterations});
    for (const char* name : front_scenes) {
        const BenchScene scene = make_bench_scene(name, size_of(plan));
        rows.push_back(json_of(scene, contest(scene, who, contest_plan(plan))));
        done("front", rows.back());
    }
    return rows;
}

Json states(const Plan& plan, const Done& done) {
    Json rows = Json::array();
    for (const char* name : state_scenes) {
        rows.push_back(
            state_costs(make_bench_scene(name, size_of(plan)), chosen_contestants(plan)[0], plan.quick));
        done("state", rows.back());
    }
    return rows;
}

Result<Json> run_extra(const std::string& part, const Plan& plan, const Done& done) {
    if (part == "state") return states(plan, done);
    if (part == "scaling") return scaling(plan, done);
    if (part == "threads") return threads(plan, done);
    if (part == "front") return front(plan, done);
    Result<Json> row = part == "verify"  ? verify_speed(plan.quick)
                       : part == "arena" ? arena_cost(plan.quick)
                                         : Result<Json>(awake_costs(plan.quick));
    if (row) done(part, *row);
    return row;
}

} // namespace

std::vector<std::string> part_names() {
    std::vector<std::string> names = scene_names();
    names.insert(names.end(), std::begin(extra_parts), std::end(extra_parts));
    return names;
}

Status check_parts(const std::vector<std::string>& parts) {
    const std::vector<std::string> known = part_names();
    for (const std::string& part : parts) {
        if (std::ranges::find(known, part) != known.end() || find_scene(part) != nullptr) continue;
        std::string list;
        for (const std::string& one : known) list += " " + one;
        return Error{"bench: there is nothing to measure called '" + part + "'; there are" + list +
                     ", and the scenes of `lockstone scenes`"};
    }
    return {};
}

std::vector<BenchScene> chosen_scenes(const Plan& plan) {
    std::vector<BenchScene> scenes;
    for (const std::string& name : plan.parts.empty() ? scene_names() : plan.parts)
        if (is_scene(name)) scenes.push_back(make_bench_scene(name, size_of(plan)));
    return scenes;
}

std::vector<Contestant> chosen_contestants(const Plan& plan) {
    std::vector<Contestant> who = default_contestants();
    if (plan.substeps.empty()) return who;
    who.erase(who.begin());
    std::vector<Contestant> ours;
    for (const int substeps : plan.substeps)
        ours.push_back({.name = "Lockstone " + std::to_string(substeps), .substeps = substeps});
    who.insert(who.begin(), ours.begin(), ours.end());
    return who;
}

Result<Json> run_parts(const Plan& plan, const Done& done) {
    Json all{{"settings", settings(plan)}};
    std::vector<std::string> parts = plan.parts;
    if (parts.empty()) {
        parts = part_names();
        std::erase_if(parts, [](const std::string& part) {
            return std::ranges::find(not_by_default, part) != std::end(not_by_default);
        });
    }
    for (const std::string& part : parts) {
        if (is_scene(part)) {
            const BenchScene scene = make_bench_scene(part, size_of(plan));
            all["scenes"].push_back(
                json_of(scene, contest(scene, chosen_contestants(plan), contest_plan(plan))));
            done("scenes", all["scenes"].back());
        } else if (find_scene(part) != nullptr) {
            const Result<Json> row = game_cost(part, plan.quick);
            if (!row) return row.error();
            all["games"].push_back(*row);
            done("games", *row);
        } else {
            Result<Json> rows = run_extra(part, plan, done);
            if (!rows) return rows.error();
            all[part] = std::move(*rows);
        }
    }
    return all;
}

} // namespace lockstone::bench
