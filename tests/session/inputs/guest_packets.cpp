// The kept inputs of the fuzzer of machines outside the match, and mutations of these inputs.
#include "fuzz/checks/guest_check.h"
#include "fuzz/corpus.h"

#include <doctest/doctest.h>

TEST_CASE("whatever packets of watchers, of those who come in and of desyncs hold, they are read as written "
          "or not at all") {
    const std::vector<fuzz::Buffer> all = fuzz::corpus("guest", fuzz::guest_seeds());
    REQUIRE(all.size() >= 14);
    for (const fuzz::Buffer& bytes : all) CHECK(fuzz::check_guest_packet(bytes) == "");
    lockstone::Random random = lockstone::Random::seeded(5);
    for (int i = 0; i < 50'000; ++i) {
        const fuzz::Buffer bytes = fuzz::mutated(all, random);
        REQUIRE(fuzz::check_guest_packet(bytes) == "");
    }
}
