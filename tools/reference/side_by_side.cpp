#include "reference/side_by_side.h"

#include "reference/start.h"
#include "scenes/scenes.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace reference {

using lockstone::Result, lockstone::Status;

namespace {

using Clock = std::chrono::steady_clock;
double microseconds_since(Clock::time_point start) {
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

/// Applies every command of the world to the other engine.
class Follower final : public lockstone::Journal {
  public:
    explicit Follower(Engine& led) : engine(led) {}
    void on_command(std::uint64_t, const lockstone::Command& command) override {
        if (status) status = engine.apply(command);
    }
    void on_tick(std::uint64_t, std::uint64_t) override {}
    void on_restore(std::uint64_t) override {}
    Status status;

  private:
    Engine& engine;
};

} // namespace

struct SideBySide::Impl {
    Impl(std::unique_ptr<lockstone::Game> played, lockstone::World started, Engine made, std::uint64_t chance)
        : game(std::move(played)), world(std::move(started)), engine(std::move(made)), follower(engine),
          seed(chance) {
        world.set_journal(&follower);
    }
    std::unique_ptr<lockstone::Game> game;
    lockstone::World world;
    Engine engine;
    Follower follower;
    std::uint64_t seed;
    double our_us = 0, their_us = 0;

    Status advance() {
        const std::size_t size = game->input_size(), players = game->player_count();
        std::vector<std::byte> bytes(size * players);
        std::vector<lockstone::PlayerInput> inputs;
        for (std::size_t p = 0; p < players; ++p) {
            const std::span<std::byte> input(bytes.data() + p * size, size);
            scripted_input(*game, seed, world.tick_count(), static_cast<std::uint32_t>(p), input);
            inputs.push_back({input, lockstone::InputStatus::confirmed});
        }
        return game->advance(world, inputs);
    }
};

SideBySide::SideBySide(std::unique_ptr<Impl> made) : impl(std::move(made)) {}
SideBySide::SideBySide(SideBySide&&) noexcept = default;
SideBySide& SideBySide::operator=(SideBySide&&) noexcept = default;
SideBySide::~SideBySide() = default;

Result<SideBySide> SideBySide::create(std::unique_ptr<lockstone::Game> game, const Settings& settings,
                                      std::uint64_t seed) {
    Result<lockstone::World> world = game->start();
    if (!world) return world.error();
    Result<Engine> engine = Engine::create(*world, settings);
    if (!engine) return engine.error();
    return SideBySide(std::make_unique<Impl>(std::move(game), std::move(*world), std::move(*engine), seed));
}

Status SideBySide::tick() {
    const Clock::time_point start = Clock::now();
    if (const Status done = impl->advance(); !done) return done;
    impl->our_us = microseconds_since(start);
    if (!impl->follower.status) return impl->follower.status;
    const Clock::time_point between = Clock::now();
    impl->engine.tick();
    impl->their_us = microseconds_since(between);
    return {};
}

lockstone::World& SideBySide::ours() { return impl->world; }
Engine& SideBySide::theirs() { return impl->engine; }
const lockstone::Game& SideBySide::game() const { return *impl->game; }

Sample SideBySide::sample() const {
    const Engine& engine = impl->engine;
    Sample s{.tick = engine.tick_count(),
             .ours = engine.measure(impl->world),
             .theirs = engine.measure(),
             .our_us = impl->our_us,
             .their_us = impl->their_us,
             .theirs_touched = engine.touched()};
    for (const lockstone::World::ContactPoint& c : impl->world.contacts())
        s.ours_touched = s.ours_touched || c.impulse.raw > 0;
    double count = 0;
    for (std::size_t i = 0; i < engine.bodies().size(); ++i) {
        if (!engine.is_dynamic(i)) continue;
        const Body& body = engine.bodies()[i];
        const Vec apart = vec(impl->world.pose(body.id).position) - body.pose.position;
        const double distance = std::sqrt(dot(apart, apart));
        s.separation_max = std::max(s.separation_max, distance);
        s.separation_mean += distance, ++count;
    }
    if (count > 0) s.separation_mean /= count;
    return s;
}

} // namespace reference
