// Soundness of models, the notes and refusals of cooking, its defaults, and files that hold triangle strips.
#include "cook/cook.h"
#include "cook/decompose.h"
#include "cook/read/ply_strips.h"
#include "cook/read/read_model.h"
#include "cook/soundness.h"
#include "support/about.h"
#include "support/cook_models.h"
#include "support/effort.h"

#include <doctest/doctest.h>

#include <ctime>
#include <sstream>

using namespace lockstone;
using namespace lockstone::cook;
using namespace cook_models;

namespace {

Soup turned_inside_out(Soup soup) {
    for (Indices& t : soup.triangles) std::swap(t[1], t[2]);
    return soup;
}

/// The notes of the cooked assets, as one text.
std::string notes_of(const Soup& model, const CookOptions& options) {
    const Result<Cooked> made = cook::cook(model, options);
    if (!made) return "refused: " + made.error().message;
    std::string all;
    for (const std::string& note : made->notes) all += note + "\n";
    return all;
}

bool holds(const std::string& text, const char* words) { return text.find(words) != std::string::npos; }

/// A strip of four corners, a restart, and a strip of five.
std::string strip_file(const std::string& indices) {
    return "ply\nformat ascii 1.0\ncomment of a scan\nelement vertex 5\nproperty float x\nproperty float "
           "y\nproperty float z\n"
           "property uchar confidence\nelement tristrips 1\nproperty list int int "
           "vertex_indices\nend_header\n"
           "0 0 0 9\n1 0 0 9\n0 1 0 9\n1 1 0 9\n0 2 1 9\n" +
           indices + "\n";
}

Result<Soup> read_strips(const std::string& file) {
    std::istringstream in(file);
    return read_ply_strips(in).value();
}

} // namespace

TEST_CASE("a closed surface is sound but an open or inside-out surface or one with disputed edges is not") {
    const Soup slab = box({0, 0, 0}, {1, 2, 3});
    CHECK(soundness_of(slab).sound());
    CHECK(soundness_of(slab).volume == test::about(6));
    CHECK(soundness_of(turned_inside_out(slab)).volume == test::about(-6));
    CHECK_FALSE(soundness_of(turned_inside_out(slab)).sound());
    Soup open = slab;
    open.triangles.pop_back();
    CHECK(soundness_of(open).edges_open == 3);
    Soup disputed = slab;
    std::swap(disputed.triangles[0][1], disputed.triangles[0][2]);
    CHECK(soundness_of(disputed).edges_disputed == 3);
    CHECK(soundness_of(disputed).closed());
}

TEST_CASE("a point in the overlap of two solids is inside and each solid becomes one part") {
    Soup two = box({0, 0, 0}, {2, 1, 1});
    two.append(box({1, -1, 0}, {1.5, 2, 1}));
    CHECK(components_of(two).size() == 2);
    const Surface surface(two);
    CHECK(surface.contains({1.2, 0.5, 0.5})); // four crossings along each axis
    CHECK_FALSE(surface.contains({0.5, 1.5, 0.5}));
    const Result<Cooked> made = cook::cook(two, {.as = Wanted::convex});
    REQUIRE(made.ok());
    CHECK(made->parts == 2);
    CHECK(made->deviation < 1e-7);
}

