// quality: runs every row in every engine and prints one table. See README.md.
#include "lockstone/world.h"
#include "quality/row.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include <sys/wait.h>
#include <unistd.h>

namespace quality {

namespace {

struct Options {
    std::vector<std::string> rows;
    bool list = false, json = false, quick = false, planted = false, alone = false;
    int substeps = 0;
    double hertz = 0, damping = 0;
};

const int precise_substeps = static_cast<int>(lockstone::WorldDef::precise().substeps);

constexpr const char* usage =
    "quality [ROW...]     the table, or some of its rows; exit status 1 when a bound is missed or a peer is "
    "better\n"
    "  --list             the rows and what they are\n"
    "  --json             the table as JSON\n"
    "  --quick            a small sample, Lockstone alone\n"
    "  --alone            Lockstone alone\n"
    "  --planted          the twins: every figure has to miss its bound\n"
    "  --substeps N, --hertz X, --damping X     Lockstone otherwise than by default\n";

[[noreturn]] void refuse(const std::string& sentence) {
    std::fprintf(stderr, "quality: %s\n%s", sentence.c_str(), usage);
    std::exit(2);
}

Options parse(int count, char** words) {
    Options o;
    for (int i = 1; i < count; ++i) {
        const std::string_view word = words[i];
        const auto number = [&]() -> double {
            char* end = nullptr;
            const double value = i + 1 < count ? std::strtod(words[++i], &end) : 0;
            if (end == nullptr || *end != '\0' || value <= 0)
                refuse(std::string(word) + " needs a number above 0");
            return value;
        };
        if (word == "--list")
            o.list = true;
        else if (word == "--json")
            o.json = true;
        else if (word == "--quick")
            o.quick = o.alone = true;
        else if (word == "--alone")
            o.alone = true;
        else if (word == "--planted")
            o.planted = o.alone = true;
        else if (word == "--substeps")
            o.substeps = static_cast<int>(number());
        else if (word == "--hertz")
            o.hertz = number();
        else if (word == "--damping")
            o.damping = number();
        else if (word.starts_with("-"))
            refuse("unknown option " + std::string(word));
        else
            o.rows.emplace_back(word);
    }
    return o;
}

std::vector<Row> chosen_rows(const Options& o) {
    std::vector<Row> all;
    for (auto* family : {stack_rows, pile_rows, surface_rows, domino_rows, free_motion_rows, joint_rows})
        std::ranges::move(family(), std::back_inserter(all));
    for (const std::string& name : o.rows)
        if (std::ranges::find(all, name, &Row::name) == all.end())
            refuse("there is no row " + name + "; see --list");
    std::erase_if(all, [&](const Row& row) {
        if (!o.rows.empty()) return std::ranges::find(o.rows, row.name) == o.rows.end();
        return o.quick && !row.in_sample;
    });
    return all;
}

/// Runs a row in its own process: an engine that aborts loses only its figures and reports that.
Figures run_apart(const Row& row, const Contestant& contestant, const Plan& plan) {
    int ends[2];
    if (pipe(ends) != 0) refuse("no pipe");
    std::fflush(stdout);
    const pid_t child = fork();
    if (child == 0) {
        const Figures f = row.run(contestant, plan);
        std::vector<double> words = f.values;
        words.push_back(f.seconds_per_tick);
        const std::size_t bytes = words.size() * sizeof(double);
        _exit(write(ends[1], words.data(), bytes) == static_cast<ssize_t>(bytes) ? 0 : 1);
    }
    close(ends[1]);
    std::vector<double> words(row.values.size() + 1);
    const ssize_t got = read(ends[0], words.data(), words.size() * sizeof(double));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    const auto count = static_cast<std::size_t>(got < 0 ? 0 : got) / sizeof(double);
    if (status != 0 || count == 0)
        return {std::vector<double>(row.values.size(), std::numeric_limits<double>::infinity()), 0};
    if (count == 1) return {};
    const double seconds = words.back();
    words.pop_back();
    return {words, seconds};
}

std::vector<Contestant> chosen_contestants(const Options& o) {
    std::vector<Contestant> all = contestants();
    all[0].substeps = o.substeps;
    all[0].contact_hertz = o.hertz;
    all[0].contact_damping = o.damping;
    if (o.alone) all.resize(1);
    return all;
}

/// Lockstone with the row's substeps, unless the command line chose them.
std::vector<Contestant> contestants_of(const Row& row, const Options& o) {
    std::vector<Contestant> all = chosen_contestants(o);
    if (row.precise && o.substeps == 0) all[0].substeps = precise_substeps;
    return all;
}

/// Compares with the other engines at their defaults. A value below a tenth of the bound counts as 0, and 5 % is noise.
std::string verdict(const Value& value, std::size_t index, const std::vector<Contestant>& who,
                    const std::vector<Figures>& all) {
    const double ours = all[0].values[index];
    if (!(ours <= value.bound)) return "OVER BOUND";
    for (std::size_t i = 1; i < who.size() && i < 3; ++i) {
        if (all[i].values.empty()) continue;
        const double theirs = all[i].values[index];
        if (theirs <= value.bound && ours > std::max(value.bound / 10, theirs * 1.05))
            return "BEHIND " + who[i].name;
    }
    return "good";
}

std::string number(double x) {
    if (std::isnan(x)) return "-";
    if (std::isinf(x)) return "crash";
    char text[32];
    if (x > 1e6) return "huge";
    std::snprintf(text, sizeof text, x != 0 && std::abs(x) < 1e-4 ? "%.0e" : "%.3g", x);
    return text;
}

std::string figure(const Figures& figures, std::size_t index) {
    return number(figures.values.empty() ? unsupported : figures.values[index]);
}

void print_header(const std::vector<Contestant>& who) {
    std::printf("%-21s %-17s %-7s %8s", "row", "figure", "unit", "bound");
    for (const Contestant& c : who) std::printf(" %11s", c.name.c_str());
    std::printf("  verdict\n");
}

/// Returns whether all values are within their bounds.
bool print_row(const Row& row, const std::vector<Contestant>& who, const std::vector<Figures>& all) {
    bool good = true;
    for (std::size_t i = 0; i < row.values.size(); ++i) {
        const Value& value = row.values[i];
        const std::string found = verdict(value, i, who, all);
        const char* name = i == 0 ? row.name.c_str() : i == 1 && row.precise ? "  (precise)" : "";
        std::printf("%-21s %-17s %-7s %8s", name, value.what.c_str(), value.unit.c_str(),
                    number(value.bound).c_str());
        for (const Figures& figures : all) std::printf(" %11s", figure(figures, i).c_str());
        std::printf("  %s\n", found.c_str());
        good = good && found == "good";
    }
    std::printf("%-21s %-17s %-7s %8s", "", "time of a tick", "us", "");
    for (const Figures& figures : all)
        std::printf(" %11s", figures.values.empty() ? "-" : number(figures.seconds_per_tick * 1e6).c_str());
    std::printf("\n");
    std::fflush(stdout);
    return good;
}

std::string json_number(double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", x);
    return std::isfinite(x) ? text : "null";
}

bool print_json_row(const Row& row, const std::vector<Contestant>& who, const std::vector<Figures>& all,
                    bool first) {
    bool good = true;
    std::printf("%s\n  {\"row\": \"%s\", \"about\": \"%s\", \"precise\": %s, \"tick_us\": {",
                first ? "[" : ",", row.name.c_str(), row.about.c_str(), row.precise ? "true" : "false");
    const char* comma = "";
    for (std::size_t k = 0; k < who.size(); ++k, comma = ", ")
        std::printf("%s\"%s\": %s", comma, who[k].name.c_str(),
                    json_number(all[k].values.empty() ? unsupported : all[k].seconds_per_tick * 1e6).c_str());
    std::printf("}, \"figures\": [");
    for (std::size_t i = 0; i < row.values.size(); ++i) {
        const Value& value = row.values[i];
        const std::string found = verdict(value, i, who, all);
        std::printf("%s\n    {\"figure\": \"%s\", \"unit\": \"%s\", \"bound\": %s", i == 0 ? "" : ",",
                    value.what.c_str(), value.unit.c_str(), json_number(value.bound).c_str());
        for (std::size_t k = 0; k < who.size(); ++k)
            std::printf(", \"%s\": %s", who[k].name.c_str(),
                        json_number(all[k].values.empty() ? unsupported : all[k].values[i]).c_str());
        std::printf(", \"verdict\": \"%s\"}", found.c_str());
        good = good && found == "good";
    }
    std::printf("]}");
    std::fflush(stdout);
    return good;
}

int run_table(const Options& o) {
    const std::vector<Contestant> who = chosen_contestants(o);
    bool good = true, first = true;
    if (!o.json) print_header(who);
    for (const Row& row : chosen_rows(o)) {
        std::vector<Figures> all;
        for (const Contestant& c : contestants_of(row, o))
            all.push_back(run_apart(row, c, {.quick = o.quick}));
        good = (o.json ? print_json_row(row, who, all, first) : print_row(row, who, all)) && good;
        first = false;
    }
    if (o.json) std::printf("\n]\n");
    return good ? 0 : 1;
}

/// Runs each figure of each row once with a planted error that the figure must show.
int run_planted(const Options& o) {
    bool good = true;
    for (const Row& row : chosen_rows(o)) {
        const Contestant us = contestants_of(row, o)[0];
        for (std::size_t i = 0; i < row.values.size(); ++i) {
            const Figures f = run_apart(row, us, {.quick = o.quick, .planted = static_cast<int>(i)});
            const bool missed = f.values[i] > row.values[i].bound && std::isfinite(f.values[i]);
            std::printf("%-21s %-17s bound %8s planted %11s  %s\n", row.name.c_str(),
                        row.values[i].what.c_str(), number(row.values[i].bound).c_str(),
                        number(f.values[i]).c_str(), missed ? "noticed" : "NOT NOTICED");
            std::fflush(stdout);
            good = good && missed;
        }
    }
    return good ? 0 : 1;
}

int run(int count, char** words) {
    const Options o = parse(count, words);
    if (o.list) {
        for (const Row& row : chosen_rows(o)) std::printf("%-21s %s\n", row.name.c_str(), row.about.c_str());
        return 0;
    }
    return o.planted ? run_planted(o) : run_table(o);
}

} // namespace

} // namespace quality

int main(int count, char** words) { return quality::run(count, words); }
