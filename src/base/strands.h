// Work cut into strands, which workers do side by side: the pieces of a strand follow one another, and some of them wait for pieces of other strands.
//
// A barrier after every step would cost about as much as many steps of a solver take. Here a worker looks at how far another strand has got only where a
// piece needs it, so who is ahead goes on. A strand that is waited for in vain, as nobody has begun it, is done by who waits: so all is done whatever
// the tasks of a host do, one item after the other, in any order, twice, or some of them never.
#pragma once

#include "base/relax.h"
#include "lockstone/tasks.h"

#include <atomic>
#include <cstdint>
#include <vector>

namespace lockstone::base {

inline constexpr std::uint32_t strands_max = 8;

/// Items [first, last) of a strand.
struct Piece {
    std::uint32_t strand, index; ///< it is piece `index` of its strand
    std::uint32_t first, last;
    std::uint32_t after[strands_max]; ///< so many pieces of each other strand come before it
};

struct StrandPlan {
    std::uint32_t strands = 0;
    std::uint32_t piece_count[strands_max] = {};
    std::vector<Piece> pieces; ///< in an order in which one worker could do all of them

    void clear() {
        strands = 0;
        pieces.clear();
    }
};

template <class Visit> class StrandRun {
  public:
    StrandRun(const StrandPlan& what, const Visit& each) : plan(what), visit(each) {}

    void run(Tasks& tasks) {
        tasks.run(
            plan.strands,
            [](void* self, std::uint32_t own, std::uint32_t) { static_cast<StrandRun*>(self)->work(own); },
            this);
    }

  private:
    /// What all look at of a strand. On a cache line of its own: one worker writes it.
    struct Strand {
        alignas(64) std::atomic<std::uint32_t> done = 0; ///< pieces
        std::atomic<bool> is_taken = false;
    };
    /// One at work, with the strands that it has taken.
    struct Worker {
        int patience = looks_max;
        bool has[strands_max] = {};
        std::uint32_t done[strands_max] = {}; ///< pieces of each strand, as far as it knows
    };
    static constexpr int looks_max = 300; ///< then a strand that nobody has begun is taken over: 3 to 10 us

    bool take(Worker& w, std::uint32_t k) {
        if (strand[k].is_taken.exchange(true, std::memory_order_relaxed)) return false;
        return w.has[k] = true;
    }
    void work(std::uint32_t own) {
        Worker w;
        if (!take(w, own)) return;
        const std::uint32_t end = static_cast<std::uint32_t>(plan.pieces.size());
        catch_up(w, end);
        for (std::uint32_t k = 0; k < plan.strands; ++k) wait(w, k, plan.piece_count[k], end);
    }
    /// All pieces before `end` of the strands that the worker has.
    void catch_up(Worker& w, std::uint32_t end) {
        for (std::uint32_t i = 0; i < end; ++i) {
            const Piece& piece = plan.pieces[i];
            if (!w.has[piece.strand] || w.done[piece.strand] != piece.index) continue;
            for (std::uint32_t k = 0; k < plan.strands; ++k) wait(w, k, piece.after[k], i);
            visit(piece.first, piece.last);
            strand[piece.strand].done.store(++w.done[piece.strand], std::memory_order_release);
        }
    }
    /// Until so many pieces of a strand are done, all of which come before piece `at` of the plan.
    void wait(Worker& w, std::uint32_t k, std::uint32_t pieces, std::uint32_t at) {
        for (int looks = 0; w.done[k] < pieces; ++looks) {
            if (w.has[k]) return catch_up(w, at);
            w.done[k] = strand[k].done.load(std::memory_order_acquire);
            if (w.done[k] >= pieces) return;
            if (looks >= w.patience && take(w, k))
                w.patience = 0; // its worker is not there: nor may others be
            else
                relax(looks);
        }
    }

    const StrandPlan& plan;
    const Visit& visit;
    Strand strand[strands_max];
};

/// visit(first, last) for all pieces of a plan, those of different strands at the same time.
template <class Visit> void for_strands(Tasks& tasks, const StrandPlan& plan, const Visit& visit) {
    StrandRun<Visit>(plan, visit).run(tasks);
}

} // namespace lockstone::base
