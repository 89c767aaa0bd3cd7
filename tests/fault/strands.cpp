// Strands of pieces: each item is visited once, and no piece runs before the pieces that it waits for, with any tasks
// of a host.
#include "base/strands.h"
#include "support/task_runners.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <thread>

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// Pieces of up to nine strands. Some wait for earlier pieces of other strands, in this round or in the last one.
base::StrandPlan random_plan(std::mt19937& random) {
    base::StrandPlan plan;
    plan.strands = 2 + static_cast<std::uint32_t>(random() % 8);
    const std::uint32_t count = static_cast<std::uint32_t>(random() % 120);
    std::uint32_t items = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t strand = static_cast<std::uint32_t>(random() % plan.strands);
        const std::uint32_t first_wait = static_cast<std::uint32_t>(plan.waits.size());
        for (std::uint32_t k = 0; k < plan.strands; ++k)
            if (k != strand && plan.count(k) != 0 && random() % 4 == 0)
                plan.waits.push_back({k, plan.count(k), random() % 2 == 0}); // all so far
        const std::uint32_t first = items;
        items += 1 + static_cast<std::uint32_t>(random() % 5);
        plan.pieces[strand].push_back(
            {first, items, first_wait, static_cast<std::uint32_t>(plan.waits.size()), i});
    }
    return plan;
}

/// Returns an error sentence unless each item is visited once in each round, after all pieces that its piece waits for.
/// `run`: as base::for_strands().
template <class Run> std::string complaint(int plans, const Run& run) {
    std::mt19937 random(3);
    for (int i = 0; i < plans; ++i) {
        const base::StrandPlan plan = random_plan(random);
        const std::uint32_t rounds = 1 + static_cast<std::uint32_t>(random() % 4);
        std::uint32_t items = 0;
        for (std::uint32_t k = 0; k < plan.strands; ++k)
            if (plan.count(k) != 0) items = std::max(items, plan.pieces[k].back().last);
        std::vector<std::uint32_t> visits(items, 0); // not atomic: one worker at a time has an item
        std::array<std::atomic<std::uint32_t>, base::strands_max> done{};
        std::atomic<std::uint32_t> early = 0;
        run(plan, rounds, [&](const base::Piece& piece, base::PieceAt at) {
            if (done[at.strand].load() != at.round * plan.count(at.strand) + at.index) ++early;
            for (std::uint32_t w = piece.first_wait; w < piece.last_wait; ++w) {
                const base::PieceWait& wait = plan.waits[w];
                const std::uint32_t round = at.round - (wait.of_last_round ? 1u : 0u);
                if (wait.of_last_round && at.round == 0) continue;
                if (done[wait.strand].load() < round * plan.count(wait.strand) + wait.pieces) ++early;
            }
            for (std::uint32_t item = piece.first; item < piece.last; ++item) ++visits[item];
            ++done[at.strand];
        });
        for (const std::uint32_t times : visits)
            if (times != rounds)
                return "an item is visited " + std::to_string(times) + " times in " + std::to_string(rounds) +
                       " rounds";
        if (early != 0) return "a piece begins too early";
    }
    return {};
}
std::string complaint_of(Tasks* tasks, int plans) {
    return complaint(plans, [&](const base::StrandPlan& plan, std::uint32_t rounds, const auto& visit) {
        base::for_strands(tasks, plan, rounds, visit);
    });
}

} // namespace

TEST_CASE("any number of workers runs each item of the strands once and piece after piece") {
    for (const std::uint32_t workers : {1u, 2u, 3u, 8u, 12u}) {
        const auto pool = make_worker_pool(workers);
        CHECK(complaint_of(pool.get(), workers > 3 ? 50 : 500) == "");
    }
    CHECK(complaint_of(nullptr, 500) == "");
}

// A worker that takes over a strand then has several. Other workers may wait for one of them while it waits for theirs.
TEST_CASE("workers complete strands if some of them stop inside pieces for longer than the patience of the "
          "others") {
    for (const std::uint32_t workers : {2u, 3u, 4u, 8u}) {
        const auto pool = make_worker_pool(workers);
        std::atomic<std::uint32_t> pieces = 0;
        CHECK(complaint(60, [&](const base::StrandPlan& plan, std::uint32_t rounds, const auto& visit) {
                  base::for_strands(pool.get(), plan, rounds,
                                    [&](const base::Piece& piece, base::PieceAt at) {
                                        if (pieces.fetch_add(1) % 16 == 0)
                                            std::this_thread::sleep_for(std::chrono::microseconds(100));
                                        visit(piece, at);
                                    });
              }) == "");
    }
}

TEST_CASE("a host that runs items one by one or in any order or twice or skips some completes all strands") {
    ShuffledTasks shuffled(6);
    CHECK(complaint_of(&shuffled, 100) == "");
    for (const auto way : {OddTasks::Way::first_alone, OddTasks::Way::last_alone,
                           OddTasks::Way::none_but_second, OddTasks::Way::twice}) {
        OddTasks odd(way);
        CHECK(complaint_of(&odd, 100) == "");
    }
    UnsteadyTasks unsteady(4, 2);
    CHECK(complaint_of(&unsteady, 100) == "");
}

TEST_CASE("planted fault: the check finds strands that skip their waits and strands that lack a piece") {
    using Plan = base::StrandPlan;
    const auto visit_round = [](const Plan& plan, std::uint32_t k, std::uint32_t round, const auto& visit) {
        for (std::uint32_t i = 0; i < plan.count(k); ++i)
            visit(plan.pieces[k][i], base::PieceAt{k, i, round});
    };
    const auto strand_by_strand = [&](const Plan& plan, std::uint32_t rounds, const auto& visit) {
        for (std::uint32_t k = 0; k < plan.strands; ++k)
            for (std::uint32_t round = 0; round < rounds; ++round) visit_round(plan, k, round, visit);
    };
    CHECK(complaint(5, strand_by_strand) == "a piece begins too early");
    CHECK(complaint(5, [&](const Plan& plan, std::uint32_t rounds, const auto& visit) {
              base::for_strands(nullptr, plan, rounds, [&](const base::Piece& piece, base::PieceAt at) {
                  if (at.index != 0 || at.round != 0) visit(piece, at);
              });
          }).starts_with("an item is visited"));
}
