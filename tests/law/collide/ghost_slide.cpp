// Bodies that slide over flat meshes and height fields without friction keep their speed and stay on the ground.
#include "support/effort.h"

#include "lockstone/world.h"
#include "oracle/mesh_scenes.h"

using namespace lockstone;
using namespace mesh_scenes;

namespace {

constexpr double speed = 10;           // [m/s]
constexpr double vertical_max = 0.001; // [m/s]
constexpr double slower_max = 0.001;   // [m/s]
constexpr int settle_ticks = 60, slide_ticks = 600;
/// The step through the 16 directions: every second one, all of them with LOCKSTONE_LONG.
int direction_step() { return std::getenv("LOCKSTONE_LONG") != nullptr ? 1 : 2; }

struct Slider {
    const char* name;
    Geometry geometry;
    double height;
    Quat rotation;
};
std::vector<Slider> sliders() {
    const Quat upright = Quat::identity(), lying = oracle::quat_of({0, 0, 1}, 1.5707963267948966);
    return {{"ball", sphere(0.5_r), 0.5, upright},
            {"small ball", sphere(0.05_r), 0.05, upright},
            {"box", box(0.5_r, 0.25_r, 0.4_r), 0.25, upright},
            {"brick", box(0.1_r, 0.03_r, 0.05_r), 0.03, upright},
            {"lying capsule", capsule(0.3_r, 0.5_r), 0.3, lying},
            {"cylinder", cylinder(0.4_r, 0.3_r), 0.3, upright}};
}

/// Adds `soup` as a mesh asset, in world coordinates.
AssetId add_mesh(AssetLibrary& library, const Soup& soup) {
    std::vector<Vec3> vertices;
    for (const D3& v : soup.vertices) vertices.push_back(real(v));
    const Result<AssetId> id = library.add(bake_mesh({.vertices = vertices, .triangles = soup.triangles}));
    if (!id) FAIL(id.error().message);
    return *id;
}

struct Floor {
    AssetId asset;
    Vec3 at;
};

struct Body {
    BodyId id;
    const char* name;
    D3 velocity;
    double vertical = 0, slower = 0, faster = 0;
};

/// Returns a sentence for each slider and direction that stumbled.
std::string slide(AssetLibrary&& library, const std::vector<Floor>& floors, D3 middle) {
    const auto assets = std::make_shared<const AssetLibrary>(std::move(library));
    Result<World> made = World::create({}, {}, assets);
    if (!made) FAIL(made.error().message);
    World& world = *made;
    for (const Floor& floor : floors) {
        const BodyId ground = world
                                  .create_body({.kind = BodyKind::static_,
                                                .pose = {.position = floor.at, .rotation = Quat::identity()}})
                                  .value();
        const Geometry geometry = assets->geometry(floor.asset).value();
        REQUIRE(world.create_shape(ground, {.geometry = geometry, .friction = 0_r}));
    }
    std::vector<Body> bodies;
    for (const Slider& s : sliders())
        for (int direction = 0; direction < 16; direction += direction_step()) {
            const double angle = direction * 0.39269908169872414 + 0.01;
            const D3 way{std::cos(angle), 0, std::sin(angle)};
            const D3 at = middle + way * -50 + D3{0, s.height, 0};
            const Quat turn = oracle::quat_of({0, 1, 0}, 0.37 * direction);
            const BodyId id =
                world.create_body({.pose = {.position = real(at), .rotation = turn * s.rotation}}).value();
            REQUIRE(
                world.create_shape(id, {.geometry = s.geometry, .friction = 0_r, .category = 2, .mask = 1}));
            bodies.push_back({id, s.name, way * speed});
        }
    for (int tick = 0; tick < settle_ticks; ++tick) world.tick();
    for (const Body& body : bodies) REQUIRE(world.set_velocity(body.id, real(body.velocity), Vec3{}));
    for (int tick = 0; tick < slide_ticks; ++tick) {
        world.tick();
        for (Body& body : bodies) {
            const D3 v = oracle::as_double(world.linear_velocity(body.id));
            body.vertical = std::max(body.vertical, std::abs(v.y));
            body.slower = std::max(body.slower, speed - std::hypot(v.x, v.z));
            body.faster = std::max(body.faster, std::hypot(v.x, v.z) - speed);
        }
    }
    std::ostringstream out;
    for (const Body& body : bodies)
        if (body.vertical > vertical_max || body.slower > slower_max || body.faster > slower_max)
            out << body.name << " along " << body.velocity.x << ' ' << body.velocity.z << ": vertical "
                << body.vertical << " m/s, slower by " << body.slower << ", faster by " << body.faster
                << "; ";
    return out.str();
}

double flat(double, double) { return 0; }

} // namespace

TEST_CASE("bodies that slide over flat meshes without friction keep their speed and stay on the ground" *
          doctest::skip(test::is_too_long_here())) {
    {
        AssetLibrary library;
        const AssetId regular = add_mesh(library, grid(-60, -60, 2, 60, 60, 0, 0, flat));
        const std::string stumbles = slide(std::move(library), {{regular, {}}}, {0.1, 0, 0.05});
        CHECK(stumbles == "");
    }
    {
        AssetLibrary library;
        const AssetId irregular = add_mesh(library, grid(-60, -60, 1.5, 80, 80, 0.2, 7, flat));
        const std::string stumbles = slide(std::move(library), {{irregular, {}}}, {0.1, 0, 0.05});
        CHECK(stumbles == "");
    }
}

TEST_CASE("bodies that slide over the seam between two meshes keep their speed and stay on the ground" *
          doctest::skip(test::is_too_long_here())) {
    AssetLibrary library;
    const AssetId left = add_mesh(library, grid(-60, -60, 3, 20, 40, 0.2, 3, flat));
    const AssetId right = add_mesh(library, grid(0, -60, 2, 30, 60, 0.2, 4, flat));
    const std::string stumbles = slide(std::move(library), {{left, {}}, {right, {}}}, {0.1, 0, 0.05});
    CHECK(stumbles == "");
}

TEST_CASE(
    "bodies that slide over flat height fields without friction keep their speed and stay on the ground" *
    doctest::skip(test::is_too_long_here())) {
    AssetLibrary library;
    const std::vector<Length> heights(121 * 121);
    const Result<AssetId> field = library.add(bake_height_field(
        {.columns = 121, .rows = 121, .spacing = Length::from_raw(1 << 24), .heights = heights}));
    REQUIRE(field);
    const std::string stumbles = slide(std::move(library), {{*field, {}}}, {60.1, 0, 60.05});
    CHECK(stumbles == "");
}

TEST_CASE("planted fault: the slide reports a step of two millimetres" *
          doctest::skip(test::is_too_long_here())) {
    AssetLibrary library;
    const AssetId bumpy = add_mesh(library, grid(-60, -60, 1.5, 80, 80, 0.2, 7, [](double x, double) {
                                       return std::abs(x - 15) < 0.8 ? 0.002 : 0.0;
                                   }));
    CHECK(slide(std::move(library), {{bumpy, {}}}, {0.1, 0, 0.05}) != "");
}
