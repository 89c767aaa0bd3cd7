// The narrow phase against references in double precision, from the definitions, for all nine pairs.
#include "oracle/double_shapes.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <optional>

using namespace oracle;
using namespace lockstone;

namespace {

const Length margin = as_fixed<Length>(0.02);

/// The results of a comparison, for the printed table.
struct Comparison {
    int poses = 0, hits = 0, wrong_hits = 0, wrong = 0;
    double own_square = 0,
           own_max = 0; // of separations with one exact value
    int own_count = 0;
    double excess_max = 0; // the depth above the least one, which the preference for faces causes
    std::string first;     // the first sentence of the checker
};

bool along_a_face(const Placed& s, D3 n) {
    return s.kind == ShapeKind::box && std::any_of(s.axes.begin(), s.axes.end(), [&](const D3& axis) {
               return norm(cross(axis, n)) < 1e-8;
           });
}

/// The error of the deepest point's separation where there is one exact value, else nothing: a corner beyond the side
/// of a face has no point, and two points along a capsule are projected on their common normal.
std::optional<double> separation_error(const Placed& a, const Placed& b, const Manifold& m, double deepest,
                                       double truth) {
    const D3 n = as_double(m.normal);
    const double along = separation_along(a, b, n);
    if (b.kind == ShapeKind::capsule && a.kind != ShapeKind::plane) {
        if (m.count == 1 && !along_a_face(a, n)) return deepest - truth;
        return std::nullopt;
    }
    if (a.kind != ShapeKind::box || b.kind != ShapeKind::box) return deepest - along;
    if (!along_a_face(a, n)) {
        if (along_a_face(b, n)) return std::nullopt;
        if (m.count > 1) return std::nullopt; // parallel edges
        return deepest - along;               // two edges
    }
    // A's face: the point of a corner of B has that corner's depth.
    for (std::uint32_t k = 0; k < m.count; ++k) {
        if (m.points[k].feature >> 16 != 2) continue;
        D3 corner = b.center;
        for (std::uint32_t i = 0; i < 3; ++i)
            corner =
                corner + b.axes[i] * ((m.points[k].feature >> i & 1u) != 0 ? b.half[static_cast<int>(i)]
                                                                           : -b.half[static_cast<int>(i)]);
        return as_double(m.points[k].separation) - (dot(n, corner) - support(a, n));
    }
    return std::nullopt;
}

Comparison compare(ShapeKind kind_a, ShapeKind kind_b, double size_min, double size_max) {
    Comparison c;
    RandomReal random(0x51ab1e + static_cast<std::uint64_t>(kind_a) * 16 +
                      static_cast<std::uint64_t>(kind_b));
    for (c.poses = 0; c.poses < pose_count(); ++c.poses) {
        const Scene s = random_scene(random, kind_a, kind_b, size_min, size_max);
        const Manifold m = collide_geometries(s.a, s.b, s.pose, margin);
        const std::string why = check_manifold(s.a, s.b, s.pose, as_double(margin), m);
        if (!why.empty() && c.wrong++ == 0) c.first = "pose " + std::to_string(c.poses) + ": " + why;
        const Placed a = place_a(s.a), b = place_b(s.b, s.pose);
        const double truth = separation(a, b);
        if (truth < -1e-6 && m.count == 0) ++c.wrong_hits;
        if (m.count == 0) continue;
        ++c.hits;
        double deepest = 16;
        for (std::uint32_t k = 0; k < m.count; ++k)
            deepest = std::min(deepest, as_double(m.points[k].separation));
        if (deepest < -15.9) continue;
        const double along = separation_along(a, b, as_double(m.normal));
        const bool boxes = kind_a == ShapeKind::box && kind_b == ShapeKind::box;
        c.excess_max = std::max(c.excess_max, truth - (boxes ? along : deepest));
        if (const std::optional<double> error = separation_error(a, b, m, deepest, truth)) {
            c.own_square += *error * *error;
            c.own_max = std::max(c.own_max, std::abs(*error));
            ++c.own_count;
        }
    }
    std::printf("  %-7s %-7s %6d %6d %5d %5d   %8.1e %8.1e   %8.1e\n", name_of(kind_a), name_of(kind_b),
                c.poses, c.hits, c.wrong_hits, c.wrong, std::sqrt(c.own_square / std::max(1, c.own_count)),
                c.own_max, c.excess_max);
    return c;
}

void compare_all(double size_min, double size_max, double own_tolerance) {
    std::printf("narrow phase against double, sizes %g .. %g m\n"
                "  A       B        poses   hits  miss wrong   rms[m]   max[m]     face preference[m]\n",
                size_min, size_max);
    for (ShapeKind a : {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box, ShapeKind::plane})
        for (ShapeKind b : {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box}) {
            if (a < b) continue;
            const Comparison c = compare(a, b, size_min, size_max);
            INFO(std::string(name_of(a)), " and ", std::string(name_of(b)), ", ", c.first);
            CHECK(c.wrong == 0);
            CHECK(c.wrong_hits == 0);
            CHECK(c.own_max < own_tolerance);
            CHECK(c.hits > c.poses / 3);
        }
}

} // namespace

TEST_CASE("manifolds of everyday sizes agree with double precision") { compare_all(0.05, 2, 1e-7); }

TEST_CASE("manifolds from 5 mm to 100 m agree with double precision") { compare_all(0.0125, 50, 5e-7); }

TEST_CASE("the manifold checker reports planted faults") {
    struct Fault {
        const char* what;
        void (*plant)(Manifold&);
        std::uint32_t points; // the least number of points of the manifold
        int planted = 0, reported = 0;
    };
    Fault faults[] = {
        {"no points", [](Manifold& m) { m.count = 0; }, 1},
        {"the normal from B to A", [](Manifold& m) { m.normal = -m.normal; }, 1},
        {"a normal 0.1 % too long", [](Manifold& m) { m.normal = m.normal * decimal<Unit>("1.001"); }, 1},
        {"20 mm too deep", [](Manifold& m) { m.points[0].separation -= decimal<Separation>("0.02"); }, 1},
        {"beyond the margin", [](Manifold& m) { m.points[0].separation = decimal<Separation>("0.021"); }, 1},
        {"two points with one feature", [](Manifold& m) { m.points[1].feature = m.points[0].feature; }, 2},
        {"1 um off the surfaces",
         [](Manifold& m) { m.points[1].position += scale<Length>(m.normal, decimal<Length>("0.000001")); },
         2},
    };
    RandomReal random(99);
    for (int i = 0; i < 8000; ++i) {
        const Scene s =
            random_scene(random, ShapeKind::box, i % 2 == 0 ? ShapeKind::box : ShapeKind::sphere, 0.2, 1);
        const Manifold good = collide_geometries(s.a, s.b, s.pose, margin);
        const auto verdict = [&](const Manifold& m) {
            return check_manifold(s.a, s.b, s.pose, as_double(margin), m);
        };
        REQUIRE(verdict(good).empty());
        const double truth = separation(place_a(s.a), place_b(s.b, s.pose));
        // deeper, both directions out of a box can be equally good
        if (truth > -0.005 || truth < -0.04) continue;
        for (Fault& fault : faults) {
            if (good.count < fault.points) continue;
            Manifold bad = good;
            fault.plant(bad);
            ++fault.planted;
            fault.reported += verdict(bad).empty() ? 0 : 1;
        }
    }
    for (const Fault& fault : faults) {
        INFO(std::string(fault.what));
        CHECK(fault.planted > 50);
        CHECK(fault.reported == fault.planted);
    }
}
