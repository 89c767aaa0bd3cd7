#include "reference/drift.h"

#include "reference/start.h"

#include "lockstone/simd.h"
#include "lockstone/tasks.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace reference {

using lockstone::Result, lockstone::Status;

namespace {

/// Applies the commands of one world to both engines.
class Pair final : public lockstone::Journal {
  public:
    Pair(Engine& first, Engine& second) : one(first), other(second) {}
    void on_command(std::uint64_t, const lockstone::Command& command) override {
        if (status) status = one.apply(command);
        if (status) status = other.apply(command);
    }
    void on_tick(std::uint64_t, std::uint64_t) override {}
    void on_restore(std::uint64_t) override {}
    Status status;

  private:
    Engine &one, &other;
};

/// Compares bits, so that -0 differs from 0 and NaN equals itself.
bool same_bits(const Pose& a, const Pose& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

double distance(const Vec& a, const Vec& b) {
    const Vec d = a - b;
    return std::sqrt(dot(d, d));
}

void note(DriftLine& line, double apart, bool same) {
    line.apart.push_back(apart);
    if (!same && !line.parts_at) line.parts_at = line.apart.size();
}

void compare(const Engine& a, const Engine& b, DriftLine& line) {
    double apart = 0;
    bool same = true;
    for (std::size_t i = 0; i < a.bodies().size(); ++i) {
        const Pose &one = a.bodies()[i].pose, &other = b.bodies()[i].pose;
        apart = std::max(apart, distance(one.position, other.position));
        same = same && same_bits(one, other);
    }
    note(line, apart, same);
}

/// Runs one tick of a game with zero inputs.
Status advance(const lockstone::Game& game, lockstone::World& world) {
    const std::vector<std::byte> bytes(game.input_size());
    const std::vector<lockstone::PlayerInput> inputs(game.player_count(),
                                                     {bytes, lockstone::InputStatus::confirmed});
    return game.advance(world, inputs);
}

} // namespace

std::optional<std::uint64_t> DriftLine::apart_by(double metres) const {
    for (std::size_t i = 0; i < apart.size(); ++i)
        if (apart[i] > metres) return i + 1;
    return std::nullopt;
}

Result<DriftLine> drift_of(const lockstone::Game& game, Settings settings, Build build, Build against,
                           std::uint64_t ticks) {
    DriftLine line{name_of(build), name_of(against), {}, {}};
    Result<lockstone::World> world = game.start();
    if (!world) return world.error();
    settings.build = build;
    Result<Engine> one = Engine::create(*world, settings);
    settings.build = against;
    Result<Engine> other = Engine::create(*world, settings);
    if (!one || !other) return one ? other.error() : one.error();
    Pair pair(*one, *other);
    world->set_journal(&pair);
    for (std::uint64_t tick = 0; tick < ticks; ++tick) {
        if (const Status done = advance(game, *world); !done) return done.error();
        if (!pair.status) return pair.status.error();
        one->tick(), other->tick();
        compare(*one, *other, line);
    }
    return line;
}

Result<DriftLine> our_drift(const lockstone::Game& game, std::uint64_t ticks) {
    DriftLine line{"Lockstone", "itself with other instructions and 3 threads", {}, {}};
    Result<lockstone::World> one = game.start(), other = game.start();
    if (!one || !other) return one ? other.error() : one.error();
    const auto pool = lockstone::make_worker_pool(3);
    other->set_tasks(pool.get());
    other->set_simd(lockstone::Simd::scalar);
    for (std::uint64_t tick = 0; tick < ticks; ++tick) {
        for (lockstone::World* world : {&*one, &*other})
            if (const Status done = advance(game, *world); !done) return done.error();
        double apart = 0;
        for (const lockstone::BodyId body : one->bodies())
            apart = std::max(apart, distance(vec(one->pose(body).position), vec(other->pose(body).position)));
        note(line, apart, one->hash() == other->hash());
    }
    other->set_tasks(nullptr);
    return line;
}

Result<std::vector<DriftLine>> all_drifts(const lockstone::Game& game, const Settings& settings,
                                          std::uint64_t ticks) {
    constexpr std::pair<Build, Build> pairs[] = {{Build::float_fast, Build::float_plain},
                                                 {Build::float_fused, Build::float_plain},
                                                 {Build::double_fused, Build::double_plain},
                                                 {Build::float_twin, Build::float_plain}};
    std::vector<DriftLine> lines;
    for (const auto& [build, against] : pairs) {
        if (!is_available(build)) continue;
        Result<DriftLine> line = drift_of(game, settings, build, against, ticks);
        if (!line) return line.error();
        lines.push_back(std::move(*line));
    }
    Result<DriftLine> ours = our_drift(game, ticks);
    if (!ours) return ours.error();
    lines.push_back(std::move(*ours));
    return lines;
}

} // namespace reference
