// Large inputs do not slow a match down.
#include "session/inputs/large.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE(
    "a match of large inputs runs 58 ticks a second or more at every latency that its prediction covers") {
    for (const HostileScene& scene : large_input_scenes()) {
        CAPTURE(std::string(scene.name));
        CHECK(scene.run() == "");
    }
}
