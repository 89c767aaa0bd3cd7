// Steps that follow one another, each shared by all workers: passes over rows of which few at a time do not depend on each other.
//
// A run of Tasks for each step would cost more than most steps take. So there is one run for all of them: each worker has a strand, its share of
// every step, and looks from step to step whether the others have done theirs. Who has waited in vain for a share that nobody has taken does it
// too: so all is done whatever the tasks of a host do, one item after the other, in any order, or some of them never.
#pragma once

#include "base/relax.h"
#include "lockstone/tasks.h"

#include <algorithm>
#include <atomic>
#include <cstdint>

namespace lockstone::base {

/// Items [first, last), which do not depend on each other.
struct Step {
    std::uint32_t first, last;
};

template <class StepOf, class Visit> class Steps {
  public:
    Steps(std::uint32_t strand_count, std::uint32_t step_count, std::uint32_t shared_from,
          const StepOf& steps, const Visit& each)
        : strands(strand_count), count(step_count), least(shared_from), step_of(steps), visit(each) {}

    void run(Tasks& tasks) {
        tasks.run(
            strands,
            [](void* self, std::uint32_t own, std::uint32_t) { static_cast<Steps*>(self)->work(own); }, this);
    }

    static constexpr std::uint32_t strands_max = 8;

  private:
    /// Steps before these are taken, and done. Each on a cache line of its own: one worker writes both, all others look at what is done.
    struct Strand {
        alignas(64) std::atomic<std::uint32_t> taken = 0;
        alignas(64) std::atomic<std::uint32_t> done = 0;
    };
    /// One step for all strands, or several for the first alone.
    struct Group {
        std::uint32_t first, last;
        bool is_shared;
    };
    static constexpr int looks_max = 300; ///< then a share is taken over: 3 to 10 us

    bool is_shared(std::uint32_t step) const {
        const Step s = step_of(step);
        return s.last - s.first >= least;
    }
    Group group_at(std::uint32_t first) const {
        Group g{first, first + 1, is_shared(first)};
        while (!g.is_shared && g.last < count && !is_shared(g.last)) ++g.last;
        return g;
    }

    /// A strand's share of a group, unless somebody has taken it.
    bool take(std::uint32_t k, const Group& g) {
        std::uint32_t seen = strand[k].taken.load(std::memory_order_relaxed);
        if (seen > g.first ||
            !strand[k].taken.compare_exchange_strong(seen, g.last, std::memory_order_relaxed))
            return false;
        for (std::uint32_t i = g.first; i < g.last; ++i) {
            const Step s = step_of(i);
            const std::uint64_t items = s.last - s.first, parts = g.is_shared ? strands : 1;
            const auto from = [&](std::uint64_t part) {
                return s.first + static_cast<std::uint32_t>(items * part / parts);
            };
            if (from(k) != from(k + 1)) visit(i, from(k), from(k + 1));
        }
        strand[k].done.store(g.last, std::memory_order_release);
        return true;
    }
    /// Until a strand's share of a group is done.
    void wait(std::uint32_t k, const Group& g, int& patience) {
        for (int looks = 0; strand[k].done.load(std::memory_order_acquire) < g.last; ++looks) {
            if (looks >= patience && take(k, g))
                patience = 0; // its worker is not there: it need not be waited for again
            relax(looks);
        }
    }
    void work(std::uint32_t own) {
        int patience = looks_max;
        for (std::uint32_t step = 0; step < count;) {
            const Group g = group_at(step);
            const std::uint32_t parts = g.is_shared ? strands : 1;
            if (own < parts) take(own, g);
            for (std::uint32_t k = 0; k < parts; ++k)
                if (k != own) wait(k, g, patience);
            if (own < parts) wait(own, g, patience);
            step = g.last;
        }
    }

    const std::uint32_t strands, count, least;
    const StepOf& step_of;
    const Visit& visit;
    Strand strand[strands_max];
};

/// visit(step, first, last) for pieces of steps [0, count), one step after the other; those with `least` items and more are shared by workers.
/// step_of(i) is a Step.
template <class StepOf, class Visit>
void for_steps(Tasks* tasks, std::uint32_t count, std::uint32_t least, const StepOf& step_of,
               const Visit& visit) {
    using All = Steps<StepOf, Visit>;
    const std::uint32_t strands = tasks == nullptr ? 1 : std::min(tasks->worker_count(), All::strands_max);
    bool any = false;
    for (std::uint32_t i = 0; i < count && strands > 1 && !any; ++i)
        any = step_of(i).last - step_of(i).first >= least;
    if (any) return All(strands, count, least, step_of, visit).run(*tasks);
    for (std::uint32_t i = 0; i < count; ++i) visit(i, step_of(i).first, step_of(i).last);
}

} // namespace lockstone::base
