// Worlds with equal starts on different tasks: checks that they stay equal.
#pragma once

#include "support/scripted_inputs.h"
#include "support/sim_scenes.h"
#include "support/task_runners.h"

namespace lockstone::test {

/// The built-in scenes, small enough to run often, large enough for several chunks of each kind of work.
inline std::unique_ptr<Game> small_scene(const SceneInfo& info) {
    SceneOptions options;
    if (info.size_default != 0)
        options.size =
            std::min(info.size_max, info.name == "pyramid" ? 14u : std::min(info.size_default, 150u));
    return make_scene(info.name, options).value();
}

/// A net of balls: thousands of joints, connected along diagonals. `side` rows of `side` balls. Each ball holds the
/// next one in its row and in its column; the first row is fixed in the air.
inline World net(int side) {
    WorldDef def = scene::small_def();
    const auto all = static_cast<std::uint32_t>(side * side);
    def.bodies_max = def.shapes_max = all, def.joints_max = 2 * all;
    World world = scene::made(World::create(def));
    std::vector<BodyId> balls;
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            const BodyId ball = scene::add(
                world,
                {.kind = row == 0 ? BodyKind::static_ : BodyKind::dynamic, .pose = scene::at(column, 0, row)},
                {.geometry = sphere(scene::real(0.4))});
            if (column > 0 && row > 0)
                scene::made(
                    world.create_joint(ball_joint(), balls.back(), ball, scene::at(column - 0.5, 0, row)));
            if (row > 0) {
                const BodyId above = balls[balls.size() - static_cast<std::size_t>(side)];
                scene::made(world.create_joint(ball_joint(), above, ball, scene::at(column, 0, row - 0.5)));
            }
            balls.push_back(ball);
        }
    return world;
}

struct Islands {
    World world;
    std::vector<BodyId> bodies;
};
/// Two jointed balls in the air: then contacts are not alone in changing velocities, and the solver runs its passes one
/// by one.
inline void add_pendulum(World& w) {
    const BodyId above = scene::add(w, {.kind = BodyKind::static_, .pose = scene::at(-500, 60, 0)},
                                    {.geometry = sphere(scene::real(0.4))}),
                 below = scene::add_ball(w, scene::at(-500, 59, 0), 0.4);
    scene::made(w.create_joint(ball_joint(), above, below, scene::at(-500, 59.5, 0)));
}
/// Towers of crates that drop a little, askew, each an island, and an immobile platform between them.
inline Islands towers(int count, int height = 2) {
    WorldDef def = scene::small_def();
    def.bodies_max = def.shapes_max = static_cast<std::uint32_t>(height * count + 8);
    def.contacts_max = static_cast<std::uint32_t>(4 * height * count);
    Islands out{scene::made(World::create(def)), {}};
    scene::add_floor(out.world);
    scene::add(out.world, {.kind = BodyKind::kinematic, .pose = scene::at(0, 0.25, -1)},
               {.geometry = box(scene::real(0.5), scene::real(0.25), scene::real(0.25))});
    for (int i = 0; i < count; ++i) {
        const double x = 1.5 * (i % 60), z = 2.0 * (i / 60), lift = 0.01 * (i % 7);
        out.bodies.push_back(scene::add_crate(out.world, scene::at(x, 0.5 + lift, z)));
        out.bodies.push_back(
            scene::add_crate(out.world, scene::at(x + 0.1 * (i % 5), 1.55 + 2 * lift, z + 0.05)));
        for (int k = 2; k < height; ++k)
            out.bodies.push_back(
                scene::add_crate(out.world, scene::at(x + 0.1 * (i % 5), 0.55 + 1.05 * k + 2 * lift, z)));
    }
    return out;
}

/// Returns the first difference of the bodies of two worlds within some ticks.
inline std::string first_difference(Islands& left, Islands& right, int ticks) {
    for (int t = 0; t < ticks; ++t) {
        left.world.tick(), right.world.tick();
        for (std::size_t i = 0; i < left.bodies.size(); ++i) {
            const BodyId a = left.bodies[i], b = right.bodies[i];
            if (left.world.pose(a) != right.world.pose(b) ||
                left.world.linear_velocity(a) != right.world.linear_velocity(b) ||
                left.world.angular_velocity(a) != right.world.angular_velocity(b))
                return "tick " + std::to_string(t) + ", body " + std::to_string(i);
        }
    }
    return {};
}

/// Returns the first difference of the outputs of the last tick; empty when there is none.
inline std::string output_difference(const World& left, const World& right) {
    const auto bytes = [](const auto& rows) {
        std::vector<std::byte> out;
        using Row = typename std::decay_t<decltype(rows)>::value_type;
        for (const Row& row : rows)
            append_canonical(std::as_bytes(std::span(&row, 1)), leaves_of<Row>(), out);
        return out;
    };
    if (bytes(left.events()) != bytes(right.events())) return "events differ";
    const auto same = [](const World::ContactPoint& a, const World::ContactPoint& b) {
        return a.shape_a == b.shape_a && a.shape_b == b.shape_b && a.point == b.point &&
               a.normal == b.normal && a.separation == b.separation && a.impulse == b.impulse;
    };
    return std::ranges::equal(left.contacts(), right.contacts(), same) ? "" : "contacts differ";
}

/// Runs the rules on a world without tasks, and on a clone of it for each of `tasks`, tick by tick. `advance` gets a
/// world and its tasks. Returns the first difference; empty when there is none.
template <class Advance>
std::string first_departure(const World& start, std::span<Tasks* const> tasks, int ticks, Advance&& advance) {
    World expected = start.clone();
    std::vector<World> worlds;
    for (Tasks* with : tasks) worlds.push_back(start.clone()), worlds.back().set_tasks(with);
    for (int t = 0; t < ticks; ++t) {
        advance(expected, nullptr);
        for (std::size_t i = 0; i < worlds.size(); ++i) {
            advance(worlds[i], tasks[i]);
            std::string found = scene::difference(expected, worlds[i]);
            if (found.empty()) found = output_difference(expected, worlds[i]);
            if (!found.empty()) return "tasks " + std::to_string(i) + ": " + found;
        }
    }
    return {};
}

/// Compares runs with the scene's rules, after `before` ticks without tasks.
inline std::string first_departure(const Game& game, std::span<Tasks* const> tasks, int before, int ticks) {
    ScriptedInputs inputs(game);
    World start = game.start().value();
    const auto advance = [&](World& world, Tasks*) {
        scene::done(game.advance(world, inputs.at(world.tick_count())));
    };
    for (int t = 0; t < before; ++t) advance(start, nullptr);
    return first_departure(start, tasks, ticks, advance);
}

} // namespace lockstone::test
