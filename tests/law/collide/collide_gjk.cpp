// Closest points and shortest separating moves of two convex cores, proved by judges in double precision, on hulls
// found by brute force, needles, plates, triangles and smooth cores. The judges detect planted faults.
#include "support/effort.h"

#include "oracle/brute_hull.h"

#include <doctest/doctest.h>

#include <cstring>

using namespace lockstone;
using namespace oracle;
using collide::Convex;

namespace {

/// A core that no solid has: a triangle, or a hull that the test makes.
struct Piece {
    Convex convex;
    DoubleCore reference;
    std::shared_ptr<shapes::Hull> hull;
};

Piece hull_piece(RandomReal& random, double size, const Quat& turn, D3 at) {
    const std::uint32_t style = random.below(4), count = 4 + random.below(style == 3 ? 60 : 12);
    D3 stretch{1, 1, 1};
    if (style == 1) stretch.y = 1e-4;
    if (style == 2) stretch.x = stretch.z = 1e-3;
    int shift = 0;
    for (double unit = std::ldexp(size, 24 - 17); unit >= 2; unit /= 2) ++shift;
    std::shared_ptr<shapes::Hull> hull;
    while (hull == nullptr) {
        std::vector<Grid> points;
        for (std::uint32_t k = 0; k < count; ++k) {
            D3 p = style == 3 ? random.direction() : random.vector(0, 1);
            if (random.below(3) == 0)
                for (int i = 0; i < 3; ++i) p[i] = p[i] < 0 ? -0.5 : 0.5; // corners of a cube: coplanar faces
            const auto grid = [](double x) { return static_cast<std::int64_t>(std::ldexp(x, 17)); };
            points.push_back({grid(p.x * stretch.x), grid(p.y * stretch.y), grid(p.z * stretch.z)});
        }
        hull = brute_hull(points, shift);
    }
    const shapes::Solid solid{instance(ShapeKind::hull, {}), hull.get()};
    const RelativePose pose = pose_of(turn, at);
    return {collide::convex_of(solid, pose.rotation, pose.position), DoubleCore(solid, pose), hull};
}

Piece triangle_piece(RandomReal& random, double size, D3 at) {
    Long3 corners[3];
    DoubleCore reference{shapes::Solid{sphere(0_r)}};
    reference.kind = ShapeKind::hull;
    const bool needle = random.below(3) == 0;
    const D3 first = random.vector(0, size);
    for (Long3& corner : corners) {
        D3 p = random.vector(0, size);
        if (needle) p = first + p * 1e-4;
        if (needle && &corner == corners) p = first * -1.0;
        for (int i = 0; i < 3; ++i) corner[i] = as_fixed<Coordinate>(p[i] + at[i]).raw;
        reference.points.push_back(from_bits(corner, 24));
    }
    static constexpr std::array<std::array<std::uint8_t, 3>, 2> both_sides{{{0, 1, 2}, {0, 2, 1}}};
    reference.faces = both_sides;
    return {collide::convex_of_triangle(corners), reference, nullptr};
}

CoreAnswer answer_of(const Convex& a, const Convex& b) {
    const collide::Gap gap = collide::closest_points(a, b);
    const auto metres = [](std::int64_t x) { return std::ldexp(static_cast<double>(x), -30); };
    if (!gap.overlap)
        return {false, from_bits(gap.normal_30, 30), metres(gap.distance_30), from_bits(gap.on_a_30, 30),
                from_bits(gap.on_b_30, 30)};
    const collide::Penetration p = collide::penetration(a, b);
    return {true, from_bits(p.normal_30, 30), -metres(p.depth_30), {}, {}};
}

Piece random_piece(RandomReal& random, double size, D3 at) {
    const Quat turn = random.below(2) == 0 ? Quat::identity() : normalized(random.rotation(0, 3));
    if (random.below(3) == 0) return triangle_piece(random, size, at);
    return hull_piece(random, size, turn, at);
}

struct Fault {
    const char* what;
    void (*plant)(CoreAnswer&);
    bool when_overlapping, when_apart;
    int planted = 0, noticed = 0;
};

} // namespace

TEST_CASE("the closest points and least separating moves of polytopes of every quality are proved") {
    RandomReal random(17);
    const int count = test::is_long_run() ? 100'000 : test::tries(3000);
    int overlaps = 0, flat_apart = 0;
    for (int i = 0; i < count; ++i) {
        const double size = random.log_uniform(0.01, 3), other = size * random.log_uniform(0.05, 1);
        D3 at = random.vector(0, 1.3 * (size + other));
        if (i % 8 == 0) at = {0, 0, 0};
        if (i % 8 == 1)
            for (int k = 0; k < 3; ++k) at[k] = std::round(2 * at[k] / size) * size / 2;
        const Piece a = random_piece(random, size, {0, 0, 0}), b = random_piece(random, other, at);
        const CoreAnswer answer = answer_of(a.convex, b.convex);
        overlaps += answer.overlap ? 1 : 0;
        INFO("pair ", i);
        // A triangle's plane has two sides and no inside, so the planes of its edges also count.
        if (a.reference.faces.size() == 2 || b.reference.faces.size() == 2) {
            const double along = separation_along(a.reference, b.reference, answer.normal);
            CHECK(std::abs(along - answer.distance) < 2e-8);
            if (answer.overlap) continue;
            CHECK(std::abs(norm(answer.on_b - answer.on_a) - answer.distance) < 1e-8);
            ++flat_apart;
            continue;
        }
        CHECK(judge(a.reference, b.reference, answer, random, 2) == "");
    }
    CHECK(overlaps > count / 5);
    CHECK(flat_apart > count / 100);
}

