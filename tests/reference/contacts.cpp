// The thesis' engine uses FCL's contacts, for every shape that FCL has.
#include "reference/scene.h"

#include "lockstone/asset.h"
#include "lockstone/math/math.h"

#include <doctest/doctest.h>

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>

#include <array>

using namespace reference_tests;
using reference::Engine;

namespace {

/// FCL's contact of a box of 1 m at the origin and a ball.
fcl::Contactd ask_fcl(const fcl::Vector3d& ball) {
    const fcl::CollisionObjectd a(std::make_shared<fcl::Boxd>(1, 1, 1));
    const fcl::CollisionObjectd b(std::make_shared<fcl::Sphered>(0.5), fcl::Matrix3d::Identity(), ball);
    fcl::CollisionRequestd request(8, true);
    request.gjk_solver_type = fcl::GST_INDEP;
    fcl::CollisionResultd result;
    fcl::collide(&a, &b, request, result);
    REQUIRE(result.numContacts() == 1);
    return result.getContact(0);
}

AssetBytes flat_mesh() {
    const std::array<Vec3, 4> corners{Vec3{-4_r, 0_r, -4_r}, Vec3{4_r, 0_r, -4_r}, Vec3{4_r, 0_r, 4_r},
                                      Vec3{-4_r, 0_r, 4_r}};
    const std::array<std::array<std::uint32_t, 3>, 2> triangles{{{0, 2, 1}, {0, 3, 2}}};
    return bake_mesh({.vertices = corners, .triangles = triangles}).value();
}

AssetBytes flat_field() {
    const std::vector<Length> heights(81);
    return bake_height_field({.columns = 9, .rows = 9, .spacing = to<Length>(1_r), .heights = heights})
        .value();
}

AssetBytes cube_hull() {
    std::vector<LengthVec3> corners;
    for (int i = 0; i < 8; ++i) {
        const auto side = [&](int bit) { return to<Length>((i & bit) != 0 ? 0.4_r : -0.4_r); };
        corners.push_back({side(1), side(2), side(4)});
    }
    return bake_hull(corners).value();
}

struct Assets {
    std::shared_ptr<AssetLibrary> library = std::make_shared<AssetLibrary>();
    Geometry hull = library->geometry(library->add(cube_hull()).value()).value();
    Geometry mesh = library->geometry(library->add(flat_mesh()).value()).value();
    Geometry field = library->geometry(library->add(flat_field()).value()).value();
};

struct Dropped {
    const char* name;
    Geometry geometry;
    Real height; ///< of the centre above its support
};

std::vector<Dropped> bodies_of(const Assets& assets) {
    return {{"sphere", sphere(0.4_r), 0.4_r},          {"box", box(0.4_r, 0.4_r, 0.4_r), 0.4_r},
            {"capsule", capsule(0.3_r, 0.4_r), 0.7_r}, {"cylinder", cylinder(0.4_r, 0.4_r), 0.4_r},
            {"cone", cone(0.5_r, 0.4_r), 0.4_r},       {"hull", assets.hull, 0.4_r}};
}

/// The height of the body after a second, dropped from 2 cm. It may turn but not sink.
double height_after(const Assets& assets, const Dropped& dropped, const Geometry& ground,
                    const Transform& place, bool box_ground = true) {
    Stage stage({}, assets.library);
    stage.add({.kind = BodyKind::static_, .pose = place}, {.geometry = ground});
    stage.add({.pose = at(0.3_r, dropped.height + 0.02_r, 0.2_r)}, {.geometry = dropped.geometry});
    Engine engine = Engine::create(stage.world, {.box_ground = box_ground}).value();
    for (int i = 0; i < 60; ++i) engine.tick();
    return engine.bodies()[1].pose.position.y - to_double(dropped.height);
}

} // namespace

