// The deviation check detects changes: each measure with its planted fault.
#include "cook/cook.h"
#include "cook/deviation.h"
#include "lockstone/math/convert.h"
#include "support/about.h"
#include "support/cook_models.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::cook;
using namespace cook_models;

namespace {

constexpr double rounding = 1e-7; ///< [m] a Length is rounded by 3e-8 m along each axis

Convex hull_of(const Soup& soup) { return convex_hull(soup.vertices).value(); }

} // namespace

TEST_CASE("the deviation of a hull from itself is zero or the distance by which a corner was moved") {
    const Soup cube = box({-1, -1, -1}, {1, 1, 1});
    const Result<Deviation> same = deviation_of_hulls(hull_of(cube), hull_of(cube));
    REQUIRE(same.ok());
    CHECK(same->largest() == 0);
    Soup moved = cube;
    moved.vertices[3].y += 0.01;
    const Result<Deviation> out = deviation_of_hulls(hull_of(cube), hull_of(moved));
    REQUIRE(out.ok());
    CHECK(out->result_to_source == test::about(0.01));
    moved.vertices[3].y -= 0.02;
    const Result<Deviation> in = deviation_of_hulls(hull_of(cube), hull_of(moved));
    REQUIRE(in.ok());
    CHECK(in->source_to_result > 0.005);
}

TEST_CASE("the deviation of parts from their solid is zero or the distance by which a corner was moved") {
    const Soup el = bracket();
    const Surface surface(el);
    std::vector<Convex> parts{hull_of(box({0, 0, 0}, {2, 1, 1})), hull_of(box({0, 1, 0}, {1, 3, 1}))};
    const Result<Deviation> same = deviation_of_solids(el, surface, parts);
    REQUIRE(same.ok());
    CHECK(same->largest() < 1e-12);
    Soup wide = box({0, 1, 0}, {1, 3, 1});
    wide.vertices[7].x += 0.05;
    parts[1] = hull_of(wide);
    CHECK(deviation_of_solids(el, surface, parts).value().result_to_source == test::about(0.05));
    parts.pop_back();
    CHECK(deviation_of_solids(el, surface, parts).value().source_to_result == test::about(2));
    // the hull fills the notch of the L
    CHECK(deviation_of_solids(el, surface, {hull_of(el)}).value().result_to_source > 0.4);
}

TEST_CASE("the deviation of a surface from itself is zero and grows when a vertex is moved or triangles are "
          "removed") {
    const Soup ground = hill(20);
    const Surface surface(ground);
    CHECK(deviation_of_surfaces(ground, surface, ground).value().largest() < 1e-12);
    CHECK(deviation_from_above(ground, surface, ground).value().largest() < 1e-12);
    Soup moved = ground;
    moved.vertices[217].y += 0.3;
    CHECK(deviation_of_surfaces(ground, surface, moved).value().largest() > 0.1);
    CHECK(deviation_from_above(ground, surface, moved).value().largest() > 0.1);
    Soup holed = ground;
    holed.triangles.erase(holed.triangles.begin() + 300, holed.triangles.begin() + 308);
    CHECK(deviation_of_surfaces(ground, surface, holed).value().source_to_result > 0.1);
}

TEST_CASE("a cooked hull equals the model's hull up to rounding and its gap measures concavity") {
    const Result<Cooked> cube = cook::cook(box({-1, -2, -3}, {1, 2, 3}), {});
    REQUIRE(cube.ok());
    CHECK(cube->kind == ShapeKind::hull);
    CHECK(cube->vertices == 8);
    CHECK(cube->deviation < rounding);
    CHECK(cube->gap < rounding);
    const Result<Cooked> el = cook::cook(bracket(), {});
    REQUIRE(el.ok());
    CHECK(el->deviation < rounding);
    CHECK(el->gap > 0.3);
}

TEST_CASE("a cooked compound matches a concave model that its hull does not match") {
    const Result<Cooked> el = cook::cook(bracket(), {.as = Wanted::convex});
    REQUIRE(el.ok());
    CHECK(el->kind == ShapeKind::compound);
    CHECK(el->parts == 2);
    CHECK(el->assets.size() == 3);
    CHECK(el->deviation < rounding);
    AssetLibrary library;
    const Result<AssetId> id = library.add(encode_assets(el->assets));
    REQUIRE(id.ok());
    CHECK(*id == el->id);
    CHECK(library.geometry(*id)->kind == ShapeKind::compound);
}

