// A loop from which several workers take items one by one, by a ticket.
#pragma once

#include "lockstone/tasks.h"

#include <atomic>
#include <cstdint>

namespace lockstone::base {

/// The ticket holds the number of the loop in the upper 40 bits and the count of items not yet taken in the lower 24.
/// A worker reads the other fields before it takes an item. They are not written while any item of their loop runs,
/// so a worker that gets an item of a loop has read the fields of that loop. The object has its own cache line.
class alignas(64) SharedLoop {
  public:
    static constexpr int left_bits = 24;
    static constexpr std::uint64_t left_mask = (std::uint64_t{1} << left_bits) - 1;

    /// Starts a loop of items [first, last), at most left_mask items; all items of the previous loop must be done.
    /// `number`: greater than that of the previous loop.
    void put_up(std::uint64_t number, std::uint32_t first, std::uint32_t last, Tasks::Item what, void* with) {
        end.store(last, std::memory_order_relaxed);
        item.store(what, std::memory_order_relaxed);
        context.store(with, std::memory_order_relaxed);
        ticket.store(number << left_bits | (last - first), std::memory_order_release);
    }
    /// Runs items until none is left. Returns the number of items that this call ran.
    std::uint32_t take_items(std::uint32_t worker) {
        std::uint32_t done = 0;
        std::uint64_t seen = ticket.load(std::memory_order_acquire);
        while ((seen & left_mask) != 0) {
            const std::uint32_t last = end.load(std::memory_order_relaxed);
            const Tasks::Item what = item.load(std::memory_order_relaxed);
            void* const with = context.load(std::memory_order_relaxed);
            if (!ticket.compare_exchange_weak(seen, seen - 1, std::memory_order_acquire)) continue;
            what(with, last - static_cast<std::uint32_t>(seen & left_mask), worker);
            ++done;
            --seen;
        }
        return done;
    }
    /// The number of the latest loop.
    std::uint64_t number() const { return ticket.load(std::memory_order_acquire) >> left_bits; }

  private:
    std::atomic<std::uint64_t> ticket = 0;
    std::atomic<std::uint32_t> end = 0; ///< index after the last item
    std::atomic<Tasks::Item> item = nullptr;
    std::atomic<void*> context = nullptr;
};

} // namespace lockstone::base
