// A runner that outlives its session. For the tests and for the planted faults.
#pragma once

#include "session/arena.h"
#include "session/hostile_scenes.h"
#include "support/stops.h"

#include <new>

namespace lockstone::test {

/// Does nothing and counts the calls that a runner makes.
class CountedSession final : public Session {
  public:
    void poll(std::uint64_t) override { ++calls; }
    void add_local_input(std::uint32_t, std::span<const std::byte>) override { ++calls; }
    Step advance() override { return ++calls, Step{}; }
    Step settle() override { return ++calls, Step{}; }
    HashCheck report_hash(std::uint64_t, std::uint64_t) override { return ++calls, HashCheck::accepted; }
    std::optional<ConfirmedTick> next_confirmed() override { return ++calls, std::nullopt; }
    std::optional<Notice> next_notice() override { return ++calls, std::nullopt; }
    Status drop_peer(PeerId) override { return ++calls, Status{}; }
    bool set_inspector(StateInspector*) override { return ++calls, true; }
    void drop_inspector(const StateInspector&) override { ++calls; }
    std::uint64_t current_tick() const override { return 0; }
    std::uint32_t images_max() const override { return 4; }
    void set_input_delay(std::uint32_t) override { ++calls; }
    PeerQuality quality(PeerId) const override { return {}; }
    const SessionStats& stats() const override { return no_stats; }

    int calls = 0;

  private:
    SessionStats no_stats;
};

/// Makes a runner, destroys its session, makes another session in the same memory, calls `then` and destroys the
/// runner. Returns the number of calls that the second session received. The memory stays allocated, so the test has
/// defined behaviour even where the runner is wrong.
template <class Then> int calls_after_the_end(Then&& then) {
    alignas(CountedSession) std::byte memory[sizeof(CountedSession)];
    auto* first = new (memory) CountedSession;
    Arena arena(2);
    std::optional<SessionRunner> runner;
    runner.emplace(*first, arena, RunnerDef{.inspected_ticks = 8});
    first->~CountedSession();
    auto* second = new (memory) CountedSession;
    then(*runner);
    runner.reset();
    const int calls = second->calls;
    second->~CountedSession();
    return calls;
}

inline std::vector<HostileScene> lifetime_scenes() {
    return {
        {"a runner does not call a session that was destroyed when it is destroyed",
         [] {
             return std::string(calls_after_the_end([](SessionRunner&) {}) == 0
                                    ? ""
                                    : "the destructor of the runner calls the session");
         }},
        {"a frame of a session that was destroyed ends the program",
         [] {
             std::string words;
             calls_after_the_end(
                 [&](SessionRunner& runner) { words = last_words([&] { runner.frame(1); }); });
             return words.find("the session was destroyed before its runner") != std::string::npos
                        ? std::string()
                        : "the frame ended with: " + words;
         }},
    };
}

} // namespace lockstone::test
