#include "bench/games.h"

#include "bench/clock.h"
#include "lockstone/game.h"
#include "lockstone/math/convert.h"
#include "lockstone/math/math.h"
#include "lockstone/play/vehicle.h"
#include "replay/replay.h"
#include "scenes/scenes.h"

namespace lockstone::bench {
namespace {

constexpr std::uint64_t script_seed = 1;

/// A game that is driven by its script.
class Played {
  public:
    explicit Played(std::unique_ptr<Game> rules, World start)
        : game(std::move(rules)), world(std::move(start)),
          bytes(game->player_count(), std::vector<std::byte>(game->input_size())),
          inputs(game->player_count()) {}

    std::span<const PlayerInput> step() {
        for (std::uint32_t p = 0; p < game->player_count(); ++p) {
            scripted_input(*game, script_seed, world.tick_count(), p, bytes[p]);
            inputs[p] = {.bytes = bytes[p]};
        }
        spent_us.push_back(thread_us([&] { failed = failed || !game->advance(world, inputs); }));
        return inputs;
    }

    std::unique_ptr<Game> game;
    World world;
    std::vector<double> spent_us = {};
    bool failed = false; ///< a rule of the game failed

  private:
    std::vector<std::vector<std::byte>> bytes;
    std::vector<PlayerInput> inputs;
};

Result<Played> play(const std::string& name, const SceneOptions& options) {
    Result<std::unique_ptr<Game>> game = make_scene(name, options);
    if (!game) return game.error();
    Result<World> world = (*game)->start();
    if (!world) return Error{name + ": cannot start: " + world.error().message};
    return Played(std::move(*game), std::move(*world));
}

Result<replay::Recording> record(Played& played, std::uint64_t ticks) {
    replay::MemorySink sink;
    Result<replay::InputRecorder> recorder = replay::InputRecorder::begin(sink, *played.game, played.world);
    if (!recorder) return recorder.error();
    for (std::uint64_t tick = 0; tick < ticks; ++tick)
        if (const Status s = recorder->after_tick(played.world, played.step()); !s) return s.error();
    if (const Status closed = recorder->close(); !closed) return closed.error();
    return replay::Recording::from_bytes(std::move(sink.bytes), "bench.lsr");
}

// ---- cars --------------------------------------------------------------------------------------------------------

/// An arena of 80 x 50 m whose floor bends up into its walls. The mesh consists of quads of 2 m with two triangles
/// each.
Result<AssetBytes> bake_arena() {
    constexpr int columns = 40, rows = 25;
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    const auto rise = [](int i, int count) { // the last three rows of quads climb
        const int from_edge = std::min(i, count - i);
        const Real up = from_edge >= 3 ? Real{} : Real(3 - from_edge);
        return up * up * Real(1);
    };
    for (int row = 0; row <= rows; ++row)
        for (int column = 0; column <= columns; ++column)
            vertices.push_back(
                {Real(2 * column - columns), rise(column, columns) + rise(row, rows), Real(2 * row - rows)});
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const auto a = static_cast<std::uint32_t>(row * (columns + 1) + column), below = a + columns + 1;
            triangles.push_back({a, below + 1, a + 1});
            triangles.push_back({a, below, below + 1});
        }
    return bake_mesh({.vertices = vertices, .triangles = triangles});
}

struct Arena {
    World world;
    std::vector<BodyId> bodies;
    std::vector<VehicleId> cars;
};

Result<Arena> make_arena() {
    AssetLibrary library;
    const Result<AssetId> mesh = library.add(bake_arena());
    if (!mesh) return mesh.error();
    Result<World> made = World::create({.tick_rate = 120, .sleeping = 0}, {},
                                       std::make_shared<const AssetLibrary>(std::move(library)));
    if (!made) return made.error();
    Arena arena{std::move(*made), {}, {}};
    World& world = arena.world;
    const auto body = [&](const BodyDef& def, const ShapeDef& shape) {
        const BodyId id = world.create_body(def).value();
        world.create_shape(id, shape).value();
        return id;
    };
    body({.kind = BodyKind::static_}, {.geometry = instance(ShapeKind::mesh, *mesh)});
    body({.pose = {.position = {0_r, 3_r, 0_r}, .rotation = Quat::identity()}, .mass = 30_r},
         {.geometry = sphere(1_r), .restitution = 0.6_r});
    for (int i = 0; i < 4; ++i) {
        const Vec3 place{Real(8 * i - 12), 0.9_r, i % 2 == 0 ? -8_r : 8_r};
        const BodyId chassis =
            body({.pose = {.position = place, .rotation = Quat::identity()}, .mass = 1300_r},
                 {.geometry = box(0.85_r, 0.25_r, 2_r), .friction = 0.3_r});
        arena.bodies.push_back(chassis);
        arena.cars.push_back(world.create_vehicle(four_wheels(chassis, {0.78_r, -0.25_r, 1.35_r})).value());
    }
    return arena;
}

/// All cars drive towards the ball.
void drive(Arena& arena, BodyId ball) {
    World& world = arena.world;
    for (std::size_t i = 0; i < arena.cars.size(); ++i) {
        const Transform pose = world.pose(arena.bodies[i]);
        const Rotation axes = to_rotation(pose.rotation);
        const Vec3 way = world.pose(ball).position - pose.position;
        const Real ahead = dot<Real>(axes.z, way), left = dot<Real>(axes.x, way);
        VehicleInput input{.throttle = 0.8_r, .gear = 1};
        input.steer = clamp(left * -0.3_r, -1_r, 1_r);
        if (ahead < 0_r) input.steer = left < 0_r ? 1_r : -1_r;
        if (const Status done = world.set_vehicle_input(arena.cars[i], input); !done) std::abort();
    }
}

} // namespace