TEST_CASE("coarsened() keeps the triangle limit and its vertices lie on the original triangles") {
    const Soup ring = compacted(welded(torus(1, 0.3, 120, 40)));
    const Soup few = coarsened(ring, 2'000);
    CHECK(few.triangles.size() <= 2'000);
    CHECK(few.triangles.size() > 500);
    const Surface surface(ring);
    for (const Point& p : few.vertices) CHECK(surface.distance(p) < 1e-9);
    CHECK(coarsened(ring, 9'600).triangles == ring.triangles);
}

TEST_CASE("a note reports a slab that is inside out and --flip corrects it") {
    const Soup slab = box({0, 0, 0}, {1, 0.2, 1});
    CHECK(notes_of(slab, {.as = Wanted::mesh}).empty());
    CHECK(holds(notes_of(turned_inside_out(slab), {.as = Wanted::mesh}), "(--flip"));
    CHECK(notes_of(turned_inside_out(slab), {.as = Wanted::mesh, .flip = true}).empty());
    CHECK(notes_of(turned_inside_out(slab), {.as = Wanted::mesh, .two_sided = true}).empty());
    Soup disputed = slab;
    std::swap(disputed.triangles[0][1], disputed.triangles[0][2]);
    CHECK(holds(notes_of(disputed, {.as = Wanted::mesh}), "(--two-sided"));
}

TEST_CASE("a note reports a hull that is lighter than a body may be") {
    CHECK(holds(notes_of(box({0, 0, 0}, {0.006, 0.006, 0.006}), {}), "0.22 g"));
    CHECK(notes_of(box({0, 0, 0}, {0.011, 0.011, 0.011}), {}).empty());
}

TEST_CASE("a cooked ball has as many corners as its deviation requires or as corners_max allows") {
    Soup soup;
    soup.vertices = ball(1, 200);
    soup.triangles = convex_hull(soup.vertices)->surface.triangles;
    soup.vertices = convex_hull(soup.vertices)->surface.vertices;
    const Result<Cooked> free = cook::cook(soup, {});
    REQUIRE(free.ok());
    CHECK(free->deviation <= free->deviation_aimed);
    CHECK(free->vertices > 64);
    const Result<Cooked> few = cook::cook(soup, {.corners_max = 40});
    REQUIRE(few.ok());
    CHECK(few->vertices == 40);
    CHECK(few->deviation > few->deviation_aimed);
    CHECK(few->good()); // within a fifth of its size
    const Result<Cooked> parts = cook::cook(soup, {.as = Wanted::convex});
    REQUIRE(parts.ok());
    CHECK(parts->deviation <= parts->deviation_aimed);
}

TEST_CASE("cook() splits a model of 60000 triangles into convex parts within ten seconds of processor time" *
          doctest::skip(test::is_too_long_here())) {
    const std::clock_t begun = std::clock();
    const Result<Cooked> made =
        cook::cook(torus(1, 0.3, 300, 100), {.as = Wanted::convex}); // 60,000 triangles
    CHECK(static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC < 10);
    REQUIRE(made.ok());
    CHECK(made->parts <= 32);
    CHECK(made->good());
}

TEST_CASE("the search for excess space finds a slot that is narrower than the distance between samples") {
    Soup soup = box({-1, -1, -1}, {1, 0, 1});
    soup.append(box({-1, 0.05, -1}, {1, 1, 1}));
    const Result<Convex> hull = convex_hull(soup.vertices);
    REQUIRE(hull.ok());
    const double found = excess(*hull, Surface(soup), 0);
    CHECK(found > 0.01);
    CHECK(found <= 0.025);
}

TEST_CASE("the error of cook() names the command-line flag that helps") {
    const auto refusal = [](const Soup& model, const CookOptions& options) {
        const Result<Cooked> made = cook::cook(model, options);
        return made ? "made" : made.error().message;
    };
    Soup wall{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 2, 0}}, {{0, 1, 2}, {0, 2, 3}, {2, 4, 3}}};
    for (const Wanted as : {Wanted::hull, Wanted::convex})
        CHECK(holds(refusal(wall, {.as = as}), "--as mesh --two-sided"));
    CHECK(holds(refusal(wall, {.as = Wanted::height_field}), "--z-up"));
    for (const Wanted as : {Wanted::hull, Wanted::convex})
        CHECK(holds(refusal(box({0, 0, 0}, {0.004, 1, 1}), {.as = as}), "--scale"));
    CHECK(holds(refusal(box({0, 0, 0}, {9000, 1, 1}), {.as = Wanted::mesh}), "--scale"));
}

TEST_CASE("the PLY reader reads all triangles of strips with restarts") {
    const Result<Soup> soup = read_strips(strip_file("9 0 1 2 3 -1 2 3 4 -1"));
    REQUIRE(soup.ok());
    CHECK(soup->vertices.size() == 5);
    CHECK(soup->triangles == std::vector<Indices>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}});
    CHECK_FALSE(soundness_of(*soup).edges_disputed > 0);
    CHECK(holds(read_strips(strip_file("9 0 1 2")).error().message, "ends within"));
    CHECK(holds(read_strips(strip_file("2 0 1")).error().message, "no triangles"));
    std::istringstream faces("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int "
                             "vertex_indices\nend_header\n3 0 1 2\n");
    CHECK_FALSE(read_ply_strips(faces).has_value());
}

TEST_CASE("the PLY reader reads triangle strips in either byte order") {
    const std::string head =
        "element vertex 3\nproperty float x\nproperty float y\nproperty double z\nelement tristrips 1\n"
        "property list uchar short vertex_indices\nend_header\n";
    const auto file = [&](bool is_big) {
        std::string out = std::string("ply\nformat ") +
                          (is_big ? "binary_big_endian" : "binary_little_endian") + " 1.0\n" + head;
        const auto put = [&](auto value) {
            char raw[sizeof value];
            std::memcpy(raw, &value, sizeof value);
            if (is_big) std::reverse(raw, raw + sizeof value);
            out.append(raw, sizeof value);
        };
        for (const Point& p : {Point{0, 0, 0.5}, Point{1, 0, -2}, Point{0, 3, 0}}) {
            put(static_cast<float>(p.x)), put(static_cast<float>(p.y)), put(p.z);
        }
        put(std::uint8_t{3});
        for (std::int16_t i = 0; i < 3; ++i) put(i);
        return out;
    };
    for (const bool is_big : {false, true}) {
        const Result<Soup> soup = read_strips(file(is_big));
        REQUIRE(soup.ok());
        CHECK(soup->vertices == std::vector<Point>{{0, 0, 0.5}, {1, 0, -2}, {0, 3, 0}});
        CHECK(soup->triangles == std::vector<Indices>{{0, 1, 2}});
    }
}

TEST_CASE("the OFF reader skips comments between faces") {
    const std::string file = "# by a tool\nOFF\n4 4 0\n# corners\n\n0 0 0 # origin\n1 0 0\n0 1 0\n0 0 1\n# 4 "
                             "facets\n# -----\n\n3 0 2 1\n3 0 1 3\n"
                             "3 0 3 2\n\n3 1 2 3\n# End of OFF\n";
    const Result<Soup> soup = read_model(std::as_bytes(std::span(file)), "off");
    REQUIRE(soup.ok());
    CHECK(soundness_of(compacted(welded(*soup))).sound());
}
