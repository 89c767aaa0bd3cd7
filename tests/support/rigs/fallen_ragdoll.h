// Ragdolls that fall over. For the tests and for the planted faults.
#pragma once

#include "lockstone/asset.h"
#include "lockstone/play/ragdoll.h"
#include "support/sim_scenes.h"
#include "support/split_mix.h"

#include <algorithm>
#include <string>

namespace lockstone::test {

/// The widest gap of a figure's joints [m].
inline double widest_joint(const World& w, const Ragdoll& doll) {
    double widest = 0;
    for (std::uint32_t k = 1; k < ragdoll_part_count; ++k) {
        const JointDef joint = w.joint(doll.joints[k]);
        const scene::D3 a = to_double(w.pose(joint.body_a) * joint.frame_a.position),
                        b = to_double(w.pose(joint.body_b) * joint.frame_b.position);
        widest = std::max(widest, scene::length(scene::operator-(a, b)));
    }
    return widest;
}

/// Kinetic and potential energy of a figure [J].
inline double energy_of(const World& w, const Ragdoll& doll) {
    double sum = to_double(w.kinetic_energy());
    for (const BodyId part : doll.bodies)
        sum -= to_double(w.mass(part)) * to_double(w.gravity().y) * scene::position(w, part)[1];
    return sum;
}

struct RagdollFall {
    std::string about;
    bool is_mesh = false;         ///< the floor is a mesh
    double widest = 0;            ///< the widest gap of a joint at the end of a tick [m]
    double first = 0, energy = 0; ///< initial energy, and the most at the end of a tick [J]
};

/// Drops a ragdoll from up to half a metre, with a push and a spin, on a plane, a box or a mesh, at 30 to 120 ticks a
/// second.
inline RagdollFall fall_over(std::uint64_t seed) {
    SplitMix random(seed);
    constexpr std::uint32_t rates[] = {30, 30, 40, 60, 60, 120};
    WorldDef def;
    def.tick_rate = rates[random.below(6)];
    auto assets = std::make_shared<AssetLibrary>();
    const Vec3 corners[] = {scene::vec(-20, 0, -20), scene::vec(20, 0, -20), scene::vec(-20, 0, 20),
                            scene::vec(20, 0, 20)};
    const std::array<std::uint32_t, 3> triangles[] = {{0, 2, 1}, {1, 2, 3}};
    const AssetId mesh =
        scene::made(assets->add(scene::made(bake_mesh({.vertices = corners, .triangles = triangles}))));
    World w = scene::made(World::create(def, {}, assets));
    const std::uint32_t floor = random.below(3);
    const Geometry floors[] = {plane(), box(20_r, 1_r, 20_r), instance(ShapeKind::mesh, mesh)};
    scene::add(w, {.kind = BodyKind::static_, .pose = scene::at(0, floor == 1 ? -1 : 0, 0)},
               {.geometry = floors[floor]});
    const double about_y = drawn(random, -180, 180), about_x = drawn(random, -60, 60);
    const Quat turn =
        normalized(scene::turned(scene::axis_y, about_y) * scene::turned(scene::axis_x, about_x));
    const double height = 0.05 + drawn(random, 0, 0.5);
    const Ragdoll doll = scene::made(make_ragdoll(w, {.place = scene::at(0, height, 0, turn)}));
    const std::uint32_t pushed = random.below(ragdoll_part_count);
    const double along = drawn(random, -20, 20), up = drawn(random, -5, 5), across = drawn(random, -20, 20);
    scene::done(w.add_impulse(doll.bodies[pushed], scene::vec(along, up, across)));
    RagdollFall out;
    out.about = "seed " + std::to_string(seed) + ", " + std::to_string(def.tick_rate) + " Hz, floor " +
                std::to_string(floor) + ": ";
    out.is_mesh = floor == 2;
    out.first = out.energy = energy_of(w, doll);
    for (std::uint32_t t = 0; t < 3 * def.tick_rate; ++t) {
        w.tick();
        out.widest = std::max(out.widest, widest_joint(w, doll));
        out.energy = std::max(out.energy, energy_of(w, doll));
    }
    return out;
}

/// Returns a sentence if a joint opens by more than 60 mm, 100 mm on a mesh, or if the figure gets 5 % more energy than
/// its initial one.
inline std::string fall_fault(const RagdollFall& fall) {
    if (fall.widest > (fall.is_mesh ? 0.1 : 0.06))
        return fall.about + "a joint opens by " + std::to_string(fall.widest) + " m";
    if (fall.energy > 1.05 * fall.first)
        return fall.about + "energy grows from " + std::to_string(fall.first) + " to " +
               std::to_string(fall.energy) + " J";
    return {};
}

} // namespace lockstone::test
