// Curves are at the heights of their values, and outlines have the sizes of their shapes.
#include "lockstone/math/decimal.h"
#include "support/about.h"
#include "view/chart.h"
#include "view/outlines.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace lockstone;
using namespace lockstone::demo;

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// 101 ticks on an area of about 100 columns and 100 px.
Chart chart_of(std::span<const double> values, ChartScale scale = ChartScale::from_zero) {
    return {.title = "",
            .scale = scale,
            .low = 0.001,
            .high = 1000,
            .ticks = 100,
            .curves = {{"", glm::vec4(1, 0, 0, 1), values}}};
}

/// The rectangles of the curve, from left to right.
std::vector<Rect> curve_of(const Chart& chart) {
    Frame frame;
    draw_chart(frame, {}, chart, {0, 0}, {200, 160});
    std::vector<Rect> curve;
    for (const Rect& rect : frame.rects)
        if (rect.colour == chart.curves[0].colour) curve.push_back(rect);
    return curve;
}

glm::vec3 greatest(const std::vector<Edge>& edges) {
    glm::vec3 reach(0);
    for (const auto& [from, to] : edges) reach = glm::max(reach, glm::max(glm::abs(from), glm::abs(to)));
    return reach;
}
bool is_near(const glm::vec3& a, const glm::vec3& b) { return glm::distance(a, b) < 1e-4f; }

} // namespace

TEST_CASE("a chart's axis is linear from zero or logarithmic between its bounds") {
    const Chart linear = chart_of({}), powers = chart_of({}, ChartScale::powers);
    CHECK(height_of(5, linear, 10) == test::about(0.5));
    CHECK(height_of(20, linear, 10) == 1);
    CHECK(height_of(-1, linear, 10) == 0);
    CHECK(height_of(1, powers, 10) == test::about(0.5));
    CHECK(height_of(1e-9, powers, 10) == 0);
    CHECK(height_of(0, powers, 10) == 0);
    CHECK(height_of(none, powers, 10) == 1);
    for (const auto& [value, rounded] :
         {std::pair(0.3, 0.5), {1.0, 1.0}, {7.0, 10.0}, {1200.0, 2000.0}, {0.0, 1.0}})
        CHECK(round_up(value) == test::about(rounded));
    CHECK(format_unit(3186604, "J") == "3.19 MJ");
    CHECK(format_unit(20, "J") == "20 J");
}

TEST_CASE("a curve has no gap where it jumps and ends at its last tick") {
    std::vector<double> values(50, 0.0);
    values.resize(60, 10.0);
    const std::vector<Rect> curve = curve_of(chart_of(values));
    REQUIRE(!curve.empty());
    for (std::size_t i = 1; i < curve.size(); ++i) {
        CHECK(curve[i].position.x == curve[i - 1].position.x + 1);
        CHECK(curve[i].position.y <= curve[i - 1].position.y + curve[i - 1].size.y);
        CHECK(curve[i].position.y + curve[i].size.y >= curve[i - 1].position.y);
    }
    const double share = static_cast<double>(curve.size()) /
                         static_cast<double>(curve_of(chart_of(std::vector<double>(100, 1.0))).size());
    CHECK(share == test::about(0.6, 0.03));
}

TEST_CASE("an outline is as large as its shape") {
    const AssetLibrary assets;
    const auto reach = [&](const Geometry& geometry) {
        return greatest(outline_of({.geometry = geometry}, assets));
    };
    CHECK(is_near(reach(box(0.5_r, 1_r, 2_r)), {0.5f, 1, 2}));
    CHECK(is_near(reach(sphere(0.7_r)), {0.7f, 0.7f, 0.7f}));
    CHECK(is_near(reach(capsule(0.25_r, 0.5_r)), {0.25f, 0.75f, 0.25f}));
    CHECK(is_near(reach(cylinder(0.3_r, 0.9_r)), {0.3f, 0.9f, 0.3f}));
    CHECK(is_near(reach(cone(0.3_r, 0.9_r)), {0.3f, 0.9f, 0.3f}));
    CHECK(outline_of({.geometry = plane()}, assets).empty());
    CHECK(outline_of({.geometry = box(1_r, 1_r, 1_r)}, assets).size() == 12); // no diagonals
}

TEST_CASE("an outline has the position of its shape on the body") {
    const AssetLibrary assets;
    ShapeDef shape{.geometry = sphere(1_r)};
    shape.local.position = {5_r, 0_r, 0_r};
    CHECK(is_near(greatest(outline_of(shape, assets)), {6, 1, 1}));
}
