// Several threads query one world at once, and each gets the results that a single thread gets.
#include "support/query_scene.h"

#include <doctest/doctest.h>

#include <thread>

using namespace lockstone;
using namespace lockstone::test::query;

namespace {

/// The results of four threads that query `w` at the same time, by thread. Each thread also hashes, saves and copies
/// the world.
std::vector<Answers> ask_at_once(const World& w, const Assets& assets, int count) {
    std::vector<Answers> answers(4);
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < answers.size(); ++i)
        threads.emplace_back([&, i] {
            answers[i] = ask(w, assets, i, count);
            Image image;
            w.save(image);
            answers[i].put(w.hash());
            answers[i].put(w.clone().hash());
            answers[i].put(w.save_portable().size());
            answers[i].put(w.kinetic_energy());
        });
    for (std::thread& thread : threads) thread.join();
    return answers;
}

} // namespace

TEST_CASE("four threads that query a world at once get the answers of one thread alone") {
    const Assets assets;
    World w = crowd(assets, 60);
    for (int round = 0; round < 6; ++round) {
        for (int t = 0; t < 5; ++t) w.tick();
        const World other = w.clone(); // its caches do not exist yet either
        const std::vector<Answers> at_once = ask_at_once(w, assets, samples(80, 400));
        for (std::size_t i = 0; i < at_once.size(); ++i) {
            Answers alone = ask(other, assets, i, samples(80, 400));
            alone.put(other.hash());
            alone.put(other.hash());
            alone.put(other.save_portable().size());
            alone.put(other.kinetic_energy());
            CHECK(at_once[i] == alone);
        }
    }
}

TEST_CASE("planted fault: the check finds answers of a world that is one tick ahead in every thread") {
    const Assets assets;
    World w = crowd(assets, 60);
    for (int t = 0; t < 5; ++t) w.tick();
    const World before = w.clone();
    w.tick();
    const std::vector<Answers> at_once = ask_at_once(w, assets, 80);
    for (std::size_t i = 0; i < at_once.size(); ++i) {
        Answers alone = ask(before, assets, i, 80);
        alone.put(before.hash());
        alone.put(before.hash());
        alone.put(before.save_portable().size());
        alone.put(before.kinetic_energy());
        CHECK_FALSE(at_once[i] == alone);
    }
}
