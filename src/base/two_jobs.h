// Runs two jobs at the same time, each on one worker. Workers without a job help with the loops of both.
//
// A job has serial parts; those of two jobs run in parallel on two workers instead of in sequence.
#pragma once

#include "base/relax.h"
#include "base/shared_loop.h"
#include "lockstone/tasks.h"

#include <atomic>
#include <cstdint>

namespace lockstone::base {

/// The Tasks of a job: the worker of the job starts loops here, and runs the items that helpers leave.
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
    /// Runs items of the current loop, if any is left. Returns true if it ran one.
    bool help(std::uint32_t by) {
        const std::uint32_t done = loop.take_items(by);
        if (done != 0) pending.fetch_sub(done, std::memory_order_release);
        return done != 0;
    }

    std::uint32_t worker = 0; ///< the worker that runs the job

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
        begin(0, 0), begin(1, 0); // a job that no worker has begun
    }

  private:
    void work(std::uint32_t job, std::uint32_t worker) {
        begin(job, worker), begin(1 - job, worker);
        for (const std::uint32_t k : {job, 1 - job}) // a worker has begun each of them
            for (int looks = 0; !is_done[k].load(std::memory_order_acquire); ++looks)
                if (!own[k].help(worker)) relax(looks);
    }
    /// Runs a job, unless a worker has begun it.
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

/// Runs first(tasks) and second(tasks) at the same time; neither reads data that the other writes. Both are
/// complete at return, however the host's Tasks call the items.
template <class First, class Second> void run_both(Tasks& tasks, const First& first, const Second& second) {
    TwoJobs(tasks, first, second).run();
}

} // namespace lockstone::base
