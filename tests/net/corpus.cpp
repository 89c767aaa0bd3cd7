// The inputs of the fuzzers of datagrams and tokens, and mutations of them. Keys are random here: no rule may depend on
// them.
#include "fuzz/corpus.h"
#include "fuzz/checks/net_check.h"

#include <doctest/doctest.h>

using namespace lockstone;

TEST_CASE("net corpus: the corpus holds every seed and no datagram of it does harm") {
    const auto seeds = fuzz::net_seeds();
    const auto all = fuzz::corpus("net", seeds);
    for (const fuzz::Seed& seed : seeds)
        CHECK_MESSAGE(std::ranges::find(all, seed.bytes) != all.end(), seed.name);
    std::uint64_t refused = 0, delivered = 0;
    for (const fuzz::Buffer& bytes : all) {
        fuzz::NetOutcome outcome;
        CHECK(fuzz::check_net(bytes, outcome) == "");
        refused += outcome.refused, delivered += outcome.delivered;
    }
    CHECK(refused > 100);
    CHECK(delivered > 500);
}

TEST_CASE("net corpus: no datagram among hundreds of mutations does harm") {
    const auto all = fuzz::corpus("net", {});
    Random random = Random::seeded(2026);
    for (std::size_t i = 0; i < fuzz::rounds(300); ++i) {
        fuzz::NetOutcome outcome;
        CAPTURE(i);
        REQUIRE(fuzz::check_net(fuzz::mutated(all, random), outcome) == "");
    }
}

TEST_CASE("net corpus: tokens and passes of any bytes open or are rejected with a reason") {
    const auto seeds = fuzz::token_seeds();
    const auto all =
        fuzz::corpus("net_token", {seeds.begin(), seeds.end() - 1}); // the last one holds a nonce
    for (const fuzz::Buffer& bytes : all) CHECK(fuzz::check_token(bytes) == "");
    CHECK(all.size() >= seeds.size() - 1);
    Random random = Random::seeded(2026);
    for (std::size_t i = 0; i < fuzz::rounds(5000); ++i)
        REQUIRE(fuzz::check_token(fuzz::mutated(all, random)) == "");
}
