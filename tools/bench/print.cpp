#include "bench/print.h"

#include <cstdio>

namespace lockstone::bench {
namespace {

double number(const Json& json, const char* key) { return json.at(key).as_double(); }
std::string text(const Json& json, const char* key) { return json.at(key).as_text(); }
std::string short_number(double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", x);
    return text;
}
const char* verdict_of(bool good) { return good ? "good" : "MISSED"; }

void print_verdict(const Json& verdict) {
    std::printf("    %-34s %9.4g, must %.4g", text(verdict, "what").c_str(), number(verdict, "found"),
                number(verdict, "must"));
    if (verdict.contains("goal")) std::printf(", goal %.4g", number(verdict, "goal"));
    std::printf("  %s\n", verdict_of(verdict.at("good").as_bool()));
}

void print_verdicts(const Json& row) {
    for (const Json& verdict : row.at("verdicts")) print_verdict(verdict);
}

void print_contest(const Json& scene) {
    std::printf("%s  %s; %d ticks\n", text(scene, "scene").c_str(), text(scene, "about").c_str(),
                scene.at("ticks").as_int());
    std::printf("    %-16s %9s %9s %9s %8s %9s %9s %9s %7s %9s %9s %5s\n", "", "mean ms", "median", "p99",
                "heap MB", "overlap", "of static", "sway mm", "fallen", "joint mm", "at worst", "lost");
    for (const Json& run : scene.at("engines")) {
        const bool stands = scene.at("stands").as_bool();
        std::printf("    %-16s %9.3f %9.3f %9.3f %8.1f %9.2f %9.2f %9s %7s %9.2f %9.2f %5d\n",
                    text(run, "engine").c_str(), number(run, "mean_ms"), number(run, "median_ms"),
                    number(run, "p99_ms"), number(run, "heap_mb"), number(run, "overlap_mm"),
                    number(run, "overlap_static_mm"),
                    stands ? short_number(number(run, "sway_mm")).c_str() : "",
                    stands ? std::to_string(run.at("fallen").as_int()).c_str() : "", number(run, "joint_mm"),
                    number(run, "joint_worst_mm"), run.at("lost").as_int());
    }
    if (const std::string name = text(scene, "figure_name"); !name.empty()) {
        std::printf("    %s:", name.c_str());
        for (const Json& run : scene.at("engines"))
            std::printf("  %s %.5g", text(run, "engine").c_str(), number(run, "figure"));
        std::printf("\n");
    }
    for (const char* peer : {"bullet", "ode"})
        if (const Json& ratio = scene.at(std::string(peer) + "_per_ours"); !ratio.is_null())
            std::printf("    %-16s %9.2f %9.2f %9.2f\n", (std::string(peer) + " / ours").c_str(),
                        number(ratio, "mean"), number(ratio, "median"), number(ratio, "p99"));
    print_verdicts(scene);
}

void print_state(const Json& row) {
    std::printf(
        "state of %s: %.0f bodies, %d contacts, %.0f bytes (%.0f a body); save %.1f us, restore %.1f, "
        "hash %.1f, memcpy %.1f; save / memcpy %.2f\n",
        text(row, "scene").c_str(), number(row, "bodies"), row.at("contacts").as_int(), number(row, "bytes"),
        number(row, "bytes_per_body"), number(row, "save_us"), number(row, "restore_us"),
        number(row, "hash_us"), number(row, "memcpy_us"), number(row, "save_per_memcpy"));
    for (const Json& rollback : row.at("rollbacks"))
        std::printf("    rollback of %2d ticks %10.1f us, its ticks alone %10.1f: %.3f x%s\n",
                    rollback.at("depth").as_int(), number(rollback, "rollback_us"),
                    number(rollback, "steps_us"), number(rollback, "ratio"),
                    rollback.at("is_exact").as_bool() ? "" : "  NOT THE SAME BITS");
    print_verdicts(row);
}

void print_awake(const Json& rows) {
    std::printf("%-8s %8s %10s %10s %10s %10s\n", "awake", "of", "tick us", "save", "restore", "hash");
    for (const Json& row : rows)
        std::printf("%-8d %8d %10.1f %10.1f %10.1f %10.1f\n", row.at("awake").as_int(),
                    row.at("bodies").as_int(), number(row, "tick_us"), number(row, "save_us"),
                    number(row, "restore_us"), number(row, "hash_us"));
}

void print_scaling(const Json& row) {
    std::printf("%6d boxes at rest:", row.at("bodies").as_int());
    for (const auto& [engine, costs] : row.members())
        if (costs.is_object())
            std::printf("  %s %.3f us, %.0f bytes a body", engine.c_str(), number(costs, "us_per_body"),
                        number(costs, "heap_bytes_per_body"));
    std::printf("\n");
    print_verdicts(row);
}

void print_verify(const Json& row) {
    std::printf("verifying %d ticks of %s with %d players: %.0f times real time, must %.0f, goal %.0f  %s\n",
                row.at("ticks").as_int(), text(row, "scene").c_str(), row.at("players").as_int(),
                number(row, "times_real_time"), number(row, "must"), number(row, "goal"),
                verdict_of(number(row, "times_real_time") >= number(row, "must")));
}

void print_arena(const Json& row) {
    std::printf("%s: mean %.1f us a tick, median %.1f, p99 %.1f, must %.0f  %s\n", text(row, "about").c_str(),
                number(row, "mean_us"), number(row, "median_us"), number(row, "p99_us"), number(row, "must"),
                verdict_of(number(row, "mean_us") <= number(row, "must")));
}

void print_threads(const Json& row) {
    std::printf("%-10s one thread %9.3f ms a tick, two %9.3f, four %9.3f; cores answer in %.0f ns: %.2f "
                "times faster, "
                "must %.1f  %s\n",
                text(row, "scene").c_str(), number(row, "one_ms"), number(row, "two_ms"),
                number(row, "four_ms"), number(row, "round_trip_ns"), number(row, "times_faster"),
                number(row, "must"), verdict_of(number(row, "times_faster") >= number(row, "must")));
}

void print_game(const Json& row) {
    std::printf("%-16s %6d bodies %8d contacts; mean %10.1f us a tick, median %10.1f, p99 %10.1f\n",
                text(row, "scene").c_str(), row.at("bodies").as_int(), row.at("contacts").as_int(),
                number(row, "mean_us"), number(row, "median_us"), number(row, "p99_us"));
}

} // namespace

void print_settings(const Json& settings) {
    std::printf("%s, load %.1f, %s; one thread, sleeping off, %d ticks a second; the time of a tick is the "
                "shortest of %d runs\n",
                text(settings, "cpu").c_str(), number(settings, "load"), text(settings, "compiler").c_str(),
                settings.at("rate").as_int(), settings.at("runs").as_int());
}

void print_row(const std::string& key, const Json& row) {
    const struct {
        const char* key;
        void (*print)(const Json&);
    } printers[] = {{"scenes", print_contest}, {"front", print_contest},   {"state", print_state},
                    {"awake", print_awake},    {"scaling", print_scaling}, {"verify", print_verify},
                    {"arena", print_arena},    {"threads", print_threads}, {"games", print_game}};
    for (const auto& printer : printers)
        if (key == printer.key) printer.print(row);
    std::fflush(stdout);
}

void print_instructions(const Json& rows) {
    std::printf("%-10s %12s %8s %8s\n", "scene", "M a tick", "must", "goal");
    for (const Json& row : rows)
        std::printf("%-10s %12.2f %8.4g %8.4g  %s\n", text(row, "scene").c_str(),
                    number(row, "millions_per_tick"), number(row, "must"), number(row, "goal"),
                    number(row, "must") == 0 ? "" : verdict_of(row.at("good").as_bool()));
}

void print_profile(const Json& scenes) {
    for (const Json& scene : scenes) {
        std::printf("%s, us a tick\n", text(scene, "scene").c_str());
        for (const auto& [phase, us] : scene.at("phases").members())
            std::printf("    %-24s %10.1f %5.1f %%\n", phase.c_str(), us.as_double(),
                        100 * us.as_double() / number(scene, "tick_us"));
    }
}

} // namespace lockstone::bench