namespace {

/// Returns whether a gap of a triangle and a point is proved: the plane through the nearest point separates the two by
/// the distance, and the nearest point is on the triangle.
bool is_proved(const std::vector<D3>& corners, D3 point, const collide::Gap& gap) {
    const D3 n = from_bits(gap.normal_30, 30), on = from_bits(gap.on_a_30, 30);
    const double distance = std::ldexp(static_cast<double>(gap.distance_30), -30);
    double most = -1e9;
    for (const D3& c : corners) most = std::max(most, dot(n, c));
    if (std::abs(dot(n, point) - most - distance) > 2e-8) return false;
    if (std::abs(norm(point - on) - distance) > 1e-8) return false;
    const D3 face = cross(corners[1] - corners[0], corners[2] - corners[0]);
    for (std::size_t k = 0; k < 3; ++k) {
        const D3 out = cross(corners[(k + 1) % 3] - corners[k], face);
        if (norm(out) > 0 && dot(out, on - corners[k]) > 1e-8 * norm(out)) return false;
    }
    return true;
}

} // namespace

TEST_CASE("the gap of a triangle and a point is proved and the check rejects the gap to another place of the "
          "triangle") {
    RandomReal random(23);
    int gaps = 0, noticed = 0;
    for (int i = 0; i < test::tries(4000); ++i) {
        const double size = random.log_uniform(0.05, 3);
        const Piece triangle = triangle_piece(random, size, {0, 0, 0});
        const std::vector<D3> corners = triangle.reference.points;
        D3 at = random.vector(0, 1.5 * size);
        if (i % 3 == 0) at = corners[0] + (corners[1] - corners[0]) * 0.3 + random.vector(0, 0.1 * size);
        Convex point{};
        point.core = Convex::Core::point;
        for (int k = 0; k < 3; ++k) point.center_24[k] = as_fixed<Coordinate>(at[k]).raw;
        at = from_bits(point.center_24, 24);
        collide::Gap gap = collide::closest_points(triangle.convex, point);
        if (gap.overlap || gap.distance_30 < 1 << 20) continue;
        ++gaps;
        INFO("triangle ", i);
        CHECK(is_proved(corners, at, gap));
        const collide::Gap back = collide::closest_points(point, triangle.convex);
        CHECK(std::abs(back.distance_30 - gap.distance_30) <= 8);
        CHECK(norm(from_bits(back.on_b_30, 30) - from_bits(gap.on_a_30, 30)) < 1e-7);
        // Planted: the gap to a point that is not the nearest.
        const D3 other = corners[static_cast<std::size_t>(i % 3)];
        if (norm(at - other) < norm(at - from_bits(gap.on_a_30, 30)) + 1e-6) continue;
        const D3 way = at - other;
        for (int k = 0; k < 3; ++k) {
            gap.normal_30[k] = static_cast<std::int64_t>(std::ldexp(way[k] / norm(way), 30));
            gap.on_a_30[k] = static_cast<std::int64_t>(std::ldexp(other[k], 30));
        }
        gap.distance_30 = static_cast<std::int64_t>(std::ldexp(norm(way), 30));
        CHECK(!is_proved(corners, at, gap));
        ++noticed;
    }
    CHECK(gaps > test::tries(4000) / 2);
    CHECK(noticed > test::tries(4000) / 4);
}

TEST_CASE("two cores have the same distance from both sides and every call returns the same bits") {
    RandomReal random(19);
    for (int i = 0; i < test::tries(1500); ++i) {
        const double size = random.log_uniform(0.05, 3);
        const Piece a = random_piece(random, size, {0, 0, 0}),
                    b = random_piece(random, size, random.vector(0, 2 * size));
        const collide::Gap there = collide::closest_points(a.convex, b.convex),
                           again = collide::closest_points(a.convex, b.convex),
                           back = collide::closest_points(b.convex, a.convex);
        CHECK(std::memcmp(&there.normal_30, &again.normal_30, sizeof there.normal_30) == 0);
        CHECK(there.distance_30 == again.distance_30);
        CHECK(there.overlap == back.overlap);
        CHECK(std::abs(there.distance_30 - back.distance_30) <= 8);
        if (there.overlap) {
            const std::int64_t d = collide::penetration(a.convex, b.convex).depth_30;
            CHECK(std::abs(d - collide::penetration(b.convex, a.convex).depth_30) <= 16);
        }
    }
}

