// Buoyancy: floating depths, righting moments, and still water that only removes energy.
#include "support/about.h"
#include "support/effort.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double pi_ = 3.14159265358979323846, g = 9.81;

/// 40 x 8 x 40 m, its surface at y = 0.
FieldDef pool() {
    Region region{.kind = RegionKind::box, .pose = at(0, -4, 0)};
    region.half_extent = vec(20, 4, 20);
    return water(region);
}
World sea(FieldDef fluid = pool(), WorldDef def = small_def()) {
    World w = made(World::create(def));
    made(w.create_field(fluid));
    return w;
}
BodyId add_floater(World& w, const Geometry& shape, double density, const Transform& pose) {
    return add(w, {.pose = pose}, {.geometry = shape, .density = real(density)});
}
void run(World& w, int ticks) {
    for (int i = 0; i < ticks; ++i) w.tick();
}

/// The depth of a floating ball's lowest point below the surface: (3 - s) s^2 = 4 ratio, s = depth / radius.
double ball_depth(double ratio, double radius) {
    double low = 0, high = 2;
    for (int i = 0; i < 60; ++i) {
        const double s = (low + high) / 2;
        ((3 - s) * s * s < 4 * ratio ? low : high) = s;
    }
    return low * radius;
}

/// Checks the rest depth of a floater's lowest point against Archimedes' law, relative to its depth.
std::string depth_fault(const Geometry& shape, double half_height, double density, double expected) {
    World w = sea();
    const BodyId b = add_floater(w, shape, density, at(0, 0.2, 0));
    run(w, 1800);
    const double depth = half_height - position(w, b)[1];
    if (std::abs(depth - expected) < 0.005 * expected) return {};
    return std::string(name_of(shape.kind)) + " of " + std::to_string(density) +
           " kg/m^3: " + std::to_string(depth) + " m deep, not " + std::to_string(expected);
}

/// Kinetic and potential energy of a box that floats level and is not fully submerged.
double energy_of(const World& w, BodyId b, double half, double mass) {
    const double y = position(w, b)[1], depth = std::clamp(half - y, 0.0, 2 * half);
    const double area = 4 * half * half, over = std::max(-y - half, 0.0);
    // Work against the water: rho g A depth^2 / 2, then with its full weight.
    return to_double(w.kinetic_energy()) + mass * g * y + 1000 * g * area * depth * (depth / 2 + over);
}

/// Drops a crate into a fluid. Returns an error sentence if its energy grows beyond the oscillation of a symplectic
/// step.
std::string energy_fault(const FieldDef& fluid) {
    World w = sea(fluid);
    const double half = 0.5, mass = 400;
    const BodyId b = add_floater(w, box(real(half), real(half), real(half)), 400, at(0, 1.5, 0));
    const double floor = -0.5 * mass * g; // about the energy at the end
    double least = energy_of(w, b, half, mass);
    for (int t = 0; t < 900; ++t) {
        w.tick();
        const double now = energy_of(w, b, half, mass);
        if (now > least + 0.01 * (least - floor) + 1)
            return "tick " + std::to_string(t) + ": " + std::to_string(now - least) + " J more";
        least = std::min(least, now);
    }
    return {};
}

double tilt_of(const World& w, BodyId b) {
    return std::acos(std::min(1.0, to_double(rotate(w.pose(b).rotation, vec(0, 1, 0)).y)));
}

} // namespace

TEST_CASE("boxes and balls and cylinders float at the depth of Archimedes' law" *
          doctest::skip(lockstone::test::is_small_sample())) {
    for (double density : {100.0, 500.0, 900.0}) {
        const double ratio = density / 1000;
        // Flat enough to float level at any density.
        CHECK(depth_fault(box(real(1), real(0.2), real(1)), 0.2, density, 0.4 * ratio) == "");
        CHECK(depth_fault(sphere(real(0.5)), 0.5, density, ball_depth(ratio, 0.5)) == "");
        CHECK(depth_fault(cylinder(real(1), real(0.2)), 0.2, density, 0.4 * ratio) == "");
    }
    CHECK(depth_fault(rounded(box(real(0.9), real(0.1), real(0.9)), real(0.1)), 0.2, 500, 0.2) == "");
}

TEST_CASE(
    "planted fault: the check reports the wrong depth of a box in brine and of a ball of another density") {
    World w = sea([] {
        FieldDef d = pool();
        d.density = Real(1030);
        return d;
    }());
    const BodyId b = add_floater(w, box(real(1), real(0.2), real(1)), 500, at(0, 0, 0));
    run(w, 1800);
    CHECK(std::abs(0.2 - position(w, b)[1] - 0.2) > 0.005 * 0.2);
    CHECK(depth_fault(sphere(real(0.5)), 0.5, 500, ball_depth(0.51, 0.5)) != "");
}

TEST_CASE("light bodies rise and heavy bodies sink in water by the weight of the water that they displace") {
    for (double density : {500.0, 2000.0}) {
        FieldDef still = pool();
        still.drag_linear = still.drag_quadratic = still.drag_angular = {};
        World w = sea(still);
        const BodyId b = add_floater(w, sphere(real(0.25)), density, at(0, -4, 0));
        run(w, 30);
        CHECK(velocity(w, b)[1] == test::about((1000 / density - 1) * g * 0.5, 0.001));
    }
}

TEST_CASE("a raft bobs with the period 2 pi sqrt(draught / g)") {
    FieldDef still = pool();
    still.drag_linear = still.drag_quadratic = still.drag_angular = {};
    World w = sea(still);
    const BodyId b = add_floater(w, box(real(2), real(0.25), real(2)), 500, at(0, 0.05, 0));
    double last = 0.05, first = -1, crossing = -1;
    int count = 0;
    for (int t = 1; t < 900; ++t) {
        w.tick();
        const double y = position(w, b)[1];
        if (last < 0 && y >= 0) {
            crossing = t - y / (y - last);
            if (first < 0)
                first = crossing;
            else
                ++count;
        }
        last = y;
    }
    REQUIRE(count > 5);
    CHECK((crossing - first) / count / 60 == test::about(2 * pi_ * std::sqrt(0.25 / g), 0.005));
}

