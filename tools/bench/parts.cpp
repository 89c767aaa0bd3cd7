#include "bench/parts.h"

#include "bench/clock.h"
#include "bench/games.h"
#include "bench/rows/rows.h"
#include "bench/state_costs.h"
#include "scenes/scenes.h"

#include <algorithm>
#include <atomic>
#include <fstream>
#include <thread>

#include <stdlib.h>

namespace lockstone::bench {
namespace {

using namespace engines;
using Done = std::function<void(const std::string& key, const Json& row)>;

constexpr const char* extra_parts[] = {"state", "awake", "scaling", "verify", "arena", "threads", "front"};
constexpr const char* all_rows = "rows";
constexpr const char* not_by_default[] = {"threads", "front"};
constexpr const char* threaded_scenes[] = {"S1", "S2", "S3", "S4", "grid"};
constexpr const char* state_scenes[] = {"S1", "S2", "S4", "S6"};
constexpr const char* front_scenes[] = {"S1", "S2", "S3", "S4", "S5", "S6"};

constexpr double heap_of_50000_mb = 270; ///< twice that of Box3D
/// The time of Jolt for a rollback of eight ticks of S6, divided by the time of one tick of Bullet in the same run.
constexpr double jolt_rollback_in_bullet_ticks = 1400.0 / 315;
constexpr double snapshot_bytes_per_body = 700; ///< with all contacts, in S1 and S2

bool is_scene(const std::string& name) {
    const std::vector<std::string> names = scene_names();
    return std::ranges::find(names, name) != names.end();
}

/// Replaces the name "rows" by the names of all rows.
std::vector<std::string> expanded(const std::vector<std::string>& parts) {
    std::vector<std::string> all;
    for (const std::string& part : parts)
        if (part == all_rows)
            for (const Maker& row : rows::makers()) all.emplace_back(row.name);
        else
            all.push_back(part);
    return all;
}

Size size_of(const Plan& plan) { return plan.quick ? Size::quick : Size::full; }
ContestPlan contest_plan(const Plan& plan) {
    return {.ticks = plan.quick ? 3 : plan.ticks, .runs = plan.quick ? 1 : plan.runs};
}

/// The conditions of a measurement. Figures are comparable only together with them.
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

/// Resting boxes in growing numbers: the cost of a body must not depend on the number of bodies.
Json scaling(const Plan& plan, const Done& done) {
    Json rows = Json::array();
    double least = 1e9, most = 0;
    for (const int count : {100, 1000, 10000, 50000}) {
        if (plan.quick && count > 100) break;
        Json row = scaling_row(count, plan);
        const Json& ours = row.at(chosen_contestants(plan)[0].name);
        const double us = ours.at("us_per_body").as_double(),
                     heap = ours.at("heap_bytes_per_body").as_double();
        if (count >= 1000) least = std::min(least, us), most = std::max(most, us);
        row["verdicts"] = Json::array();
        if (count == 50000) {
            row["verdicts"].push_back(
                at_most("dearest / cheapest body, 1,000 to 50,000", most / least, 1.25));
            row["verdicts"].push_back(at_most("heap, MB", 1e-6 * heap * count, heap_of_50000_mb));
        }
        done("scaling", row);
        rows.push_back(std::move(row));
    }
    return rows;
}

/// The time that two cores take to answer each other through one cache line, there and back [ns]: the least mean of
/// many runs of round trips.
double round_trip_ns() {
    constexpr int runs = 40, trips = 2000;
    double least = 1e9;
    for (int run = 0; run < runs; ++run) {
        alignas(64) std::atomic<int> turn{0};
        std::thread other([&turn] {
            for (int i = 0; i < trips; ++i) {
                while (turn.load(std::memory_order_acquire) != 2 * i + 1) {}
                turn.store(2 * i + 2, std::memory_order_release);
            }
        });
        turn.store(1, std::memory_order_release); // the first trip includes the start of the thread
        while (turn.load(std::memory_order_acquire) != 2) {}
        const double spent = wall_us([&turn] {
            for (int i = 1; i < trips; ++i) {
                turn.store(2 * i + 1, std::memory_order_release);
                while (turn.load(std::memory_order_acquire) != 2 * i + 2) {}
            }
        });
        other.join();
        least = std::min(least, 1e3 * spent / (trips - 1));
    }
    return least;
}

/// Compares one worker with two and with four, in turns, by wall time. The gain of two depends on how fast the cores
/// answer each other, so the bound does too.
Json threads(const Plan& plan, const Done& done) {
    constexpr double near_ns = 120; // cores of one cluster answer within 90 ns, those of two within 400
    Json rows = Json::array();
    for (const char* name : threaded_scenes) {
        const BenchScene scene = make_bench_scene(name, size_of(plan));
        ContestPlan how = contest_plan(plan);
        how.is_judged = false;
        const std::string simd = plan.simd.empty() ? std::string{} : plan.simd[0];
        const std::vector<Contestant> who{{.name = "1", .simd = simd, .by_wall = true},
                                          {.name = "2", .threads = 2, .simd = simd, .by_wall = true},
                                          {.name = "4", .threads = 4, .simd = simd, .by_wall = true}};
        const double before = round_trip_ns();
        const std::vector<Run> runs = contest(scene, who, how);
        const double answer = std::max(before, round_trip_ns());
        rows.push_back({{"scene", name},
                        {"one_ms", mean(runs[0].tick_us) / 1e3},
                        {"two_ms", mean(runs[1].tick_us) / 1e3},
                        {"four_ms", mean(runs[2].tick_us) / 1e3},
                        {"round_trip_ns", answer},
                        {"times_faster", mean(runs[0].tick_us) / mean(runs[1].tick_us)},
                        {"must", answer <= near_ns ? 1.5 : 1.3}});
        done("threads", rows.back());
    }
    return rows;
}

/// Cost against quality: Lockstone with several numbers of substeps, Bullet with several numbers of iterations.
Json front(const Plan& plan, const Done& done) {
    Json rows = Json::array();
    std::vector<Contestant> who;
    for (const int substeps : plan.substeps.empty() ? std::vector{2, 4, 8, 16} : plan.substeps)
        who.push_back({.name = "Lockstone " + std::to_string(substeps), .substeps = substeps});
    if (is_built(Product::bullet))
        for (const int iterations : {5, 10, 20, 40})
            who.push_back(bullet_as_it_comes("Bullet " + std::to_string(iterations), iterations));
    for (const char* name : front_scenes) {
        const BenchScene scene = make_bench_scene(name, size_of(plan));
        rows.push_back(json_of(scene, contest(scene, who, contest_plan(plan))));
        done("front", rows.back());
    }
    return rows;
}

/// The verdicts on the state costs. S6 is the scene whose rollback is judged.
Json state_verdicts(const Json& row, const Plan& plan) {
    Json list = Json::array();
    const std::string name = row.at("scene").as_text();
    if (name == "S1" || name == "S2")
        list.push_back(
            at_most("snapshot, bytes a body", row.at("bytes_per_body").as_double(), snapshot_bytes_per_body));
    if (name != "S6") return list;
    const Json& eight = row.at("rollbacks").at(0);
    list.push_back(at_most("rollback of 8 ticks / its ticks", eight.at("ratio").as_double(), 1.05));
    if (!is_built(Product::bullet)) return list;
    ContestPlan how = contest_plan(plan);
    how.is_judged = false;
    const std::vector<Run> bullet =
        contest(make_bench_scene("S6", size_of(plan)), {bullet_as_it_comes("Bullet")}, how);
    const double jolt_us = jolt_rollback_in_bullet_ticks * mean(bullet[0].tick_us);
    list.push_back(
        at_most("rollback of 8 ticks, us, Jolt's here", eight.at("rollback_us").as_double(), jolt_us));
    return list;
}

Json states(const Plan& plan, const Done& done) {
    Json rows = Json::array();
    for (const char* name : state_scenes) {
        Json row =
            state_costs(make_bench_scene(name, size_of(plan)), chosen_contestants(plan)[0], plan.quick);
        row["verdicts"] = state_verdicts(row, plan);
        done("state", row);
        rows.push_back(std::move(row));
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
    std::vector<std::string> known = part_names();
    known.emplace_back(all_rows);
    for (const std::string& part : parts) {
        if (std::ranges::find(known, part) != known.end() || find_scene(part) != nullptr) continue;
        std::string list;
        for (const std::string& one : known) list += " " + one;
        return Error{"bench: there is no part '" + part + "'; the parts are" + list +
                     ", and the scenes of `lockstone scenes`"};
    }
    return {};
}

std::vector<BenchScene> chosen_scenes(const Plan& plan) {
    std::vector<BenchScene> scenes;
    for (const std::string& name : plan.parts.empty() ? scene_names() : expanded(plan.parts))
        if (is_scene(name)) scenes.push_back(make_bench_scene(name, size_of(plan)));
    return scenes;
}

std::vector<Contestant> chosen_contestants(const Plan& plan) {
    std::vector<Contestant> who = default_contestants();
    if (plan.substeps.empty() && plan.simd.empty()) return who;
    who.erase(who.begin());
    std::vector<Contestant> ours;
    for (const int substeps : plan.substeps)
        ours.push_back({.name = "Lockstone " + std::to_string(substeps), .substeps = substeps});
    for (const std::string& simd : plan.simd) ours.push_back({.name = "Lockstone " + simd, .simd = simd});
    who.insert(who.begin(), ours.begin(), ours.end());
    return who;
}

Result<Json> run_parts(const Plan& plan, const Done& done) {
    Json all{{"settings", settings(plan)}};
    std::vector<std::string> parts = expanded(plan.parts);
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
