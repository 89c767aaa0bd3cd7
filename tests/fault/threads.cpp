// The pool keeps its contract under contention. The tests also detect tasks that break the rule of equal results.
#include "base/bell.h"
#include "support/task_worlds.h"

#include <doctest/doctest.h>

#include <chrono>
#include <cstdlib>
#include <thread>

using namespace lockstone;
using namespace lockstone::test;

namespace {

const bool is_long = std::getenv("LOCKSTONE_LONG") != nullptr;

/// The counts of one run.
struct Count {
    std::vector<std::uint32_t> times;                    ///< by item; not atomic: one worker has an item
    std::array<std::atomic<int>, workers_max> at_work{}; ///< by worker
    std::atomic<bool> two_at_once = false;
    std::uint32_t worker_count = 0;
    std::atomic<bool> unknown_worker = false;
};

void count_item(void* context, std::uint32_t index, std::uint32_t worker) {
    Count& count = *static_cast<Count*>(context);
    if (worker >= count.worker_count) {
        count.unknown_worker = true;
        return;
    }
    if (count.at_work[worker].fetch_add(1) != 0) count.two_at_once = true;
    ++count.times[index];
    count.at_work[worker].fetch_sub(1);
}

/// Returns an error sentence unless every item of many runs ran once, on a worker that ran no other item meanwhile.
std::string complaint(Tasks& tasks, int runs) {
    std::mt19937 random(11);
    Count count;
    count.worker_count = tasks.worker_count();
    for (int run = 0; run < runs; ++run) {
        const std::uint32_t items = static_cast<std::uint32_t>(random() % (run % 8 == 0 ? 2000 : 12));
        count.times.assign(items, 0);
        tasks.run(items, count_item, &count);
        for (std::uint32_t i = 0; i < items; ++i)
            if (count.times[i] != 1)
                return "run " + std::to_string(run) + ": item " + std::to_string(i) + " of " +
                       std::to_string(items) + " was run " + std::to_string(count.times[i]) + " times";
        if (run % 500 == 0) std::this_thread::yield();
    }
    if (count.unknown_worker) return "a worker beyond worker_count()";
    return count.two_at_once ? "one worker had two items at once" : "";
}

/// A game row in which rules store the result of their own tasks.
struct Note {
    std::uint64_t sum;
};
template <class V> constexpr void describe(Note& n, V&& v) { v("sum", n.sum); }
constexpr Column<Note> note{0};

World noting_world() {
    GameSchema schema;
    schema.add_record<Note>("game.note");
    World world = scene::made(World::create(scene::small_def(), schema));
    scene::add_floor(world);
    scene::add_stack(world, 3);
    return world;
}

/// Compares worlds whose rules fold the numbers of their items with `fold`, in tasks of random order. Returns the first
/// difference.
template <class Fold> std::string departure_of(Fold&& fold) {
    ShuffledTasks shuffled(4);
    return first_departure(
        noting_world(), std::array<Tasks*, 1>{&shuffled}, 10, [&](World& world, Tasks* tasks) {
            struct Job {
                std::uint64_t sum = 1;
                Fold& combine;
            } job{1, fold};
            const Tasks::Item item = [](void* context, std::uint32_t index, std::uint32_t) {
                Job& j = *static_cast<Job*>(context);
                j.sum = j.combine(j.sum, std::uint64_t{index} + 1);
            };
            if (tasks != nullptr)
                tasks->run(20, item, &job);
            else
                for (std::uint32_t i = 0; i < 20; ++i) item(&job, i, 0);
            scene::done(world.write(note, {job.sum}));
            world.tick();
        });
}

} // namespace

TEST_CASE("a pool with any number of workers runs every item once") {
    for (const std::uint32_t workers : {1u, 2u, 3u, 8u, 64u}) {
        INFO(workers);
        const auto pool = make_worker_pool(workers);
        CHECK(complaint(*pool, is_long ? 20000 : workers > 8 ? 4 : 60) == "");
    }
    UnsteadyTasks unsteady(4, 3);
    CHECK(complaint(unsteady, 20) == "");
}

TEST_CASE("a run of a pool reads what the items of the previous run wrote") {
    const auto pool = make_worker_pool(4);
    std::vector<std::uint64_t> numbers(300, 1);
    struct Job {
        std::vector<std::uint64_t>& numbers;
        std::size_t shift;
    };
    std::vector<std::uint64_t> expected = numbers;
    for (std::size_t shift = 1; shift < 80; ++shift) {
        // Even runs read the upper half and write the lower one; odd runs do the reverse.
        Job job{numbers, shift};
        const Tasks::Item item = [](void* context, std::uint32_t index, std::uint32_t) {
            const Job& j = *static_cast<const Job*>(context);
            const std::size_t to = j.shift % 2 == 0 ? 0 : 150, from = 150 - to;
            j.numbers[to + index] += j.numbers[from + (index + j.shift) % 150];
        };
        pool->run(150, item, &job);
        Job again{expected, shift};
        for (std::uint32_t i = 0; i < 150; ++i) item(&again, i, 0);
    }
    CHECK(numbers == expected);
}

namespace {

/// A faulty bell: it compares before it locks, as libstdc++ 12 does where the system has no futex, and sleeps in
/// between.
class EarlyBell {
  public:
    void wait(const std::atomic<std::uint32_t>& number, std::uint32_t seen) {
        if (number.load() != seen) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        std::unique_lock hold(guard);
        if (rung.wait_for(hold, std::chrono::milliseconds(100)) == std::cv_status::timeout) ++missed;
    }
    void ring_one(std::atomic<std::uint32_t>&) { rung.notify_one(); }
    std::atomic<int> missed = 0;

