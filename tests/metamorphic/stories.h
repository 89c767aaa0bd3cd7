// Worlds that exercise each part: characters, joints, sleepers, vehicles, water, scenes, every kind of shape.
#pragma once

#include "scenes/scenes.h"
#include "support/character_course.h"
#include "support/effort.h"
#include "support/rigs/joint_scenes.h"
#include "support/rigs/joint_variants.h"
#include "support/rigs/vehicle_rig.h"
#include "support/scripted_inputs.h"
#include "support/sim_replay.h"
#include "support/sim_shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace lockstone::test::scene {

inline int long_or(int whole, int quick) { return std::getenv("LOCKSTONE_LONG") != nullptr ? whole : quick; }

/// Stairs, a low beam, a lift, a turning disc, crates, a ball, a sensor, and three characters among them.
inline World start_characters() {
    World w = made(World::create(small_def()));
    add_floor(w);
    character::add_stairs(w, 5, 0.25, 0.3);
    add_wall(w, at(-3, 2.25, 0), vec(0.6, 1, 2)); // a beam 1.25 m above the ground
    add(w,
        {.kind = BodyKind::kinematic,
         .pose = at(-1, 0.1, 3),
         .linear_velocity = vec(0.5, 0.4, 0),
         .angular_velocity = vec(0, 1, 0)},
        {.geometry = box(1_r, 0.1_r, 1_r)});
    for (int i = 0; i < 3; ++i)
        add(w, {.pose = at(-1.2, 0.3 + 0.6 * i, -1.5), .mass = 25_r}, {.geometry = box(0.3_r, 0.3_r, 0.3_r)});
    add(w, {.pose = at(4, 0.4, -1.5), .linear_velocity = vec(-6, 0, 0)}, {.geometry = sphere(0.4_r)});
    add(w, {.kind = BodyKind::static_, .pose = at(-1, 1, -2)}, {.geometry = box(1_r, 1_r, 1_r), .sensor = 1});
    character::add_character(w, 0, 0.01, 0);
    character::add_character(w, -1, 0.5, 3);
    character::add_character(w, 0.3, 0.01, -1.6);
    return w;
}

inline void step_characters(World& w) {
    using character::drive;
    const auto t = static_cast<int>(w.tick_count());
    drive(w, w.character_at(0), t < 120 ? 3 : -3.5, 0, t % 50 == 40, t > 180);
    drive(w, w.character_at(1), t > 60 ? 1 : 0, t > 90 ? -2 : 0, t % 70 == 30);
    drive(w, w.character_at(2), -2, 0.2 * (t % 7 - 3), t == 100);
    w.tick();
}

/// A pair of bodies for every kind of joint, side by side over a floor, and a chain that comes to rest.
inline World start_joints() {
    WorldDef def = drowsy_def();
    def.joints_max = 64;
    def.sleep_time = real(0.2);
    World w = made(World::create(def));
    add_floor(w);
    for (std::size_t i = 0; i < std::size(joint_kinds); ++i) {
        const double z = 4.0 * static_cast<double>(i);
        const JointKind kind = joint_kinds[i];
        const BodyId a = add_crate(w, at(-1, 3, z)), b = add_crate(w, at(1, 3, z));
        JointDef joint = plain_joint(kind);
        joint.user_key = i;
        if (i % 3 == 0) made(w.create_joint(hinge_joint(), {}, a, at(-1, 3.4, z)));
        if (kind == JointKind::pulley) joint.ground_a = vec(-1, 6, z), joint.ground_b = vec(1, 6, z);
        if (kind == JointKind::hinge)
            joint.axis[about_x] = {.mode = AxisMode::limited,
                                   .lower = real(-0.5),
                                   .upper = real(0.5),
                                   .motor_speed = Real(2),
                                   .motor_force = Real(900)};
        if (kind == JointKind::ball) joint.swing = real(0.5), joint.axis[about_x].friction = Real(20);
        if (kind == JointKind::weld) joint.break_torque = Real(9000);
        joint.body_a = a, joint.body_b = b;
        if (kind < JointKind::distance || kind > JointKind::pulley)
            made(w.create_joint(joint, a, b, at(0, 3, z)));
        else
            made(w.create_joint(joint));
    }
    BodyId before{};
    for (int i = 0; i < 4; ++i) {
        const BodyId link =
            add(w, {.pose = at(6 + 0.5 * i, 0.2, 0)}, {.geometry = capsule(real(0.1), real(0.1))});
        if (before) made(w.create_joint(ball_joint(), before, link, at(5.75 + 0.5 * i, 0.2, 0)));
        before = link;
    }
    return w;
}

