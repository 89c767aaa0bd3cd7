// Random loads on every kind of joint, by seed: no energy is gained, no gap remains, no number overflows.
// LOCKSTONE_LONG=1 takes 10,000 seeds for each kind and for each further use of a kind; LOCKSTONE_SEEDS=first..last the
// named seeds; LOCKSTONE_SHARD=2/5 every fifth seed from the second on.
#include "support/effort.h"
#include "support/rigs/joint_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr int loaded_ticks = 40, quiet_ticks = 30;

struct Loaded {
    const char* name;
    JointKind kind;
    JointDef def;
    double power = 0; ///< the greatest power of its motors [W]
};

std::vector<Loaded> plain_kinds() {
    std::vector<Loaded> all;
    for (JointKind kind : joint_kinds) all.push_back({lockstone::name_of(kind), kind, plain_joint(kind)});
    return all;
}
/// Further uses of the kinds, with their options.
std::vector<Loaded> other_uses() {
    JointDef cone = ball_joint(), steered = wheel_joint(Real(2), Real(1)),
             slack = plain_joint(JointKind::pulley);
    cone.swing = real(0.7);
    cone.axis[about_x] = {.mode = AxisMode::limited, .lower = real(-0.5), .upper = real(0.4)};
    steered.axis[about_y] = {.mode = AxisMode::limited,
                             .spring = 1,
                             .lower = real(-0.5),
                             .upper = real(0.5),
                             .frequency = Real(4)};
    slack.axis[along_x] = {.mode = AxisMode::limited, .upper = real(6.4)};
    JointDef turning = hinge_joint(), pushing = slider_joint(), winch = rope_joint(Real(1)),
             pose = six_dof_joint();
    turning.axis[about_x].motor_speed = Real(10), turning.axis[about_x].motor_force = Real(300);
    pushing.axis[along_x] = {.mode = AxisMode::limited,
                             .lower = real(-0.5),
                             .upper = real(0.5),
                             .motor_speed = Real(2),
                             .motor_force = Real(2000)};
    winch.axis[along_x].upper = real(1.5);
    winch.axis[along_x].motor_speed = Real(1), winch.axis[along_x].motor_force = Real(2000);
    for (JointAxis& axis : pose.axis)
        axis = {.mode = AxisMode::limited,
                .spring = 1,
                .lower = real(-0.3),
                .upper = real(0.3),
                .frequency = Real(3)};
    return {{"ball within cone and twist", JointKind::ball, cone},
            {"wheel, steered", JointKind::wheel, steered},
            {"weld, soft", JointKind::weld, weld_joint(Real(4))},
            {"rope", JointKind::distance, rope_joint(real(1.2))},
            {"spring", JointKind::distance, spring_joint(Real(1), Real(3), real(0.5))},
            {"pulley, slack", JointKind::pulley, slack},
            {"hinge with a motor", JointKind::hinge, turning, 3000},
            {"slider with a motor", JointKind::slider, pushing, 4000},
            {"rope on a winch", JointKind::distance, winch, 2000},
            {"six_dof, sprung within limits", JointKind::six_dof, pose}};
}

/// A joint with the addition that the seed chooses: limits or friction.
JointDef def_of(const Loaded& what, std::uint64_t seed) {
    JointDef def = what.def;
    if (seed % 3 == 1 && what.kind < JointKind::distance)
        for (JointAxis& axis : def.axis)
            if (axis.mode == AxisMode::free)
                axis.mode = AxisMode::limited, axis.lower = real(-0.5), axis.upper = real(0.4);
    if (seed % 3 == 2)
        for (JointAxis& axis : def.axis) axis.friction = Real(500);
    return def;
}

/// B's mass over A's.
double mass_ratio(std::uint64_t seed) { return std::array{1.0, 0.1, 10.0, 0.01}[seed / 11 % 4]; }

Jointed jointed(const Loaded& what, std::uint64_t seed) {
    const Quat turn = normalized(turned(axis_z, static_cast<double>(seed % 7) * 25) *
                                 turned(axis_x, static_cast<double>(seed % 5) * 31));
    Jointed j = join_two(what.kind, def_of(what, seed), turn);
    const Vec3 gyration = vec(0.408248290, 0.408248290, 0.408248290); // of a crate of 1 m
    done(j.world.set_mass({j.b, real(1000 * mass_ratio(seed)), Vec3{}, gyration, Quat::identity()}));
    return j;
}
/// Loads each body in proportion to its mass.
void apply(Loads& loads, Jointed& j, double force, double torque) {
    for (const BodyId body : {j.a, j.b}) {
        const double share = to_double(j.world.mass(body)) / 1000;
        loads.force = force * share, loads.torque = torque * share;
        loads.apply(j.world, body);
    }
}

/// 10 N to 10^5 N on bodies of 1000 kg.
Loads seeded_loads(std::uint64_t seed) {
    const double strength = std::pow(10, static_cast<double>(seed % 11) / 2.5);
    return loads_of(seed, 10 * strength, 3 * strength);
}

std::string name_of(const Loaded& what, std::uint64_t seed, int tick) {
    return std::string(what.name) + ", seed " + std::to_string(seed) + ", tick " + std::to_string(tick) +
           ": ";
}

