// The pool of make_worker_pool. Workers take items one by one from a ticket; nobody takes part who is not awake.
#include "lockstone/tasks.h"

#include "base/assert.h"
#include "base/bell.h"
#include "base/relax.h"

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
    explicit WorkerPool(std::uint32_t workers) {
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

    // The ticket: number of the run in the upper 40 bits, items that nobody has taken yet in the lower 24. The fields of
    // the job are read before an item is taken. They are not written while any item of their run is under way, so
    // whoever takes an item of a run has read the fields of that run.
    static constexpr int left_bits = 24;
    static constexpr std::uint64_t left_mask = (std::uint64_t{1} << left_bits) - 1;

    void publish(std::uint32_t items, Item item, void* context) {
        job_items.store(items, std::memory_order_relaxed);
        job_item.store(item, std::memory_order_relaxed);
        job_context.store(context, std::memory_order_relaxed);
        pending.store(items, std::memory_order_relaxed);
        const std::uint64_t number = (ticket.load(std::memory_order_relaxed) >> left_bits) + 1;
        ticket.store(number << left_bits | items, std::memory_order_release);
        announce(items - 1);
    }
    /// Wakes no more workers than there is work for. Those that sleep on are not missed: the rest take all items.
    void announce(std::uint32_t helpers) {
        announced.fetch_add(1, std::memory_order_release);
        if (helpers >= threads.size())
            work_bell.ring_all(announced);
        else
            for (std::uint32_t i = 0; i < helpers; ++i) work_bell.ring_one(announced);
    }

    void take_items(std::uint32_t worker) {
        std::uint32_t done = 0;
        std::uint64_t seen = ticket.load(std::memory_order_acquire);
        while ((seen & left_mask) != 0) {
            const std::uint32_t items = job_items.load(std::memory_order_relaxed);
            const Item item = job_item.load(std::memory_order_relaxed);
            void* const context = job_context.load(std::memory_order_relaxed);
            if (!ticket.compare_exchange_weak(seen, seen - 1, std::memory_order_acquire)) continue;
            item(context, items - static_cast<std::uint32_t>(seen & left_mask), worker);
            ++done;
            --seen;
        }
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
        std::uint32_t seen = 0;
        for (int looks = 0;;) {
            if (announced.load(std::memory_order_acquire) == seen) {
                if (++looks < looks_max)
                    base::relax(looks);
                else
                    work_bell.wait(announced, seen);
                continue;
            }
            if (stops.load(std::memory_order_relaxed)) return;
            seen = announced.load(std::memory_order_acquire);
            looks = 0;
            take_items(worker);
        }
    }

    std::vector<std::thread> threads;
    std::atomic<bool> runs_now = false, stops = false;
    std::atomic<std::uint32_t> job_items = 0;
    std::atomic<Item> job_item = nullptr;
    std::atomic<void*> job_context = nullptr;
    // Each on a cache line of its own: all workers write them.
    alignas(64) std::atomic<std::uint64_t> ticket = 0;
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