TEST_CASE(
    "a search with a limit stops early and never returns a distance within the limit for cores beyond it") {
    RandomReal random(23);
    int stopped = 0;
    const int count = test::tries(3000);
    for (int i = 0; i < count; ++i) {
        const double size = random.log_uniform(0.05, 3);
        const Piece a = random_piece(random, size, {0, 0, 0}),
                    b = random_piece(random, size, random.vector(size, 4 * size));
        const std::int64_t limit = static_cast<std::int64_t>(std::ldexp(random.uniform(0, 2 * size), 30));
        const collide::Gap whole = collide::closest_points(a.convex, b.convex),
                           limited = collide::closest_points_within(a.convex, b.convex, limit);
        CHECK(whole.overlap == limited.overlap);
        if (whole.overlap) continue;
        if (whole.distance_30 > limit + 8) {
            CHECK(limited.distance_30 > limit);
            CHECK(limited.distance_30 <= whole.distance_30 + 8);
        } else if (whole.distance_30 <= limit) {
            CHECK(limited.distance_30 == whole.distance_30);
        }
        stopped += limited.distance_30 < whole.distance_30 ? 1 : 0;
    }
    CHECK(stopped > count / 30);
}

TEST_CASE("flat or coincident or touching cores have a defined normal and distance") {
    const Convex::Core cores[] = {Convex::Core::point, Convex::Core::segment, Convex::Core::box,
                                  Convex::Core::cylinder, Convex::Core::cone};
    constexpr std::int64_t one = std::int64_t{1} << 30, unit = std::int64_t{1} << 24;
    for (const Convex::Core ca : cores)
        for (const Convex::Core cb : cores)
            for (const Long3 at :
                 {Long3{0, 0, 0}, Long3{2 * unit, 0, 0}, Long3{0, 2 * unit, 0}, Long3{unit, unit, unit}}) {
                const Convex a{
                    ca,      {},   {}, {{one, 0, 0}, {0, one, 0}, {0, 0, one}}, {unit, unit, unit}, nullptr,
                    nullptr, true, {}};
                Convex b = a;
                b.core = cb;
                b.center_24 = at;
                const CoreAnswer answer = answer_of(a, b);
                CHECK(std::abs(norm(answer.normal) - 1) < 4e-9);
                CHECK(std::abs(answer.distance) < 4);
            }
}

TEST_CASE("the judges of closest points and depths report planted faults" *
          doctest::skip(lockstone::test::is_small_sample())) {
    Fault faults[] = {
        {"a flipped normal", [](CoreAnswer& x) { x.normal = x.normal * -1.0; }, true, true},
        {"a hundredth of a degree",
         [](CoreAnswer& x) {
             x.normal = x.normal + cross(x.normal, {0.6, 0, 0.8}) * 2e-4;
         },
         true, false},
        {"a micrometre too far", [](CoreAnswer& x) { x.distance += 1e-6; }, true, true},
        {"a point a micrometre outside", [](CoreAnswer& x) { x.on_a = x.on_a + x.normal * 1e-6; }, false,
         true},
        {"an overlap that is none", [](CoreAnswer& x) { x.overlap = true, x.distance = 0; }, false, true},
    };
    RandomReal random(29);
    for (int i = 0; i < 600; ++i) {
        const double size = random.log_uniform(0.2, 2);
        const Piece a = hull_piece(random, size, Quat::identity(), {0, 0, 0}),
                    b = hull_piece(random, size, normalized(random.rotation(0, 3)),
                                   random.vector(0.2 * size, 2 * size));
        const CoreAnswer good = answer_of(a.convex, b.convex);
        REQUIRE(judge(a.reference, b.reference, good, random, 2) == "");
        for (Fault& f : faults) {
            if (!(good.overlap ? f.when_overlapping : f.when_apart) || std::abs(good.distance) < 1e-4)
                continue;
            CoreAnswer bad = good;
            f.plant(bad);
            ++f.planted;
            f.noticed += judge(a.reference, b.reference, bad, random, 2).empty() ? 0 : 1;
        }
        shapes::Hull lost = *a.hull; // a lost vertex: the distance is then too large
        lost.vertices[0] = lost.vertices[1];
        Convex damaged = a.convex;
        damaged.hull = &lost;
        if (!good.overlap && a.hull->vertices.size() <= 24) {
            const CoreAnswer bad = answer_of(damaged, b.convex);
            if (std::abs(bad.distance - good.distance) > 1e-6)
                CHECK(judge(a.reference, b.reference, bad, random, 2) != "");
        }
    }
    for (const Fault& f : faults) {
        INFO(std::string(f.what));
        CHECK(f.planted > 50);
        CHECK(f.noticed >= f.planted - f.planted / 50);
    }
}
