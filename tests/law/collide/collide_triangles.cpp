// Contacts with meshes and height fields, scene by scene.
#include "law/collide/sunken.h"
#include "oracle/mesh_scenes.h"

#include <cmath>
#include <cstring>

using namespace lockstone;
using namespace mesh_scenes;
using oracle::quat_of;

namespace {

const Length margin = as_fixed<Length>(0.02);
constexpr double quarter = 1.5707963267948966;

collide::Manifolds contacts(const Owned& a, const Geometry& b, D3 at, Quat rotation = Quat::identity()) {
    collide::NarrowScratch scratch;
    collide::Manifolds m;
    collide::collide(a.solid, primitive(b), pose_at(at, rotation), margin, scratch, m);
    return m;
}

std::string show(const collide::Manifolds& m) {
    std::ostringstream out;
    for (std::uint32_t i = 0; i < m.count; ++i) {
        const D3 n = oracle::as_double(m.items[i].normal);
        out << "normal " << n.x << ' ' << n.y << ' ' << n.z << ':';
        for (std::uint32_t k = 0; k < m.items[i].count; ++k) {
            const D3 p = oracle::as_double(m.items[i].points[k].position);
            out << " [" << p.x << ' ' << p.y << ' ' << p.z << " s "
                << oracle::as_double(m.items[i].points[k].separation) << "]";
        }
        out << "; ";
    }
    return out.str();
}

bool is_normal(const collide::Manifold& m, D3 n, double tolerance = 1e-6) {
    return oracle::norm(oracle::as_double(m.normal) - n * (1 / oracle::norm(n))) < tolerance;
}
double separation(const collide::Manifold& m, std::uint32_t k = 0) {
    return oracle::as_double(m.points[k].separation);
}
/// Returns whether there is one manifold with this normal, whose points all have this separation.
bool is_only(const collide::Manifolds& m, D3 normal, double gap, std::uint32_t points,
             double tolerance = 1e-6) {
    bool good = m.count == 1 && is_normal(m.items[0], normal, tolerance) && m.items[0].count == points;
    for (std::uint32_t k = 0; good && k < points; ++k)
        good = std::abs(separation(m.items[0], k) - gap) < tolerance;
    return good;
}

/// A cone of `sides` triangles with its tip at the origin.
Soup spike(int sides, double radius, double height) {
    Soup s;
    const auto rim = [&](int k) {
        const double angle = 6.283185307179586 * k / sides;
        return D3{radius * std::cos(angle), -height, radius * std::sin(angle)};
    };
    for (int k = 0; k < sides; ++k) s.add({0, 0, 0}, rim(k + 1), rim(k));
    return s;
}
/// A roof: its ridge lies along z through the origin, and both sides fall with this slope.
Soup ridge(double slope, double width = 5) {
    Soup s;
    s.add({0, 0, -5}, {-width, -slope * width, -5}, {-width, -slope * width, 5}, {0, 0, 5});
    s.add({0, 0, -5}, {0, 0, 5}, {width, -slope * width, 5}, {width, -slope * width, -5});
    return s;
}
Soup block(D3 low, D3 high) {
    Soup s;
    for (int axis = 0; axis < 3; ++axis)
        for (const bool top : {false, true}) {
            D3 corner[4];
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            for (int k = 0; k < 4; ++k) {
                corner[k][axis] = top ? high[axis] : low[axis];
                corner[k][u] = (k == 1 || k == 2) == top ? high[u] : low[u];
                corner[k][v] = k >= 2 ? high[v] : low[v];
            }
            if (top)
                s.add(corner[0], corner[1], corner[2], corner[3]);
            else
                s.add(corner[0], corner[1], corner[2], corner[3]);
        }
    return s;
}

} // namespace

TEST_CASE("a ball touches a spike of twelve triangles in one point from any side of its cone") {
    const Owned tip = mesh(spike(12, 1, 2));
    CHECK(is_only(contacts(tip, sphere(0.5_r), {0, 0.499, 0}), {0, 1, 0}, -0.001, 1));
    oracle::RandomReal random(5);
    for (int i = 0; i < 300; ++i) {
        const double lean = random.uniform(0, 0.4), turn = random.uniform(0, 6.2831853);
        const D3 n{std::sin(lean) * std::cos(turn), std::cos(lean), std::sin(lean) * std::sin(turn)};
        const collide::Manifolds m = contacts(tip, sphere(0.5_r), n * 0.503);
        INFO("leaning by ", lean, " at ", turn, ": ", show(m));
        CHECK(is_only(m, n, 0.003, 1));
    }
}

