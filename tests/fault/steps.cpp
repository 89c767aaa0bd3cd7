// Steps that workers share: every item once, no step before the one before it is done, whatever the tasks of a host do.
#include "base/steps.h"
#include "support/task_runners.h"

#include <doctest/doctest.h>

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

struct Table {
    std::vector<base::Step> steps;
    std::uint32_t items = 0;
};
Table random_table(std::mt19937& random) {
    Table table;
    const std::uint32_t count = static_cast<std::uint32_t>(random() % 40);
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t size = static_cast<std::uint32_t>(random() % (i % 5 == 0 ? 60 : 9));
        table.steps.push_back({table.items, table.items + size});
        table.items += size;
    }
    return table;
}

/// Empty when all items are visited once, and none before all of the steps before. `run`: as base::for_steps().
template <class Run> std::string complaint(int tables, const Run& run) {
    std::mt19937 random(3);
    for (int i = 0; i < tables; ++i) {
        const Table table = random_table(random);
        std::vector<std::uint32_t> visits(table.items, 0); // not atomic: each item has its own
        std::atomic<std::uint32_t> done = 0, early = 0;
        run(
            static_cast<std::uint32_t>(table.steps.size()),
            [&](std::uint32_t step) { return table.steps[step]; },
            [&](std::uint32_t step, std::uint32_t first, std::uint32_t last) {
                if (done.load() < table.steps[step].first) ++early;
                for (std::uint32_t item = first; item < last; ++item) ++visits[item];
                done += last - first;
            });
        for (const std::uint32_t times : visits)
            if (times != 1) return "an item is visited " + std::to_string(times) + " times";
        if (early != 0) return "a step begins too early";
    }
    return {};
}
std::string complaint_of(Tasks* tasks, int tables) {
    return complaint(tables, [&](std::uint32_t count, const auto& step_of, const auto& visit) {
        base::for_steps(tasks, count, 6, step_of, visit);
    });
}

} // namespace

TEST_CASE("steps are shared by any number of workers, each item once and step after step") {
    CHECK(complaint_of(nullptr, 50) == "");
    for (const std::uint32_t workers : {1u, 2u, 3u, 8u, 12u}) {
        const auto pool = make_worker_pool(workers);
        CHECK(complaint_of(pool.get(), workers > 3 ? 50 : 500) == "");
    }
}

TEST_CASE("steps are all done on a host that runs its items one by one, in any order, twice or some of them "
          "never") {
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

TEST_CASE("planted fault: steps that are turned round, and those that lack an item, are told") {
    CHECK(complaint(5, [](std::uint32_t count, const auto& step_of, const auto& visit) {
              for (std::uint32_t i = count; i-- > 0;) visit(i, step_of(i).first, step_of(i).last);
          }) == "a step begins too early");
    CHECK(complaint(5, [](std::uint32_t count, const auto& step_of, const auto& visit) {
              for (std::uint32_t i = 0; i < count; ++i)
                  if (step_of(i).first != step_of(i).last) visit(i, step_of(i).first + 1, step_of(i).last);
          }) == "an item is visited 0 times");
}
