// Drag, wind, and explosions.
#include "support/about.h"
#include "support/random.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double pi_ = 3.14159265358979323846, g = 9.81;

FieldDef air(double linear, double quadratic, Vec3 velocity = {}) {
    FieldDef d = wind(velocity);
    d.drag_linear = real(linear);
    d.drag_quadratic = real(quadratic);
    return d;
}
void run(World& w, int ticks) {
    for (int i = 0; i < ticks; ++i) w.tick();
}
std::string near(double value, double expected, double share) {
    if (std::abs(value - expected) <= share * std::abs(expected)) return {};
    return std::to_string(value) + ", not " + std::to_string(expected);
}

/// Checks the speed after a fall of 20 s: m g = (c1 + c2 v) v A.
std::string terminal_fault(const Geometry& shape, double area, double linear, double quadratic,
                           double scale = 1) {
    World w = made(World::create(small_def()));
    made(w.create_field(air(linear, quadratic)));
    const BodyId b = add(w, {.pose = at(0, 3000, 0), .drag_scale = real(scale)}, {.geometry = shape});
    run(w, 1200);
    const double m = to_double(w.mass(b)), c1 = linear * area, c2 = quadratic * area;
    const double v = c2 == 0 ? m * g / c1 : (-c1 + std::sqrt(c1 * c1 + 4 * c2 * m * g)) / (2 * c2);
    return near(-velocity(w, b)[1], v, 0.005);
}

/// The velocity that a blast at `distance` gives a free ball of 0.25 m.
D3 blast_speed(double distance, Falloff falloff, double radius = 100) {
    World w = made(World::create(weightless()));
    const BodyId b = add(w, {.pose = at(distance, 0, 0)}, {.geometry = sphere(real(0.25))});
    ExplosionDef blast;
    blast.radius = real(radius);
    blast.impulse = Real(5000);
    blast.core = real(0.5);
    blast.falloff = falloff;
    done(w.explode(blast));
    return velocity(w, b);
}
const double ball_mass = 1000 * 4.0 / 3 * pi_ * 0.25 * 0.25 * 0.25;

} // namespace

TEST_CASE("falling bodies reach the speed at which drag balances their weight") {
    CHECK(terminal_fault(sphere(real(0.1)), pi_ * 0.01, 0, 50) == "");
    CHECK(terminal_fault(sphere(real(0.1)), pi_ * 0.01, 400, 0) == "");
    CHECK(terminal_fault(sphere(real(0.1)), pi_ * 0.01, 100, 20) == "");
    CHECK(terminal_fault(box(real(0.3), real(0.1), real(0.2)), 0.24, 0, 40) == "");
    CHECK(terminal_fault(capsule(real(0.1), real(0.2)), pi_ * 0.01, 0, 400) == "");
    CHECK(terminal_fault(cylinder(real(0.2), real(0.05)), pi_ * 0.04, 0, 40) == "");
}

TEST_CASE("planted fault: the check reports that a body with a tenth more drag falls too slowly") {
    CHECK(terminal_fault(sphere(real(0.1)), pi_ * 0.01, 0, 50, 1.1) != "");
    CHECK(terminal_fault(sphere(real(0.1)), pi_ * 0.011, 400, 0) != "");
}

TEST_CASE("wind accelerates free bodies to its own speed and does not move bodies with drag_scale 0") {
    World w = made(World::create(weightless()));
    made(w.create_field(air(50, 10, vec(8, 0, -3))));
    const BodyId leaf = add(w, {.pose = at(0, 0, 0)},
                            {.geometry = box(real(0.2), real(0.02), real(0.2)), .density = Real(50)});
    const BodyId ghost = add(w, {.pose = at(0, 5, 0), .drag_scale = {}}, {.geometry = sphere(real(0.2))});
    run(w, 900);
    CHECK(near(velocity(w, leaf)[0], 8, 0.005) == "");
    CHECK(near(velocity(w, leaf)[2], -3, 0.005) == "");
    CHECK(w.linear_velocity(ghost) == Vec3{});
}

