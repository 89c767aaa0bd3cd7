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
#include <memory>
#include <vector>

namespace lockstone::base {

inline constexpr std::uint32_t strands_max = 64;

/// Before a piece come so many pieces of another strand, of its own round or of the one before.
struct PieceWait {
    std::uint32_t strand, pieces;
    bool of_last_round;
};
/// Items [first, last) of a strand, of which each round does all.
struct Piece {
    std::uint32_t first = 0, last = 0;
    std::uint32_t first_wait = 0, last_wait = 0; ///< of StrandPlan::waits
    std::uint32_t order = 0;                     ///< of a round: above that of all pieces that come before it
};

/// Pieces by strand. There is an order in which one worker could do all of them.
struct StrandPlan {
    std::uint32_t strands = 0;
    std::vector<Piece> pieces[strands_max];
    std::vector<PieceWait> waits;

    void clear() {
        for (std::uint32_t k = 0; k < strands; ++k) pieces[k].clear();
        waits.clear();
        strands = 0;
    }
    std::uint32_t count(std::uint32_t strand) const {
        return static_cast<std::uint32_t>(pieces[strand].size());
    }
};

/// Where a worker is in a plan.
struct PieceAt {
    std::uint32_t strand, index, round;
    std::uint32_t worker = 0; ///< of Tasks
};

template <class Visit> class StrandRun {
  public:
    StrandRun(const StrandPlan& what, std::uint32_t how_often, const Visit& each)
        : plan(what), rounds(how_often), visit(each) {
        for (std::uint32_t k = 0; k < plan.strands; ++k) std::construct_at(&strand[k]);
    }

    void run(Tasks* tasks) {
        if (tasks != nullptr)
            tasks->run(
                plan.strands,
                [](void* self, std::uint32_t own, std::uint32_t worker) {
                    static_cast<StrandRun*>(self)->work(own, worker);
                },
                this);
        // What nobody has begun:
        Worker w(plan.strands, 0);
        for (std::uint32_t k = 0; k < plan.strands; ++k) take(w, k);
        finish(w);
    }

  private:
    /// What all look at of a strand. On a cache line of its own: one worker writes it.
    struct Strand {
        alignas(64) std::atomic<std::uint32_t> done = 0; ///< pieces, of all rounds
        std::atomic<bool> is_taken = false;
    };
    /// One at work, with the strands that it has taken. There is room for strands_max of them; those of the plan are made.
    struct Worker {
        std::uint32_t number; ///< of Tasks
        int patience = looks_max;
        bool has[strands_max];
        std::uint32_t done[strands_max];                      ///< pieces of each strand, as far as it knows
        std::uint32_t index[strands_max], round[strands_max]; ///< of the next piece of each that it has

        Worker(std::uint32_t strands, std::uint32_t of_tasks) : number(of_tasks) {
            for (std::uint32_t k = 0; k < strands; ++k) has[k] = false, done[k] = index[k] = round[k] = 0;
        }
    };
    static constexpr int looks_max = 300; ///< then a strand that nobody has begun is taken over: 3 to 10 us

    std::uint32_t all_of(std::uint32_t k) const { return rounds * plan.count(k); }
    bool take(Worker& w, std::uint32_t k) {
        if (strand[k].is_taken.exchange(true, std::memory_order_relaxed)) return false;
        return w.has[k] = true;
    }
    void work(std::uint32_t own, std::uint32_t number) {
        Worker w(plan.strands, number);
        if (take(w, own)) finish(w);
    }
    /// All strands that it has taken, and takes meanwhile. Of all that nobody has done the first piece in order waits for nothing, and whoever has
    /// its strand does it next: so all goes on.
    void finish(Worker& w) {
        for (std::uint32_t k; (k = first_of(w)) != strands_max;)
            if (is_free(w, k)) do_next(w, k);
    }
    /// Of the strands that a worker has, the one whose next piece is the first in order; strands_max: all are done.
    std::uint32_t first_of(const Worker& w) const {
        std::uint32_t first = strands_max;
        std::uint64_t least = UINT64_MAX;
        for (std::uint32_t k = 0; k < plan.strands; ++k) {
            if (!w.has[k] || w.done[k] == all_of(k)) continue;
            const std::uint64_t at = std::uint64_t{w.round[k]} << 32 | plan.pieces[k][w.index[k]].order;
            if (at < least) least = at, first = k;
        }
        return first;
    }
    /// Waits for what comes before the next piece of a strand. False: it has taken another strand meanwhile, which may come first.
    bool is_free(Worker& w, std::uint32_t k) {
        const Piece& piece = plan.pieces[k][w.index[k]];
        for (std::uint32_t i = piece.first_wait; i < piece.last_wait; ++i)
            if (!wait(w, plan.waits[i].strand, pieces_before(w, k, plan.waits[i]))) return false;
        return true;
    }
    /// So many pieces of another strand, of all rounds, come before the next piece of a strand; 0: none.
    std::uint32_t pieces_before(const Worker& w, std::uint32_t k, const PieceWait& wait) const {
        if (wait.of_last_round && w.round[k] == 0) return 0;
        const std::uint32_t rounds_before = w.round[k] - (wait.of_last_round ? 1u : 0u);
        return rounds_before * plan.count(wait.strand) + wait.pieces;
    }
    void do_next(Worker& w, std::uint32_t k) {
        visit(plan.pieces[k][w.index[k]], PieceAt{k, w.index[k], w.round[k], w.number});
        if (++w.index[k] == plan.count(k)) w.index[k] = 0, ++w.round[k];
        strand[k].done.store(++w.done[k], std::memory_order_release);
    }
    /// Until so many pieces of a strand are done. False: it has taken that strand.
    bool wait(Worker& w, std::uint32_t k, std::uint32_t pieces) {
        for (int looks = 0; w.done[k] < pieces; ++looks) {
            w.done[k] = strand[k].done.load(std::memory_order_acquire);
            if (w.done[k] >= pieces) return true;
            if (looks >= w.patience && take(w, k)) {
                w.patience = 0; // its worker is not there: nor may others be
                return false;
            }
            relax(looks);
        }
        return true;
    }

    const StrandPlan& plan;
    const std::uint32_t rounds;
    const Visit& visit;
    union { // a run of few strands takes a microsecond: the others are not made
        Strand strand[strands_max];
    };
};

/// visit(piece, PieceAt) for all pieces of a plan, round after round, those of different strands at the same time. Without tasks: in order.
template <class Visit>
void for_strands(Tasks* tasks, const StrandPlan& plan, std::uint32_t rounds, const Visit& visit) {
    StrandRun<Visit>(plan, rounds, visit).run(tasks);
}

} // namespace lockstone::base