/// Drives, changes, makes and destroys joints.
inline void step_joints(World& w) {
    const std::uint64_t tick = w.tick_count();
    const auto joint_from = [&](std::uint64_t start) {
        return w.joint_at(static_cast<std::uint32_t>(start % w.joint_count()));
    };
    const BodyId body = w.body_at(static_cast<std::uint32_t>(tick * 5 % w.body_count()));
    if (tick % 11 == 3 && w.kind(body) == BodyKind::dynamic)
        done(w.add_impulse(body, vec(900, 500, static_cast<double>(tick % 3) * 300), vec(50, 200, 30)));
    if (tick % 13 == 5) {
        const JointId joint = joint_from(tick);
        JointAxis axis = w.joint(joint).axis[about_x];
        axis.motor_speed = -axis.motor_speed, axis.friction = Real(static_cast<std::int32_t>(tick % 50));
        done(w.set_joint_axis(joint, about_x, axis));
    }
    if (tick % 29 == 17) {
        const JointDef def = w.joint(joint_from(tick / 2));
        done(w.destroy(joint_from(tick / 2)));
        made(w.create_joint(def));
    }
    if (tick % 37 == 21) {
        const JointId joint = joint_from(tick);
        JointDef def = w.joint(joint);
        def.frame_b.position.y += real(0.05);
        done(w.set_joint_frames(joint, def.frame_a, def.frame_b));
    }
    w.tick();
}

/// Towers that fall asleep, balls that wake them in turn, a lift that starts and stops, joined pairs.
inline World start_sleepers() {
    WorldDef def = drowsy_def();
    def.contacts_max = 400;
    World w = made(World::create(def));
    add_floor(w);
    for (int t = 0; t < 4; ++t)
        for (int i = 0; i < 3; ++i) add_crate(w, at(5.0 * t, 0.5 + i, 0));
    add(w, {.kind = BodyKind::kinematic, .pose = at(-6, 0.25, 0), .user_key = 7},
        {.geometry = box(real(1), real(0.25), real(1))});
    add_crate(w, at(-6, 1, 0));
    const BodyId a = add_ball(w, at(-12, 0.5, 0)), b = add_ball(w, at(-14, 0.5, 0));
    made(w.create_joint(weld_joint(), a, b, at(-13, 0.5, 0)));
    return w;
}

inline void step_sleepers(World& w) {
    const std::uint64_t t = w.tick_count();
    const std::vector<BodyId> bodies = w.bodies();
    const BodyId lift = *std::ranges::find_if(bodies, [&](BodyId b) { return w.user_key(b) == 7; });
    if (t % 60 == 55) {
        const int tower = static_cast<int>(t / 60 % 4);
        add(w, {.pose = at(5.0 * tower - 1.5, 1.7, 0.1), .linear_velocity = vec(6, 1, 0)},
            {.geometry = sphere(real(0.3))});
    }
    if (t == 80) done(w.set_velocity(lift, vec(0, 0.5, 0), {}));
    if (t == 120) done(w.set_velocity(lift, {}, {}));
    if (t == 190) done(w.wake_body(lift));
    w.tick();
}

/// Two cars and a tank on hills, with crates in their way.
inline World start_vehicles() {
    std::vector<Length> heights;
    for (int row = 0; row < 41; ++row)
        for (int column = 0; column < 41; ++column)
            heights.push_back(quantize<Length>(0.6 * std::sin(row * 0.5) * std::cos(column * 0.4)));
    AssetLibrary library;
    const AssetId hills = made(library.add(made(
        bake_height_field({.columns = 41, .rows = 41, .spacing = to<Length>(2_r), .heights = heights}))));
    const Geometry ground = made(library.geometry(hills));
    World w = made(World::create(small_def(), {}, std::make_shared<const AssetLibrary>(std::move(library))));
    add(w, {.kind = BodyKind::static_, .pose = at(-40, 0, -40)}, {.geometry = ground});
    for (int i = 0; i < 6; ++i) add_crate(w, at(-3 + 1.2 * i, 1.5, 6), 0.4);
    for (int i = 0; i < 2; ++i) {
        const BodyId body =
            add(w, {.pose = at(-3 + 6 * i, 2, 0), .mass = 1200_r}, {.geometry = box(0.8_r, 0.3_r, 2_r)});
        VehicleDef def = four_wheels(body, {0.75_r, -0.3_r, 1.4_r});
        def.cast = i == 0 ? WheelCast::sphere : WheelCast::ray;
        def.anti_roll[0] = {0, 1, 10000_r};
        def.differential[0] = {DifferentialKind::limited, 4, 8, 0, 100_r, 0.5_r};
        def.steer_speed = 3_r;
        made(w.create_vehicle(def));
    }
    const BodyId body =
        add(w, {.pose = at(0, 2.5, -8), .mass = 20000_r}, {.geometry = box(1.4_r, 0.5_r, 2.8_r)});
    made(w.create_vehicle(two_tracks(body, {1.5_r, -0.5_r, 2.4_r}, 3)));
    return w;
}

