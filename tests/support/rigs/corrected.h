// Bodies that position correction moves, and floating bodies: none may fall asleep before it reaches its final place.
// For the tests and for the planted faults.
#pragma once

#include "support/sim_scenes.h"
#include "support/split_mix.h"

#include <string>

namespace lockstone::test {

/// A body without gravity that a joint pulls from far away. Returns a sentence if it sleeps more than 0.1 degrees or 1
/// mm from its place.
inline std::string pulled_body_fault(std::uint64_t seed) {
    SplitMix random(seed);
    World w = scene::made(World::create(scene::weightless(scene::drowsy_def())));
    const BodyId body =
        scene::add(w,
                   {.pose = scene::at(drawn(random, -3, 3), drawn(random, -3, 3), 0,
                                      scene::turned(scene::axis_z, drawn(random, -150, 150)))},
                   {.geometry = box(scene::real(drawn(random, 0.05, 1)), 0.2_r, 0.1_r)});
    const JointDef defs[] = {hinge_joint(), slider_joint(), weld_joint()};
    JointDef def = defs[random.below(3)];
    const bool turns = def.kind == JointKind::hinge;
    if (def.kind != JointKind::weld) {
        JointAxis& axis = def.axis[turns ? about_x : along_x];
        axis.mode = AxisMode::limited;
        axis.lower = axis.upper = scene::real(drawn(random, -1, 1));
    }
    def.body_b = body;
    const JointId joint = scene::made(w.create_joint(def));
    for (int t = 0; t < 60 * 30 && w.is_awake(body); ++t) w.tick();
    if (w.is_awake(body)) return "seed " + std::to_string(seed) + ": the body is awake after 30 s";
    const JointState state = w.joint_state(joint);
    for (std::size_t i = 0; i < def.axis.size(); ++i) {
        const JointAxis& axis = def.axis[i];
        const double wanted = axis.mode == AxisMode::limited ? to_double(axis.lower) : 0;
        if (axis.mode == AxisMode::free) continue;
        const double off = std::abs(to_double(state.position[i]) - wanted);
        if (off > (i < 3 ? 0.001 : 0.00175))
            return "seed " + std::to_string(seed) + ": axis " + std::to_string(i) + " sleeps off by " +
                   std::to_string(off);
    }
    return {};
}

/// A box that begins inside a static box. Returns a sentence if it sleeps deeper than 1 mm in it.
inline std::string buried_body_fault(std::uint64_t seed) {
    SplitMix random(seed);
    World w = scene::made(World::create(scene::weightless(scene::drowsy_def())));
    scene::add_wall(w, scene::at(0, 0, 0), scene::vec(3, 3, 3));
    const double half = drawn(random, 0.1, 1);
    const BodyId body =
        scene::add(w, {.pose = scene::at(drawn(random, -2, 2), drawn(random, -2, 2), drawn(random, -2, 2))},
                   {.geometry = box(scene::real(half), scene::real(half), scene::real(half))});
    for (int t = 0; t < 60 * 30 && w.is_awake(body); ++t) w.tick();
    if (w.is_awake(body)) return "seed " + std::to_string(seed) + ": the box is awake after 30 s";
    const scene::D3 at = scene::position(w, body);
    const double depth = 3 + half - std::max({std::abs(at[0]), std::abs(at[1]), std::abs(at[2])});
    return depth <= 0.001
               ? ""
               : "seed " + std::to_string(seed) + ": the box sleeps " + std::to_string(depth) + " m deep";
}

/// A box that begins inside a static box, alone or held by a joint. Returns a sentence unless the overlap is pushed out
/// at between half of the bound and the bound. The bound is push_speed_max, and a tenth of it for a body with a joint.
inline std::string push_fault(std::uint64_t seed) {
    SplitMix random(seed);
    const double most = drawn(random, 0.5, 5), half = drawn(random, 0.4, 1);
    WorldDef def = scene::weightless(scene::drowsy_def());
    def.push_speed_max = scene::real(most);
    World w = scene::made(World::create(def));
    scene::add_wall(w, scene::at(0, -3, 0), scene::vec(3, 3, 3));
    const Geometry cube = box(scene::real(half), scene::real(half), scene::real(half));
    const BodyId body = scene::add(w, {.pose = scene::at(0, 0, 0)}, {.geometry = cube});
    const bool is_held = random.below(2) != 0;
    if (is_held) {
        JointDef joint = ball_joint();
        joint.body_a = body;
        joint.body_b = scene::add(w, {.pose = scene::at(0, 3 * half, 0)}, {.geometry = cube});
        joint.frame_a.position = scene::vec(0, 1.5 * half, 0);
        joint.frame_b.position = scene::vec(0, -1.5 * half, 0);
        scene::made(w.create_joint(joint));
    }
    const double bound = is_held ? most / 10 : most;
    double before = 0, fastest = 0;
    for (int t = 0; t < 30; ++t) {
        w.tick();
        const double now = scene::position(w, body)[1];
        fastest = std::max(fastest, (now - before) * def.tick_rate);
        before = now;
    }
    return fastest <= 1.01 * bound && fastest >= bound / 2
               ? ""
               : "seed " + std::to_string(seed) + ": a " + (is_held ? "held" : "free") +
                     " box is pushed out at " + std::to_string(fastest) + " m/s, of " + std::to_string(bound);
}

/// A raft that drops into water. Returns a sentence if it sleeps more than 2 mm from the depth at which it displaces
/// its mass.
inline std::string raft_fault(std::uint64_t seed) {
    SplitMix random(seed);
    World w = scene::made(World::create(scene::drowsy_def()));
    scene::made(w.create_field(water(
        {.kind = RegionKind::box, .pose = scene::at(0, -50, 0), .half_extent = scene::vec(100, 50, 100)})));
    const double height = drawn(random, 0.1, 2), share = drawn(random, 0.1, 0.9);
    const BodyId body =
        scene::add(w, {.pose = scene::at(0, drawn(random, -0.5, 1), 0)},
                   {.geometry = box(scene::real(height * drawn(random, 1, 4)), scene::real(height / 2),
                                    scene::real(height * drawn(random, 1, 4))),
                    .density = scene::real(1000 * share)});
    for (int t = 0; t < 60 * 240 && w.is_awake(body); ++t) w.tick();
    if (w.is_awake(body)) return "seed " + std::to_string(seed) + ": the raft is awake after 240 s";
    const double off = std::abs(scene::position(w, body)[1] - (height / 2 - height * share));
    return off <= 0.002 ? ""
                        : "seed " + std::to_string(seed) + ": a raft of " + std::to_string(height) +
                              " m sleeps " + std::to_string(off) + " m off its waterline";
}

} // namespace lockstone::test
