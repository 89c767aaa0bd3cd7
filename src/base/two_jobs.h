// Two jobs at once, each by one worker; who has no job helps with the loops of both.
//
// A job has parts that cannot be shared, and what two workers do at once of two jobs they would else do one after the other.
#pragma once

#include "base/relax.h"
#include "base/shared_loop.h"
#include "lockstone/tasks.h"

#include <atomic>
#include <cstdint>

namespace lockstone::base {

/// The tasks of a job: its worker puts up loops here, and does what helpers leave of them.
class JobTasks final : public Tasks {
  public:
    explicit JobTasks(std::uint32_t count) : workers(count) {}

    std::uint32_t worker_count() const override { return workers; }
    void run(std::uint32_t items, Item item, void* context) override {
        pending.store(items, std::memory_order_relaxed);
        loop.put_up(++number, 0, items, item, context);
        help(worker);
        for (int looks = 0; pending.load(std::memory_order_acquire) != 0; ++looks) relax(looks);
    }
    /// Does items of the loop that is up, if any is left. Whether it did.
    bool help(std::uint32_t by) {
        const std::uint32_t done = loop.take_items(by);
        if (done != 0) pending.fetch_sub(done, std::memory_order_release);
        return done != 0;
    }

    std::uint32_t worker = 0; ///< that has the job

  private:
    std::uint32_t workers;
    std::uint64_t number = 0;
    SharedLoop loop;
    alignas(64) std::atomic<std::uint32_t> pending = 0; ///< items that are not done
};

template <class First, class Second> class TwoJobs {
  public:
    TwoJobs(Tasks& tasks, const First& one, const Second& other)
        : all(tasks), first(one),
          second(other), own{JobTasks(tasks.worker_count()), JobTasks(tasks.worker_count())} {}

    void run() {
        all.run(
            all.worker_count(),
            [](void* self, std::uint32_t index, std::uint32_t worker) {
                static_cast<TwoJobs*>(self)->work(index % 2, worker);
            },
            this);
        begin(0, 0), begin(1, 0); // what nobody has begun
    }

  private:
    void work(std::uint32_t job, std::uint32_t worker) {
        begin(job, worker), begin(1 - job, worker);
        for (const std::uint32_t k : {job, 1 - job}) // somebody has begun both
            for (int looks = 0; !is_done[k].load(std::memory_order_acquire); ++looks)
                if (!own[k].help(worker)) relax(looks);
    }
    /// Does all of a job, unless somebody has begun it.
    void begin(std::uint32_t job, std::uint32_t worker) {
        if (is_taken[job].exchange(true, std::memory_order_relaxed)) return;
        own[job].worker = worker;
        job == 0 ? first(&own[job]) : second(&own[job]);
        is_done[job].store(true, std::memory_order_release);
    }

    Tasks& all;
    const First& first;
    const Second& second;
    JobTasks own[2];
    std::atomic<bool> is_taken[2] = {}, is_done[2] = {};
};

/// first(tasks) and second(tasks), which look at nothing that the other one writes, at the same time; and all of both, whatever the tasks
/// of a host do.
template <class First, class Second> void run_both(Tasks& tasks, const First& first, const Second& second) {
    TwoJobs(tasks, first, second).run();
}

} // namespace lockstone::base
