// Runners that outlive their sessions.
#include "session/lifetime.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("a runner does not call a session that was destroyed") {
    for (const HostileScene& scene : lifetime_scenes()) {
        CAPTURE(std::string(scene.name));
        CHECK(scene.run() == "");
    }
}