TEST_CASE("the contact of a box on a spike has the normal of the box's face") {
    const Owned tip = mesh(spike(8, 1, 2));
    for (const double gap : {0.004, -0.0003, -0.004}) {
        const collide::Manifolds m = contacts(tip, box(0.5_r, 0.5_r, 0.5_r), {0.1, 0.5 + gap, 0.05});
        INFO("gap ", gap, ": ", show(m));
        CHECK(is_only(m, {0, 1, 0}, gap, 1));
        const Quat tilted = quat_of({0, 0, 1}, 0.2);
        const D3 n{-std::sin(0.2), std::cos(0.2), 0};
        const collide::Manifolds t = contacts(tip, box(0.5_r, 0.5_r, 0.5_r), n * (0.5 + gap), tilted);
        INFO("tilted: ", show(t));
        CHECK(is_only(t, n, gap, 1));
    }
}

TEST_CASE("a box on a ridge has two contact points and a box on a side of the ridge has four") {
    const Owned roof = mesh(ridge(0.5));
    for (const double gap : {0.004, -0.0003, -0.004}) {
        const collide::Manifolds m = contacts(roof, box(0.5_r, 0.5_r, 0.5_r), {0.1, 0.5 + gap, 0.05});
        INFO("gap ", gap, ": ", show(m));
        CHECK(is_only(m, {0, 1, 0}, gap, 2));
    }
    const collide::Manifolds flat =
        contacts(roof, box(0.5_r, 0.25_r, 0.5_r), D3{1, -0.5, 0} + D3{0.5, 1, 0} * (0.25 / std::sqrt(1.25)),
                 quat_of({0, 0, 1}, -std::atan(0.5)));
    INFO("on a side of the roof: ", show(flat));
    CHECK(is_only(flat, {0.5, 1, 0}, 0, 4));
}

TEST_CASE("a capsule in a groove has contacts with both sides of the groove") {
    const Owned groove = mesh(ridge(-1));
    const double height = 0.3 * std::sqrt(2.0) - 0.001 * std::sqrt(2.0);
    const collide::Manifolds m =
        contacts(groove, capsule(0.3_r, 0.6_r), {0, height, 0.1}, quat_of({1, 0, 0}, quarter));
    INFO(show(m));
    REQUIRE(m.count == 2);
    for (int i = 0; i < 2; ++i) {
        CHECK(m.items[i].count == 2);
        CHECK(std::abs(separation(m.items[i]) + 0.001) < 1e-6);
    }
    CHECK((is_normal(m.items[0], {1, 1, 0}) || is_normal(m.items[0], {-1, 1, 0})));
    CHECK((is_normal(m.items[1], {1, 1, 0}) || is_normal(m.items[1], {-1, 1, 0})));
}

TEST_CASE("a box that overhangs a step has contacts with the top of the step only") {
    const Owned step = mesh(block({-4, -2, -4}, {0, 0, 4}));
    for (const double gap : {0.004, -0.0003, -0.003}) {
        for (const double x : {0.45, 0.2, -0.2, -0.497}) {
            const collide::Manifolds m = contacts(step, box(0.5_r, 0.5_r, 0.5_r), {x, 0.5 + gap, 0.3});
            INFO("gap ", gap, " at ", x, ": ", show(m));
            CHECK(is_only(m, {0, 1, 0}, gap, 4));
        }
    }
}

TEST_CASE("the contact of a tilted box on the edge of a step has the normal of the box's face") {
    const Owned step = mesh(block({-4, -2, -4}, {0, 0, 4}));
    for (const double tilt : {0.1, 0.4, 0.7, 1.0})
        for (const double gap : {0.005, -0.001, -0.004}) {
            const D3 n{std::sin(tilt), std::cos(tilt), 0};
            const collide::Manifolds m =
                contacts(step, box(0.5_r, 0.5_r, 0.5_r), n * (0.5 + gap), quat_of({0, 0, 1}, -tilt));
            INFO("tilt ", tilt, " gap ", gap, ": ", show(m));
            CHECK(is_only(m, n, gap, 2));
        }
}

TEST_CASE("a contact pushes a shape whose centre is behind the surface out to the front") {
    const Owned ground = mesh(grid(-20, -20, 1, 40, 40, 0.2, 9, [](double, double) { return 0.0; }));
    CHECK(is_only(contacts(ground, sphere(0.5_r), {0.1, -0.3, 0.2}), {0, 1, 0}, -0.8, 1));
    const collide::Manifolds low = contacts(ground, box(0.5_r, 0.5_r, 0.5_r), {0.1, -0.3, 0.2});
    INFO(show(low));
    CHECK(is_only(low, {0, 1, 0}, -0.8, 4));
    CHECK(contacts(ground, sphere(0.5_r), {0.1, -0.6, 0.2}).count == 0);

    const Owned field = height_field(41, 41, 1, [](auto, auto) { return 0.0; });
    for (const double depth : {0.3, 0.7, 5.0, 12.0}) {
        INFO("depth ", depth);
        CHECK(is_only(contacts(field, sphere(0.5_r), {20.1, -depth, 20.3}), {0, 1, 0}, -depth - 0.5, 1));
        CHECK(is_only(contacts(field, box(0.5_r, 0.5_r, 0.5_r), {20.1, -depth, 20.3}), {0, 1, 0},
                      -depth - 0.5, 4));
    }
}

