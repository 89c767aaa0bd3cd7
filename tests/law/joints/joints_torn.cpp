// A hinge uses other rows from the moment within a tick at which its axes are more than 45 degrees apart
// (solve/joints/joint_parts.h).
#include "support/rigs/torn_hinge.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

TEST_CASE(
    "a hinge that is torn apart within a tick pulls with the same torque as a six-dof joint with its axes") {
    for (const JointAxis& about : {turns_freely, hardly_turns})
        for (const int speed : {60, 90, 150}) {
            CAPTURE(static_cast<int>(about.mode));
            CAPTURE(speed);
            TornHinge hinge(hinge_with(about), Real(speed)), axes(wheel_like_hinge(about), Real(speed));
            hinge.world.tick(), axes.world.tick();
            REQUIRE(hinge.closeness() < 0.7_r);
            const Real wanted = axes.torque();
            CHECK(wanted > 100000000_r);
            CHECK(abs(hinge.torque() - wanted) < wanted / Real(100)); // rounding only
        }
}
