// Strands of pieces: every item once, no piece before those that it waits for, whatever the tasks of a host do.
#include "base/strands.h"
#include "support/task_runners.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <string>

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// Runs some of the items it is given: the others are never run, or all of them twice.
class OddTasks final : public Tasks {
  public:
    enum class Way { first_alone, last_alone, none_but_second, twice };
    explicit OddTasks(Way what) : way(what) {}
    std::uint32_t worker_count() const override { return 3; }
    void run(std::uint32_t items, Item item, void* context) override {
        for (int time = 0; time < (way == Way::twice ? 2 : 1); ++time)
            for (std::uint32_t i = 0; i < items; ++i)
                if (way == Way::twice || i == (way == Way::first_alone  ? 0
                                               : way == Way::last_alone ? items - 1
                                                                        : 1))
                    item(context, i, i);
    }

  private:
    Way way;
};

/// Pieces of up to eight strands, some of which wait for earlier ones of others.
base::StrandPlan random_plan(std::mt19937& random) {
    base::StrandPlan plan;
    plan.strands = 2 + static_cast<std::uint32_t>(random() % (base::strands_max - 1));
    const std::uint32_t count = static_cast<std::uint32_t>(random() % 120);
    std::uint32_t items = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        base::Piece piece{};
        piece.strand = static_cast<std::uint32_t>(random() % plan.strands);
        for (std::uint32_t k = 0; k < plan.strands; ++k)
            if (k != piece.strand && random() % 4 == 0) piece.after[k] = plan.piece_count[k]; // all so far
        piece.index = plan.piece_count[piece.strand]++;
        piece.first = items, piece.last = items += 1 + static_cast<std::uint32_t>(random() % 5);
        plan.pieces.push_back(piece);
    }
    return plan;
}

/// Empty when all items are visited once, and none before what its piece waits for. `run`: as base::for_strands().
template <class Run> std::string complaint(int plans, const Run& run) {
    std::mt19937 random(3);
    for (int i = 0; i < plans; ++i) {
        const base::StrandPlan plan = random_plan(random);
        const std::uint32_t items = plan.pieces.empty() ? 0 : plan.pieces.back().last;
        std::vector<std::uint32_t> visits(items, 0), piece_of(items); // not atomic: each item has its own
        for (std::uint32_t p = 0; p < plan.pieces.size(); ++p)
            std::fill(piece_of.begin() + plan.pieces[p].first, piece_of.begin() + plan.pieces[p].last, p);
        std::array<std::atomic<std::uint32_t>, base::strands_max> done{};
        std::atomic<std::uint32_t> early = 0;
        run(plan, [&](std::uint32_t first, std::uint32_t last) {
            const base::Piece& piece = plan.pieces[piece_of[first]];
            if (done[piece.strand].load() != piece.index) ++early;
            for (std::uint32_t k = 0; k < plan.strands; ++k)
                if (done[k].load() < piece.after[k]) ++early;
            for (std::uint32_t item = first; item < last; ++item) ++visits[item];
            ++done[piece.strand];
        });
        for (const std::uint32_t times : visits)
            if (times != 1) return "an item is visited " + std::to_string(times) + " times";
        if (early != 0) return "a piece begins too early";
    }
    return {};
}
std::string complaint_of(Tasks& tasks, int plans) {
    return complaint(plans, [&](const base::StrandPlan& plan, const auto& visit) {
        base::for_strands(tasks, plan, visit);
    });
}

} // namespace

TEST_CASE("strands are done by any number of workers, each item once and piece after piece") {
    for (const std::uint32_t workers : {1u, 2u, 3u, 8u, 12u}) {
        const auto pool = make_worker_pool(workers);
        CHECK(complaint_of(*pool, workers > 3 ? 50 : 500) == "");
    }
}

TEST_CASE(
    "strands are all done on a host that runs its items one by one, in any order, twice or some of them "
    "never") {
    ShuffledTasks shuffled(6);
    CHECK(complaint_of(shuffled, 100) == "");
    for (const auto way : {OddTasks::Way::first_alone, OddTasks::Way::last_alone,
                           OddTasks::Way::none_but_second, OddTasks::Way::twice}) {
        OddTasks odd(way);
        CHECK(complaint_of(odd, 100) == "");
    }
    UnsteadyTasks unsteady(4, 2);
    CHECK(complaint_of(unsteady, 100) == "");
}

TEST_CASE(
    "planted fault: strands that wait for nobody, that are turned round, and that lack a piece, are told") {
    const auto strand_by_strand = [](const base::StrandPlan& plan, const auto& visit) {
        for (std::uint32_t k = 0; k < plan.strands; ++k)
            for (const base::Piece& piece : plan.pieces)
                if (piece.strand == k) visit(piece.first, piece.last);
    };
    CHECK(complaint(5, strand_by_strand) == "a piece begins too early");
    CHECK(complaint(5, [](const base::StrandPlan& plan, const auto& visit) {
              for (std::size_t i = plan.pieces.size(); i-- > 0;)
                  visit(plan.pieces[i].first, plan.pieces[i].last);
          }) == "a piece begins too early");
    CHECK(complaint(5, [](const base::StrandPlan& plan, const auto& visit) {
              for (std::size_t i = 0; i + 1 < plan.pieces.size(); ++i)
                  visit(plan.pieces[i].first, plan.pieces[i].last);
          }) == "an item is visited 0 times");
}