Result<Json> verify_speed(bool quick) {
    const std::uint64_t ticks = quick ? 60 : 3600;
    Result<Played> played = play("rollback-arena", {.players = 4});
    if (!played) return played.error();
    const Result<replay::Recording> recording = record(*played, ticks);
    if (!recording) return recording.error();
    replay::VerifyReport report;
    const double spent = thread_us([&] { report = replay::verify(*recording, played->game.get()); });
    if (!report.good()) return Error{report.sentence};
    const double played_us = 1e6 * static_cast<double>(ticks) / 60;
    return Json{{"scene", "rollback-arena"},
                {"players", 4},
                {"ticks", ticks},
                {"bytes", recording->size_bytes()},
                {"times_real_time", played_us / spent},
                {"must", 150},
                {"goal", 400}};
}

Result<Json> arena_cost(bool quick) {
    Result<Arena> arena = make_arena();
    if (!arena) return arena.error();
    const BodyId ball = arena->world.body_at(1);
    std::vector<double> spent;
    for (int tick = 0; tick < (quick ? 10 : 1200); ++tick) {
        drive(*arena, ball);
        spent.push_back(thread_us([&] { arena->world.tick(); }));
    }
    return Json{{"about", "four cars and a ball on an arena's mesh, 120 ticks a second"},
                {"mean_us", mean(spent)},
                {"median_us", percentile(spent, 0.5)},
                {"p99_us", percentile(spent, 0.99)},
                {"must", 40}};
}

Result<Json> game_cost(const std::string& name, bool quick) {
    Result<Played> played = play(name, {});
    if (!played) return played.error();
    for (int tick = 0; tick < (quick ? 3 : 240); ++tick) played->step();
    const std::vector<double>& spent = played->spent_us;
    return Json{{"scene", name},
                {"bodies", played->world.body_count()},
                {"contacts", played->world.contacts().size()},
                {"mean_us", mean(spent)},
                {"median_us", percentile(spent, 0.5)},
                {"p99_us", percentile(spent, 0.99)}};
}

} // namespace lockstone::bench
