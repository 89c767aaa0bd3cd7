// Loops whose chunks may run in parallel.
#pragma once

#include "lockstone/tasks.h"

#include <algorithm>
#include <atomic>

namespace lockstone::base {

/// Calls body(first, last, worker) for [0, chunk), [chunk, 2 chunk) ... up to `count`, by `tasks`, or if `tasks` is
/// null, in order on this thread. No chunk may write data that another chunk reads or writes; then the result does
/// not depend on the order. Chunks depend on `count` and `chunk` alone.
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

/// Like for_chunks(), for work that has to be complete even if the host's Tasks skip items: if a chunk was skipped,
/// all chunks run again on this thread. So a chunk must not read data that it writes.
template <class Body>
void for_all_chunks(Tasks* tasks, std::uint32_t count, std::uint32_t chunk, Body&& body) {
    std::atomic<std::uint32_t> done = 0;
    for_chunks(tasks, count, chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t worker) {
        body(first, last, worker);
        done.fetch_add(last - first, std::memory_order_relaxed);
    });
    if (done.load(std::memory_order_relaxed) != count) for_chunks(nullptr, count, chunk, body);
}

/// Returns true if for_chunks() gives chunks to workers.
inline bool is_shared(const Tasks* tasks, std::uint32_t count, std::uint32_t chunk) {
    return tasks != nullptr && count > chunk;
}

inline std::uint32_t worker_count(const Tasks* tasks) { return tasks == nullptr ? 1 : tasks->worker_count(); }

/// Adds the count of a chunk to a sum that all chunks share. Integer addition, so the order does not change the
/// result.
inline void add_count(std::uint64_t& sum, std::uint64_t count) {
    if (count != 0) std::atomic_ref(sum).fetch_add(count, std::memory_order_relaxed);
}

} // namespace lockstone::base
