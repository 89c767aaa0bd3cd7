// The number of degrees of freedom that a joint removes. The response of two joined bodies to impulses is a projection
// onto their allowed motions, and the trace of a projection is the number of its dimensions.
#include "support/about.h"
#include "support/effort.h"
#include "support/rigs/joint_variants.h"

#include <doctest/doctest.h>

#include <bit>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// A gear or a rack without its axles, which would remove degrees of freedom too.
Jointed bare_pair(const JointDef& def, Quat turn) {
    if (def.kind < JointKind::gear) return join_two(def.kind, def, turn);
    Jointed j{bare_world(), {}, {}, {}};
    j.a = add_crate(j.world, at(-1, 0, 0)), j.b = add_crate(j.world, at(1, 0, 0));
    j.joint = made(j.world.create_joint(def, j.a, j.b, at(0, 0, 0, turn)));
    return j;
}

/// The share that remains, after a tick, of a speed along one of the twelve degrees of freedom of two crates.
double share_left(const JointDef& def, Quat turn, std::uint32_t degree) {
    constexpr double given = 0.25;
    Jointed j = bare_pair(def, turn);
    const BodyId body = degree < 6 ? j.a : j.b;
    D3 speed{};
    speed[degree % 3] = given;
    const bool turns = degree % 6 >= 3;
    const Vec3 v = vec(speed[0], speed[1], speed[2]);
    done(j.world.set_velocity(body, turns ? Vec3{} : v, turns ? v : Vec3{}));
    j.world.tick();
    return (turns ? spin(j.world, body) : velocity(j.world, body))[degree % 3] / given;
}

double degrees_left(const JointDef& def, Quat turn) {
    double sum = 0;
    for (std::uint32_t degree = 0; degree < 12; ++degree) sum += share_left(def, turn, degree);
    return sum;
}

} // namespace

TEST_CASE("every kind of joint removes its declared number of degrees of freedom and no others") {
    for (const JointVariant& v : joint_variants())
        for (const Quat turn : {Quat::identity(), turned(axis_y, 35), turned(axis_z, 70)}) {
            INFO(std::string(v.name));
            CHECK(degrees_left(v.def, turn) == test::about(12.0 - v.taken, 0.004));
        }
}

TEST_CASE("a six-dof joint removes one degree of freedom for each axis that it locks") {
    for (std::uint32_t mask = 0; mask < 64;
         mask += test::is_too_long_here() ? 9u : 1u) { // every ninth mask has each axis free and locked
        JointDef def = six_dof_joint();
        for (std::uint32_t i = 0; i < 6; ++i)
            if ((mask >> i & 1u) != 0) def.axis[i].mode = AxisMode::locked;
        INFO("mask ", mask);
        CHECK(degrees_left(def, turned(axis_x, 20)) == test::about(12.0 - std::popcount(mask), 0.004));
    }
}

TEST_CASE("a taut rope removes its degree of freedom only against motion that would stretch it") {
    JointDef taut = rope_joint(Real(1));
    for (const double way : {1.0, -1.0}) {
        Jointed j = join_two(JointKind::distance, taut);
        done(j.world.set_velocity(j.b, vec(0.25 * way, 0, 0), {}));
        j.world.tick();
        const double parting = velocity(j.world, j.b)[0] - velocity(j.world, j.a)[0];
        CHECK(parting == test::about(way > 0 ? 0 : -0.25, 0.01));
    }
}

TEST_CASE("planted fault: the count of degrees of freedom shows one axis more or less") {
    JointDef universal = ball_joint(), loose = hinge_joint();
    universal.axis[about_x].mode = AxisMode::locked;
    loose.axis[along_z].mode = AxisMode::free;
    CHECK(degrees_left(universal, Quat::identity()) != test::about(12 - 3, 0.004));
    CHECK(degrees_left(loose, Quat::identity()) != test::about(12 - 5, 0.004));
}