TEST_CASE("the reference engine has the contacts of FCL") {
    Stage stage(weightless());
    stage.add({}, {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
    stage.add({.pose = at(0.2_r, 0.95_r, 0.1_r)}, {.geometry = sphere(0.5_r)});
    Engine engine = Engine::create(stage.world, strict()).value();
    const reference::Vec ball = engine.bodies()[1].center;
    const fcl::Contactd theirs = ask_fcl({ball.x, ball.y, ball.z});
    engine.tick();
    REQUIRE(engine.contacts().size() == 1);
    const reference::Contact& ours = engine.contacts()[0];
    CHECK(ours.depth == theirs.penetration_depth);
    CHECK(length(ours.point - reference::Vec{theirs.pos.x(), theirs.pos.y(), theirs.pos.z()}) == 0);
    CHECK(length(ours.normal + reference::Vec{theirs.normal.x(), theirs.normal.y(), theirs.normal.z()}) == 0);
}

TEST_CASE(
    "the reference engine has no other contacts: without FCL's contacts a ball falls through the ground") {
    Stage stage;
    stage.ground();
    stage.add({.pose = at(0_r, 1_r, 0_r)}, {.geometry = sphere(0.5_r)});
    for (const bool dropped : {false, true}) {
        reference::Settings settings;
        if (dropped)
            settings.on_contacts = [](std::vector<reference::Contact>& contacts) { contacts.clear(); };
        Engine engine = Engine::create(stage.world, settings).value();
        for (int i = 0; i < 60; ++i) engine.tick();
        CHECK((engine.bodies()[1].center.y < 0) == dropped);
    }
}

TEST_CASE("a plane and a box hold every shape that FCL has") {
    const Assets assets;
    for (const Dropped& dropped : bodies_of(assets)) {
        CAPTURE(dropped.name);
        CHECK(std::abs(height_after(assets, dropped, plane(), Transform::identity())) <= 0.01);
        CHECK(std::abs(height_after(assets, dropped, box(4_r, 1_r, 4_r), at(0_r, -1_r, 0_r))) <= 0.01);
    }
}

TEST_CASE("a mesh and a height field hold every shape that FCL has") {
    const Assets assets;
    for (const Dropped& dropped : bodies_of(assets)) {
        CAPTURE(dropped.name);
        CHECK(std::abs(height_after(assets, dropped, assets.mesh, Transform::identity())) <= 0.01);
        CHECK(std::abs(height_after(assets, dropped, assets.field, at(-4_r, 0_r, -4_r))) <= 0.01);
    }
}

TEST_CASE("a contact with a mesh does not depend on the order in which the two bodies were added") {
    const Assets assets;
    const Transform leaning{{0.3_r, 0.35_r, 0.2_r},
                            from_axis_angle(UnitVec3{unit_one, Unit{}, Unit{}}, 0.3_r)};
    std::array<reference::Vec, 2> pushed{};
    for (const bool mesh_first : {true, false}) {
        Stage stage(weightless(), assets.library);
        const auto add_mesh = [&] { stage.add({.kind = BodyKind::static_}, {.geometry = assets.mesh}); };
        if (mesh_first) add_mesh();
        stage.add({.pose = leaning}, {.geometry = box(0.4_r, 0.4_r, 0.4_r)});
        if (!mesh_first) add_mesh();
        Engine engine = Engine::create(stage.world, strict()).value();
        engine.tick();
        REQUIRE(!engine.contacts().empty());
        const reference::Vec n = engine.contacts()[0].normal;
        pushed[mesh_first] = mesh_first ? n * -1 : n; // in the direction of the box
    }
    CHECK(pushed[0].y >= 1 - 1e-6);
    CHECK(pushed[1].y >= 1 - 1e-6);
}

TEST_CASE("the reference engine rejects features that FCL or the thesis lacks and names the reason") {
    const auto refusal = [](const World& world, const reference::Settings& settings = {}) {
        const Result<Engine> engine = Engine::create(world, settings);
        return engine ? std::string() : engine.error().message;
    };
    Stage rounded_box;
    rounded_box.ground();
    rounded_box.add({}, {.geometry = rounded(box(0.5_r, 0.5_r, 0.5_r), 0.1_r)});
    CHECK(refusal(rounded_box.world) == "body 1: FCL has no rounded box");

    Stage joined;
    const BodyId a = joined.add({}, {}), b = joined.add({.pose = at(2_r, 0_r, 0_r)}, {});
    CHECK(refusal(joined.world).empty());
    joined.world.create_joint(ball_joint(), a, b, {}).value();
    CHECK(refusal(joined.world) == "the thesis' engine has no joints");

    Stage wet;
    wet.world.create_field(wind({1_r, 0_r, 0_r})).value();
    CHECK(refusal(wet.world) == "a fluid is nothing that the thesis' engine has");

    Stage good;
    good.ground();
    CHECK(refusal(good.world, {.position_iterations = 0}) ==
          "position iterations is 0, must be 1 to 1000000");
    CHECK(refusal(good.world, {.velocity_iterations = -3}) ==
          "velocity iterations is -3, must be 1 to 1000000");
    CHECK(refusal(good.world, {.position_epsilon = std::nan("")}).starts_with("position epsilon is"));
}
