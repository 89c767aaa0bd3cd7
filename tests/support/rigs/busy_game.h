// A game with events of every kind, and with every pair of kinds in some tick.
#pragma once

#include "lockstone/game.h"
#include "lockstone/math/random.h"
#include "lockstone/session.h"
#include "support/sim_scenes.h"

#include <array>
#include <string>

namespace lockstone::test {

/// `advance` depends on the state only, so a session may run it again.
struct BusyGame : Game {
    static constexpr std::uint64_t crate = 1u << 16, ball = 2u << 16, hung = 3u << 16, crowd = 4u << 16;

    std::string name() const override { return "busy"; }
    std::uint64_t content_id() const override { return 1; }
    std::uint32_t player_count() const override { return 1; }
    std::uint32_t input_size() const override { return 1; }

    Result<World> start() const override {
        WorldDef def = scene::drowsy_def();
        def.bodies_max = def.shapes_max = 512, def.joints_max = 64, def.contacts_max = 400;
        World world = scene::made(World::create(def));
        scene::add_floor(world);
        const BodyId gate =
            scene::made(world.create_body({.kind = BodyKind::static_, .pose = scene::at(0, 50, 0)}));
        scene::made(world.create_shape(gate, {.geometry = box(2_r, 2_r, 2_r), .sensor = 1}));
        for (std::size_t i = 0; i < hoppers.size(); ++i)
            hoppers[i] = scene::made(
                world.create_character({.position = scene::vec(3 * static_cast<double>(i), 1, -20)}));
        return world;
    }

    Status advance(World& world, std::span<const PlayerInput>) const override {
        const auto t = static_cast<std::uint32_t>(world.tick_count());
        // user_key holds the body's kind and the tick of its creation.
        for (const BodyId body : world.bodies()) {
            const std::uint64_t key = world.user_key(body), age = t - (key & 0xffffu);
            if ((key & ~0xffffull) == crate && age == 55 && key % 3 == 0)
                scene::done(world.add_impulse(body, scene::vec(0, 100, 0)));
            if (key != 0 && age == lifetime(key & ~0xffffull)) scene::done(world.destroy(body));
        }
        const double lane = 2 * (t % 80);
        for (int i = 0; i < 2; ++i) {
            add(world, crate | t, scene::at(lane, 0.2, 2 * i), box(0.2_r, 0.2_r, 0.2_r));
            add(world, ball | t, scene::at(4 * i - 2, 50, 0), sphere(0.5_r));
            const BodyId weight = add(world, hung | t, scene::at(lane, 20, 5 + 2 * i), sphere(0.2_r));
            JointDef weak = weld_joint();
            weak.break_force = 1_r;
            scene::made(world.create_joint(weak, {}, weight, scene::at(lane, 20.5, 5 + 2 * i)));
        }
        lockstone::Random random = lockstone::Random::seeded(t);
        if (random.next_u64() % 2 == 0)
            for (int i = 0; i < 30; ++i) add(world, crowd | t, scene::at(0, 100, 0), sphere(0.5_r));
        for (const CharacterId c : hoppers) scene::done(world.set_character_input(c, {.jump = t % 2}));
        world.tick();
        return {};
    }

  private:
    mutable std::array<CharacterId, 3> hoppers{}; ///< every start creates the same ids

    static std::uint64_t lifetime(std::uint64_t what) {
        return what == crate ? 75 : what == ball ? 3 : what == hung ? 10 : 1;
    }
    static BodyId add(World& world, std::uint64_t key, const Transform& pose, const Geometry& geometry) {
        return scene::add(world, {.pose = pose, .user_key = key}, {.geometry = geometry});
    }
};

/// The pairs of kinds that the events of some tick contained. A pair of one kind means two events of it.
class KindPairs {
  public:
    static constexpr std::size_t kinds = 9;
    void see(std::span<const Event> events) {
        for (std::size_t i = 0; i < events.size(); ++i)
            for (std::size_t j = i + 1; j < events.size(); ++j) {
                const auto a = static_cast<std::size_t>(events[i].kind),
                           b = static_cast<std::size_t>(events[j].kind);
                seen[std::min(a, b)][std::max(a, b)] = true;
            }
    }
    /// Returns the pairs that no tick contained, as "4 and 8, ". A tick has at most one contacts_dropped.
    std::string missing() const {
        std::string text;
        const auto dropped = static_cast<std::size_t>(EventKind::contacts_dropped);
        for (std::size_t a = 0; a < kinds; ++a)
            for (std::size_t b = a; b < kinds; ++b)
                if (!seen[a][b] && !(a == dropped && b == dropped))
                    text += std::to_string(a) + " and " + std::to_string(b) + ", ";
        return text;
    }

  private:
    std::array<std::array<bool, kinds>, kinds> seen{};
};

/// A rollback session of one player that runs the game. Its ledger ends the program if events are out of order.
struct Busy {
    KindPairs pairs;
    std::size_t happened = 0; ///< events of the ticks of all frames
    std::size_t told = 0;     ///< events that the session published
};
inline Busy run_busy_game(std::uint64_t frames) {
    const BusyGame game;
    World world = game.start().value();
    SimulatedNetwork network(1, {}, 1);
    const auto session = make_rollback_session(session_def(game, 0, {0}), network.endpoint(0)).value();
    WorldSimulation simulation(world, game);
    SessionRunner runner(*session, simulation);
    Busy busy;
    for (std::uint64_t frame = 0; frame < frames; ++frame) {
        session->add_local_input(0, std::array{std::byte{}});
        runner.frame(frame * 16);
        busy.pairs.see(world.events());
        busy.happened += world.events().size(), busy.told += runner.events().size();
    }
    return busy;
}

} // namespace lockstone::test