/// w^2 r: the acceleration with which rotating bodies pull at their joint [m/s^2]; r at least 1 m.
double pull_of(const Jointed& j) {
    const double w = std::max(length(spin(j.world, j.a)), length(spin(j.world, j.b)));
    const D3 way = to_double(j.world.pose(j.b).position - j.world.pose(j.a).position);
    return w * w * std::max(1.0, length(way));
}

/// violation(), with exceptions: for lines the length beyond their limit, for steered wheels all axes but the steering
/// one, for soft welds zero, because a spin faster than their frequency keeps them apart.
double off_by(const Jointed& j, JointKind kind) {
    const JointDef def = j.world.joint(j.joint);
    const bool is_line = kind == JointKind::distance || kind == JointKind::pulley;
    if (is_line && def.axis[along_x].mode == AxisMode::free) return 0;
    if (is_line && def.axis[along_x].mode == AxisMode::limited) // the target is 0
        return std::max(0.0, violation(j, kind) - to_double(def.axis[along_x].upper));
    if (kind == JointKind::weld && def.axis[along_x].frequency > Real{}) return 0;
    if (kind != JointKind::wheel || def.axis[about_y].mode == AxisMode::locked) return violation(j, kind);
    const Place a = place_of(j.world, def.body_a, def.frame_a),
                b = place_of(j.world, def.body_b, def.frame_b);
    const D3 along = offset_of(a, b).along;
    return std::max({std::abs(along[0]), std::abs(along[2]), std::abs(std::asin(dot(b.axes[0], a.axes[1])))});
}

/// The bound of the energy: loads give sqrt(2 E) <= pushed; motors add y' <= pushed' + power / y.
double energy_max(const Loads& loads, double work) {
    const double most = loads.pushed + std::sqrt(2 * work);
    return 0.5 * most * most;
}

/// Loads, then none. Under the loads the kinetic energy is at most `factor` times the energy that they can have added;
/// afterwards the joint's locks close again, and no value was clamped.
std::string load_fault(const Loaded& what, std::uint64_t seed, double factor = 1) {
    Jointed j = jointed(what, seed);
    Loads loads = seeded_loads(seed);
    const double force = loads.force, torque = loads.torque;
    double pull = 0; // the greatest of the quiet ticks: a stretch takes ticks to close
    double off =
        1e9; // for a rope the least of the quiet ticks: it gives way while a body winds around its pulley
    for (int t = 0; t < loaded_ticks + quiet_ticks; ++t) {
        if (t >= loaded_ticks + quiet_ticks - (what.kind == JointKind::pulley ? quiet_ticks : 1))
            off = std::min(off, off_by(j, what.kind));
        if (t < loaded_ticks) apply(loads, j, force, torque);
        j.world.tick();
        if (t >= loaded_ticks) pull = std::max(pull, pull_of(j));
        const double energy = to_double(j.world.kinetic_energy());
        const double most = energy_max(loads, what.power * (t + 1) / j.world.def().tick_rate);
        if (energy > factor * (1.05 * most + 0.01))
            return name_of(what, seed, t) + std::to_string(energy) + " J of at most " + std::to_string(most);
    }
    const double tolerance = 0.005 + 2e-5 * pull; // the locks' softness
    if (off > tolerance * factor)
        return name_of(what, seed, loaded_ticks + quiet_ticks) + "off by " + std::to_string(off);
    if (j.world.faults() != Faults{})
        return name_of(what, seed, loaded_ticks + quiet_ticks) + "something was clamped";
    return {};
}

struct Seeds {
    unsigned long long first = 0, last = 0, step = 1;
};
Seeds seeds_to_run() {
    Seeds seeds;
    seeds.last = static_cast<unsigned long long>(test::tries(25)) - 1;
    if (std::getenv("LOCKSTONE_LONG") != nullptr) seeds.last = 9999;
    if (const char* text = std::getenv("LOCKSTONE_SEEDS"); text != nullptr)
        REQUIRE(std::sscanf(text, "%llu..%llu", &seeds.first, &seeds.last) == 2);
    unsigned long long shard = 1;
    if (const char* text = std::getenv("LOCKSTONE_SHARD"); text != nullptr)
        REQUIRE(std::sscanf(text, "%llu/%llu", &shard, &seeds.step) == 2);
    REQUIRE((shard >= 1 && shard <= seeds.step));
    seeds.first += shard - 1;
    return seeds;
}

} // namespace

TEST_CASE("under random loads every kind of joint adds no energy and closes its locks afterwards") {
    const Seeds seeds = seeds_to_run();
    for (const Loaded& what : plain_kinds())
        for (unsigned long long seed = seeds.first; seed <= seeds.last; seed += seeds.step)
            CHECK(load_fault(what, seed) == "");
}

TEST_CASE("under random loads ropes and springs and soft welds and cones and wheels and motors add no energy "
          "and close") {
    const Seeds seeds = seeds_to_run();
    for (const Loaded& what : other_uses())
        for (unsigned long long seed = seeds.first; seed <= seeds.last; seed += seeds.step)
            CHECK(load_fault(what, seed) == "");
}

TEST_CASE("planted fault: the check reports energy above a bound that is too low for the loads") {
    for (const Loaded& what : other_uses()) {
        INFO(std::string(what.name));
        CHECK(load_fault(what, 3, 0.01) != "");
    }
    CHECK(load_fault(plain_kinds()[1], 3, 0.01) != "");
}