TEST_CASE("contacts push a shape whose centre is inside a closed mesh out of the nearest face") {
    lockstone::test::scene::RandomPoint random(21);
    for (int i = 0; i < 1000; ++i) CHECK(lockstone::test::sunken_fault(random) == "");
}

TEST_CASE("a thin wall pushes a shape to the side where its centre is") {
    const Owned wall = mesh(block({-0.05, -5, -5}, {0.05, 5, 5}));
    CHECK(is_only(contacts(wall, sphere(0.5_r), {0.5, 0.2, 0.1}), {1, 0, 0}, -0.05, 1));
    CHECK(is_only(contacts(wall, sphere(0.5_r), {-0.5, 0.2, 0.1}), {-1, 0, 0}, -0.05, 1));
    CHECK(is_only(contacts(wall, sphere(0.5_r), {0.02, 0.2, 0.1}), {1, 0, 0}, -0.53, 1));
    CHECK(is_only(contacts(wall, box(0.5_r, 0.5_r, 0.5_r), {-0.5, 0.2, 0.1}), {-1, 0, 0}, -0.05, 4));
    CHECK(is_only(contacts(wall, box(0.5_r, 0.5_r, 0.5_r), {-0.03, 0.2, 0.1}), {-1, 0, 0}, -0.52, 4));
}

TEST_CASE("two-sided triangles push shapes out on both of their sides") {
    const Soup sheet = grid(-20, -20, 1, 40, 40, 0.2, 9, [](double, double) { return 0.0; });
    const Owned both = mesh(sheet, true);
    CHECK(is_only(contacts(both, sphere(0.5_r), {0.1, 0.45, 0.2}), {0, 1, 0}, -0.05, 1));
    CHECK(is_only(contacts(both, sphere(0.5_r), {0.1, -0.45, 0.2}), {0, -1, 0}, -0.05, 1));
    CHECK(is_only(contacts(both, box(0.5_r, 0.5_r, 0.5_r), {0.1, -0.45, 0.2}), {0, -1, 0}, -0.05, 4));
    const Owned bent = mesh(ridge(-1), true); // a groove from above is a ridge from below
    const collide::Manifolds m = contacts(bent, box(0.5_r, 0.5_r, 0.5_r), {0.1, -0.501, 0.05});
    INFO(show(m));
    CHECK(is_only(m, {0, -1, 0}, 0.001, 2));
}

TEST_CASE("contacts with triangles of a kilometre are as exact as contacts with small ones") {
    Soup big;
    big.add({-1000, 0, -1000}, {-1000, 0, 1000}, {1000, 0, 1000}, {1000, 0, -1000});
    const Owned ground = mesh(big);
    oracle::RandomReal random(3);
    for (int i = 0; i < 200; ++i) {
        const double x = random.uniform(-995, 995),
                     z = i % 2 == 0 ? x + random.uniform(-1, 1) : random.uniform(-990, 990);
        INFO("at ", x, ' ', z);
        CHECK(is_only(contacts(ground, sphere(0.5_r), {x, 0.499, z}), {0, 1, 0}, -0.001, 1));
        const collide::Manifolds m =
            contacts(ground, box(0.5_r, 0.25_r, 0.5_r), {x, 0.252, z}, quat_of({0, 1, 0}, x));
        INFO(show(m));
        CHECK(is_only(m, {0, 1, 0}, 0.002, 4));
    }
    Soup cliff; // a ridge of needles: 1 km long, 10 cm wide
    cliff.add({0, 0, -500}, {-0.1, -0.1, -500}, {-0.1, -0.1, 500}, {0, 0, 500});
    cliff.add({0, 0, -500}, {0, 0, 500}, {0.1, -0.1, 500}, {0.1, -0.1, -500});
    const Owned needles = mesh(cliff);
    for (const double z : {-400.0, -100.03, 0.0, 250.07, 499.0}) {
        const collide::Manifolds m = contacts(needles, box(0.5_r, 0.5_r, 0.5_r), {0.2, 0.5, z});
        INFO("needles at ", z, ": ", show(m));
        CHECK(is_only(m, {0, 1, 0}, 0, 2));
        CHECK(is_only(contacts(needles, sphere(0.5_r), {0.1, 0.499, z}), {0.1, 0.499, 0},
                      std::hypot(0.1, 0.499) - 0.5, 1));
    }
}