TEST_CASE("wind turns the larger end of a vane to leeward") {
    World w = made(World::create(weightless()));
    made(w.create_field(air(20, 5, vec(10, 0, 0))));
    const BodyId vane =
        add(w, {}, {.geometry = box(real(0.05), real(0.05), real(0.05)), .density = Real(100)});
    made(w.create_shape(
        vane,
        {.geometry = box(real(0.02), real(0.3), real(0.3)), .local = at(0, 0, 1), .density = real(0.05)}));
    JointDef def = hinge_joint();
    def.axis[about_x].friction = real(0.02);
    made(w.create_joint(def, {}, vane, at(0, 0, 0, turned(axis_z, 90)))); // about y
    run(w, 1800);
    const Vec3 points = rotate(w.pose(vane).rotation, vec(0, 0, 1));
    CHECK(to_double(points.x) > 0.98);
}

TEST_CASE("angular drag reduces a spin as exp(-c A / m t)") {
    World w = made(World::create(weightless()));
    FieldDef still = air(0, 0);
    still.drag_angular = Real(200);
    made(w.create_field(still));
    const BodyId b = add(w, {.angular_velocity = vec(0, 5, 0)}, {.geometry = sphere(real(0.25))});
    run(w, 60);
    CHECK(near(spin(w, b)[1], 5 * std::exp(-200 * pi_ * 0.0625 / ball_mass), 0.005) == "");
}

TEST_CASE("wind pushes the part of a body above the water and the current pushes the part below") {
    const auto drift = [](double density) {
        World w = made(World::create(small_def()));
        Region region{.kind = RegionKind::box, .pose = at(0, -4, 0)};
        region.half_extent = vec(500, 4, 500);
        FieldDef sea = water(region);
        sea.velocity = vec(0, 0, 1);
        made(w.create_field(sea));
        made(w.create_field(air(300, 0, vec(1, 0, 0)))); // as strong as the water's drag
        const BodyId b =
            add(w, {}, {.geometry = box(real(1), real(0.25), real(1)), .density = real(density)});
        run(w, 1800);
        return velocity(w, b);
    };
    const D3 deep = drift(950), high = drift(100);
    CHECK(deep[2] > 0.9);
    CHECK(deep[0] < 0.1);
    CHECK(high[0] > 0.3);
    CHECK(high[0] > 3 * deep[0]);
}

TEST_CASE("a light sheet in strong drag does not reverse and gains no energy at any coefficient") {
    for (double c : {1.0, 1e3, 1e6}) {
        World w = made(World::create(weightless()));
        made(w.create_field(air(c, c)));
        const BodyId b = add(w, {.linear_velocity = vec(30, -20, 10), .angular_velocity = vec(3, 8, -5)},
                             {.geometry = box(real(1), real(0.01), real(1)), .density = real(0.01)});
        double last = to_double(w.kinetic_energy());
        for (int t = 0; t < 120; ++t) {
            w.tick();
            const double now = to_double(w.kinetic_energy());
            CHECK(now <= last * 1.0001 + 1e-9);
            last = now;
        }
        CHECK(velocity(w, b)[0] > -0.01);
    }
}

TEST_CASE("a field of acceleration acts only on bodies in its region and of its mask") {
    World w = made(World::create(weightless()));
    FieldDef lift;
    lift.kind = FieldKind::uniform;
    lift.acceleration = vec(0, 4, 0);
    lift.mask = 4;
    lift.region.kind = RegionKind::sphere;
    lift.region.half_extent.x = Real(10);
    made(w.create_field(lift));
    const auto ball = [&](double x, std::uint32_t category) {
        return add(w, {.pose = at(x, 0, 0)}, {.geometry = sphere(real(0.25)), .category = category});
    };
    const BodyId in = ball(0, 5), out = ball(11, 5), other = ball(3, 3);
    run(w, 60);
    CHECK(near(velocity(w, in)[1], 4, 0.001) == "");
    CHECK(w.linear_velocity(out) == Vec3{});
    CHECK(w.linear_velocity(other) == Vec3{});
}

TEST_CASE("a blast gives a ball far or near its impulse per solid angle times pi a^2 / r^2") {
    // A ball in an impulse of j per steradian receives j pi sin^2 of its half angle: an equal expression.
    for (double r : {0.6, 1.0, 2.0, 5.0, 20.0}) {
        const double expected = 5000 * (0.5 / r) * (0.5 / r) * pi_ * 0.0625 / ball_mass;
        CHECK(near(blast_speed(r, Falloff::inverse_square)[0], expected, 0.001 + 1e-5 * r * r) == "");
    }
    CHECK(near(blast_speed(3, Falloff::none)[0], 5000 * pi_ * 0.0625 / ball_mass, 0.001) == "");
    CHECK(near(blast_speed(3.25, Falloff::linear, 6)[0], 0.5 * 5000 * pi_ * 0.0625 / ball_mass, 0.001) == "");
    CHECK(blast_speed(7, Falloff::none, 6)[0] == 0);
}

