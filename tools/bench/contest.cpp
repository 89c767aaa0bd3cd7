#include "bench/contest.h"

#include "bench/clock.h"
#include "engines/lockstone_engine.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <malloc.h>

namespace lockstone::bench {
namespace {

using namespace engines;

constexpr int block = 5; ///< ticks that an engine runs before the next engine's turn

double heap_bytes() {
    const struct mallinfo2 info = mallinfo2();
    return static_cast<double>(info.uordblks + info.hblkhd);
}

/// An engine and the memory that it has allocated. During its turn no other code allocates memory.
struct Lane {
    Product product;
    std::unique_ptr<Engine> engine = nullptr;
    double heap = 0;
    std::vector<double> tick_us = {};
    double joint_worst_mm = 0;
    std::size_t near_most = 0;

    Lane(const Contestant& who, const Scene& scene) : product(who.product) {
        const double before = heap_bytes();
        engine = make_engine(who, scene);
        heap = heap_bytes() - before;
    }

    void advance(const BenchScene& scene, int from, int to, bool timed) {
        for (int tick = from; tick < to; ++tick) {
            if (scene.script) scene.script(*engine, tick);
            const double heap_before = heap_bytes(), spent = timed_act(scene, *engine, tick);
            heap += heap_bytes() - heap_before;
            if (timed) tick_us.push_back(spent);
            joint_worst_mm = std::max(joint_worst_mm, widest_joint_mm(scene.scene, *engine));
            if (scene.target.near_points != 0) near_most = std::max(near_most, near_points());
        }
    }