TEST_CASE("the border of a mesh has contacts with shapes at its side and not with shapes that only come near "
          "its top") {
    const Owned sheet = mesh(grid(-4, -4, 1, 4, 8, 0, 0, [](double, double) { return 0.0; }));
    // The middle of the box's side touches the border: the contact pushes the box away from the sheet.
    const collide::Manifolds side = contacts(sheet, box(0.5_r, 0.5_r, 0.5_r), {0.498, 0, 0.2});
    INFO(show(side));
    CHECK(is_only(side, {1, 0, 0}, -0.002, 2));
    CHECK(is_only(contacts(sheet, sphere(0.5_r), {0.497, -0.03, 0.2}), {0.497, -0.03, 0},
                  std::hypot(0.497, 0.03) - 0.5, 1));
    // Beside the sheet and level with it, before it slides onto it: no contact yet.
    CHECK(contacts(sheet, box(0.5_r, 0.5_r, 0.5_r), {0.51, 0.501, 0.2}).count == 0);
    CHECK(contacts(sheet, box(0.5_r, 0.5_r, 0.5_r), {0.51, 0.499, 0.2}).count == 0);
}

TEST_CASE("features are unique and stay the same while the contact moves a little") {
    const Owned ground = mesh(grid(-20, -20, 0.37, 100, 100, 0.2, 9, [](double x, double z) {
        return 0.1 * std::sin(x) + 0.1 * std::cos(1.3 * z);
    }));
    oracle::RandomReal random(11);
    int moved = 0, kept = 0;
    for (int i = 0; i < 400; ++i) {
        const D3 at{random.uniform(-10, 10), 0, random.uniform(-10, 10)};
        const double floor = 0.1 * std::sin(at.x) + 0.1 * std::cos(1.3 * at.z);
        const Quat q = random.rotation(0, 3);
        const D3 start = at + D3{0, floor + 0.3, 0};
        const collide::Manifolds m = contacts(ground, box(0.3_r, 0.25_r, 0.35_r), start, q);
        const collide::Manifolds n =
            contacts(ground, box(0.3_r, 0.25_r, 0.35_r), start + random.vector(0, 2e-6), q);
        std::vector<std::uint32_t> names, others;
        for (std::uint32_t k = 0; k < m.count; ++k)
            for (std::uint32_t p = 0; p < m.items[k].count; ++p)
                names.push_back(m.items[k].points[p].feature);
        for (std::uint32_t k = 0; k < n.count; ++k)
            for (std::uint32_t p = 0; p < n.items[k].count; ++p)
                others.push_back(n.items[k].points[p].feature);
        std::sort(names.begin(), names.end());
        CHECK(std::adjacent_find(names.begin(), names.end()) == names.end());
        for (const std::uint32_t name : names)
            kept += std::find(others.begin(), others.end(), name) != others.end();
        moved += static_cast<int>(names.size());
    }
    INFO(kept, " of ", moved, " kept");
    CHECK(moved > 400);
    CHECK(kept > moved * 98 / 100);
}

TEST_CASE("a mesh of half the size at scale 2 has bit for bit the same contacts") {
    // Only a mesh at scale 1 drops triangles by their planes alone.
    Soup soup = grid(-8, -8, 0.5, 32, 32, 0.2, 21,
                     [](double x, double z) { return 0.4 * std::sin(2 * x) + 0.3 * std::cos(2.3 * z); });
    for (D3& v : soup.vertices)
        for (int i = 0; i < 3; ++i) v[i] = std::round(v[i] * 1024) / 1024;
    const Owned whole = mesh(soup);
    for (D3& v : soup.vertices) v = v * 0.5;
    const Owned half = mesh(soup, false, {Length(2), Length(2), Length(2)});
    const Geometry shapes[] = {sphere(0.4_r), capsule(0.2_r, 0.5_r), box(0.5_r, 0.2_r, 0.3_r),
                               cylinder(0.3_r, 0.4_r), rounded(box(0.3_r, 0.3_r, 0.2_r), 0.05_r)};
    oracle::RandomReal random(31);
    int touching = 0;
    for (int i = 0; i < 4000; ++i) {
        const Geometry& shape = shapes[i % 5];
        D3 at{random.uniform(-6, 6), 0, random.uniform(-6, 6)};
        at.y = 0.4 * std::sin(2 * at.x) + 0.3 * std::cos(2.3 * at.z) + random.uniform(-0.1, 0.7);
        const Quat turn = random.rotation(0, 3);
        const collide::Manifolds m = contacts(whole, shape, at, turn), n = contacts(half, shape, at, turn);
        INFO("pose ", i, ": ", show(m), " or ", show(n));
        touching += m.count > 0;
        REQUIRE(m.count == n.count);
        CHECK(std::memcmp(m.items, n.items, m.count * sizeof(collide::Manifold)) == 0);
    }
    CHECK(touching > 2000);
}
