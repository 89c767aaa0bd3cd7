// A name in the world gives way to panels: it is not drawn where its letters would overlap one.
#include "render/frame.h"

#include <doctest/doctest.h>

#include <array>

using namespace lockstone::demo;

TEST_CASE("a line of text touches a rect exactly where its letters do") {
    const std::array panels{Rect{.position = {100, 50}, .size = {200, 80}, .colour = {}}};
    const glm::vec2 cell(9, 17);
    const auto at = [&](float x, float y, const char* text = "P2") {
        return touches({.text = text, .position = {x, y}}, cell, panels);
    };
    CHECK(at(150, 80)); // within
    CHECK_FALSE(at(100 - 18, 80));
    CHECK(at(100 - 17, 80));
    CHECK_FALSE(at(300, 80));
    CHECK(at(299, 80));
    CHECK_FALSE(at(150, 50 - 17));
    CHECK(at(150, 50 - 16));
    CHECK_FALSE(at(150, 130));
    CHECK(at(150, 129));
    CHECK_FALSE(at(100 - 9, 80, "\u00fc")); // one letter of two bytes
    CHECK_FALSE(touches({.text = "P2", .position = {150, 80}}, cell, {}));
}