    /// The number of contact points of the last tick that do not touch; 0 for other engines.
    std::size_t near_points() const {
        if (product != Product::lockstone) return 0;
        const auto points = world_of(*engine).contacts();
        return static_cast<std::size_t>(
            std::ranges::count_if(points, [](const auto& point) { return point.separation > Separation{}; }));
    }
};

std::vector<Run> run_once(const BenchScene& scene, const std::vector<Contestant>& who, int ticks,
                          int judged_after) {
    std::vector<Lane> lanes;
    for (const Contestant& one : who) lanes.emplace_back(one, scene.scene);
    for (Lane& lane : lanes) lane.advance(scene, 0, scene.settle, false);
    const int end = scene.settle + ticks;
    for (int tick = scene.settle; tick < end; tick += block)
        for (Lane& lane : lanes) lane.advance(scene, tick, std::min(tick + block, end), true);
    std::vector<Run> runs;
    for (std::size_t i = 0; i < lanes.size(); ++i) {
        Lane& lane = lanes[i];
        Run run{.who = who[i], .tick_us = std::move(lane.tick_us), .heap_mb = lane.heap / 1e6};
        if (judged_after > 0) {
            lane.advance(scene, end, scene.settle + judged_after, false);
            run.quality = quality_of(scene, *lane.engine);
            if (scene.figure) run.figure = scene.figure(*lane.engine);
        }
        run.joint_worst_mm = lane.joint_worst_mm;
        if (who[i].product == Product::lockstone) {
            const World& world = world_of(*lane.engine);
            run.contacts = world.contacts().size(), run.dropped = world.faults().contacts_dropped;
            run.near_most = lane.near_most;
        }
        runs.push_back(std::move(run));
    }
    return runs;
}

Json ratio_json(const std::vector<Run>& runs, Product product) {
    const auto theirs = std::ranges::find(runs, product, [](const Run& run) { return run.who.product; });
    if (theirs == runs.end() || runs[0].who.product != Product::lockstone) return nullptr;
    return {{"mean", mean(theirs->tick_us) / mean(runs[0].tick_us)},
            {"median", percentile(theirs->tick_us, 0.5) / percentile(runs[0].tick_us, 0.5)},
            {"p99", percentile(theirs->tick_us, 0.99) / percentile(runs[0].tick_us, 0.99)}};
}

/// The 99th percentile of the ticks after the bodies have landed, divided by their mean.
double p99_per_mean(const BenchScene& scene, const Run& run) {
    const auto landed = static_cast<std::size_t>(scene.landed_after);
    if (run.tick_us.size() <= landed) return 0;
    const std::vector<double> ticks(run.tick_us.begin() + scene.landed_after, run.tick_us.end());
    return percentile(ticks, 0.99) / mean(ticks);
}

/// One entry for each figure that has a bound. The time ratio must be at least its bound, all other figures at most
/// theirs.
Json verdicts(const BenchScene& scene, const std::vector<Run>& runs, const Json& bullet_per_ours) {
    const Target& target = scene.target;
    const Run& ours = runs[0];
    Json list = Json::array();
    const auto ask = [&](const char* what, double found, double must) {
        if (must != 0) list.push_back(at_most(what, found, must));
    };
    if (target.ratio_must != 0 && !bullet_per_ours.is_null()) {
        list.push_back(at_least("Bullet / ours", bullet_per_ours.at("mean").as_double(), target.ratio_must));
        list.back()["goal"] = target.ratio_goal;
        if (target.p99_ratio_must != 0)
            list.push_back(
                at_least("Bullet / ours, p99", bullet_per_ours.at("p99").as_double(), target.p99_ratio_must));
    }
    if (target.overlap_with_static)
        ask("overlap with what is static, mm", ours.quality.overlap_static_mm, target.overlap_mm);
    else
        ask("overlap, mm", ours.quality.overlap_mm, target.overlap_mm);
    ask("sway, mm", ours.quality.sway_mm, target.sway_mm);
    if (target.sway_mm != 0) list.push_back(at_most("bodies fallen", ours.quality.fallen, 0));
    ask("widest joint of the run, mm", ours.joint_worst_mm, target.joint_mm);
    ask("p99 / mean once landed", p99_per_mean(scene, ours), target.p99_per_mean);
    ask("heap, MB", ours.heap_mb, target.heap_mb);
    ask("near points that do not touch, in any tick", static_cast<double>(ours.near_most),
        target.near_points);
    list.push_back(at_most("bodies lost", ours.quality.lost, 0));
    list.push_back(at_most("contacts dropped", static_cast<double>(ours.dropped), 0));
    return list;
}

} // namespace

Json at_most(const char* what, double found, double must) {
    return {{"what", what}, {"found", found}, {"must", must}, {"good", found <= must}};
}

Json at_least(const char* what, double found, double must) {
    return {{"what", what}, {"found", found}, {"must", must}, {"good", found >= must}};
}

double mean(const std::vector<double>& values) {
    if (values.empty()) return 0;
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double percentile(std::vector<double> samples, double fraction) {
    if (samples.empty()) return 0;
    const auto rank = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(samples.size() - 1));
    std::nth_element(samples.begin(), samples.begin() + rank, samples.end());
    return samples[static_cast<std::size_t>(rank)];
}

Contestant bullet_as_it_comes(const std::string& name, int iterations) {
    return {.name = name, .product = Product::bullet, .iterations = iterations, .default_margins = true};
}

std::vector<Contestant> default_contestants() {
    std::vector<Contestant> who{{.name = "Lockstone"}};
    if (is_built(Product::bullet)) who.push_back(bullet_as_it_comes("Bullet"));
    if (is_built(Product::ode)) who.push_back({.name = "ODE", .product = Product::ode});
    return who;
}

double timed_act(const BenchScene& scene, Engine& engine, int tick) {
    const double before = engine.seconds_spent();
    if (scene.act) return thread_us([&] { scene.act(engine, tick); });
    engine.advance(1);
    return 1e6 * (engine.seconds_spent() - before);
}

std::vector<Run> contest(const BenchScene& scene, const std::vector<Contestant>& all,
                         const ContestPlan& plan) {
    std::vector<Contestant> who = all;
    if (!scene.against_ode)
        std::erase_if(who, [](const Contestant& one) { return one.product == Product::ode; });
    const int ticks = plan.ticks != 0 ? plan.ticks : scene.ticks;
    const int judged_after = plan.ticks != 0 ? plan.ticks : scene.judged_after;
    std::vector<Run> runs = run_once(scene, who, ticks, plan.is_judged ? judged_after : 0);
    for (int i = 1; i < plan.runs; ++i) {
        const std::vector<Run> more = run_once(scene, who, ticks, 0);
        for (std::size_t k = 0; k < runs.size(); ++k)
            std::ranges::transform(runs[k].tick_us, more[k].tick_us, runs[k].tick_us.begin(),
                                   [](double a, double b) { return std::min(a, b); });
    }
    return runs;
}

Json json_of(const Run& run) {
    return {{"engine", run.who.name},
            {"mean_ms", mean(run.tick_us) / 1e3},
            {"median_ms", percentile(run.tick_us, 0.5) / 1e3},
            {"p99_ms", percentile(run.tick_us, 0.99) / 1e3},
            {"heap_mb", run.heap_mb},
            {"overlap_mm", run.quality.overlap_mm},
            {"overlap_static_mm", run.quality.overlap_static_mm},
            {"sway_mm", run.quality.sway_mm},
            {"fallen", run.quality.fallen},
            {"joint_mm", run.quality.joint_mm},
            {"joint_worst_mm", run.joint_worst_mm},
            {"lost", run.quality.lost},
            {"figure", run.figure},
            {"contacts", run.contacts},
            {"near_most", run.near_most},
            {"dropped", run.dropped}};
}

Json json_of(const BenchScene& scene, const std::vector<Run>& runs) {
    Json engines = Json::array();
    for (const Run& run : runs) engines.push_back(json_of(run));
    const Json bullet = ratio_json(runs, Product::bullet);
    return {{"scene", scene.name},
            {"about", scene.about},
            {"bodies", scene.scene.bodies.size()},
            {"joints", scene.scene.joints.size()},
            {"ticks", runs[0].tick_us.size()},
            {"stands", scene.stands},
            {"figure_name", scene.figure_name},
            {"engines", engines},
            {"bullet_per_ours", bullet},
            {"ode_per_ours", ratio_json(runs, Product::ode)},
            {"verdicts", verdicts(scene, runs, bullet)}};
}

} // namespace lockstone::bench