TEST_CASE("a cooked mesh and a height field with samples at the vertices equal the model up to rounding") {
    const Soup ground = hill(16);
    const Result<Cooked> mesh = cook::cook(ground, {.as = Wanted::mesh});
    REQUIRE(mesh.ok());
    CHECK(mesh->kind == ShapeKind::mesh);
    CHECK(mesh->triangles == 2 * 16 * 16);
    CHECK(mesh->deviation < rounding);
    const Result<Cooked> field = cook::cook(ground, {.as = Wanted::height_field, .spacing = 1});
    REQUIRE(field.ok());
    CHECK(field->kind == ShapeKind::height_field);
    CHECK(field->vertices == 17 * 17);
    CHECK(field->deviation < rounding);
    const Result<Cooked> coarse = cook::cook(ground, {.as = Wanted::height_field, .spacing = 4});
    REQUIRE(coarse.ok());
    CHECK(coarse->deviation > 0.1);
    const Result<Cooked> by_itself = cook::cook(ground, {.as = Wanted::height_field, .deviation = 0.05});
    REQUIRE(by_itself.ok());
    CHECK(by_itself->good());
}

TEST_CASE("cook() applies the scale and the up axis before all other steps") {
    const Result<Cooked> big = cook::cook(box({0, 0, 0}, {100, 200, 300}), {.scale = 0.01, .z_up = true});
    REQUIRE(big.ok());
    AssetLibrary library;
    const Result<AssetId> id = library.add(encode_assets(big->assets));
    REQUIRE(id.ok());
    Box box;
    for (const Point& p : to_soup(triangulate(library.geometry(*id).value(), library)).vertices) box.add(p);
    CHECK(box.upper.y == test::about(3));
    CHECK(box.lower.z == test::about(-2));
}

TEST_CASE("cook() rejects a model that no asset can hold and its error names the reason") {
    const auto refused = [](const Soup& model, const CookOptions& options, const char* words) {
        const Result<Cooked> made = cook::cook(model, options);
        REQUIRE_FALSE(made.ok());
        CAPTURE(made.error().message);
        CHECK(made.error().message.find(words) != std::string::npos);
    };
    refused({}, {}, "no triangle");
    refused(hill(1), {.scale = 1e-7}, "");
    refused(box({0, 0, 0}, {1, 1, 1}), {.scale = 1e6}, "--scale");
    refused(box({0, 0, 0}, {1, 1, 1}), {.scale = 500}, "within 100 m");
    refused(hill(10), {.as = Wanted::height_field, .scale = 100}, "");
    refused(box({0, 0, 0}, {1, 0.001, 1}), {}, "");
    Soup bad = box({0, 0, 0}, {1, 1, 1});
    bad.triangles[5][1] = 99;
    refused(bad, {.as = Wanted::mesh}, "triangle 5 names vertex 99 of 8");
    bad = box({0, 0, 0}, {1, 1, 1});
    bad.vertices[2].y = std::numeric_limits<double>::quiet_NaN();
    refused(bad, {}, "vertex 2 is not a finite point");
}

TEST_CASE("a library rejects an asset set in which any byte is changed or the end is missing") {
    const Result<Cooked> made = cook::cook(bracket(), {.as = Wanted::convex});
    REQUIRE(made.ok());
    const AssetBytes good = encode_assets(made->assets);
    for (std::size_t at = 0; at < good.size(); ++at) {
        AssetBytes bad = good;
        bad[at] ^= std::byte{0x10};
        AssetLibrary library;
        const Result<AssetId> id = library.add(bad);
        if (id.ok()) FAIL_CHECK("byte ", at, " was changed and nobody noticed");
        CHECK(library.ids().empty()); // the hulls before the changed asset are removed again
    }
    for (const std::size_t length : {std::size_t{0}, std::size_t{9}, good.size() / 2, good.size() - 1}) {
        AssetLibrary library;
        CHECK_FALSE(library.add(std::span(good).first(length)).ok());
    }
}