inline void step_vehicles(World& w) {
    const std::uint64_t t = w.tick_count();
    for (std::uint32_t row = 0; t % 20 == 0 && row < w.vehicle_count(); ++row) {
        const std::uint64_t k = (t / 20 * 7 + row * 3) % 11;
        VehicleInput input;
        input.throttle = k < 8 ? 1_r : 0_r;
        input.brake = k == 9 ? 1_r : 0_r;
        input.hand_brake = k == 8 ? 1_r : 0_r;
        input.steer = Real(static_cast<std::int64_t>(k) - 5) / 5_r;
        input.gear = k == 4 ? -1 : 1;
        done(w.set_vehicle_input(w.vehicle_at(row), input));
    }
    w.tick();
}

/// Creates, changes and destroys more kinds of bodies and shapes than the comparison has rows.
inline void step_kinds(World& w) {
    const auto from = static_cast<int>(w.tick_count()) * 90;
    for (int i = 0; i < 90; ++i) {
        const int kind = (from + i * 5) % 400;
        add(w, {.pose = {.position = {Real(i % 40), 1_r, 0_r}}, .linear_damping = Real(kind % 7)},
            {.geometry = sphere(0.25_r), .friction = Real(kind) / Real(1000)});
    }
    const std::vector<BodyId> bodies = w.bodies();
    for (std::size_t i = 0; i < bodies.size(); i += 3) done(w.destroy(bodies[i]));
    for (std::size_t i = 1; i < bodies.size(); i += 3) {
        done(w.set_body_parameters({.body = bodies[i], .linear_damping = Real(static_cast<int>(i) % 5)}));
        done(w.add_force(bodies[i], {1_r, 0_r, 0_r}));
    }
    w.tick();
}

/// A built-in scene, played with its script.
inline Story scene_story(const char* name, std::uint32_t size, int ticks) {
    const std::shared_ptr<const Game> game = made(make_scene(name, {.size = size}));
    return {name,
            [=] { return made(game->start()); },
            [=](World& w) {
                ScriptedInputs inputs(*game);
                done(game->advance(w, inputs.at(w.tick_count())));
            },
            ticks,
            12,
            10,
            30};
}

/// One joint of a kind, with every feature that an axis can have on its free axes. Slow springs become quick, and slack
/// ropes short.
inline Story joint_story(const JointVariant& v, double break_force = 0, double break_torque = 0) {
    JointDef def = v.def;
    for (std::uint32_t i = 0; i < joint_axis_count; ++i) {
        JointAxis& axis = def.axis[i];
        if (axis.frequency > Real{}) axis.frequency = Real(3);
        if (axis.mode == AxisMode::free && i % 2 == 0)
            axis.motor_speed = Real(1), axis.motor_force = Real(300);
        if (axis.mode == AxisMode::free && i % 2 == 1) axis.friction = Real(200);
    }
    if (def.axis[along_x].mode == AxisMode::limited) def.axis[along_x].upper -= real(0.95);
    def.break_force = real(break_force), def.break_torque = real(break_torque);
    const auto start = [def] { return join_two(def.kind, def, turned(axis_y, 20)); };
    const Jointed ids = start();
    const auto step = [a = ids.a, b = ids.b, joint = ids.joint](World& w) {
        const std::uint64_t tick = w.tick_count();
        Loads loads = loads_of(100 + tick, 8000, 3000);
        loads.apply(w, a), loads.apply(w, b);
        done(w.add_force(a, vec(-5000, -5000, 0))), done(w.add_force(b, vec(5000, -5000, 0)));
        if (tick % 13 == 7 && w.is_alive(joint)) {
            JointAxis axis = w.joint(joint).axis[about_x];
            axis.motor_speed = -axis.motor_speed;
            done(w.set_joint_axis(joint, about_x, axis));
        }
        w.tick();
    };
    return {std::string(v.name) + (break_force + break_torque > 0 ? ", that breaks" : ""),
            [start] { return start().world; }, step, 40, 8};
}