  private:
    std::mutex guard;
    std::condition_variable rung;
};

/// Two threads pass a number to and fro and sleep in between.
template <class Bell> void hand_to_and_fro(Bell& to, Bell& fro, std::uint32_t times) {
    std::atomic<std::uint32_t> there = 0, back = 0;
    std::thread other([&] {
        for (std::uint32_t i = 0; i < times; ++i) {
            while (there.load() == i) to.wait(there, i);
            ++back;
            fro.ring_one(back);
        }
    });
    for (std::uint32_t i = 0; i < times; ++i) {
        ++there;
        to.ring_one(there);
        while (back.load() == i) fro.wait(back, i);
    }
    other.join();
}

} // namespace

TEST_CASE("the bell of the system and the bell with a lock wake a thread that sleeps") {
    base::SystemBell system[2];
    hand_to_and_fro(system[0], system[1], is_long ? 200000 : 5000);
    base::LockedBell locked[2];
    hand_to_and_fro(locked[0], locked[1], is_long ? 200000 : 5000);
    std::atomic<std::uint32_t> number = 1;
    locked[0].wait(number, 0); // the number differs, so the call returns at once
}

TEST_CASE("planted fault: a bell that compares before it locks leaves a thread asleep") {
    EarlyBell early[2];
    hand_to_and_fro(early[0], early[1], 20);
    CHECK(early[0].missed + early[1].missed > 0);
}

namespace {

/// Returns an error sentence unless workers that fell asleep between runs take part again, and run() returns to a
/// caller that waits long for another worker's item. Items take a millisecond, so a woken worker finds some left.
std::string complaint_of_sleepers(Tasks& tasks) {
    struct Run {
        std::atomic<std::uint32_t> items = 0, by_others = 0;
    };
    Run all;
    const Tasks::Item item = [](void* context, std::uint32_t, std::uint32_t worker) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        Run& run = *static_cast<Run*>(context);
        ++run.items;
        if (worker != 0) ++run.by_others;
    };
    constexpr std::uint32_t rounds = 10, items = 9; // odd: one worker waits
    for (std::uint32_t round = 0; round < rounds; ++round) {
        std::this_thread::sleep_for(std::chrono::milliseconds(3)); // longer than workers spin
        for (int twice = 0; twice < 2; ++twice) tasks.run(items, item, &all);
    }
    if (all.items != 2 * rounds * items) return "items are missing";
    return all.by_others < rounds ? "workers that slept do not take part" : "";
}

} // namespace

TEST_CASE("workers that slept take part again and a caller that sleeps wakes up") {
    for (const std::uint32_t workers : {2u, 3u, 8u}) {
        INFO(workers);
        CHECK(complaint_of_sleepers(*make_worker_pool(workers)) == "");
    }
}

TEST_CASE("planted fault: the check finds workers that never wake by their missing work") {
    CHECK(complaint_of_sleepers(*make_worker_pool(1)) == "workers that slept do not take part");
}

TEST_CASE("pools start and stop with and without use") {
    for (int i = 0; i < 20; ++i) {
        const auto pool = make_worker_pool(1 + static_cast<std::uint32_t>(i) % 5);
        if (i % 3 != 0) CHECK(complaint(*pool, i % 7) == "");
    }
}

TEST_CASE("planted fault: the count finds tasks that leave an item out or run one twice") {
    FaultyTasks leaves_out(FaultyTasks::Fault::leaves_out, 40), twice(FaultyTasks::Fault::runs_twice, 40);
    CHECK(complaint(leaves_out, 60).find("run 40: ") == 0);
    CHECK(complaint(twice, 60).find("was run 2 times") != std::string::npos);
}

TEST_CASE(
    "planted fault: the comparison of worlds finds work whose result depends on the order of its items") {
    CHECK(departure_of([](std::uint64_t sum, std::uint64_t item) { return sum + item; }) == "");
    const std::string found =
        departure_of([](std::uint64_t sum, std::uint64_t item) { return sum * 31 + item; });
    CHECK(found.find("column game.note, row 0, sum") != std::string::npos);
}

// An item that is left out leaves unwritten memory. Builds that poison memory would stop in the sanitizers at such a
// read.
#ifdef NDEBUG
constexpr bool poisons_scratch = false;
#else
constexpr bool poisons_scratch = true;
#endif

TEST_CASE("planted fault: the comparison of worlds finds tasks that leave an item out or run one twice" *
          doctest::skip(poisons_scratch)) {
    const auto game = small_scene(*find_scene("pile"));
    FaultyTasks sound(FaultyTasks::Fault::leaves_out, ~std::uint64_t{0});
    CHECK(first_departure(*game, std::array<Tasks*, 1>{&sound}, 20, 20) == "");
    REQUIRE(sound.runs > 100);
    for (const std::uint64_t first : {sound.runs / 2, sound.runs - 40}) {
        INFO(first);
        int noticed = 0; // leaving out a pass over bodies without forces has no effect
        for (std::uint64_t run = first; run < first + 8; ++run) {
            FaultyTasks leaves_out(FaultyTasks::Fault::leaves_out, run);
            noticed += first_departure(*game, std::array<Tasks*, 1>{&leaves_out}, 20, 20) != "" ? 1 : 0;
        }
        CHECK(noticed >= 2);
    }
    bool any_twice = false; // running an item twice is harmless where it only copies
    for (std::uint64_t run = sound.runs / 2; run < sound.runs / 2 + 8; ++run) {
        FaultyTasks twice(FaultyTasks::Fault::runs_twice, run);
        any_twice = any_twice || first_departure(*game, std::array<Tasks*, 1>{&twice}, 20, 20) != "";
    }
    CHECK(any_twice);
}
