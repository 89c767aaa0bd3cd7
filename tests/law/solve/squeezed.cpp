// Boxes that are held squeezed, about where contacts begin to be solved in order of their depth.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Where contacts of bodies that move leave the order by levels: depth_step of contact_order.cpp [m].
constexpr double jump = 0.01;

/// Four boxes of 1 m in a row on a floor, between a wall and one that swings once a second. Contacts with walls are four
/// times as stiff, so of a squeeze the three between boxes take 6 parts in 7.
struct Squeezed {
    static constexpr int count = 4;
    World world;
    std::vector<BodyId> boxes;
    BodyId wall;

    /// `overlap`: of two boxes, if all give alike [m].
    explicit Squeezed(double overlap) : world(made(World::create({.sleeping = 0}))) {
        add_floor(world);
        add_wall(world, at(-1, 2, 0), vec(1, 2, 2));
        for (int i = 0; i < count; ++i)
            boxes.push_back(add_crate(world, at(0.5 - overlap / 4 + i * (1 - overlap), 0.5, 0)));
        const double end = count - (count - 1) * overlap - overlap / 2;
        wall = add(world, {.kind = BodyKind::kinematic, .pose = at(end + 1, 2, 0)},
                   {.geometry = box(Real(1), Real(2), Real(2))});
    }
    /// Overlap of the two in the middle [m].
    double middle() const {
        return 1 - (position(world, boxes[count / 2])[0] - position(world, boxes[count / 2 - 1])[0]);
    }
};

struct Motion {
    double fastest = 0; ///< of the boxes [m/s]
    int crossings = 0;  ///< of the jump by the overlap in the middle
};

/// In ten seconds, the first three of which are left to settle. `swing`: of the wall [m].
Motion motion_of(double overlap, double swing = 0.001) {
    Squeezed s(overlap);
    Motion out;
    bool above = false;
    for (int t = 0; t < 600; ++t) {
        const double turn = 2 * 3.14159265358979323846, speed = swing * turn * std::cos(turn * t / 60);
        done(s.world.set_velocity(s.wall, vec(t < 180 ? 0 : speed, 0, 0), {}));
        s.world.tick();
        if (t < 180) continue;
        for (const BodyId box : s.boxes) out.fastest = std::max(out.fastest, length(velocity(s.world, box)));
        out.crossings += t > 180 && above != (s.middle() > jump) ? 1 : 0;
        above = s.middle() > jump;
    }
    return out;
}

/// What is slower than this may fall asleep: a row that shakes faster would stay awake for ever [m/s].
const double still = to_double(WorldDef{}.sleep_speed);

} // namespace

TEST_CASE("boxes that are squeezed to about the depth where the order of contacts changes do not shake") {
    int crossings = 0;
    for (const double overlap : {0.0085, 0.009, 0.0093, 0.0097, 0.0105, 0.0115}) {
        const Motion motion = motion_of(overlap);
        CHECK(motion.fastest < still);
        crossings += motion.crossings;
    }
    CHECK(crossings >= 10); // twice a second, in one row at least
}

TEST_CASE("planted fault: boxes that shake by more than the speed of sleep are found out") {
    CHECK(motion_of(0.0093, 0.008).fastest > still); // the wall is as fast as 50 mm/s
}
