// A loop whose items several workers take one by one, from a ticket.
#pragma once

#include "lockstone/tasks.h"

#include <atomic>
#include <cstdint>

namespace lockstone::base {

/// The ticket: number of the loop in the upper 40 bits, items that nobody has taken yet in the lower 24. The other fields are read before an
/// item is taken. They are not written while any item of their loop is under way, so whoever takes an item of a loop has read the fields
/// of that loop. On a cache line of its own.
class alignas(64) SharedLoop {
  public:
    static constexpr int left_bits = 24;
    static constexpr std::uint64_t left_mask = (std::uint64_t{1} << left_bits) - 1;

    /// Puts up items [first, last), at most left_mask, once those of the loop before are done. `number`: above that of the loop before.
    void put_up(std::uint64_t number, std::uint32_t first, std::uint32_t last, Tasks::Item what, void* with) {
        end.store(last, std::memory_order_relaxed);
        item.store(what, std::memory_order_relaxed);
        context.store(with, std::memory_order_relaxed);
        ticket.store(number << left_bits | (last - first), std::memory_order_release);
    }
    /// Does items until none is left. Returns how many.
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
    /// Of the latest loop.
    std::uint64_t number() const { return ticket.load(std::memory_order_acquire) >> left_bits; }

  private:
    std::atomic<std::uint64_t> ticket = 0;
    std::atomic<std::uint32_t> end = 0; ///< one more than the last item
    std::atomic<Tasks::Item> item = nullptr;
    std::atomic<void*> context = nullptr;
};

} // namespace lockstone::base
