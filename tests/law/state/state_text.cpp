#include "state/leaf_text.h"
#include "support/state_sample.h"

#include <doctest/doctest.h>

#include <limits>

namespace lockstone::test {

TEST_CASE("values print as exact decimals of up to twelve places and are rounded if they have more") {
    constexpr std::int64_t lowest = std::numeric_limits<std::int64_t>::min();
    constexpr std::int64_t highest = std::numeric_limits<std::int64_t>::max();
    CHECK(decimal_text(0, 32) == "0");
    CHECK(decimal_text(-655360, 19) == "-1.25");
    CHECK(decimal_text(1, 1) == "0.5");
    CHECK(decimal_text(lowest, 0) == "-9223372036854775808");
    CHECK(decimal_text(lowest, 63) == "-1");
    CHECK(decimal_text(highest, 0) == "9223372036854775807");
    CHECK(decimal_text(highest, 63) == "1"); // carries through all twelve nines
    CHECK(decimal_text(highest, 32) == "2147483647.999999999767");
    CHECK(decimal_text(1, 12) == "0.000244140625");
    CHECK(decimal_text(1, 13) == "0.000122070313"); // a tie, away from zero
    CHECK(decimal_text(-1, 60) == "0");
    CHECK(decimal_text((std::int64_t{1} << 32) / 3, 32) == "0.333333333256");
    CHECK(decimal_text((std::int64_t{1} << 62) + (std::int64_t{1} << 22), 62) ==
          "1.000000000001"); // 1 + 0.9e-12
}

TEST_CASE("the text of a Real reads back as the same bits") {
    SplitMix random(7);
    for (int i = 0; i < 20000; ++i) {
        const auto raw = static_cast<std::int64_t>(random.next()) >> random.below(60);
        const std::string text = decimal_text(raw, Real::fraction_bits);
        const auto read = parse_decimal<Real>(text);
        CAPTURE(text);
        REQUIRE(read.error == DecimalError::none);
        REQUIRE(read.value.raw == raw);
    }
}

TEST_CASE("a state difference names column and row and field and both values in decimal and raw") {
    const Sample s = make_sample();
    State left = random_state(s, 5, 9, 2, 3);
    left.edit_row(s.velocity, 3).y = Speed::from_raw(-655360);
    left.edit_row(s.manifold, 8).points[1].feature = 40;
    left.edit_row(s.health, 0).luck = -1;
    State right = left;
    CHECK(State::diff(left, right, 10).empty());

    right.edit_row(s.velocity, 3).y = Speed::from_raw(524288);
    right.edit_row(s.manifold, 8).points[1].feature = 41;
    right.edit_row(s.health, 0).luck = 127;
    right.resize(s.tag, 12);
    const auto differences = State::diff(left, right, 10);
    REQUIRE(differences.size() == 4);
    CHECK(to_string(differences[0]) == "row count of tag: 2 (raw 0x2) against 12 (raw 0xc)");
    CHECK(to_string(differences[1]) ==
          "column body.velocity, row 3, y: -1.25 (raw 0xfff60000) against 1 (raw 0x80000)");
    CHECK(to_string(differences[2]) ==
          "column contact.manifold, row 8, points[1].feature: 40 (raw 0x28) against 41 (raw 0x29)");
    CHECK(to_string(differences[3]) ==
          "column game.health, row 0, luck: -1 (raw 0xff) against 127 (raw 0x7f)");
    CHECK(State::diff(left, right, 2).size() == 2);
    CHECK(State::diff(left, right, 0).empty());
}

TEST_CASE("a state dump has one line with every field for each live row") {
    const Sample s = make_sample();
    State state(s.layout);
    CHECK(state.dump().empty());
    state.resize(s.body, 2);
    state.edit_row(s.pose, 1).position.x = 1.5_r;
    state.edit_row(s.health,
                   1) = {.shield = -0.25_r, .points = -7, .bonus = 3, .mood = Mood::alert, .luck = 0};
    CHECK(state.dump() ==
          "body.pose[0] position.x=0 position.y=0 position.z=0 rotation.x=0 rotation.y=0 rotation.z=0 "
          "rotation.w=0\n"
          "body.pose[1] position.x=1.5 position.y=0 position.z=0 rotation.x=0 rotation.y=0 rotation.z=0 "
          "rotation.w=0\n"
          "body.velocity[0] x=0 y=0 z=0\n"
          "body.velocity[1] x=0 y=0 z=0\n"
          "game.health[0] shield=0 points=0 bonus=0 mood=0 luck=0\n"
          "game.health[1] shield=-0.25 points=-7 bonus=3 mood=1 luck=0\n"
          "game.flag[0] value=0\n"
          "game.flag[1] value=0\n");
}

} // namespace lockstone::test
