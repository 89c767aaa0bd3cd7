// The checker of the contract: a moved or restored world must continue like the run that never stopped.
#pragma once

#include "lockstone/state.h"
#include "support/sim_script.h"

#include <functional>
#include <string>

namespace lockstone::test::scene {

/// A world whose commands before each tick follow from its state and tick.
struct Story {
    std::string name;
    std::function<World()> start;
    std::function<void(World&)> step = [](World& w) { w.tick(); };
    int ticks = 60;         ///< of the run
    std::size_t after = 10; ///< ticks in which a restored world is compared
    int moved_every = 1;    ///< ticks between moves to another world
    std::size_t after_move = 8;
};

inline Story script_story(Scenery scenery, int ticks,
                          Integrator integrator = Integrator::semi_implicit_euler) {
    const auto all = static_cast<std::size_t>(ticks);
    return {std::string(name_of(scenery)) + ", " + std::string(name_of(integrator)),
            [=] { return start_script(scenery, integrator); },
            step_script,
            ticks,
            all,
            1,
            20};
}

inline std::uint64_t hash_of_events(const World& w) {
    std::vector<std::byte> bytes;
    for (const Event& e : w.events())
        append_canonical(std::as_bytes(std::span(&e, 1)), leaves_of<Event>(), bytes);
    return hash_bytes(bytes);
}

/// A run without interruption: the hash and the events after each tick and an image before it.
struct Run {
    Story story;
    std::vector<Image> images;
    std::vector<std::uint64_t> hashes, events;
};

inline Run run_of(const Story& story) {
    Run run{story, {}, {}, {}};
    World w = story.start();
    for (int t = 0; t <= story.ticks; ++t) {
        w.save(run.images.emplace_back());
        run.hashes.push_back(w.hash());
        run.events.push_back(hash_of_events(w));
        if (t < story.ticks) story.step(w);
    }
    return run;
}

/// Runs `w`, which is at tick `from`, for at most `ticks`, and compares it with the run. Empty when every hash and all
/// events agree.
inline std::string departs(const Run& run, World& w, std::size_t from, std::size_t ticks) {
    const std::string where = "from tick " + std::to_string(from) + ": ";
    for (std::size_t t = from;; ++t) {
        if (w.hash() != run.hashes[t]) {
            World expected = run.story.start();
            expected.restore(run.images[t]);
            return where + difference(expected, w);
        }
        if (t != from && hash_of_events(w) != run.events[t])
            return where + "other events at tick " + std::to_string(t);
        if (t + 1 == run.hashes.size() || t == from + ticks) return {};
        run.story.step(w);
    }
}

/// All calls that a journal gets.
struct Tape : Journal {
    void on_restore(std::uint64_t) override {}
    struct Entry {
        std::uint64_t tick;
        Command command;
    };
    std::vector<Entry> commands;
    std::vector<std::uint64_t> hashes; ///< by tick
    void on_command(std::uint64_t tick, const Command& command) override {
        commands.push_back({tick, command});
    }
    void on_tick(std::uint64_t tick, std::uint64_t hash) override {
        if (tick != hashes.size()) throw std::runtime_error("the journal heard of ticks out of order");
        hashes.push_back(hash);
    }
};

} // namespace lockstone::test::scene
