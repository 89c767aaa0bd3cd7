// The pool of make_worker_pool. Workers take items one by one from a ticket. A run does not wait for a worker that
// sleeps.
#include "lockstone/tasks.h"

#include "base/assert.h"
#include "base/bell.h"
#include "base/relax.h"
#include "base/shared_loop.h"

#include <atomic>
#include <system_error>
#include <thread>
#include <vector>

namespace lockstone {

namespace {

/// How often a worker polls before it sleeps. Long enough to outlast the serial parts of a tick: a tick has a hundred
/// runs, and waking a thread would delay each of them.
constexpr int looks_max = 4000;

class WorkerPool final : public Tasks {
  public:
    explicit WorkerPool(std::uint32_t workers) : shares(workers), progress(workers) {
        threads.reserve(workers - 1);
#if defined(__cpp_exceptions)
        try {
            start(workers);
        } catch (const std::system_error&) {} // the pool works with the threads that were created
#else
        // Without exceptions, the standard library ends the program if the system has no more threads.
        start(workers);
#endif
    }
    ~WorkerPool() override {
        stops.store(true, std::memory_order_relaxed);
        wake_workers();
        for (std::thread& thread : threads) thread.join();
    }
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    std::uint32_t worker_count() const override { return static_cast<std::uint32_t>(threads.size()) + 1; }

    void run(std::uint32_t items, Item item, void* context) override {
        LOCKSTONE_ASSERT(items <= Share::left_mask, "a run of ", items, " items");
        LOCKSTONE_ASSERT(!runs_now.exchange(true, std::memory_order_acquire), "two runs at once");
        if (items < 2 || threads.empty()) {
            for (std::uint32_t i = 0; i < items; ++i) item(context, i, 0);
        } else {
            publish(items, item, context);
            take_items(0);
            wait_until_done();
        }
        runs_now.store(false, std::memory_order_release);
    }

  private:
    void start(std::uint32_t workers) {
        for (std::uint32_t worker = 1; worker < workers; ++worker)
            threads.emplace_back([this, worker] { serve(worker); });
    }

    /// Each worker has its own share of the items, as a loop of its own. From run to run a worker gets the same part
    /// of the range, so the data of that part stays in its cache. A worker that has finished its share helps with the
    /// other shares.
    using Share = base::SharedLoop;

    void publish(std::uint32_t items, Item item, void* context) {
        const std::uint64_t workers = worker_count();
        ++number, wanted += items;
        std::uint32_t first = 0, helpers = 0;
        for (std::uint64_t worker = 0; worker < workers; ++worker) {
            const std::uint32_t end =
                static_cast<std::uint32_t>((items * (worker + 1) + workers - 1) / workers);
            if (end == first) continue;
            shares[worker].put_up(number, first, end, item, context);
            first = end;
            if (worker != 0) ++helpers;
        }
        // A worker that is about to sleep may miss this run. The other workers then run all items, and the next run
        // wakes it.
        if (helpers != 0 && sleepers.load(std::memory_order_relaxed) != 0) wake_workers();
    }
    void wake_workers() {
        calls.fetch_add(1, std::memory_order_release);
        work_bell.ring_all(calls);
    }

    /// Takes the items of a worker's own share first. Reports them before it tries other shares, which takes a while.
    void take_items(std::uint32_t worker) {
        const std::uint32_t workers = worker_count();
        for (std::uint32_t k = 0; k < workers; ++k) {
            Share& share = shares[worker + k < workers ? worker + k : worker + k - workers];
            if (const std::uint32_t done = share.take_items(worker); done != 0) report(worker, done);
        }
    }
    void report(std::uint32_t worker, std::uint32_t done) {
        std::atomic<std::uint64_t>& own = progress[worker].items;
        own.store(own.load(std::memory_order_relaxed) + done, std::memory_order_seq_cst);
        if (!caller_sleeps.load(std::memory_order_seq_cst)) return;
        reports.fetch_add(1, std::memory_order_release);
        done_bell.ring_one(reports);
    }
    bool is_done() const {
        std::uint64_t done = 0;
        for (const Progress& of : progress) done += of.items.load(std::memory_order_seq_cst);
        return done == wanted;
    }
    void wait_until_done() {
        for (int looks = 1; !is_done(); ++looks) {
            if (looks < looks_max) {
                base::relax(looks);
                continue;
            }
            const std::uint32_t seen = reports.load(std::memory_order_acquire);
            // A worker that reports after is_done() below has read its count sees this.
            caller_sleeps.store(true, std::memory_order_seq_cst);
            if (!is_done()) done_bell.wait(reports, seen);
            caller_sleeps.store(false, std::memory_order_relaxed);
        }
    }

    void serve(std::uint32_t worker) {
        constexpr int looks_at_once = 64; // polls of its own share between two checks if the pool stops
        std::uint64_t last = 0;           // the latest run in which it has seen its share
        for (int looks = 1;; ++looks) {
            if (const std::uint64_t run = shares[worker].number(); run != last) {
                last = run;
                looks = 0;
                take_items(worker);
                continue;
            }
            if (looks % looks_at_once == 0 && stops.load(std::memory_order_relaxed)) return;
            if (looks < looks_max)
                base::relax(looks);
            else
                sleep(worker, last);
        }
    }
    void sleep(std::uint32_t worker, std::uint64_t last) {
        const std::uint32_t seen = calls.load(std::memory_order_acquire);
        sleepers.fetch_add(1, std::memory_order_relaxed);
        if (!stops.load(std::memory_order_relaxed) && shares[worker].number() == last)
            work_bell.wait(calls, seen);
        sleepers.fetch_sub(1, std::memory_order_relaxed);
    }

    /// Items that a worker has done since the pool was created. On its own cache line.
    struct alignas(64) Progress {
        std::atomic<std::uint64_t> items = 0;
    };

    // Members that all workers read and that are rarely written, apart from the members that the caller writes in
    // every run.
    std::vector<std::thread> threads;
    std::vector<Share> shares;      ///< by worker
    std::vector<Progress> progress; ///< by worker
    std::atomic<bool> stops = false, caller_sleeps = false;
    base::Bell work_bell, done_bell; ///< for changes of `calls` and of `reports`
    alignas(64) std::atomic<bool> runs_now = false;
    std::uint64_t number = 0;                            ///< number of the run
    std::uint64_t wanted = 0;                            ///< items of all runs so far
    alignas(64) std::atomic<std::uint32_t> sleepers = 0; ///< workers that sleep, or are about to
    std::atomic<std::uint32_t> calls = 0, reports = 0;   ///< incremented to wake workers, and the caller
};

} // namespace

std::unique_ptr<Tasks> make_worker_pool(std::uint32_t workers) {
    LOCKSTONE_ASSERT(workers >= 1 && workers <= workers_max, "a pool of ", workers, " workers");
    return std::make_unique<WorkerPool>(workers);
}

} // namespace lockstone
