// Random worlds in random execution modes: all give the bits of the reference mode.
//
//   worlds FIRST LAST [--modes N] [--bodies N] [--work N]    compares; on a difference shrinks the world and prints a
//                                                            program
//          --coverage                                        prints the number of worlds that took each execution
//                                                            path; fails if no world took one
//          --coverage --least N                              also fails if fewer than N worlds took a path, or if
//                                                            none took it together with a feature that it can meet
//   worlds --hashes FIRST LAST                               a line for each seed: seed, digest of its whole course
//   worlds --planted FIRST LAST                              changes one velocity in one tick: the run must find it
//                                                            and name it
//   worlds --about FIRST LAST                                a line for each seed: the features of the world
#include "compare.h"
#include "draw.h"
#include "shrink.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

using namespace worlds;

namespace {

std::string about(const Story& story) {
    std::string out =
        std::to_string(story.steps.size()) + " steps, " + std::to_string(story.ticks) + " ticks:";
    for (std::uint32_t f = 0; f < feature_count; ++f)
        if (story.has(static_cast<Feature>(f)))
            out += std::string(" ") + name_of(static_cast<Feature>(f)) + ",";
    out.pop_back();
    return out;
}

/// Paths that no world can take together with some features, and the reason.
struct Apart {
    const char* why;
    std::vector<std::string_view> paths;
    std::vector<Feature> features;
};

const std::vector<Apart>& apart() {
    using enum Feature;
    static const std::vector<Apart> all{
        {"passes are one run only where contacts alone change velocities",
         {"strands_by_order", "strands_by_island", "passes_in_one_run", "passes_by_island"},
         {joints, joint_springs, joint_limits, joint_motors, joint_friction, joints_break, loops_of_joints,
          fields, fluids, vehicles, ragdolls, bounces, rolls, integrators}},
        {"a world of wild values has 60 bodies, one far away 120",
         {"moves_by_workers", "packs_beyond_cache", "joints_many_strands", "joint_strands_by_island",
          "joint_strands_by_place", "stiffness_by_workers", "followed_by_workers", "trees_by_workers",
          "pairs_in_crowd", "near_cut", "shared_rows_beyond", "driven_in_trees", "solvers_at_once",
          "strands_by_order", "strands_by_island", "passes_in_one_run", "passes_by_island"},
         {wild, far_away}},
        {"a crowd beyond the table has no groups, which leave pairs out", {"pairs_in_crowd"}, {groups}},
        {"a table of few contacts has no packs beyond a cache", {"packs_beyond_cache"}, {drops_contacts}}};
    return all;
}

/// A factor of a tree of joints has 60 bits, and no known chain of joints needs more (docs/results).
constexpr std::string_view never_taken = "tree_solved_in_passes";

bool can_meet(std::string_view path, Feature feature) {
    return std::ranges::none_of(apart(), [&](const Apart& a) {
        return std::ranges::find(a.paths, path) != a.paths.end() &&
               std::ranges::find(a.features, feature) != a.features.end();
    });
}

/// The number of worlds that took a path, in all and by feature.
class Coverage {
  public:
    void add(const testing::PathSet& paths, const Story& story) {
        for (std::size_t p = 0; p < worlds_of.size(); ++p) {
            if (!paths[p]) continue;
            ++worlds_of[p];
            for (std::uint32_t f = 0; f < feature_count; ++f)
                with[p][f] += story.has(static_cast<Feature>(f)) ? 1u : 0u;
        }
    }
    /// Prints a line for each path: worlds, its name, and the features that it can meet but that no world with it had.
    /// Returns the number of paths that fewer than `least` worlds took; with `pairs`, it also counts these features.
    std::uint64_t print(std::uint64_t least, bool pairs) const {
        std::uint64_t missing = 0;
        const std::span<const std::string_view> names = testing::path_names();
        for (std::size_t p = 0; p < names.size(); ++p) {
            if (names[p] == never_taken && worlds_of[p] == 0) continue;
            missing += worlds_of[p] < least ? 1u : 0u;
            std::string without;
            for (std::uint32_t f = 0; f < feature_count && worlds_of[p] != 0; ++f) {
                const auto feature = static_cast<Feature>(f);
                if (with[p][f] != 0 || !can_meet(names[p], feature)) continue;
                without += std::string(", ") + name_of(feature);
                missing += pairs ? 1u : 0u;
            }
            if (!without.empty()) without = "   never beside " + without.substr(2);
            std::printf("%8llu  %s%s\n", static_cast<unsigned long long>(worlds_of[p]),
                        std::string(names[p]).c_str(), without.c_str());
        }
        return missing;
    }

