// Do the plans of passes keep the order of solving?
//
// Contacts and joints have an order, and each body has to be moved by its constraints in that order. Packs, strands, workers and lanes only choose which
// constraints of different bodies come first. Here is the check of that, from the plan alone:
//
//   rank     of a constraint: its place in the order
//   item     what a piece of a plan counts: a pack of contacts, a step of joints. Constraints of one item move different bodies
//   clock    of a piece: for each strand, so many pieces of it are done for certain before the piece begins, by the strand's own order and by waits
//
// Two constraints of a body that follow one another by rank are in order, if the item of the first one comes earlier in the same strand, or if the
// clock of the second one's piece has the first one's piece.
#pragma once

#include "base/assert.h"
#include "base/strands.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

namespace lockstone::solve {

/// Builds without NDEBUG check each plan when it is made, and count in each pass.
#ifdef NDEBUG
inline constexpr bool checks_order = false;
#else
inline constexpr bool checks_order = true;
#endif

/// Memory of checks. It does not come from operator new, so a tick that allocates nothing also allocates nothing in a build that checks it.
template <class T> struct CheckAllocator {
    using value_type = T;
    CheckAllocator() = default;
    template <class U> CheckAllocator(const CheckAllocator<U>&) {}
    T* allocate(std::size_t count) {
        void* const memory = std::malloc(count * sizeof(T));
        LOCKSTONE_ASSERT(memory != nullptr, "no memory for a check: ", count * sizeof(T), " bytes");
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t) { std::free(memory); }
    friend bool operator==(CheckAllocator, CheckAllocator) { return true; }
};
template <class T> using CheckVector = std::vector<T, CheckAllocator<T>>;

inline constexpr std::uint32_t no_body = 0xffffffffu;

/// A constraint in a pass.
struct Solved {
    std::uint32_t item, rank;
    std::uint32_t moved[2]; ///< the bodies that it moves, or no_body
};
/// A body that is integrated between two passes, after a piece.
struct BetweenPasses {
    std::uint32_t body, strand, piece;
};

/// The first fault of a pass in a sentence; empty: each body is moved in ascending rank, and each item of `solved` is in the plan. In a plan
/// without strands items follow one another by number.
std::string order_fault(const base::StrandPlan& plan, std::span<const Solved> solved);
/// The first fault of passes that are one run: order_fault(), or a body that is followed before its last constraint of a pass, after its first one of the
/// next pass, or not once.
std::string order_fault(const base::StrandPlan& plan, std::span<const Solved> solved,
                        std::span<const BetweenPasses> followed);

/// The last constraint that moved each body, while passes run. A body needs no lock here: only the worker that
/// moves the body counts its constraint, and the plan puts workers of one body in order.
class PassCounter {
  public:
    /// A tick begins.
    void begin(std::size_t bodies) {
        if (checks_order) last.assign(bodies, 0);
        pass = 0;
    }
    /// A pass begins.
    std::uint32_t next_pass() { return ++pass; }
    /// A constraint of a pass moves a body; passes count from one.
    void move(std::uint32_t of_pass, std::uint32_t rank, std::uint32_t body) {
        if (!checks_order || body == no_body) return;
        const std::uint64_t now = std::uint64_t{of_pass} << 32 | rank;
        LOCKSTONE_ASSERT(now > last[body], "body ", body, " is moved by rank ", rank, " of pass ", of_pass,
                         " after rank ", last[body] & 0xffffffffu, " of pass ", last[body] >> 32);
        last[body] = now;
    }

  private:
    CheckVector<std::uint64_t> last; ///< by body: pass << 32 | rank
    std::uint32_t pass = 0;
};

} // namespace lockstone::solve
