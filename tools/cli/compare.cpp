// The command `lockstone compare`.
#include "cli/commands.h"
#include "cli/gnuplot.h"
#include "cli/text.h"
#include "cli/timing.h"
#include "reference/drift.h"
#include "reference/plot.h"
#include "reference/scenes.h"
#include "json/json.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

namespace lockstone::cli {
namespace {

using json::Value;
using reference::Sample;

struct Args {
    std::string scene, integrator = "semi-implicit-euler", plot;
    SceneOptions options;
    std::uint32_t iterations = 200, substeps = 0;
    std::uint64_t ticks = 0;
    bool gyroscopic = false, drift = false, json = false;
};

const std::map<std::string, reference::Integrator> integrators{
    {"semi-implicit-euler", reference::Integrator::semi_implicit_euler},
    {"verlet", reference::Integrator::verlet},
    {"velocity-verlet", reference::Integrator::velocity_verlet},
    {"runge-kutta-4", reference::Integrator::runge_kutta_4}};

void describe(CLI::App& command, Args& args) {
    std::string scenes;
    for (const reference::CompareScene& scene : reference::compare_scenes())
        scenes += std::string(scene.name) + ", ";
    add_text(command, "SCENE", args.scene, scenes + "or a scene of `lockstone scenes`").required();
    add_number(command, "--ticks", args.ticks, "number of ticks; 0: enough to show the scene", 0, 1000000);
    add_number(command, "--size", args.options.size,
               "number of objects in the scene; 0: the default for a comparison");
    add_number(command, "--seed", args.options.seed, "seed of placement and random numbers");
    std::vector<std::string> names;
    for (const auto& [name, integrator] : integrators) names.push_back(name);
    add_text(command, "--integrator", args.integrator, "integrator of the thesis' engine")
        .one_of(names)
        .show_default();
    add_number(command, "--iterations", args.iterations,
               "largest number of iterations of the thesis' resolver, 1 to 1000000, for positions and then "
               "for velocities",
               1, 1000000);
    add_number(command, "--substeps", args.substeps,
               "number of substeps in a tick of the thesis' engine, up to 64; 0: as many as in Lockstone", 0,
               64);
    add_flag(command, "--gyroscopic", args.gyroscopic,
             "add the gyroscopic term, which the thesis leaves out, to the thesis' engine");
    add_flag(command, "--drift", args.drift,
             "print only how far builds of the thesis' engine differ, and that builds of Lockstone do not");
    add_text(command, "--plot", args.plot, "SVG picture to draw with gnuplot").type_name("FILE.svg");
    add_flag(command, "--json", args.json, "print the results as JSON");
}

/// The results of a comparison.
struct Found {
    std::size_t bodies = 0;
    double tick_rate = 60;
    std::vector<Sample> samples;
    std::vector<reference::DriftLine> drifts;
};

double size_of(const reference::Vec& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

/// The tick of the first sample that fulfils `is`; 0 if no sample does.
template <class Is> std::uint64_t first_tick(const std::vector<Sample>& samples, Is is) {
    const auto found = std::find_if(samples.begin(), samples.end(), is);
    return found == samples.end() ? 0 : found->tick;
}
std::uint64_t apart_by(const Found& found, double metres) {
    return first_tick(found.samples, [&](const Sample& s) { return s.separation_max > metres; });
}
double deepest(const std::vector<Sample>& samples, reference::Measures Sample::*whose) {
    double worst = 0;
    for (const Sample& s : samples) worst = std::max(worst, (s.*whose).penetration);
    return worst;
}
double median_cost(const std::vector<Sample>& samples, double Sample::*cost) {
    std::vector<double> all;
    for (const Sample& s : samples) all.push_back(s.*cost);
    return median(std::move(all));
}

void print_row(const Sample& s) {
    std::printf("%6llu %10.2e %10.2e %12.2f %12.2f %10.2f %10.2f %8.2f %8.2f %8.0f %8.0f\n",
                static_cast<unsigned long long>(s.tick), s.separation_max, s.separation_mean, s.ours.energy(),
                s.theirs.energy(), size_of(s.ours.momentum), size_of(s.theirs.momentum),
                1000 * s.ours.penetration, 1000 * s.theirs.penetration, s.our_us, s.their_us);
}

std::string tick_text(std::uint64_t tick) { return tick == 0 ? "never" : "tick " + std::to_string(tick); }
std::string tick_text(std::optional<std::uint64_t> tick) { return tick_text(tick.value_or(0)); }

void print_samples(const Found& found) {
    std::printf("%6s %21s %25s %21s %17s %17s\n", "", "apart m", "energy J", "momentum N s", "overlap mm",
                "us a tick");
    std::printf("%6s %10s %10s %12s %12s %10s %10s %8s %8s %8s %8s\n", "tick", "farthest", "mean", "ours",
                "thesis", "ours", "thesis", "ours", "thesis", "ours", "thesis");
    const std::size_t step = std::max<std::size_t>(1, found.samples.size() / 12);
    for (std::size_t i = step - 1; i < found.samples.size(); i += step) print_row(found.samples[i]);
    std::printf(
        "first contact: ours %s, thesis %s\n",
        tick_text(first_tick(found.samples, [](const Sample& s) { return s.ours_touched; })).c_str(),
        tick_text(first_tick(found.samples, [](const Sample& s) { return s.theirs_touched; })).c_str());
    std::printf("apart by 1 cm: %s, 10 cm: %s, 1 m: %s\n", tick_text(apart_by(found, 0.01)).c_str(),
                tick_text(apart_by(found, 0.1)).c_str(), tick_text(apart_by(found, 1)).c_str());
    std::printf("deepest overlap: ours %.2f mm, thesis %.2f mm; median tick: ours %.0f us, thesis %.0f us\n",
                1000 * deepest(found.samples, &Sample::ours), 1000 * deepest(found.samples, &Sample::theirs),
                median_cost(found.samples, &Sample::our_us), median_cost(found.samples, &Sample::their_us));
}

void print(const Args& args, const Found& found) {
    if (!found.samples.empty()) {
        std::printf("%s: %zu bodies; the thesis' engine with %s and %u iterations\n", args.scene.c_str(),
                    found.bodies, args.integrator.c_str(), args.iterations);
        print_samples(found);
    }
    for (const reference::DriftLine& line : found.drifts)
        std::printf("built twice: %s against %s: first difference: %s, 1 mm apart: %s\n", line.name.c_str(),
                    line.against.c_str(), tick_text(line.parts_at).c_str(),
                    tick_text(line.apart_by(0.001)).c_str());
}

Value json_of(const reference::Measures& m) {
    return {{"kinetic_j", m.kinetic},
            {"potential_j", m.potential},
            {"momentum_ns", {m.momentum.x, m.momentum.y, m.momentum.z}},
            {"angular_momentum_nms", {m.angular_momentum.x, m.angular_momentum.y, m.angular_momentum.z}},
            {"penetration_m", m.penetration}};
}

Value json_of(const std::optional<std::uint64_t>& tick) { return tick ? Value(*tick) : Value(); }

Value json_of(const Args& args, const Found& found) {
    Value ticks = Value::array(), drifts = Value::array();
    for (const Sample& s : found.samples)
        ticks.push_back({{"tick", s.tick},
                         {"separation_max_m", s.separation_max},
                         {"separation_mean_m", s.separation_mean},
                         {"ours", json_of(s.ours)},
                         {"thesis", json_of(s.theirs)},
                         {"ours_us", s.our_us},
                         {"thesis_us", s.their_us},
                         {"ours_touched", s.ours_touched},
                         {"thesis_touched", s.theirs_touched}});
    for (const reference::DriftLine& line : found.drifts)
        drifts.push_back({{"name", line.name},
                          {"against", line.against},
                          {"parts_at", json_of(line.parts_at)},
                          {"apart_1mm_at", json_of(line.apart_by(0.001))},
                          {"apart_m", line.apart}});
    return {{"scene", args.scene},           {"bodies", found.bodies}, {"integrator", args.integrator},
            {"iterations", args.iterations}, {"ticks", ticks},         {"drift", drifts}};
}

Result<Found> find(const Args& args, const reference::Settings& settings, std::uint64_t ticks) {
    Found found;
    Result<std::unique_ptr<Game>> game = reference::make_compare_scene(args.scene, args.options);
    if (!game) return game.error();
    Result<reference::SideBySide> both =
        reference::SideBySide::create(std::move(*game), settings, args.options.seed);
    if (!both) return Error{args.scene + ": " + both.error().message};
    found.bodies = both->theirs().bodies().size();
    found.tick_rate = both->ours().def().tick_rate;
    for (std::uint64_t tick = 0; tick < ticks && !args.drift; ++tick) {
        if (const Status done = both->tick(); !done) return Error{args.scene + ": " + done.error().message};
        found.samples.push_back(both->sample());
    }
    Result<std::vector<reference::DriftLine>> drifts = reference::all_drifts(both->game(), settings, ticks);
    if (!drifts) return Error{args.scene + ": " + drifts.error().message};
    found.drifts = std::move(*drifts);
    return found;
}

Result<Exit> act(const Args& args) {
    if (const Status can = check_outputs({args.plot}); !can) return can.error();
    const reference::CompareScene* scene = reference::find_compare_scene(args.scene);
    const std::uint64_t own = scene != nullptr ? scene->ticks : 600;
    const auto iterations = static_cast<int>(args.iterations);
    const reference::Settings settings{.integrator = integrators.at(args.integrator),
                                       .substeps = static_cast<int>(args.substeps),
                                       .position_iterations = iterations,
                                       .velocity_iterations = iterations,
                                       .gyroscopic = args.gyroscopic};
    const Result<Found> found = find(args, settings, args.ticks != 0 ? args.ticks : own);
    if (!found) return found.error();
    if (args.json)
        std::printf("%s\n", json_of(args, *found).dump(2).c_str());
    else
        print(args, *found);
    if (args.plot.empty()) return Exit::good;
    const reference::Drawn drawn{args.scene, found->tick_rate, found->samples, found->drifts};
    if (const Status done = draw(reference::plot_script(drawn, args.plot), args.plot); !done)
        return done.error();
    return Exit::good;
}

} // namespace

void add_compare(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "compare",
                      "Run a scene in Lockstone and in the thesis' floating-point engine, and compare them; "
                      "see tools/reference/README.md.",
                      describe, act);
}

} // namespace lockstone::cli
