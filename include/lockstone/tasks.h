// Task scheduling of a tick: on threads of the host, on a pool of this library, or on the calling thread.
//
//   std::unique_ptr<Tasks> pool = make_worker_pool(4);
//   world.set_tasks(pool.get());                 // the pool must outlive its use
//   world.tick();
//
// No bit of a tick depends on the number of workers, on the assignment of items to workers or on their order.
// A host engine provides its own threads by an implementation of Tasks.
#pragma once

#include <cstdint>
#include <memory>

namespace lockstone {

/// A task scheduler. It executes one run() at a time: worlds that tick at the same time need one scheduler
/// each.
class Tasks {
  public:
    /// An item of work. `index`: below the number of items. `worker`: below worker_count(), different for two
    /// items that run at the same time. An item does not throw and does not call run(). It may spin until an
    /// item that has already started reaches a given point; it never waits for an item that has not started.
    using Item = void (*)(void* context, std::uint32_t index, std::uint32_t worker);

    virtual ~Tasks() = default;
    /// Number of workers: at least 1, constant.
    virtual std::uint32_t worker_count() const = 0;
    /// Calls item(context, index, worker) once for each index below `items`, on any threads in any order.
    /// Returns when all items are done and their writes are visible to the caller. A tick calls it a few
    /// hundred times, often with less than 10 us of work for an item, so workers should spin and not sleep
    /// between runs.
    virtual void run(std::uint32_t items, Item item, void* context) = 0;
};

inline constexpr std::uint32_t workers_max = 64; ///< limit of make_worker_pool()

/// A pool of 1..workers_max workers; the thread that calls run() is one of them. Between runs the others spin
/// for 40 to 200 us, then sleep. If the system has too few threads, the pool has fewer workers. A wrong
/// number of workers, a run of 2^24 items or more, and two runs at a time end the program.
std::unique_ptr<Tasks> make_worker_pool(std::uint32_t workers);

} // namespace lockstone
