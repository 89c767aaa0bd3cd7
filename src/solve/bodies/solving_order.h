// Checks that the plans of passes keep the order of solving.
//
// Contacts and joints have an order, and the constraints of each body have to move it in that order. Packs, strands,
// workers and lanes only choose which constraints of different bodies come first. This file checks that, from the plan
// alone:
//
//   rank     of a constraint: its position in the order
//   item     the unit that pieces of a plan consist of: a pack of contacts, a step of joints. Constraints of one item
//            move different bodies
//   clock    of a piece: for each strand, the number of its pieces that are certainly done before the piece begins,
//            because of the order within its own strand and of waits
//
// Two constraints of a body with adjacent ranks are in order if the item of the first one comes earlier in the same
// strand, or if the clock of the second one's piece includes the piece of the first one.
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

/// Builds without NDEBUG check each plan when it is made, and count constraints in each pass.
#ifdef NDEBUG
inline constexpr bool checks_order = false;
#else
inline constexpr bool checks_order = true;
#endif

/// Allocates memory for checks. It does not use operator new, so a tick that allocates nothing also allocates nothing
/// in a build with checks.
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

/// The first fault of a pass, in a sentence; empty if each body is moved in ascending rank, and each item of `solved`
/// is in the plan. In a plan without strands, items run in the order of their numbers.
std::string order_fault(const base::StrandPlan& plan, std::span<const Solved> solved);
/// The first fault of passes that are one run: a fault as above; or the steps of a body between passes come before its
/// last constraint of a pass, after its first constraint of the next pass, never, or twice.
std::string order_fault(const base::StrandPlan& plan, std::span<const Solved> solved,
                        std::span<const BetweenPasses> followed);

/// The last constraint that moved each body, while passes run. The entry of a body needs no lock: only the worker that
/// moves the body counts its constraint, and the plan orders the workers of one body.
class PassCounter {
  public:
    /// Starts a tick.
    void begin(std::size_t bodies) {
        if (checks_order) last.assign(bodies, 0);
        pass = 0;
    }
    /// Starts a pass, and returns its number; passes count from one.
    std::uint32_t next_pass() { return ++pass; }
    /// Counts that a constraint of a pass moves a body.
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
