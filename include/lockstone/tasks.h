// How a tick shares out its work: over threads of the host, over a pool of this library, or not at all.
//
//   std::unique_ptr<Tasks> pool = make_worker_pool(4);
//   world.set_tasks(pool.get());                 // the pool outlives its use; null: everything runs on the caller
//   world.tick();
//
// The bits of a tick do not depend on the tasks: how many workers there are, which of them takes what, and in which order.
// A host engine hands over its own workers by implementing Tasks.
#pragma once

#include <cstdint>
#include <memory>

namespace lockstone {

/// Runs items of work, which may run at once or one after the other. One run at a time: worlds that tick at once need one each.
class Tasks {
  public:
    /// `index` below the number of items; `worker` below worker_count(), never the same for two items that run at once.
    /// Items do not throw, and do not call run(). Some wait until others that have begun have got as far as they need, for a few microseconds, or
    /// until they are done, and help them meanwhile. None waits for one that has not begun.
    using Item = void (*)(void* context, std::uint32_t index, std::uint32_t worker);

    virtual ~Tasks() = default;
    /// At least 1, and the same from call to call.
    virtual std::uint32_t worker_count() const = 0;
    /// Calls item(context, index, worker) once for every index below `items`, on any threads and in any order, and
    /// returns when all are done; what they wrote is then seen by the caller. Called a few hundred times a tick, often
    /// with less than 10 us of work an item: workers that sleep between runs cost more time than they save.
    virtual void run(std::uint32_t items, Item item, void* context) = 0;
};

inline constexpr std::uint32_t workers_max = 64;

/// A pool of `workers` threads (1 to workers_max, asserted), of which the thread that calls run() is one. Between runs
/// they look for work for some 40 to 200 microseconds, then sleep. When the system gives fewer threads, there are fewer workers.
/// One run takes fewer than 2^24 items (asserted).
std::unique_ptr<Tasks> make_worker_pool(std::uint32_t workers);

} // namespace lockstone
