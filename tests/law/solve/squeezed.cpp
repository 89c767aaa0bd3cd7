// Squeezed bodies rest, and share the overlap as springs do.
#include "support/effort.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Boxes of 1 m in a row on a floor, between two walls.
struct Squeezed {
    World world;
    std::vector<BodyId> row;
    double end = 0; ///< the place of the second wall [m]; the first wall is at 0
    BodyId wall;

    /// `overlaps`: of the first wall and body, of neighbours, of the last body and wall [m].
    Squeezed(const WorldDef& def, const std::vector<double>& overlaps) : world(made(World::create(def))) {
        add_floor(world);
        add_wall(world, at(-1, 2, 0), vec(1, 2, 2));
        for (std::size_t i = 0; i + 1 < overlaps.size(); ++i) {
            const Transform pose = at(end - overlaps[i] + 0.5, 0.5, 0);
            row.push_back(add_crate(world, pose));
            end += 1 - overlaps[i];
        }
        end -= overlaps.back();
        wall = add(world, {.kind = BodyKind::kinematic, .pose = at(end + 1, 2, 0)},
                   {.geometry = box(Real(1), Real(2), Real(2))});
    }
    /// The overlap of each contact along the row, from the first wall on [m].
    std::vector<double> overlaps() const {
        std::vector<double> out;
        double reached = 0;
        for (const BodyId body : row) {
            const double x = position(world, body)[0];
            out.push_back(reached - (x - 0.5));
            reached = x + 0.5;
        }
        out.push_back(reached - end);
        return out;
    }
};

/// All springs of a row carry one force. Two bodies have a reduced mass of half a body; a body against a static one has
/// its whole mass, and a spring that is four times as stiff (StepConstants::soft_static). So the overlap at a wall is
/// an eighth of that between two bodies.
constexpr double wall_share = 1.0 / 8;

/// The overlaps of a row of `count` bodies: `overlap` [m] between each two, the wall's share at the ends.
std::vector<double> even(int count, double overlap) {
    std::vector<double> out(static_cast<std::size_t>(count) + 1, overlap);
    out.front() = out.back() = overlap * wall_share;
    return out;
}

WorldDef awake(WorldDef def) {
    def.sleeping = 0;
    return def;
}

/// Returns the greatest speed in the row during seven seconds, after three to settle [m/s]. `swing`: the wall's
/// amplitude, at 1 Hz [m].
double fastest_of(Squeezed& s, double swing) {
    double fastest = 0;
    for (int t = 0; t < 600; ++t) {
        const double turn = 2 * 3.14159265358979323846, speed = swing * turn * std::cos(turn * t / 60);
        done(s.world.set_velocity(s.wall, vec(t < 180 ? 0 : speed, 0, 0), {}));
        s.world.tick();
        if (t < 180) continue;
        for (const BodyId body : s.row) fastest = std::max(fastest, length(velocity(s.world, body)));
    }
    return fastest;
}

/// Below this speed a body may fall asleep; a row that shakes faster stays awake forever [m/s].
const double still = to_double(WorldDef{}.sleep_speed);

/// Returns the largest difference between the overlaps of a row and those of springs, relative to a spring's overlap.
double unevenness(Squeezed& s, int ticks) {
    for (int t = 0; t < ticks; ++t) s.world.tick();
    const std::vector<double> found = s.overlaps();
    double sum = 0, worst = 0;
    for (const double overlap : found) sum += overlap;
    const double each = sum / (static_cast<double>(found.size()) - 2 + 2 * wall_share);
    for (std::size_t i = 0; i < found.size(); ++i) {
        const bool at_wall = i == 0 || i + 1 == found.size();
        worst = std::max(worst, std::abs(found[i] - each * (at_wall ? wall_share : 1)));
    }
    return worst / each;
}

/// Friction with the floor holds 0.6 of the weight of each box. Two boxes that overlap by 24.6 mm, a share of 80 mm,
/// push each other with 100 weights: half a mass by (2 pi 45 Hz)^2 by 24.6 mm. So from one end of four boxes to the
/// other the push may change by this part.
constexpr double unevenness_max = 4 * 0.6 / 100;

} // namespace

TEST_CASE("rows of boxes that two walls squeeze come to rest" * doctest::skip(test::is_too_long_here())) {
    for (const WorldDef& def : {awake({}), awake(WorldDef::precise())})
        for (const int count : {2, 4, 8})
            for (const double overlap : {0.004, 0.009, 0.0105, 0.016, 0.03, 0.06}) {
                INFO("substeps: ", def.substeps, ", boxes: ", count, ", overlap: ", overlap);
                Squeezed held(def, even(count, overlap));
                CHECK(fastest_of(held, 0) < still);
                Squeezed swings(def, even(count, overlap));
                CHECK(fastest_of(swings, 0.001) < still); // the wall moves at 6 mm/s
            }
}

TEST_CASE("planted fault: the test detects boxes that shake faster than the sleep speed") {
    Squeezed s(awake({}), even(4, 0.0093));
    CHECK(fastest_of(s, 0.008) > still); // the wall moves at up to 50 mm/s
}

TEST_CASE("squeezed boxes share an overlap as springs do regardless of the place where it begins") {
    for (int deep = 0; deep <= 4; ++deep) {
        std::vector<double> overlaps(5, 0.0);
        overlaps[static_cast<std::size_t>(deep)] = 0.08;
        Squeezed boxes(awake({}), overlaps);
        CHECK(unevenness(boxes, 0) > 0.5); // negative control: the initial overlaps
        CHECK(unevenness(boxes, 600) < unevenness_max);
    }
}