  private:
    std::vector<std::uint64_t> worlds_of = std::vector<std::uint64_t>(testing::path_names().size());
    std::vector<std::array<std::uint64_t, feature_count>> with =
        std::vector<std::array<std::uint64_t, feature_count>>(testing::path_names().size());
};

/// Compares the world of one seed. Returns true if all modes give the same bits.
bool holds(std::uint64_t seed, std::uint32_t modes, const Extent& extent, Coverage& coverage) {
    const Drawn drawn = draw(seed, extent);
    const Course expected = run(drawn.story, reference_mode());
    Random random = Random::seeded(seed, 99);
    testing::PathSet paths = expected.paths;
    for (std::uint32_t i = 0; i <= modes; ++i) {
        Mode mode = i < modes ? draw_mode(random) : reference_mode();
        if (i == modes && expected.states != drawn.hashes) {
            mode = Mode{};
            mode.simd = best_simd(); // the mode in which the story was drawn
        } else if (i == modes) {
            continue;
        }
        const std::optional<Departure> found = departure(drawn.story, expected, mode, &paths);
        if (!found) continue;
        std::printf("seed %llu: %s\n  mode: %s\n  first difference: tick %llu, %s\n",
                    static_cast<unsigned long long>(seed), about(drawn.story).c_str(),
                    to_string(mode).c_str(), static_cast<unsigned long long>(found->tick),
                    found->about.c_str());
        std::fflush(stdout);
        const Shrunk small = shrink(drawn.story, mode);
        std::printf("  shrunk to %zu steps, mode: %s\n%s", small.story.steps.size(),
                    to_string(small.mode).c_str(), program_of(small).c_str());
        std::fflush(stdout);
        return false;
    }
    coverage.add(paths, drawn.story);
    return true;
}

/// Returns true if the comparison finds a changed velocity after its tick, and names it.
bool is_found(std::uint64_t seed, const Extent& extent) {
    const Story story = draw(seed, extent).story;
    const Course expected = run(story, reference_mode());
    Mode mode;
    mode.simd = best_simd(), mode.planted = 1 + seed % story.ticks;
    const std::optional<Departure> found = departure(story, expected, mode);
    if (found && found->tick + 1 == mode.planted && found->about.find("body.velocity") != std::string::npos)
        return true;
    std::printf("seed %llu: a velocity changed after tick %llu: %s\n", static_cast<unsigned long long>(seed),
                static_cast<unsigned long long>(mode.planted - 1),
                found ? found->about.c_str() : "not found");
    return false;
}

} // namespace

int main(int argc, char** argv) {
    std::vector<std::uint64_t> numbers;
    std::string what;
    std::uint32_t modes = 6;
    Extent extent;
    bool shows_coverage = false;
    std::uint32_t least = 0; // 0: not given
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        const auto value = [&] { return static_cast<std::uint32_t>(std::strtoul(argv[++i], nullptr, 10)); };
        if (word == "--modes" && i + 1 < argc)
            modes = value();
        else if (word == "--bodies" && i + 1 < argc)
            extent.bodies_most = value();
        else if (word == "--work" && i + 1 < argc)
            extent.work = value();
        else if (word == "--least" && i + 1 < argc)
            least = value();
        else if (word == "--coverage")
            shows_coverage = true;
        else if (word == "--hashes" || word == "--about" || word == "--planted")
            what = word;
        else
            numbers.push_back(std::strtoull(argv[i], nullptr, 10));
    }
    if (numbers.size() != 2) {
        std::fprintf(
            stderr,
            "worlds [--hashes | --about | --planted] FIRST LAST [--modes N] [--bodies N] [--work N]\n");
        return 2;
    }
    Coverage coverage;
    std::uint64_t differ = 0, worlds = 0;
    for (std::uint64_t seed = numbers[0]; seed <= numbers[1]; ++seed, ++worlds) {
        if (what == "--about") {
            std::printf("%llu %s\n", static_cast<unsigned long long>(seed),
                        about(draw(seed, extent).story).c_str());
        } else if (what == "--hashes") {
            Mode mode;
            mode.simd = best_simd();
            std::printf("%llu %016llx\n", static_cast<unsigned long long>(seed),
                        static_cast<unsigned long long>(run(draw(seed, extent).story, mode).digest()));
        } else if (what == "--planted") {
            differ += is_found(seed, extent) ? 0u : 1u;
        } else if (!holds(seed, modes, extent, coverage)) {
            ++differ;
        }
        std::fflush(stdout);
    }
    if (what.empty())
        std::printf("%llu worlds, %llu differ\n", static_cast<unsigned long long>(worlds),
                    static_cast<unsigned long long>(differ));
    // The run has not compared a path that no world took.
    const std::uint64_t missing = shows_coverage ? coverage.print(std::max(least, 1u), least != 0) : 0;
    if (missing != 0)
        std::printf("%llu paths, or paths beside a feature, were taken by too few worlds\n",
                    static_cast<unsigned long long>(missing));
    return differ + missing == 0 ? 0 : 1;
}
