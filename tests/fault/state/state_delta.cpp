// Damaged, foreign and hostile deltas: refused with an error sentence and without a change, or applied to exactly the
// right state.
#include "base/bytes.h"
#include "base/hash.h"
#include "support/state_sample.h"

#include <doctest/doctest.h>

namespace lockstone::test {
namespace {

using Bytes = std::vector<std::byte>;

/// Two states with rows that are equal, moved, changed, new and removed, and the delta between them.
struct Pair {
    Sample s = make_sample();
    State from = random_state(s, 4, 6, 5, 17), to = random_state(s, 4, 6, 5, 17);
    Bytes delta;
    Pair() {
        const Manifold moved = to.rows(s.manifold)[1];
        to.edit_row(s.manifold, 1) = to.rows(s.manifold)[4];
        to.edit_row(s.manifold, 4) = moved;
        to.edit_row(s.velocity, 2).x += Speed::from_raw(12345);
        to.edit_row(s.health, 0).points = -7;
        to.resize(s.contact, 8);
        to.resize(s.body, 3);
        delta = to.save_delta(from);
    }
};
const Pair& pair() {
    static const Pair one;
    return one;
}

/// Writes a valid size field and checksum, as an attacker would do.
void seal(Bytes& delta) {
    base::store_little_endian<std::uint64_t>(delta.size(), delta.data() + 12);
    const std::size_t end = delta.size() - 8;
    base::store_little_endian(base::xxh3(std::span<const std::byte>(delta).first(end)), delta.data() + end);
}

/// Applies a delta. Returns an empty string if it is refused with a sentence and without a change, or gives the right
/// state. Else an error sentence.
template <class Apply> std::string misused(const Bytes& delta, Apply&& apply) {
    State state = pair().from;
    const Status status = apply(state, delta);
    if (status.ok()) return state.hash() == pair().to.hash() ? "" : "taken, and the state is another";
    if (!status.error().message.starts_with("state delta: ")) return "no sentence: " + status.error().message;
    return same_bytes(state.block_bytes(), pair().from.block_bytes()) ? "" : "refused, but the state changed";
}
std::string misused(const Bytes& delta) {
    return misused(delta, [](State& state, const Bytes& bytes) { return state.apply_delta(bytes); });
}
std::string refusal(const Bytes& delta, const State& base) {
    State state = base;
    const Status status = state.apply_delta(delta);
    REQUIRE(!status.ok());
    REQUIRE(same_bytes(state.block_bytes(), base.block_bytes()));
    return status.error().message;
}

/// Tries every delta with one changed byte and a valid checksum. Returns the first error of `check`.
template <class Check> std::string first_resealed(Check&& check) {
    for (std::size_t at = 0; at + 8 < pair().delta.size(); ++at)
        for (const unsigned flip : {1u, 2u, 0x40u, 0x80u, 0xffu}) {
            Bytes delta = pair().delta;
            delta[at] ^= static_cast<std::byte>(flip);
            if (at < 12 || at >= 20) seal(delta);
            if (std::string wrong = check(delta); !wrong.empty())
                return "byte " + std::to_string(at) + ": " + wrong;
        }
    return {};
}

} // namespace

TEST_CASE("a state accepts a delta that is unchanged since it was saved") {
    State state = pair().from;
    REQUIRE(state.apply_delta(pair().delta).ok());
    CHECK(same_bytes(state.block_bytes(), pair().to.block_bytes()));
}

TEST_CASE("a state rejects a delta with any change of a single byte") {
    for (std::size_t at = 0; at < pair().delta.size(); ++at)
        for (unsigned flip = 1; flip < 256; ++flip) {
            Bytes delta = pair().delta;
            delta[at] ^= static_cast<std::byte>(flip);
            State state = pair().from;
            REQUIRE(!state.apply_delta(delta).ok());
        }
    CHECK(first_resealed([](const Bytes& delta) { return misused(delta); }) == "");
}

TEST_CASE("a state rejects every truncated delta and every extra byte with an old or a new checksum") {
    for (std::size_t size = 0; size < pair().delta.size(); ++size) {
        Bytes delta(pair().delta.begin(), pair().delta.begin() + static_cast<std::ptrdiff_t>(size));
        refusal(delta, pair().from);
        if (size < 28) continue;
        seal(delta);
        refusal(delta, pair().from);
    }
    Bytes longer = pair().delta;
    longer.insert(longer.end() - 8, std::byte{});
    refusal(longer, pair().from);
    seal(longer);
    CHECK(refusal(longer, pair().from).find("ends here, but 1 bytes follow") != std::string::npos);
}

TEST_CASE("a state rejects random bytes under a valid head and checksum or applies them completely") {
    SplitMix random(3);
    for (int i = 0; i < 3000; ++i) {
        Bytes delta(pair().delta.begin(), pair().delta.begin() + 44);
        for (std::uint32_t n = random.below(200); n > 0; --n)
            delta.push_back(
                static_cast<std::byte>(random.below(3) == 0 ? random.next() & 255u : random.below(9)));
        delta.resize(delta.size() + 8);
        seal(delta);
        REQUIRE(misused(delta) == "");
    }
}

TEST_CASE("a state rejects a delta of another base and reports this reason") {
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
        CHECK(refusal(pair().delta, random_state(pair().s, seed))
                  .starts_with("state delta: hash of the base is 0x"));
    CHECK(refusal(pair().delta, pair().to).find("it is the difference to another state (at byte 28)") !=
          std::string::npos);
}

TEST_CASE("the error of a rejected delta names the place and both values") {
    CHECK(refusal(pair().from.save_portable(), pair().from) ==
          "state delta: not a state delta: it should begin with 'LSDELTA' and a line feed (at byte 0)");
    Bytes delta = pair().delta;
    delta[8] = std::byte{7};
    CHECK(refusal(delta, pair().from) ==
          "state delta: format version 7, this build reads version 1 (at byte 8)");
    delta = pair().delta;
    delta[60] ^= std::byte{1};
    CHECK(refusal(delta, pair().from).starts_with("state delta: damaged: the checksum is 0x"));
    delta = pair().delta;
    delta[20] ^= std::byte{1};
    seal(delta);
    CHECK(refusal(delta, pair().from).find("the fields of some column differ (at byte 20)") !=
          std::string::npos);
    delta = pair().delta;
    delta[36] ^= std::byte{1};
    seal(delta);
    CHECK(refusal(delta, pair().from).find("hash of the result is 0x") != std::string::npos);
    delta = pair().delta;
    delta[44] = std::byte{9}; // rows of the first table
    seal(delta);
    CHECK(refusal(delta, pair().from)
              .find("table 'body' has 9 rows in the delta, but capacity for 8 (at byte 44)") !=
          std::string::npos);
}

TEST_CASE("planted fault: the checks find a reader that trusts the bytes and a reader that leaves a partial "
          "state") {
    const auto trusting = [](State& state, const Bytes& delta) -> Status {
        State next = pair().to; // as if applied, without a check of the hash
        if (delta[50] != pair().delta[50]) next.edit_row(pair().s.velocity, 0).x.raw ^= 1;
        state = next;
        return {};
    };
    CHECK(first_resealed([&](const Bytes& delta) { return misused(delta, trusting); }) ==
          "byte 50: taken, and the state is another");
    const auto half = [](State& state, const Bytes& delta) {
        const Status status = state.apply_delta(delta);
        if (!status.ok()) state.resize(pair().s.contact, 8);
        return status;
    };
    CHECK(first_resealed([&](const Bytes& delta) { return misused(delta, half); }) ==
          "byte 0: refused, but the state changed");
}

} // namespace lockstone::test
