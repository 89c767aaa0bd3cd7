// A bullet that passes through a sensor, within one tick or several, gives one begin event and one end event.
#include "law/zoo/passage.h"
#include "support/effort.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("bullets of any shape and speed enter and leave each sensor on their way once") {
    const int count = is_long_run() ? 100'000 : tries(2000);
    for (int seed = 1; seed <= count; ++seed)
        CHECK(zoo::passage_fault(static_cast<std::uint64_t>(seed)) == "");
}