TEST_CASE("a tilted raft turns upright and a pencil on its end falls over and a boat with a low load stays "
          "upright") {
    World w = sea();
    const BodyId raft =
        add_floater(w, box(real(1), real(0.2), real(1)), 400, at(-6, 0, 0, turned(axis_z, 25)));
    const BodyId pencil = add_floater(w, cylinder(real(0.2), real(1)), 500, at(0, 0, 0, turned(axis_z, 3)));
    const BodyId boat =
        add_floater(w, box(real(0.5), real(0.5), real(1)), 200, at(6, 0, 0, turned(axis_z, 20)));
    made(w.create_shape(boat, {.geometry = box(real(0.4), real(0.05), real(0.8)),
                               .local = at(0, -0.44, 0),
                               .density = Real(3000)}));
    run(w, 1800);
    CHECK(tilt_of(w, raft) < 0.01);
    CHECK(std::abs(tilt_of(w, pencil) - pi_ / 2) < 0.02);
    CHECK(tilt_of(w, boat) < 0.02);
}

TEST_CASE("the energy of a floating body only falls in still water") { CHECK(energy_fault(pool()) == ""); }

TEST_CASE("planted fault: the check reports the energy that a body gains in water that flows upwards") {
    FieldDef fountain = pool();
    fountain.velocity = vec(0, 6, 0);
    CHECK(energy_fault(fountain) != "");
}

TEST_CASE(
    "a floating body at rest sleeps and wakes when the water is destroyed or rises or when wind starts") {
    for (int what = 0; what < 3; ++what) {
        World w = made(World::create(drowsy_def()));
        const FieldId field = made(w.create_field(pool()));
        const BodyId b = add_floater(w, box(real(1), real(0.2), real(1)), 500, at(0, 0, 0));
        int ticks = 0;
        while (w.is_awake(b) && ticks < 600) w.tick(), ++ticks;
        REQUIRE(!w.is_awake(b));
        run(w, 10);
        if (what == 0) done(w.destroy(field));
        if (what == 1) {
            FieldDef high = pool();
            high.region.pose = at(0, -3.5, 0);
            done(w.set_field(field, high));
        }
        if (what == 2) made(w.create_field(wind(vec(20, 0, 0))));
        run(w, 30);
        CHECK(w.is_awake(b));
        const D3 v = velocity(w, b);
        CHECK((what == 0 ? v[1] < -1 : what == 1 ? v[1] > 0.1 : v[0] > 0.01));
    }
}

TEST_CASE("water has no effect on bodies outside its mask or its region or with enable_fields 0") {
    World w = sea([] {
        FieldDef d = pool();
        d.mask = 2;
        return d;
    }());
    const auto ball = [&](const BodyDef& def, std::uint32_t category) {
        return add(w, def, {.geometry = sphere(real(0.25)), .density = Real(500), .category = category});
    };
    const BodyId wet = ball({.pose = at(0, -2, 0)}, 2), other = ball({.pose = at(2, -2, 0)}, 1);
    const BodyId off = ball({.pose = at(4, -2, 0), .enable_fields = 0}, 2),
                 outside = ball({.pose = at(21, -2, 0)}, 2);
    run(w, 30);
    CHECK(velocity(w, wet)[1] > 0.5);
    for (BodyId dry : {other, off, outside}) CHECK(velocity(w, dry)[1] == test::about(-g / 2, 0.001));
}

TEST_CASE("a compound and a hull float like the box of their form") {
    std::vector<LengthVec3> corners;
    for (unsigned i = 0; i < 8; ++i)
        corners.push_back(to<Length>(vec(i & 1u ? 1 : -1, i & 2u ? 0.2 : -0.2, i & 4u ? 1 : -1)));
    AssetLibrary library;
    const AssetId hull = library.add(bake_hull(corners)).value();
    const std::vector<CompoundPart> parts{{box(real(0.5), real(0.2), real(1)), at(-0.5, 0, 0)},
                                          {box(real(0.5), real(0.2), real(1)), at(0.5, 0, 0)}};
    const AssetId compound = library.add(bake_compound(parts)).value();
    World w = made(World::create(small_def(), {}, std::make_shared<const AssetLibrary>(std::move(library))));
    made(w.create_field(pool()));
    const BodyId a = add_floater(w, instance(ShapeKind::hull, hull), 300, at(-3, 0.1, 0, turned(axis_z, 10)));
    const BodyId b =
        add_floater(w, instance(ShapeKind::compound, compound), 300, at(3, 0.1, 0, turned(axis_z, 10)));
    run(w, 1800);
    for (BodyId body : {a, b}) {
        CHECK(0.2 - position(w, body)[1] == test::about(0.12, 0.005));
        CHECK(tilt_of(w, body) < 0.01);
    }
}

TEST_CASE(
    "cubes of 22 to 28 m with half the density of water float half submerged at any size of their volume") {
    for (int i = 0; i < 12; ++i) {
        const double half = 11 + i * 0.25;
        Region region{.kind = RegionKind::box, .pose = at(0, -50, 0)};
        region.half_extent = vec(100, 50, 100);
        World w = sea(water(region));
        const BodyId b = add_floater(w, box(real(half), real(half), real(half)), 500, at(0, 0, 0));
        run(w, 120);
        INFO("half an edge: ", half, " m");
        CHECK(std::abs(position(w, b)[1]) < 0.01);
    }
}
