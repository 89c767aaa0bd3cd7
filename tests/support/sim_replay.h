// The checker of the contract: does a world that was moved or restored go on as the run that never stopped?
#pragma once

#include "support/sim_script.h"

namespace lockstone::test::scene {

/// A run that never stopped: the hash after each tick and an image before it.
struct Run {
    Scenery scenery;
    Integrator integrator;
    std::vector<Image> images;
    std::vector<std::uint64_t> hashes;
};

inline Run run_of(Scenery scenery, int ticks, Integrator integrator = Integrator::semi_implicit_euler) {
    Run run{scenery, integrator, {}, {}};
    World w = start_script(scenery, integrator);
    for (int t = 0; t <= ticks; ++t) {
        w.save(run.images.emplace_back());
        run.hashes.push_back(w.hash());
        if (t < ticks) step_script(w);
    }
    return run;
}

/// Runs `w`, which stands at tick `from`, for at most `ticks` along the run. Empty when every hash agrees.
inline std::string departs(const Run& run, World& w, std::size_t from, std::size_t ticks) {
    for (std::size_t t = from;; ++t) {
        if (w.hash() != run.hashes[t]) {
            World expected = start_script(run.scenery, run.integrator);
            expected.restore(run.images[t]);
            return "from tick " + std::to_string(from) + ": " + difference(expected, w);
        }
        if (t + 1 == run.hashes.size() || t == from + ticks) return {};
        step_script(w);
    }
}

/// All that a journal hears.
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
