// Points of joints that are open are closed within a tick, by moving bodies.
#include "support/rigs/joint_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// A net of balls in space, held to their neighbours half way; packs solve its points, for it has loops.
struct Net {
    static constexpr int side = 6;
    World world;
    std::vector<BodyId> balls;
    std::vector<JointId> joints;

    Net() : world(made(World::create({.gravity = {}, .sleeping = 0}))) {
        for (int i = 0; i < side * side; ++i)
            balls.push_back(add(world, {.pose = at(i % side, i / side, 0)}, {.geometry = sphere(real(0.3))}));
        for (int i = 0; i < side * side; ++i) {
            if (i % side + 1 < side) join(i, i + 1, vec(0.5, 0, 0));
            if (i + side < side * side) join(i, i + side, vec(0, 0.5, 0));
        }
    }
    void join(int a, int b, Vec3 way) {
        JointDef def = ball_joint();
        def.body_a = balls[static_cast<std::size_t>(a)], def.body_b = balls[static_cast<std::size_t>(b)];
        def.frame_a.position = way, def.frame_b.position = -way;
        joints.push_back(made(world.create_joint(def)));
    }
    double widest() const {
        double out = 0;
        for (const JointId joint : joints) {
            const JointDef def = world.joint(joint);
            const Offset o =
                offset_of(place_of(world, def.body_a, def.frame_a), place_of(world, def.body_b, def.frame_b));
            out = std::max(out, length(o.along));
        }
        return out;
    }
    D3 center() const {
        D3 sum{};
        for (const BodyId ball : balls) sum = sum + position(world, ball);
        return 1.0 / (side * side) * sum;
    }
};

} // namespace

// 8 mm are what JointSolver::close leaves to the next substeps. Without it a tick takes 43 % out of a gap, and 31 mm leave 18.
TEST_CASE("points that are open are closed within a tick, and what they hold stays where it is") {
    Random random = Random::seeded(5);
    for (int i = 0; i < 20; ++i) {
        Net net;
        const BodyId ball = net.balls[random.below(Net::side * Net::side)];
        Transform away = net.world.pose(ball);
        away.position += Vec3{random.range(0.018_r, 0.025_r), random.range(0.018_r, 0.025_r), {}};
        done(net.world.set_pose(ball, away));
        const D3 before = net.center();
        CHECK(net.widest() > 0.02); // twin: it is open
        net.world.tick();
        CHECK(net.widest() < 0.008);
        CHECK(length(net.center() - before) < 1e-5);
    }
}
