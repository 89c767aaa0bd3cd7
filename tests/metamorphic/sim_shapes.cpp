// Worlds with shapes of every kind, with their assets or without.
#include "support/sim_shapes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

TEST_CASE("a world rejects a state or a shape whose asset it lacks and names the column or the asset") {
    const Zoo zoo = make_zoo();
    const World full = zoo_world(zoo);
    World bare = made(World::create(full.def()));
    const Status status = bare.restore_portable(full.save_portable());
    REQUIRE_FALSE(status);
    CHECK(status.error().message.find("shape_traits.row") != std::string::npos);
    const Result<ShapeId> shape =
        bare.create_shape(made(bare.create_body({})), {.geometry = instance(ShapeKind::hull, zoo.hull)});
    REQUIRE_FALSE(shape);
    CHECK(shape.error().message.find("asset") != std::string::npos);
}

TEST_CASE("another order of added assets and extra assets change no tick") {
    const Zoo zoo = make_zoo();
    AssetLibrary other;
    made(other.add(wave_bytes(9)));
    made(other.add(step_bytes()));
    made(other.add(wave_bytes()));
    made(other.add(gem_bytes()));
    made(other.add(zoo.library->bytes(zoo.table)));
    Zoo shuffled = zoo;
    shuffled.library = std::make_shared<const AssetLibrary>(std::move(other));
    World a = zoo_world(zoo), b = zoo_world(shuffled);
    for (int t = 0; t < 120; ++t) {
        a.tick(), b.tick();
        REQUIRE(difference(a, b) == "");
    }
}

TEST_CASE("a snapshot of a world with a terrain has as many bytes as one without") {
    std::vector<Length> heights(320 * 320);
    for (std::size_t i = 0; i < heights.size(); ++i)
        heights[i] = to<Length>(real(0.01 * static_cast<double>(i % 7)));
    AssetLibrary library;
    const AssetId terrain = made(library.add(bake_height_field({320, 320, to<Length>(1_r), heights})));
    World with =
        made(World::create(small_def(), {}, std::make_shared<const AssetLibrary>(std::move(library))));
    World without = made(World::create(small_def()));
    add(with, {.kind = BodyKind::static_}, {.geometry = instance(ShapeKind::height_field, terrain)});
    add(without, {.kind = BodyKind::static_}, {.geometry = box(10_r, 1_r, 10_r)});
    Image a, b;
    with.save(a), without.save(b);
    CHECK(a.size() == b.size());
    CHECK(with.save_portable().size() == without.save_portable().size());
}
