// Loops whose chunks may run at once.
#pragma once

#include "lockstone/tasks.h"

#include <algorithm>
#include <atomic>

namespace lockstone::base {

/// body(first, last, worker) for [0, chunk), [chunk, 2 chunk) ... up to `count`, by `tasks`; null: here, in order. No chunk may
/// write what another reads or writes: then the result is that of any order. Chunks depend on `count` alone.
template <class Body> void for_chunks(Tasks* tasks, std::uint32_t count, std::uint32_t chunk, Body&& body) {
    const std::uint32_t chunks = count / chunk + (count % chunk != 0 ? 1u : 0u);
    const auto run = [&](std::uint32_t index, std::uint32_t worker) {
        body(index * chunk, std::min(count - index * chunk, chunk) + index * chunk, worker);
    };
    if (tasks == nullptr || chunks < 2) {
        for (std::uint32_t i = 0; i < chunks; ++i) run(i, 0);
        return;
    }
    using Run = decltype(run);
    const auto item = [](void* context, std::uint32_t index, std::uint32_t worker) {
        (*static_cast<const Run*>(context))(index, worker);
    };
    tasks->run(chunks, item, const_cast<void*>(static_cast<const void*>(&run)));
}

/// The same, for what has to be done whatever the tasks of a host do: where they leave a chunk out, all of them are done again, here. So no
/// chunk may read what it writes.
template <class Body>
void for_all_chunks(Tasks* tasks, std::uint32_t count, std::uint32_t chunk, Body&& body) {
    std::atomic<std::uint32_t> done = 0;
    for_chunks(tasks, count, chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t worker) {
        body(first, last, worker);
        done.fetch_add(last - first, std::memory_order_relaxed);
    });
    if (done.load(std::memory_order_relaxed) != count) for_chunks(nullptr, count, chunk, body);
}

/// True where for_chunks() gives chunks to workers.
inline bool is_shared(const Tasks* tasks, std::uint32_t count, std::uint32_t chunk) {
    return tasks != nullptr && count > chunk;
}

inline std::uint32_t worker_count(const Tasks* tasks) { return tasks == nullptr ? 1 : tasks->worker_count(); }

/// Adds what a chunk counted to a sum that all chunks share: whole numbers, so the order is not seen.
inline void add_count(std::uint64_t& sum, std::uint64_t count) {
    if (count != 0) std::atomic_ref(sum).fetch_add(count, std::memory_order_relaxed);
}

} // namespace lockstone::base
