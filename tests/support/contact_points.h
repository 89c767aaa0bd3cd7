// The world computes contact points on request. The time of the request must not change them.
#pragma once

#include "support/sim_script.h"

#include <algorithm>
#include <vector>

namespace lockstone::test::scene {

inline bool same_point(const World::ContactPoint& a, const World::ContactPoint& b) {
    return a.shape_a == b.shape_a && a.shape_b == b.shape_b && a.point == b.point && a.normal == b.normal &&
           a.separation == b.separation && a.impulse == b.impulse && a.part_a == b.part_a &&
           a.part_b == b.part_b;
}

/// Applies one command after a tick, of another kind each time, to a touching body if there is one.
inline void command_after_tick(World& w, std::uint64_t tick, BodyId touching) {
    const BodyId b =
        w.is_alive(touching) ? touching : w.body_at(static_cast<std::uint32_t>(tick % w.body_count()));
    const bool is_dynamic = w.kind(b) == BodyKind::dynamic;
    switch (tick % 8) {
    case 0: {
        const BodyId fresh = made(w.create_body({.pose = at(0, 9, 0)}));
        made(w.create_shape(fresh, {.geometry = sphere(0.25_r)}));
        done(w.destroy(fresh));
        break;
    }
    case 1:
        if (is_dynamic) done(w.set_velocity(b, vec(0.1, 0.2, 0), {}));
        break;
    case 2:
        if (!w.shapes(b).empty()) done(w.set_material({w.shapes(b).front(), real(0.7)}));
        break;
    case 3:
        if (is_dynamic) done(w.set_pose(b, at(0.2, 4, -0.1)));
        break;
    case 4:
        if (is_dynamic && w.shapes(b).size() > 1) done(w.destroy(w.shapes(b).front()));
        break;
    case 5:
        if (is_dynamic) done(w.destroy(b));
        break;
    case 6:
        done(w.wake_body(w.body_at(w.body_count() - 1)));
        break;
    default:
        done(w.set_gravity(vec(0, -9, 0)));
        break;
    }
}

/// Boxes that fall asleep in sequence while a ball rolls. Sometimes a box is woken.
inline World start_quiet() {
    World w = made(World::create(drowsy_def()));
    add_floor(w);
    for (int i = 0; i < 5; ++i) add_crate(w, at(2.5 * i - 5, 0.5 + 0.3 * i, 0));
    add_ball(w, at(-5, 0.5, 3));
    return w;
}
inline void step_quiet(World& w) {
    const std::uint64_t tick = w.tick_count();
    if (tick % 90 == 60)
        done(w.add_impulse(w.body_at(1 + static_cast<std::uint32_t>(tick % 5)), vec(0, 3000, 0)));
    w.tick();
}
/// Returns whether a point lies within two metres of one of its dynamic bodies. No other body of this scene is that
/// near for long.
inline bool is_on_bodies(const World& w, const World::ContactPoint& point) {
    for (const ShapeId shape : {point.shape_a, point.shape_b}) {
        const BodyId body = w.body_of(shape);
        if (w.kind(body) == BodyKind::dynamic && length(w.pose(body).position - point.point) > 2_r)
            return false;
    }
    return true;
}

/// Requests points late, after contacts of sleeping bodies have left the table; see late_points_difference().
inline std::string points_of_sleepers_difference(int ticks) {
    World early = start_quiet(), late = start_quiet();
    std::size_t seen = 0;
    for (int t = 0; t < ticks; ++t) {
        step_quiet(early), step_quiet(late);
        const std::vector<World::ContactPoint> points(early.contacts().begin(), early.contacts().end());
        seen += points.size();
        for (const World::ContactPoint& point : points)
            if (!is_on_bodies(early, point))
                return "tick " + std::to_string(t) + ": a contact point lies far from its bodies";
        if (t % 7 == 0) {
            const BodyId b = early.body_at(early.body_count() - 1);
            if (early.kind(b) == BodyKind::dynamic) done(early.wake_body(b)), done(late.wake_body(b));
        }
        if (!std::ranges::equal(points, late.contacts(), same_point))
            return "tick " + std::to_string(t) + ": contact points that were asked for late are others";
    }
    return seen > 100 ? "" : "hardly any contact points";
}

/// Runs a script twice. One run requests the contact points right after each tick, the other after a later command.
/// Returns an empty string if the points are equal and not few, else the tick.
inline std::string late_points_difference(Scenery scenery, std::uint64_t ticks) {
    World early = start_script(scenery), late = start_script(scenery);
    std::size_t seen = 0;
    for (std::uint64_t t = 0; t < ticks; ++t) {
        step_script(early), step_script(late);
        const std::vector<World::ContactPoint> points(early.contacts().begin(), early.contacts().end());
        seen += points.size();
        if (t % 3 == 0) {
            const BodyId touching =
                points.empty() ? BodyId{} : early.body_of(points[t % points.size()].shape_b);
            command_after_tick(early, t / 3, touching), command_after_tick(late, t / 3, touching);
        }
        if (!std::ranges::equal(points, late.contacts(), same_point))
            return "tick " + std::to_string(t) + ": contact points that were asked for late are others";
    }
    return seen > 100 ? "" : "hardly any contact points";
}

} // namespace lockstone::test::scene
