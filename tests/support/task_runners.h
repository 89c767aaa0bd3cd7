// Ways in which a host may run tasks, and some that break the contract.
#pragma once

#include "lockstone/tasks.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <random>
#include <thread>
#include <utility>
#include <vector>

namespace lockstone::test {

/// One thread that runs the items in random order and reports a random worker number each time.
class ShuffledTasks final : public Tasks {
  public:
    explicit ShuffledTasks(std::uint32_t seed, std::uint32_t workers = 5)
        : random(seed), workers_said(workers) {}
    std::uint32_t worker_count() const override { return workers_said; }
    void run(std::uint32_t items, Item item, void* context) override {
        order.resize(items);
        std::iota(order.begin(), order.end(), 0u);
        std::shuffle(order.begin(), order.end(), random);
        for (const std::uint32_t index : order) {
            item(context, index, static_cast<std::uint32_t>(random() % workers_said));
            ++items_run;
        }
        ++runs;
    }
    std::uint64_t runs = 0, items_run = 0;

  private:
    std::mt19937 random;
    std::uint32_t workers_said;
    std::vector<std::uint32_t> order;
};

/// A pool whose workers sometimes yield the processor within an item.
class UnsteadyTasks final : public Tasks {
  public:
    UnsteadyTasks(std::uint32_t workers, std::uint32_t seed)
        : pool(make_worker_pool(workers)), random(seed) {}
    std::uint32_t worker_count() const override { return pool->worker_count(); }
    void run(std::uint32_t items, Item item, void* context) override {
        Job job{item, context, static_cast<std::uint32_t>(random())};
        pool->run(
            items,
            [](void* c, std::uint32_t index, std::uint32_t worker) {
                const Job& j = *static_cast<const Job*>(c);
                const std::uint32_t chance = (index + 1) * 2654435761u ^ j.salt;
                for (std::uint32_t i = 0; i < chance % 4; ++i) std::this_thread::yield();
                j.item(j.context, index, worker);
            },
            &job);
    }

  private:
    struct Job {
        Item item;
        void* context;
        std::uint32_t salt;
    };
    std::unique_ptr<Tasks> pool;
    std::mt19937 random;
};

/// Breaks the contract of Tasks in one run of many: leaves out its last item, or runs its first one twice.
class FaultyTasks final : public Tasks {
  public:
    enum class Fault { leaves_out, runs_twice };
    FaultyTasks(Fault what, std::uint64_t when) : fault(what), faulty_run(when) {}
    std::uint32_t worker_count() const override { return 1; }
    void run(std::uint32_t items, Item item, void* context) override {
        const bool now = runs++ == faulty_run;
        if (now && fault == Fault::runs_twice) item(context, 0, 0);
        if (now && fault == Fault::leaves_out) --items;
        for (std::uint32_t i = 0; i < items; ++i) item(context, i, 0);
    }
    std::uint64_t runs = 0;

  private:
    Fault fault;
    std::uint64_t faulty_run;
};

/// Runs only some of its items, or all of them twice.
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

} // namespace lockstone::test
