// The kept inputs of the fuzzer of machines outside the match, and mutations of these inputs.
#include "fuzz/checks/guest_check.h"
#include "fuzz/corpus.h"

#include <doctest/doctest.h>

TEST_CASE("spectator, join and desync packets of any bytes are read as written or rejected") {
    const std::vector<fuzz::Buffer> all = fuzz::corpus("guest", fuzz::guest_seeds());
    REQUIRE(all.size() >= 14);
    for (const fuzz::Buffer& bytes : all) CHECK(fuzz::check_guest_packet(bytes) == "");
    lockstone::Random random = lockstone::Random::seeded(5);
    for (int i = 0; i < 50'000; ++i) {
        const fuzz::Buffer bytes = fuzz::mutated(all, random);
        REQUIRE(fuzz::check_guest_packet(bytes) == "");
    }
}
