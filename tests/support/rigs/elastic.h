// Elastic bodies: rows that a body strikes, bouncing balls, bodies in a closed room.
#pragma once

#include "lockstone/math/random.h"
#include "support/sim_scenes.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace lockstone::test {

inline ShapeDef elastic_shape(const Geometry& geometry, double restitution = 1) {
    return {.geometry = geometry, .friction = Real{}, .restitution = scene::real(restitution)};
}

struct RowDef {
    int count = 5;
    double speed = 2, restitution = 1, gap = 0;
    bool reversed = false; ///< the struck end is created last
    Geometry geometry = sphere(0.1_r);
};
/// Speeds [m/s] along the row, and the greatest energy of all ticks relative to the initial one.
struct ElasticRow {
    double last, most_energy;
};
/// A body strikes a row of equal bodies, all 0.1 m in radius, without gravity.
inline ElasticRow strike_row(World& w, const RowDef& def) {
    std::vector<BodyId> row(static_cast<std::size_t>(def.count));
    for (int k = 0; k < def.count; ++k) {
        const int i = def.reversed ? def.count - 1 - k : k;
        const double x = i == 0 ? -0.6 : (0.2 + def.gap) * i;
        row[static_cast<std::size_t>(i)] = scene::add(
            w, {.pose = scene::at(x, 0, 0), .linear_velocity = scene::vec(i == 0 ? def.speed : 0, 0, 0)},
            elastic_shape(def.geometry, def.restitution));
    }
    const double start = to_double(w.kinetic_energy());
    ElasticRow out{0, 1};
    const int ticks = static_cast<int>(60 * (0.5 + def.gap * def.count) / def.speed) + 10;
    for (int t = 0; t < 2 * ticks; ++t) {
        w.tick();
        out.most_energy = std::max(out.most_energy, to_double(w.kinetic_energy()) / start);
    }
    out.last = scene::velocity(w, row.back())[0];
    return out;
}

/// The greatest distance of a bouncing ball of 0.1 m from its place in continuous time, after it bounced off a floor
/// without gravity [m]. `speed`: up to 5 m/s; a ball that moves farther in a tick than its radius may sink in first.
inline double farthest_off_bounce(double restitution, double speed) {
    double worst = 0;
    for (int i = 0; i < 40; ++i) {
        World w = scene::made(World::create(scene::weightless()));
        scene::add_floor(w, elastic_shape(plane(), restitution));
        const double height = 0.3 + 0.0137 * i;
        const BodyId ball = scene::add(
            w, {.pose = scene::at(0, height + 0.1, 0), .linear_velocity = scene::vec(0, -speed, 0)},
            elastic_shape(sphere(0.1_r), restitution));
        const int ticks = static_cast<int>(60 * 0.85 / speed) + 3;
        for (int t = 0; t < ticks; ++t) w.tick();
        const double left = ticks / double(w.def().tick_rate) - height / speed;
        worst = std::max(worst, std::abs(scene::position(w, ball)[1] - 0.1 - restitution * speed * left));
    }
    return worst;
}

/// A ball with restitution 1 is dropped from 3 m. Returns the greatest loss of height from one bounce to another [m].
inline double height_lost(int bounces) {
    World w = scene::made(World::create(scene::small_def()));
    scene::add_floor(w, elastic_shape(plane()));
    const BodyId ball = scene::add(w, {.pose = scene::at(0, 3.1, 0)}, elastic_shape(sphere(0.1_r)));
    double least = 1e9, most = 0, top = 0;
    bool rises = false;
    for (int count = 0, t = 0; count < bounces && t < 6000; ++t) {
        w.tick();
        const double y = scene::position(w, ball)[1], v = scene::velocity(w, ball)[1];
        if (v > 0) rises = true, top = std::max(top, y + v * v / (2 * 9.81));
        if (v <= 0 && rises) {
            least = std::min(least, top), most = std::max(most, top);
            rises = false, top = 0, ++count;
        }
    }
    return most - least;
}

/// The sum of the normal impulses that contacts report in the tick in which a ball or a box, 0.2 m high, hits a floor,
/// without gravity. It should be (1 + e) times its speed [m/s].
inline double reported_impulse(const Geometry& geometry, double restitution, double speed, double height) {
    World w = scene::made(World::create(scene::weightless()));
    scene::add_floor(w, elastic_shape(plane(), restitution));
    scene::add(w, {.pose = scene::at(0, height + 0.1, 0), .linear_velocity = scene::vec(0, -speed, 0)},
               elastic_shape(geometry, restitution));
    double most = 0;
    for (int t = 0; t < 60; ++t) {
        w.tick();
        double sum = 0;
        for (const World::ContactPoint& point : w.contacts()) sum += to_double(point.impulse);
        most = std::max(most, sum);
    }
    return most;
}

/// The greatest energy of bodies that fly and spin in a closed room, without friction and gravity, relative to the
/// initial one.
inline double energy_in_room(const Geometry& geometry, int count, std::uint64_t seed, int ticks) {
    World w = scene::made(World::create(scene::weightless()));
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-4.0, 4.0}) {
            double p[3] = {}, half[3] = {4, 4, 4};
            p[axis] = side, half[axis] = 1;
            scene::add(w, {.kind = BodyKind::static_, .pose = scene::at(p[0], p[1], p[2])},
                       elastic_shape(box(scene::real(half[0]), scene::real(half[1]), scene::real(half[2]))));
        }
    Random random = Random::seeded(seed);
    const auto draw = [&](double most) { return most * (double(random.below(2001)) / 1000 - 1); };
    for (int i = 0; i < count; ++i) {
        BodyDef body{.pose = scene::at(-2 + i % 4 * 1.3, -2 + i / 4 % 4 * 1.3, -2 + i / 16 * 1.3)};
        const double x = draw(10), y = draw(10), z = draw(10), a = draw(10), b = draw(10), c = draw(10);
        body.linear_velocity = scene::vec(x, y, z), body.angular_velocity = scene::vec(a, b, c);
        scene::add(w, body, elastic_shape(geometry));
    }
    const double start = to_double(w.kinetic_energy());
    double most = 1;
    for (int t = 0; t < ticks; ++t) {
        w.tick();
        most = std::max(most, to_double(w.kinetic_energy()) / start);
    }
    return most;
}

} // namespace lockstone::test
