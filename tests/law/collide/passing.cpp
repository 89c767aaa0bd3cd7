// An edge does not stop a body that flies or rolls past it: speculative contact points exist only for shapes in the
// way.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// The height of the hop of a ball that rolls or slides over the joint of two flush boxes [m], and the fraction of its
/// speed that remains.
struct Crossing {
    double hop = 0, kept = 0;
};
Crossing cross_joint(double radius, double speed, double start, bool rolls) {
    World w = made(World::create(small_def()));
    for (const double side : {-20.0, 20.0})
        add(w, {.kind = BodyKind::static_, .pose = at(side, -1, 0)},
            {.geometry = box(20_r, 1_r, 20_r), .friction = rolls ? 1_r : 0_r});
    const BodyId ball = add(w,
                            {.pose = at(-start, radius, 0.13),
                             .linear_velocity = vec(speed, 0, 0),
                             .angular_velocity = vec(0, 0, rolls ? -speed / radius : 0)},
                            {.geometry = sphere(real(radius)), .friction = rolls ? 1_r : 0_r});
    Crossing out;
    for (int t = 0; t < 60; ++t) {
        w.tick();
        out.hop = std::max(out.hop, position(w, ball)[1] - radius);
    }
    out.kept = velocity(w, ball)[0] / speed;
    return out;
}

} // namespace

TEST_CASE("a ball crosses the joint of two flush boxes without a hop and keeps its speed") {
    // A plane gives no hop at all. The bounds allow a graze of 2 mm and its effect on a ball of 0.1 m at 2 m/s.
    for (const bool rolls : {false, true})
        for (const double radius : {0.1, 0.3, 1.0})
            for (const double speed : {2.0, 5.0, 15.0, 30.0})
                for (int k = 0; k < 8; ++k) {
                    const Crossing c =
                        cross_joint(radius, speed, 0.3 * speed + radius + 0.013 * k * speed / 5, rolls);
                    INFO((rolls ? "rolling" : "sliding"), ", radius ", radius, ", ", speed, " m/s, start ",
                         k);
                    CHECK(c.hop < 0.004);
                    CHECK(c.kept > 0.98);
                }
}

TEST_CASE("a ball that misses an obstacle keeps its direction and has no contact") {
    const Geometry obstacles[] = {box(0.5_r, 0.5_r, 0.5_r), sphere(0.5_r), cylinder(0.5_r, 0.5_r)};
    for (const Geometry& obstacle : obstacles)
        for (const double clearance : {0.01, 0.05})
            for (const double speed : {5.0, 20.0, 60.0})
                for (int k = 0; k < 8; ++k) {
                    World w = made(World::create(weightless()));
                    add(w, {.kind = BodyKind::static_}, {.geometry = obstacle});
                    const BodyId ball =
                        add(w,
                            {.pose = at(-speed / 4 - 0.017 * k * speed / 5, 0.8 + clearance, 0.05),
                             .linear_velocity = vec(speed, 0, 0)},
                            {.geometry = sphere(0.3_r)});
                    std::size_t touched = 0;
                    for (int t = 0; t < 40; ++t) {
                        w.tick();
                        for (const Event& e : w.events())
                            touched += e.kind == EventKind::contact_begin ? 1 : 0;
                    }
                    INFO("kind ", static_cast<int>(obstacle.kind), ", clearance ", clearance, ", ", speed,
                         " m/s, start ", k);
                    CHECK(std::abs(velocity(w, ball)[1]) < 1e-5);
                    CHECK(touched == 0);
                }
}

TEST_CASE("an obstacle stops a ball that hits it") {
    // The negative control of the cases above: half of the ball is in the way.
    for (const double speed : {5.0, 20.0, 60.0}) {
        World w = made(World::create(weightless()));
        add(w, {.kind = BodyKind::static_}, {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
        const BodyId ball = add(w, {.pose = at(-speed / 4, 0.4, 0), .linear_velocity = vec(speed, 0, 0)},
                                {.geometry = sphere(0.3_r)});
        for (int t = 0; t < 40; ++t) w.tick();
        CHECK(position(w, ball)[0] < -0.78);
    }
}
