// The motions that each kind of joint locks and leaves free, under loads from all sides; and limits.
#include "support/about.h"
#include "support/rigs/joint_scenes.h"

#include <doctest/doctest.h>

#include <bit>
#include <cstdlib>
#include <string>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Loads the joint of `def` for a second and a half. Returns an error sentence unless it keeps the locks of kind
/// `claimed` and moves along its free axes.
std::string freedom_fault(JointKind kind, const JointDef& def, JointKind claimed, std::uint64_t seed) {
    Jointed j = join_two(kind, def, turned(axis_y, static_cast<double>(seed % 5) * 40));
    Loads loads = loads_of(seed, 10000, 3000);
    D3 along{}, about{};
    double worst = 0;
    for (int t = 0; t < 90; ++t) {
        loads.apply(j.world, j.a), loads.apply(j.world, j.b);
        j.world.tick();
        worst = std::max(worst, violation(j, claimed));
        const Offset o = offset_of(j.world, j.joint);
        for (std::size_t i = 0; i < 3; ++i) {
            along[i] = std::max(along[i], std::abs(o.along[i]));
            about[i] = std::max(about[i], std::abs(o.about[i]));
        }
    }
    const std::string who = std::string(name_of(claimed)) + ", seed " + std::to_string(seed) + ": ";
    if (worst > 0.01) return who + "off by " + std::to_string(worst);
    if (claimed >= JointKind::distance) return {};
    for (std::uint32_t i : free_axes(claimed))
        if ((i < 3 ? along[i] : about[i - 3]) < 0.01) return who + "stuck on axis " + std::to_string(i);
    return {};
}

int seeds() { return std::getenv("LOCKSTONE_LONG") != nullptr ? 200 : 6; }

} // namespace

TEST_CASE("every kind of joint keeps its locks and leaves its other axes free under loads from all sides") {
    for (JointKind kind : joint_kinds)
        for (int seed = 0; seed < seeds(); ++seed)
            CHECK(freedom_fault(kind, plain_joint(kind), kind, static_cast<std::uint64_t>(seed)) == "");
}

TEST_CASE("planted fault: the check reports that a joint of another kind locks too little or too much") {
    CHECK(freedom_fault(JointKind::ball, ball_joint(), JointKind::hinge, 1) != "");
    CHECK(freedom_fault(JointKind::hinge, hinge_joint(), JointKind::ball, 1) != "");
    CHECK(freedom_fault(JointKind::weld, weld_joint(), JointKind::slider, 1) != "");
    CHECK(freedom_fault(JointKind::wheel, plain_joint(JointKind::wheel), JointKind::weld, 1) != "");
    CHECK(freedom_fault(JointKind::six_dof, six_dof_joint(), JointKind::ball, 1) != "");
    JointDef slack = distance_joint(Real(1));
    slack.axis[0] = {.mode = AxisMode::limited, .upper = real(1.1), .target = Real(1)};
    CHECK(freedom_fault(JointKind::distance, slack, JointKind::distance, 1) != "");
}

TEST_CASE("any table of six axes keeps its locked axes in place and lets its free axes move") {
    for (std::uint32_t mask = 0; mask < 64; mask += std::getenv("LOCKSTONE_LONG") != nullptr ? 1u : 3u) {
        JointDef def = six_dof_joint();
        for (std::uint32_t i = 0; i < 6; ++i)
            if ((mask >> i & 1u) != 0) def.axis[i].mode = AxisMode::locked;
        if (std::popcount(mask >> 3) == 1)
            continue; // two free angles are no vector: the tests of kinds above measure them
        Jointed j = join_two(JointKind::six_dof, def);
        Loads loads = loads_of(mask, 6000, 1500);
        D3 along{}, about{};
        for (int t = 0; t < 60; ++t) {
            loads.apply(j.world, j.a), loads.apply(j.world, j.b);
            j.world.tick();
            const Offset o = offset_of(j.world, j.joint);
            for (std::size_t i = 0; i < 3; ++i) {
                along[i] = std::max(along[i], std::abs(o.along[i]));
                about[i] = std::max(about[i], std::abs(o.about[i]));
            }
        }
        for (std::uint32_t i = 0; i < 6; ++i) {
            INFO("mask ", mask, ", axis ", i);
            const double most = i < 3 ? along[i] : about[i - 3];
            if ((mask >> i & 1u) != 0)
                CHECK(most < 0.005);
            else
                CHECK(most > 0.005);
        }
    }
}

TEST_CASE("a ball joint keeps B's x axis within its cone in all directions") {
    for (double cone : {0.3, 1.2, 2.5}) {
        JointDef def = ball_joint();
        def.swing = real(cone);
        double widest = 0;
        for (int way = 0; way < 8; ++way) {
            World w = bare_world();
            const BodyId b = add_crate(w, at(1, 0, 0));
            const JointId joint = made(w.create_joint(def, {}, b, at(0, 0, 0)));
            for (int t = 0; t < 150; ++t) {
                done(w.add_force(b, {}, vec(0, 2000 * std::cos(way * 0.785), 2000 * std::sin(way * 0.785))));
                w.tick();
                const double tilt = offset_of(w, joint).tilt;
                CHECK(tilt < cone + 0.01);
                widest = std::max(widest, tilt);
            }
        }
        CHECK(widest > cone - 0.01);
    }
}
