// Work split into strands, which workers run in parallel. The pieces of a strand run in order; a piece may depend on
// pieces of other strands.
//
// A barrier after every step would cost about as much as many steps of a solver. Here a worker checks the progress of
// another strand only where a piece depends on it, so a worker that is ahead goes on. If no worker has begun a strand
// on which another one depends, the worker that needs it takes it over. So all work is done however the host's Tasks
// call the items: in sequence, in any order, twice, or some of them never.
#pragma once

#include "base/relax.h"
#include "lockstone/tasks.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

namespace lockstone::base {

inline constexpr std::uint32_t strands_max = 64;

/// A dependency of a piece: the first `pieces` pieces of another strand must be done, in the same round or, with
/// of_last_round, in the round before.
struct PieceWait {
    std::uint32_t strand, pieces;
    bool of_last_round;
};
/// Items [first, last) of a strand. Each round runs all pieces.
struct Piece {
    std::uint32_t first = 0, last = 0;
    std::uint32_t first_wait = 0, last_wait = 0; ///< range in StrandPlan::waits
    std::uint32_t order = 0; ///< within a round: above the order of all pieces on which it depends
};

/// Pieces by strand. Their dependencies have no cycle, so a single worker can run all of them.
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

/// The position of a worker in a plan.
struct PieceAt {
    std::uint32_t strand, index, round;
    std::uint32_t worker = 0; ///< index of the worker in Tasks
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
        // Runs the strands that no worker has begun:
        Worker w(plan.strands, 0);
        for (std::uint32_t k = 0; k < plan.strands; ++k) take(w, k);
        finish(w);
    }

  private:
    /// The progress of a strand, which all workers read. On its own cache line, because one worker writes it.
    struct Strand {
        alignas(64) std::atomic<std::uint32_t> done = 0; ///< pieces done, over all rounds
        std::atomic<bool> is_taken = false;
    };
    /// A worker, with the strands that it has taken. There is room for strands_max strands; only those of the plan
    /// are initialised.
    struct Worker {
        std::uint32_t number; ///< index of the worker in Tasks
        int patience = looks_max;
        bool has[strands_max];
        std::uint32_t done[strands_max];                      ///< pieces of each strand that it has seen done
        std::uint32_t index[strands_max], round[strands_max]; ///< next piece of each strand that it has taken

        Worker(std::uint32_t strands, std::uint32_t of_tasks) : number(of_tasks) {
            for (std::uint32_t k = 0; k < strands; ++k) has[k] = false, done[k] = index[k] = round[k] = 0;
        }
    };
    /// Polls before a worker takes over a strand that no worker has begun: a few microseconds.
    static constexpr int looks_max = 300;

    std::uint32_t all_of(std::uint32_t k) const { return rounds * plan.count(k); }
    bool take(Worker& w, std::uint32_t k) {
        if (strand[k].is_taken.exchange(true, std::memory_order_relaxed)) return false;
        return w.has[k] = true;
    }
    void work(std::uint32_t own, std::uint32_t number) {
        Worker w(plan.strands, number);
        if (take(w, own)) finish(w);
    }
    /// Runs all strands that the worker has taken, and those that it takes meanwhile. There is no deadlock: of all
    /// pieces that are not done, the first in order depends on none of the others, and the worker that has its strand
    /// runs it next.
    void finish(Worker& w) {
        for (std::uint32_t k; (k = first_of(w)) != strands_max;)
            if (is_free(w, k)) do_next(w, k);
    }
    /// Returns, of the strands of a worker, the one whose next piece is first in order; strands_max if all are done.
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
    /// Waits for the dependencies of a strand's next piece. Returns false if it has taken another strand meanwhile,
    /// whose piece may come first.
    bool is_free(Worker& w, std::uint32_t k) {
        const Piece& piece = plan.pieces[k][w.index[k]];
        for (std::uint32_t i = piece.first_wait; i < piece.last_wait; ++i)
            if (!wait(w, plan.waits[i].strand, pieces_before(w, k, plan.waits[i]))) return false;
        return true;
    }
    /// Returns how many pieces of another strand, over all rounds, must be done before the next piece of a strand; 0:
    /// none.
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
    /// Waits until `pieces` pieces of a strand are done. Returns false if it has taken over that strand.
    bool wait(Worker& w, std::uint32_t k, std::uint32_t pieces) {
        for (int looks = 0; w.done[k] < pieces; ++looks) {
            w.done[k] = strand[k].done.load(std::memory_order_acquire);
            if (w.done[k] >= pieces) return true;
            if (looks >= w.patience && take(w, k)) {
                w.patience = 0; // its worker is not running; others may not run either
                return false;
            }
            relax(looks);
        }
        return true;
    }

    const StrandPlan& plan;
    const std::uint32_t rounds;
    const Visit& visit;
    union { // a union, so that only the strands in use are constructed: a run of few strands takes a microsecond
        Strand strand[strands_max];
    };
};

/// Calls visit(piece, PieceAt) for all pieces of a plan, round after round; pieces of different strands may run at
/// the same time. Without tasks, all run in order on this thread.
template <class Visit>
void for_strands(Tasks* tasks, const StrandPlan& plan, std::uint32_t rounds, const Visit& visit) {
    StrandRun<Visit>(plan, rounds, visit).run(tasks);
}

} // namespace lockstone::base