TEST_CASE(
    "planted fault: the check distinguishes a linear falloff from one with the square of the distance") {
    CHECK(near(blast_speed(2, Falloff::linear, 4)[0], 5000 / 16.0 * pi_ * 0.0625 / ball_mass, 0.001) != "");
}

TEST_CASE("a blast pushes a box by the area of its near side and wakes only the bodies that it hits") {
    World w = made(World::create(drowsy_def()));
    add_floor(w);
    const BodyId near_crate = add_crate(w, at(3, 0.5, 0)), far_crate = add_crate(w, at(20, 0.5, 0));
    const BodyId sensor =
        add(w, {.kind = BodyKind::static_, .pose = at(0, 1, 0)}, {.geometry = sphere(real(1)), .sensor = 1});
    run(w, 120);
    REQUIRE(!w.is_awake(near_crate));
    done(w.explode({.center = vec(0, 0.5, 0), .radius = Real(5), .impulse = Real(1000)}));
    CHECK(w.is_awake(near_crate));
    CHECK(!w.is_awake(far_crate));
    CHECK(!w.is_awake(sensor));
    CHECK(near(velocity(w, near_crate)[0], 1000.0 / 9 / 1000, 0.001) == "");
    CHECK(length(spin(w, near_crate)) < 1e-6);
    done(w.explode({.center = vec(0, 0.5, 0), .radius = Real(5), .impulse = Real(1000), .mask = 2}));
    CHECK(near(velocity(w, near_crate)[0], 1000.0 / 9 / 1000, 0.001) == "");
}

TEST_CASE("the order in which bodies are created changes no effect of water and wind and blasts") {
    const auto after = [](bool reversed) {
        World w = made(World::create(small_def()));
        Region region{.kind = RegionKind::box, .pose = at(0, -4, 0)};
        region.half_extent = vec(60, 4, 60);
        if (reversed) made(w.create_field(wind(vec(3, 0, 1))));
        made(w.create_field(water(region)));
        if (!reversed) made(w.create_field(wind(vec(3, 0, 1))));
        std::vector<Transform> poses(12);
        std::vector<BodyId> ids(12);
        for (std::size_t i = 0; i < 12; ++i) {
            const std::size_t k = reversed ? 11 - i : i;
            const double x = 5.0 * static_cast<double>(k) - 28;
            ids[k] = add(w, {.pose = at(x, 1, 0, turned(axis_x, 17.0 * static_cast<double>(k)))},
                         {.geometry = k % 3 == 0   ? sphere(real(0.5))
                                      : k % 3 == 1 ? box(real(0.7), real(0.3), real(0.4))
                                                   : capsule(real(0.3), real(0.5)),
                          .density = Real(300 + 100 * static_cast<int>(k))});
        }
        for (int t = 0; t < 120; ++t) {
            if (t == 60)
                done(w.explode(
                    {.center = vec(1, -1, 2), .radius = Real(40), .impulse = Real(3000), .core = Real(2)}));
            w.tick();
        }
        for (std::size_t k = 0; k < 12; ++k) poses[k] = w.pose(ids[k]);
        return poses;
    };
    CHECK(after(false) == after(true));
}

TEST_CASE("create_field() rejects a region without the sizes that its kind needs") {
    World w = made(World::create(small_def()));
    FieldDef box_of_nothing = wind({});
    box_of_nothing.region.kind = RegionKind::box;
    const Result<FieldId> field = w.create_field(box_of_nothing);
    REQUIRE(!field);
    CHECK(field.error().message.starts_with("create_field: region.half_extent.x is 0"));
    CHECK(w.field_count() == 0);
}

TEST_CASE("drag is exact for the thickest fluid and the largest plate whose product is beyond the range of a "
          "Real") {
    World w = made(World::create(weightless()));
    FieldDef tar = wind({});
    tar.drag_quadratic = {}, tar.drag_linear = Real(1000000);
    made(w.create_field(tar));
    const BodyId b = add(w, {.linear_velocity = vec(0, 10, 0), .mass = Real(1000000000)},
                         {.geometry = box(real(50), real(0.1), real(50))});
    for (int t = 0; t < 6; ++t) w.tick();
    CHECK(velocity(w, b)[1] == test::about(10 * std::exp(-1.0), 0.04)); // 1e6 * 1e4 / 1e9 = 10 / s
}
