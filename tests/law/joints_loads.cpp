// Random loads on every kind of joint, by seed: nothing gains energy, nothing stays apart, nothing overflows.
// LOCKSTONE_LONG=1 takes 10,000 seeds a kind; LOCKSTONE_SEEDS=first..last those of a kind; LOCKSTONE_SHARD=2/5 every fifth
// seed from the second on.
#include "support/joint_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr int loaded_ticks = 40, quiet_ticks = 30;

/// A joint of a kind with what a seed adds: limits, friction, a spring or a motor.
JointDef def_of(JointKind kind, std::uint64_t seed) {
    JointDef def = plain_joint(kind);
    if (seed % 3 == 1 && kind < JointKind::distance)
        for (JointAxis& axis : def.axis)
            if (axis.mode == AxisMode::free)
                axis.mode = AxisMode::limited, axis.lower = real(-0.5), axis.upper = real(0.4);
    if (seed % 3 == 2)
        for (JointAxis& axis : def.axis) axis.friction = Real(500);
    return def;
}

/// B's mass over A's.
double mass_ratio(std::uint64_t seed) { return std::array{1.0, 0.1, 10.0, 0.01}[seed / 11 % 4]; }

Jointed jointed(JointKind kind, std::uint64_t seed) {
    const Quat turn = normalized(turned(axis_z, static_cast<double>(seed % 7) * 25) *
                                 turned(axis_x, static_cast<double>(seed % 5) * 31));
    Jointed j = join_two(kind, def_of(kind, seed), turn);
    SetMass mass{j.b, real(1000 * mass_ratio(seed)), {}, {}, Quat::identity()};
    mass.gyration = vec(0.408248290, 0.408248290, 0.408248290); // of a crate of 1 m
    done(j.world.set_mass(mass));
    return j;
}
/// On each body in proportion to its mass.
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

std::string name_of(JointKind kind, std::uint64_t seed, int tick) {
    return std::string(lockstone::name_of(kind)) + ", seed " + std::to_string(seed) + ", tick " +
           std::to_string(tick) + ": ";
}

/// w^2 r: how hard bodies that fly round each other pull at their joint [m/s^2]; r at least 1 m.
double pull_of(const Jointed& j) {
    const double w = std::max(length(spin(j.world, j.a)), length(spin(j.world, j.b)));
    const D3 way = to_double(j.world.pose(j.b).position - j.world.pose(j.a).position);
    return w * w * std::max(1.0, length(way));
}

/// Loads, then none. While they act, the kinetic energy is never more than `factor` times what they can have put in; when
/// they are over, what the joint keeps comes back to where it belongs; nothing was clamped.
std::string load_fault(JointKind kind, std::uint64_t seed, double factor = 1) {
    Jointed j = jointed(kind, seed);
    Loads loads = seeded_loads(seed);
    const double force = loads.force, torque = loads.torque;
    double pull = 0; // the most of the quiet ticks: what it stretched takes ticks to come back
    double off =
        1e9; // of a rope the least of the quiet ticks: it gives while a body is wound about its pulley
    for (int t = 0; t < loaded_ticks + quiet_ticks; ++t) {
        if (t >= loaded_ticks + quiet_ticks - (kind == JointKind::pulley ? quiet_ticks : 1))
            off = std::min(off, violation(j, kind));
        if (t < loaded_ticks) apply(loads, j, force, torque);
        j.world.tick();
        if (t >= loaded_ticks) pull = std::max(pull, pull_of(j));
        const double energy = to_double(j.world.kinetic_energy());
        if (energy > factor * (1.05 * loads.energy_max() + 0.01))
            return name_of(kind, seed, t) + std::to_string(energy) + " J of at most " +
                   std::to_string(loads.energy_max());
    }
    const double tolerance = 0.005 + 2e-5 * pull; // the locks' softness
    if (off > tolerance * factor)
        return name_of(kind, seed, loaded_ticks + quiet_ticks) + "off by " + std::to_string(off);
    if (j.world.faults() != Faults{})
        return name_of(kind, seed, loaded_ticks + quiet_ticks) + "something was clamped";
    return {};
}

struct Seeds {
    unsigned long long first = 0, last = 24, step = 1;
};
Seeds seeds_to_run() {
    Seeds seeds;
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

TEST_CASE("random loads on every kind: no energy from nowhere, and all is in its place again") {
    const Seeds seeds = seeds_to_run();
    for (JointKind kind : joint_kinds)
        for (unsigned long long seed = seeds.first; seed <= seeds.last; seed += seeds.step)
            CHECK(load_fault(kind, seed) == "");
}

TEST_CASE("planted fault: a bound too low for what the loads put in is found to be exceeded") {
    CHECK(load_fault(JointKind::ball, 3, 0.01) != "");
}
