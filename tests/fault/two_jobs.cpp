// Two jobs at once: each job, and every item of its loops, runs once, with any tasks of a host.
#include "base/two_jobs.h"
#include "support/task_runners.h"

#include <doctest/doctest.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// A job of some successive loops, and its error counts.
struct Job {
    static constexpr std::uint32_t loops = 40;
    std::uint32_t times = 0;
    std::uint64_t seed;
    bool sleeps = false; ///< in some items
    std::array<std::atomic<bool>, 64>* is_at_work;
    std::atomic<std::uint32_t> at_once = 0, other_times = 0;

    struct Loop {
        Job& job;
        std::vector<std::uint32_t> visits; ///< not atomic: one worker has an item
    };
    /// `tasks`: the tasks of this job.
    void run(Tasks& tasks) {
        ++times;
        std::mt19937_64 random(seed);
        for (std::uint32_t i = 0; i < loops; ++i) {
            Loop loop{*this, std::vector<std::uint32_t>(random() % 30)};
            tasks.run(static_cast<std::uint32_t>(loop.visits.size()), visit, &loop);
            for (const std::uint32_t n : loop.visits)
                if (n != 1) ++other_times;
        }
    }
    static void visit(void* context, std::uint32_t index, std::uint32_t worker) {
        Loop& loop = *static_cast<Loop*>(context);
        if ((*loop.job.is_at_work)[worker].exchange(true)) ++loop.job.at_once;
        if (loop.job.sleeps && index % 7 == 3) std::this_thread::sleep_for(std::chrono::microseconds(20));
        ++loop.visits[index];
        (*loop.job.is_at_work)[worker] = false;
    }
};

/// Returns an error sentence unless both jobs run once and correctly. `run(first, second)`: as base::run_both() with a
/// host's tasks.
template <class Run> std::string complaint(int times, bool sleep, const Run& run) {
    for (int i = 0; i < times; ++i) {
        std::array<std::atomic<bool>, 64> is_at_work{};
        Job jobs[2] = {{.seed = static_cast<std::uint64_t>(i), .is_at_work = &is_at_work},
                       {.seed = static_cast<std::uint64_t>(i) + 1000, .is_at_work = &is_at_work}};
        jobs[i % 2].sleeps = sleep;
        run([&](Tasks* own) { jobs[0].run(*own); }, [&](Tasks* own) { jobs[1].run(*own); });
        for (const Job& job : jobs) {
            if (job.times != 1) return "a job is done " + std::to_string(job.times) + " times";
            if (job.other_times != 0) return "an item is not visited once before its loop ends";
            if (job.at_once != 0) return "one worker does two items at once";
        }
    }
    return {};
}
std::string complaint_of(Tasks& tasks, int times, bool sleep = false) {
    return complaint(times, sleep,
                     [&](const auto& first, const auto& second) { base::run_both(tasks, first, second); });
}

} // namespace

TEST_CASE("any number of workers runs each of two jobs once with all items of their loops") {
    for (const std::uint32_t workers : {1u, 2u, 3u, 8u}) {
        const auto pool = make_worker_pool(workers);
        CHECK(complaint_of(*pool, workers > 3 ? 30 : 300) == "");
        CHECK(complaint_of(*pool, 5, true) == "");
    }
}

TEST_CASE("a host that runs items one by one or in any order or twice or skips some completes two jobs") {
    ShuffledTasks shuffled(6);
    CHECK(complaint_of(shuffled, 50) == "");
    for (const auto way : {OddTasks::Way::first_alone, OddTasks::Way::last_alone,
                           OddTasks::Way::none_but_second, OddTasks::Way::twice}) {
        OddTasks odd(way);
        CHECK(complaint_of(odd, 50) == "");
    }
    UnsteadyTasks unsteady(4, 2);
    CHECK(complaint_of(unsteady, 50) == "");
}

TEST_CASE("planted fault: the check finds jobs that are left out or done twice or lose an item") {
    struct InOrder final : Tasks {
        std::uint32_t left_out = 0;
        std::uint32_t worker_count() const override { return 2; }
        void run(std::uint32_t items, Item item, void* context) override {
            for (std::uint32_t i = 0; i + left_out < items; ++i) item(context, i, 0);
        }
    } whole, part;
    part.left_out = 1;
    CHECK(complaint(1, false,
                    [&](const auto& first, const auto& second) { first(&whole), second(&whole); }) == "");
    CHECK(complaint(1, false, [&](const auto& first, const auto&) { first(&whole); }) ==
          "a job is done 0 times");
    CHECK(complaint(1, false, [&](const auto& first, const auto& second) {
              first(&whole), second(&whole), second(&whole);
          }) == "a job is done 2 times");
    CHECK(complaint(1, false, [&](const auto& first, const auto& second) {
              first(&whole), second(&part);
          }).starts_with("an item is not visited once"));
}
