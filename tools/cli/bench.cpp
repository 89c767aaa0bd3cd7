// The command `lockstone bench`.
#include "bench/instructions.h"
#include "bench/parts.h"
#include "bench/plot.h"
#include "bench/print.h"
#include "bench/profile.h"
#include "cli/commands.h"
#include "cli/gnuplot.h"
#include "cli/text.h"

#include <cstdio>
#include <sstream>

namespace lockstone::cli {
namespace {

using bench::Json;

struct Args {
    std::vector<std::string> parts;
    std::vector<int> substeps;
    std::uint32_t ticks = 0, runs = 3;
    bool json = false, quick = false, instructions = false;
    std::string simd, keep, counted, profile, plot;
};

void describe(CLI::App& command, Args& args) {
    add_texts(
        command, "PART", args.parts,
        "S1 to S6, pyramids, grid, drum, S4-plane; trees, logs, bullets, kinematic-drum, "
        "kinematic-drum-unswept, ragdoll-rain, ragdolls-50, spring-chains, tower, large-pyramid, characters, "
        "vehicles, explosions, churn, static-first, static-creation, creation; rays-bodies, rays-mesh, "
        "ball-cast-mesh, box-cast-mesh, ball-overlap-mesh, box-overlap-mesh, casts-bodies, overlaps-bodies; "
        "rows: all from trees on; state, awake, scaling, verify, arena, threads, front, or a scene of "
        "`lockstone scenes`; none: all but threads, front and those scenes");
    add_number(command, "--ticks", args.ticks,
               "to time, with --instructions: before those that count; 0: as the scene asks for", 0, 1000000);
    add_number(command, "--runs", args.runs, "of each scene: of each tick the least counts", 1, 100);
    add_numbers(command, "--substeps", args.substeps,
                "of Lockstone, 1 to 16; several, with commas: each is a contestant", 1, 16);
    add_text(command, "--simd", args.simd,
             "of Lockstone: scalar, sse41, avx2, avx512, neon, wasm128; several, with commas: each is a "
             "contestant");
    add_flag(command, "--json", args.json, "for programs");
    add_flag(command, "--quick", args.quick, "a few ticks of small scenes: whether all runs, not how fast");
    add_flag(command, "--instructions", args.instructions,
             "count them under callgrind, in the chosen scenes");
    add_text(command, "--keep", args.keep, "with --instructions: a folder for the files of callgrind");
    add_text(command, "--profile", args.profile, "FILE.json: the chosen scenes by phases, as a Chrome trace");
    add_text(command, "--plot", args.plot, "FILE.svg: a picture of the scenes, or of 'front', by gnuplot");
    // Set by --instructions for its child process under callgrind.
    add_text(command, "--counted", args.counted, "").hide();
}

void print(const Args& args, const Json& rows, void (*print_rows)(const Json&)) {
    if (args.json)
        std::printf("%s\n", rows.dump(2).c_str());
    else
        print_rows(rows);
}

Result<Exit> measure(const Args& args, const bench::Plan& plan) {
    const Result<Json> all = bench::run_parts(plan, [&](const std::string& key, const Json& row) {
        if (!args.json) bench::print_row(key, row);
    });
    if (!all) return all.error();
    if (args.json) std::printf("%s\n", all->dump(2).c_str());
    if (!args.json) bench::print_settings(all->at("settings"));
    if (args.plot.empty()) return Exit::good;
    const Result<std::string> script = bench::plot_script(*all, args.plot);
    if (!script) return script.error();
    if (const Status drawn = draw(*script, args.plot); !drawn) return drawn.error();
    return Exit::good;
}

/// The parts of a text between commas.
std::vector<std::string> split(const std::string& names) {
    std::vector<std::string> parts;
    std::istringstream in(names);
    for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
    return parts;
}

Result<Exit> act(const Args& args) {
    const bench::Plan plan{.parts = args.parts,
                           .substeps = args.substeps,
                           .simd = split(args.simd),
                           .ticks = static_cast<int>(args.ticks),
                           .runs = static_cast<int>(args.runs),
                           .quick = args.quick};
    if (const Status known = bench::check_parts(plan.parts); !known) return known.error();
    if (const Status can = check_outputs({args.profile, args.plot}); !can) return can.error();
    for (const std::string& simd : plan.simd)
        if (const Status has = check_simd(simd); !has) return has.error();
    const engines::Contestant ours = bench::chosen_contestants(plan)[0];
    std::vector<bench::BenchScene> scenes = bench::chosen_scenes(plan);
    if (plan.ticks != 0)
        for (bench::BenchScene& scene : scenes) scene.counted_from = plan.ticks;
    if (!args.counted.empty()) {
        const Status done = bench::run_counted(scenes.at(0), ours, args.counted);
        if (!done) return done.error();
        return Exit::good;
    }
    if (args.instructions || !args.profile.empty()) {
        const Result<Json> rows =
            args.instructions ? bench::count_instructions(scenes, ours, args.keep)
                              : bench::profile(scenes, ours, plan.quick ? 3 : plan.ticks, args.profile);
        if (!rows) return rows.error();
        print(args, *rows, args.instructions ? bench::print_instructions : bench::print_profile);
        return Exit::good;
    }
    return measure(args, plan);
}

} // namespace

void add_bench(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "bench",
                      "Times beside Bullet and ODE, and what they are worth: tools/bench/README.md.",
                      describe, act);
}

} // namespace lockstone::cli
