// The pool of make_worker_pool. Workers take items one by one from a ticket; nobody takes part who is not awake.
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

/// How often a worker looks before it sleeps: 40 to 200 us, longer than what a tick does by one thread alone. Who sleeps takes 5 to 50 us
/// to be woken, and a tick has a hundred runs.
constexpr int looks_max = 4000;

class WorkerPool final : public Tasks {
  public:
    explicit WorkerPool(std::uint32_t workers) : shares(workers) {
        threads.reserve(workers - 1);
#if defined(__cpp_exceptions)
        try {
            start(workers);
        } catch (const std::system_error&) {} // those that there are will do
#else
        start(workers); // the standard library ends the program where the system has no more threads
#endif
    }
    ~WorkerPool() override {
        stops.store(true, std::memory_order_relaxed);
        announce(worker_count());
        for (std::thread& thread : threads) thread.join();
    }
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    std::uint32_t worker_count() const override { return static_cast<std::uint32_t>(threads.size()) + 1; }

    void run(std::uint32_t items, Item item, void* context) override {
        LOCKSTONE_ASSERT(items <= left_mask, "a run of ", items, " items");
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

    /// Each worker has a share of the items, a loop of its own: shares that follow one another stay in its cache from run to run. Who has done
    /// its share helps others.
    using Share = base::SharedLoop;
    static constexpr std::uint64_t left_mask = Share::left_mask;

    void publish(std::uint32_t items, Item item, void* context) {
        pending.store(items, std::memory_order_relaxed);
        const std::uint64_t workers = worker_count();
        ++number;
        std::uint32_t first = 0, helpers = 0;
        for (std::uint64_t worker = 0; worker < workers; ++worker) {
            const std::uint32_t end =
                static_cast<std::uint32_t>((items * (worker + 1) + workers - 1) / workers);
            if (end == first) continue;
            shares[worker].put_up(number, first, end, item, context);
            first = end;
            if (worker != 0) ++helpers;
        }
        announce(helpers);
    }
    /// Those that sleep on are not missed: the rest take all items.
    void announce(std::uint32_t helpers) {
        announced.fetch_add(1, std::memory_order_release);
        if (helpers != 0) work_bell.ring_all(announced);
    }

    void take_items(std::uint32_t worker) {
        std::uint32_t done = 0;
        const std::uint32_t workers = worker_count();
        for (std::uint32_t k = 0; k < workers; ++k)
            done += shares[worker + k < workers ? worker + k : worker + k - workers].take_items(worker);
        if (done != 0 && pending.fetch_sub(done, std::memory_order_acq_rel) == done)
            done_bell.ring_one(pending);
    }
    void wait_until_done() {
        int looks = 0;
        for (std::uint32_t left; (left = pending.load(std::memory_order_acquire)) != 0;) {
            if (++looks < looks_max)
                base::relax(looks);
            else
                done_bell.wait(pending, left);
        }
    }

    void serve(std::uint32_t worker) {
        std::uint64_t last = 0; // the latest run of which it has seen its share
        for (int looks = 0;;) {
            const std::uint32_t rings = announced.load(std::memory_order_acquire);
            if (stops.load(std::memory_order_relaxed)) return;
            const std::uint64_t run = shares[worker].number();
            if (run == last) {
                if (++looks < looks_max)
                    base::relax(looks);
                else
                    work_bell.wait(announced, rings);
                continue;
            }
            last = run;
            looks = 0;
            take_items(worker);
        }
    }

    std::vector<std::thread> threads;
    std::atomic<bool> runs_now = false, stops = false;
    std::uint64_t number = 0;  ///< of the run
    std::vector<Share> shares; ///< by worker
    // Each on a cache line of its own: all workers write them.
    alignas(64) std::atomic<std::uint32_t> pending = 0;   ///< items that are not done
    alignas(64) std::atomic<std::uint32_t> announced = 0; ///< goes up with every run
    base::Bell work_bell, done_bell;                      ///< of `announced` and of `pending`
};

} // namespace

std::unique_ptr<Tasks> make_worker_pool(std::uint32_t workers) {
    LOCKSTONE_ASSERT(workers >= 1 && workers <= workers_max, "a pool of ", workers, " workers");
    return std::make_unique<WorkerPool>(workers);
}

} // namespace lockstone
