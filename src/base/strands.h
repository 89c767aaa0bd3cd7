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
        : plan(what), rounds(how_often), visit(each) {}

    void run(Tasks* tasks) {
        if (tasks != nullptr)
            tasks->run(
                plan.strands,
                [](void* self, std::uint32_t own, std::uint32_t worker) {
                    static_cast<StrandRun*>(self)->work(own, worker);
                },
                this);
        // What nobody has begun:
        Worker w;
        for (std::uint32_t k = 0; k < plan.strands; ++k)
            if (take(w, k)) advance(w, k, all_of(k));
    }

  private:
    /// What all look at of a strand. On a cache line of its own: one worker writes it.
    struct Strand {
        alignas(64) std::atomic<std::uint32_t> done = 0; ///< pieces, of all rounds
        std::atomic<bool> is_taken = false;
    };
    /// One at work, with the strands that it has taken.
    struct Worker {
        std::uint32_t number = 0; ///< of Tasks
        int patience = looks_max;
        bool has[strands_max] = {};
        std::uint32_t done[strands_max] = {}; ///< pieces of each strand, as far as it knows
        std::uint32_t index[strands_max] = {},
                      round[strands_max] = {}; ///< of the next piece of each that it has
    };
    static constexpr int looks_max = 300; ///< then a strand that nobody has begun is taken over: 3 to 10 us

    std::uint32_t all_of(std::uint32_t k) const { return rounds * plan.count(k); }
    bool take(Worker& w, std::uint32_t k) {
        if (strand[k].is_taken.exchange(true, std::memory_order_relaxed)) return false;
        return w.has[k] = true;
    }
    void work(std::uint32_t own, std::uint32_t number) {
        Worker w;
        w.number = number;
        if (!take(w, own)) return;
        advance(w, own, all_of(own));
        for (std::uint32_t k = 0; k < plan.strands; ++k) // those that it has begun
            if (w.has[k]) advance(w, k, all_of(k));
    }
    /// A strand that the worker has, until so many pieces are done.
    void advance(Worker& w, std::uint32_t k, std::uint32_t pieces) {
        while (w.done[k] < pieces) {
            const Piece& piece = plan.pieces[k][w.index[k]];
            for (std::uint32_t i = piece.first_wait; i < piece.last_wait; ++i) {
                const PieceWait& before = plan.waits[i];
                const std::uint32_t rounds_before = w.round[k] - (before.of_last_round ? 1u : 0u);
                if (w.round[k] != 0 || !before.of_last_round)
                    wait(w, before.strand, rounds_before * plan.count(before.strand) + before.pieces);
            }
            visit(piece, PieceAt{k, w.index[k], w.round[k], w.number});
            if (++w.index[k] == plan.count(k)) w.index[k] = 0, ++w.round[k];
            strand[k].done.store(++w.done[k], std::memory_order_release);
        }
    }
    /// Until so many pieces of a strand are done.
    void wait(Worker& w, std::uint32_t k, std::uint32_t pieces) {
        for (int looks = 0; w.done[k] < pieces; ++looks) {
            if (w.has[k]) return advance(w, k, pieces);
            w.done[k] = strand[k].done.load(std::memory_order_acquire);
            if (w.done[k] >= pieces) return;
            if (looks >= w.patience && take(w, k))
                w.patience = 0; // its worker is not there: nor may others be
            else
                relax(looks);
        }
    }

    const StrandPlan& plan;
    const std::uint32_t rounds;
    const Visit& visit;
    Strand strand[strands_max];
};

/// visit(piece, PieceAt) for all pieces of a plan, round after round, those of different strands at the same time. Without tasks: strand after strand,
/// as far as each goes.
template <class Visit>
void for_strands(Tasks* tasks, const StrandPlan& plan, std::uint32_t rounds, const Visit& visit) {
    StrandRun<Visit>(plan, rounds, visit).run(tasks);
}

} // namespace lockstone::base
