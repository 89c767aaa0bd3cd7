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
        "parts to measure: S1 to S6, pyramids, grid, drum, S4-plane; trees, logs, bullets, kinematic-drum, "
        "kinematic-drum-unswept, ragdoll-rain, ragdolls-50, spring-chains, tower, large-pyramid, characters, "
        "vehicles, explosions, churn, static-first, static-creation, creation; rays-bodies, rays-mesh, "
        "ball-cast-mesh, box-cast-mesh, ball-overlap-mesh, box-overlap-mesh, casts-bodies, overlaps-bodies; "
        "rows: all parts from trees to overlaps-bodies; state, awake, scaling, verify, arena, threads, "
        "front, or a scene of `lockstone scenes`; default: all parts except threads, front and the scenes of "
        "`lockstone scenes`");
    add_number(command, "--ticks", args.ticks,
               "number of ticks to time; with --instructions, number of ticks before the counted ticks; 0: "
               "the scene's own number",
               0, 1000000);
    add_number(command, "--runs", args.runs,
               "number of runs of each scene, 1 to 100; the time of a tick is the shortest of all runs", 1,
               100);
    add_numbers(
        command, "--substeps", args.substeps,
        "substeps of Lockstone, 1 to 16; several values, separated by commas, are measured separately", 1,
        16);
    add_text(command, "--simd", args.simd,
             "instruction set of Lockstone: scalar, sse41, avx2, avx512, neon, wasm128; several values, "
             "separated by commas, are measured separately");
    add_flag(command, "--json", args.json, "print the results as JSON");
    add_flag(command, "--quick", args.quick,
             "run only a few ticks of small scenes, to check that every part works; the times mean little");
    add_flag(command, "--instructions", args.instructions,
             "count the instructions of the chosen scenes with callgrind");
    add_text(command, "--keep", args.keep, "folder for the output files of callgrind, with --instructions");
    add_text(command, "--profile", args.profile,
             "FILE.json: write the phases of the chosen scenes as a Chrome trace");
    add_text(command, "--plot", args.plot, "FILE.svg: draw the chosen scenes, or 'front', with gnuplot");
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
                      "Measure Lockstone next to Bullet and ODE; tools/bench/README.md explains the results.",
                      describe, act);
}

} // namespace lockstone::cli