/// The joint breaks at 0.95 of its largest load.
inline Story breaking_story(const JointVariant& v) {
    const Story whole = joint_story(v);
    World w = whole.start();
    double force = 0, torque = 0;
    for (int t = 0; t < whole.ticks; ++t) {
        whole.step(w);
        for (std::uint32_t row = 0; row < w.joint_count(); ++row) {
            if (w.joint(w.joint_at(row)).kind != v.def.kind) continue;
            const JointState s = w.joint_state(w.joint_at(row));
            force = std::max(force, length(to_double(s.force)));
            torque = std::max(torque, length(to_double(s.torque)));
        }
    }
    if (std::max(force, torque) <= 0) throw std::runtime_error(v.name + std::string(" bears nothing"));
    return joint_story(v, 0.95 * force, 0.95 * torque);
}

/// Adds objects of every kind to a heap; the tick alone decides which.
inline void step_heap(World& w) {
    const auto tick = static_cast<int>(w.tick_count());
    for (int i = 0; i < tick % 5; ++i) {
        const BodyId body =
            add_something(w, tick + i, {.pose = at(0.4 * (tick % 7) - 1, 1 + 0.8 * i, 0.5 * (tick % 5) - 1)});
        if (tick % 3 == 0 && w.body_count() > 4) {
            const BodyId other = w.body_at(2);
            made(w.create_joint(weld_joint(), other, body, w.pose(body)));
            done(w.set_pair_filter(other, body, false));
        }
    }
    if (tick % 4 == 1) made(w.create_field({.center = vec(1, 1, 1), .strength = Real(1)}));
    if (tick % 6 == 2) made(w.create_character({.position = vec(0.5 * tick, 0, 6)}));
    if (tick % 11 == 10) done(w.destroy(w.body_at(w.body_count() - 1)));
    w.tick();
}

inline WorldDef heap_def() {
    WorldDef def = WorldDef::precise();
    def.bodies_max = def.shapes_max = 2000;
    return def;
}
inline World start_heap() {
    World w = made(World::create(heap_def(), script_schema()));
    add_floor(w);
    return w;
}

inline std::vector<Story> stories() {
    std::vector<Story> all;
    for (const Scenery scenery : sceneries) all.push_back(script_story(scenery, long_or(600, 150)));
    for (const Integrator i : {Integrator::verlet, Integrator::velocity_verlet, Integrator::runge_kutta_4}) {
        all.push_back(script_story(Scenery::fields, 60, i));
        all.back().after_move = 60;
    }
    const Zoo zoo = make_zoo();
    all.push_back({.name = "every kind of shape",
                   .start = [=] { return zoo_world(zoo); },
                   .ticks = 240,
                   .after = 3,
                   .moved_every = 3,
                   .after_move = 3});
    all.push_back({"characters", start_characters, step_characters, 240, 3, 1, 3});
    all.push_back({"a heap that takes more memory as it grows", start_heap, step_heap, 45, 8, 1, 8});
    all.push_back({"joints", start_joints, step_joints, long_or(400, 120), 15, 1, 8});
    all.push_back({"sleepers", start_sleepers, step_sleepers, 260, 40, 5, 70});
    all.push_back({"vehicles", start_vehicles, step_vehicles, long_or(900, 240), 8, 10, 12});
    all.push_back({"rows that are shared",
                   [] { return made(World::create({.bodies_max = 2000, .shapes_max = 2000})); }, step_kinds,
                   8, 3, 1, 3});
    all.push_back(scene_story("water", 40, 260));
    all.push_back(scene_story("blast", 2, 260));
    for (const char* name : {"pile", "convex-pile", "rollback-arena", "terrain"}) {
        all.push_back(scene_story(name, name == std::string("rollback-arena") ? 0 : 150, long_or(600, 40)));
        all.back().after = 5;
    }
    for (const JointVariant& v : joint_variants())
        all.push_back(joint_story(v)), all.push_back(breaking_story(v));
    for (Story& story : all)
        if (is_too_long_here()) story.moved_every *= 4;
    return all;
}

} // namespace lockstone::test::scene
