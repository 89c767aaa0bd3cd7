// Matches of real worlds: bodies with contacts, driven by players over a bad network.
#include "lockstone/session/forgetful.h"
#include "session/match.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// Eight balls on a plane. Each player pushes all balls, each by its own remainder, and the balls collide.
class PushGame final : public Game {
  public:
    std::string name() const override { return "push"; }
    std::uint64_t content_id() const override { return 1; }
    std::uint32_t player_count() const override { return 2; }
    std::uint32_t input_size() const override { return input_size_of<Pad>; }

    Result<World> start() const override {
        WorldDef def;
        def.bodies_max = 16;
        def.shapes_max = 16;
        def.contacts_max = 256;
        auto world = World::create(def);
        if (!world) return world;
        const BodyId ground = world->create_body({.kind = BodyKind::static_}).value();
        world->create_shape(ground, {.geometry = box({20_r, 0.5_r, 20_r}), .local = down()}).value();
        for (int i = 0; i < 8; ++i) {
            BodyDef ball;
            ball.pose.position = {Real(i % 4) * 2 - Real(3), 1_r, Real(i / 4) * 2 - Real(1)};
            ball.user_key = static_cast<std::uint64_t>(i);
            const BodyId body = world->create_body(ball).value();
            world->create_shape(body, {.geometry = sphere(0.5_r), .restitution = 0.5_r}).value();
        }
        return world;
    }

    Status advance(World& world, std::span<const PlayerInput> inputs) const override {
        for (std::uint32_t row = 0; row < world.body_count(); ++row) {
            const BodyId body = world.body_at(row);
            if (world.kind(body) != BodyKind::dynamic) continue;
            const Pad pad = decode_input<Pad>(inputs[world.user_key(body) % 2]);
            // a pull to the origin keeps the balls on the ground
            const Vec3 place = world.pose(body).position;
            const Vec3 force{Real(pad.push / 8) - place.x * 400, 0_r,
                             Real(pad.buttons) * 900 - place.z * 400};
            if (!world.add_force(body, force)) continue; // out of range: no force
        }
        world.tick();
        return {};
    }

  private:
    static Transform down() {
        Transform t = Transform::identity();
        t.position.y = -0.5_r;
        return t;
    }
};

/// A simulation that owns its world. WorldSimulation does not own it.
class PushSimulation final : public Simulation {
  public:
    explicit PushSimulation(const Game& rules) : world(rules.start().value()), driven(world, rules) {}
    void save(Image& image) const override { driven.save(image); }
    void restore(const Image& image) override { driven.restore(image); }
    void advance(std::span<const PlayerInput> inputs) override { driven.advance(inputs); }
    std::uint64_t hash() const override { return driven.hash(); }
    std::span<const Event> events() const override { return driven.events(); }
    State& state() override { return driven.state(); }

  private:
    World world;
    WorldSimulation driven;
};

const PushGame game;

} // namespace

TEST_CASE("two worlds 120 ms apart with 10 % loss agree at all 3,600 ticks and with a run without sessions") {
    MatchDef def;
    def.link = {.latency_ms = 120, .jitter_ms = 20, .loss_permille = 100};
    Match match(def, [](PeerId) { return std::make_unique<PushSimulation>(game); });
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < 6000 && match.machine(0).timeline.ticks.size() < 3600; ++i) match.frame();
    const auto took =
        std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - start);
    CHECK(match.machine(0).timeline.ticks.size() >= 3600);
    CHECK(match.agree(0, 1));
    for (PeerId id = 0; id < 2; ++id) {
        CHECK(match.notices<Desync>(id).empty());
        CHECK(match.machine(id).events.holds(match.machine(id).timeline.ticks.size()));
        CHECK(match.machine(id).events.count(EventStatus::confirmed) > 20);
    }
    PushSimulation straight(game);
    CHECK(run_straight(match.machine(0).timeline, 2, straight) ==
          match.machine(0).timeline.ticks.back().hash);
    const SessionStats& stats = match.machine(0).session->stats();
    const EventLaw& events = match.machine(0).events;
    MESSAGE("worlds: ", took.count(), " ms, ticks ", stats.ticks, ", rollbacks ", stats.rollbacks,
            ", resimulated ", stats.resimulated, ", depth ", stats.depth_max, ", stalls ", stats.stalls,
            ", bytes/player/s ", stats.bytes_per_player_second(), ", events predicted ",
            events.count(EventStatus::predicted), ", confirmed ", events.count(EventStatus::confirmed),
            ", cancelled ", events.count(EventStatus::cancelled));
}

TEST_CASE("the sync test names every changing column that the snapshot lacks") {
    PushSimulation probe(game);
    std::vector<std::string> names;
    for (const ColumnInfo& column : probe.state().layout().columns()) names.push_back(column.name);
    std::uint32_t caught = 0;
    for (const std::string& name : names) {
        CAPTURE(name);
        const auto session = make_sync_test_session(session_def(game, 0, {0, 0}), 6).value();
        PushSimulation simulation(game);
        testing::ForgetfulSimulation forgetful(simulation, name);
        SessionRunner runner(*session, forgetful);
        std::vector<std::byte> before;
        bool changed = false;
        const std::uint32_t index =
            static_cast<std::uint32_t>(std::ranges::find(names, name) - names.begin());
        for (std::uint64_t tick = 0; tick < 120 && runner.sync_failure() == nullptr; ++tick) {
            for (std::uint32_t p = 0; p < 2; ++p)
                session->add_local_input(p, encode_input(scripted_pad(p, tick)));
            runner.frame(tick);
            const auto bytes = simulation.state().bytes(index);
            changed =
                changed || (tick > 0 && bytes.size() == before.size() && !std::ranges::equal(bytes, before));
            before.assign(bytes.begin(), bytes.end());
        }
        const SyncTestFailure* failure = runner.sync_failure();
        if (failure == nullptr) {
            CHECK_FALSE(changed);
            continue;
        }
        ++caught;
        REQUIRE_FALSE(failure->differences.empty());
        CHECK(failure->differences[0].column == name);
        CHECK(to_string(*failure).find(name) != std::string::npos);
    }
    CHECK(caught >= 4);
}
