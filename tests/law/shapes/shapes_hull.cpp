// Hulls of known solids and of random points: exact convexity, closedness, faces.
#include "lockstone/math/math.h"
#include "oracle/double_shapes.h"
#include "shapes/hull/hull.h"
#include "support/about.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>

using namespace lockstone;
using namespace lockstone::shapes;
using oracle::as_double;
using oracle::D3;

namespace {

using Points = std::vector<LengthVec3>;

LengthVec3 point(double x, double y, double z) {
    return {oracle::as_fixed<Length>(x), oracle::as_fixed<Length>(y), oracle::as_fixed<Length>(z)};
}
LengthVec3 point(D3 p) { return point(p.x, p.y, p.z); }

Points box_corners(double x, double y, double z) {
    Points out;
    for (int i = 0; i < 8; ++i) out.push_back(point(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z));
    return out;
}
Points on_sphere(int count, double radius) {
    Points out;
    for (int i = 0; i < count; ++i) {
        const double y = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - y * y), a = 2.399963229728653 * i;
        out.push_back(point(radius * r * std::cos(a), radius * y, radius * r * std::sin(a)));
    }
    return out;
}
Points icosahedron() {
    const double g = (1 + std::sqrt(5.0)) / 2;
    Points out;
    for (double a : {-1.0, 1.0})
        for (double b : {-g, g}) {
            out.push_back(point(0, a, b));
            out.push_back(point(a, b, 0));
            out.push_back(point(b, 0, a));
        }
    return out;
}

Hull hull_of(const Points& points) {
    Result<Hull> made = make_hull(points);
    REQUIRE_MESSAGE(made.ok(), (made.ok() ? "" : made.error().message));
    return std::move(*made);
}

/// Returns an error sentence unless the surface is closed, convex everywhere and uses all vertices, by integer
/// determinants of every triangle with every vertex.
std::string check_surface(const Hull& h, const Points& inside) {
    std::set<std::pair<int, int>> directed;
    std::set<int> used;
    for (const auto& t : h.triangles) {
        const LengthVec3 a = h.vertices[t[0]];
        const WideVec3 n = exact_normal(a, h.vertices[t[1]], h.vertices[t[2]]);
        for (const Points* all : {&h.vertices, &inside})
            for (const LengthVec3& v : *all)
                if (Wide::from(0) < exact_height(n, a, v)) return "a point is outside";
        for (std::size_t k = 0; k < 3; ++k) {
            used.insert(t[k]);
            if (!directed.insert({t[k], t[(k + 1) % 3]}).second) return "an edge occurs twice";
        }
    }
    for (const auto& [from, to] : directed)
        if (!directed.contains({to, from})) return "an edge is open";
    if (used.size() != h.vertices.size()) return "a vertex is not used";
    if (h.vertices.size() + h.triangles.size() != directed.size() / 2 + 2) return "Euler";
    return {};
}

/// Checks the faces: their outlines cover every edge between two faces once, the whole hull is below each, and their
/// number is small.
std::string check_faces(const Hull& h) {
    std::set<std::pair<int, int>> directed;
    std::size_t on_faces = 0;
    for (const Hull::Face& f : h.faces) {
        if (f.count < 3) return "a face has fewer than three corners";
        double lowest = 0;
        for (const LengthVec3& v : h.vertices)
            if (dot(as_double(f.normal), as_double(v)) > as_double(f.offset) + 1e-9)
                return "a vertex is above a face";
        for (std::size_t k = 0; k < f.count; ++k) {
            const int from = h.loops[f.first + k], to = h.loops[f.first + (k + 1u) % f.count];
            if (!directed.insert({from, to}).second) return "an outline edge occurs twice";
            lowest = std::max(
                lowest, as_double(f.offset) -
                            dot(as_double(f.normal), as_double(h.vertices[static_cast<std::size_t>(from)])));
        }
        on_faces += f.count;
        if (lowest > 4 * as_double(face_tolerance(h, Length(1)))) return "a corner is far below its face";
    }
    if (on_faces != h.loops.size() || h.edges.size() * 2 != on_faces) return "edge count";
    for (const Hull::Edge& e : h.edges) {
        if (!directed.contains({e.from, e.to}) || !directed.contains({e.to, e.from}))
            return "edge without outline";
        const Hull::Face& left = h.faces[e.left];
        bool found = false;
        for (std::size_t k = 0; k < left.count; ++k)
            found = found || (h.loops[left.first + k] == e.from &&
                              h.loops[left.first + (k + 1u) % left.count] == e.to);
        if (!found || e.left == e.right) return "edge with a wrong face";
    }
    return {};
}

std::string check_neighbours(const Hull& h) {
    std::set<std::pair<int, int>> links, listed;
    for (const auto& t : h.triangles)
        for (std::size_t k = 0; k < 3; ++k) links.insert({t[k], t[(k + 1) % 3]});
    for (std::size_t v = 0; v < h.vertices.size(); ++v)
        for (std::size_t i = h.first_neighbour[v]; i < h.first_neighbour[v + 1]; ++i) {
            if (i > h.first_neighbour[v] && h.neighbours[i - 1] >= h.neighbours[i]) return "order";
            listed.insert({static_cast<int>(v), h.neighbours[i]});
        }
    return links == listed && h.neighbours.size() == links.size() ? "" : "links";
}

void require_good(const Hull& h, const Points& from) {
    REQUIRE(check_surface(h, from) == "");
    REQUIRE(check_faces(h) == "");
    REQUIRE(check_neighbours(h) == "");
    for (const auto& t : h.triangles) {
        const D3 a = as_double(h.vertices[t[0]]);
        const D3 n = cross(as_double(h.vertices[t[1]]) - a, as_double(h.vertices[t[2]]) - a);
        const double depth = dot(n, a - as_double(h.interior)) / norm(n);
        CHECK(depth >= as_double(h.inner_radius));
    }
}

Points rotated_box(oracle::RandomReal& random, double size) {
    const Rotation r = to_rotation(random.rotation(0, 3));
    const double x = random.uniform(0.2, 1) * size, y = random.uniform(0.2, 1) * size,
                 z = random.uniform(0.2, 1) * size;
    Points out;
    for (int i = 0; i < 8; ++i)
        out.push_back(point(as_double(r.x) * (i & 1 ? x : -x) + as_double(r.y) * (i & 2 ? y : -y) +
                            as_double(r.z) * (i & 4 ? z : -z)));
    return out;
}

} // namespace

TEST_CASE("a cube has 8 corners and 6 faces and 12 edges and 12 triangles") {
    Points points = box_corners(1, 2, 3);
    // Repeated corners and points on edges, on faces and inside change nothing.
    for (const LengthVec3& p : box_corners(1, 2, 3)) points.push_back(p);
    points.insert(points.begin(), {point(0, 0, 0), point(1, 2, 0), point(1, 0, 3), point(1, 0, 0),
                                   point(-1, -2, 1), point(0, 2, 3)});
    const Hull h = hull_of(points);
    require_good(h, points);
    CHECK(h.vertices.size() == 8);
    CHECK(h.faces.size() == 6);
    CHECK(h.edges.size() == 12);
    CHECK(h.triangles.size() == 12);
    CHECK(h.interior == LengthVec3{});
    CHECK(as_double(h.inner_radius) == test::about(1, 1e-6));
    CHECK(h.properties.mass == 48_r);
    Hull bad = h; // planted
    std::swap(bad.triangles[3][0], bad.triangles[3][1]);
    CHECK(check_surface(bad, points) != "");
    bad = h;
    bad.vertices[5] = point(0.9, 1.9, 0);
    CHECK(check_surface(bad, points) == "a point is outside");
    bad = h;
    bad.triangles.pop_back();
    CHECK(check_surface(bad, points) == "an edge is open");
    bad = h;
    std::swap(bad.loops[0], bad.loops[1]);
    CHECK(check_faces(bad) != "");
    bad = h;
    std::swap(bad.edges[0].left, bad.edges[0].right);
    CHECK(check_faces(bad) == "edge with a wrong face");
    bad = h;
    std::swap(bad.neighbours[0], bad.neighbours[1]);
    CHECK(check_neighbours(bad) != "");
}

TEST_CASE("an icosahedron has 12 corners and 20 faces") {
    const Points points = icosahedron();
    const Hull h = hull_of(points);
    require_good(h, points);
    CHECK(h.vertices.size() == 12);
    CHECK(h.faces.size() == 20);
    CHECK(h.edges.size() == 30);
}

TEST_CASE("make_hull() keeps 255 points on a sphere as corners and rejects 256") {
    const Points points = on_sphere(255, 2);
    const Hull h = hull_of(points);
    require_good(h, points);
    CHECK(h.vertices.size() == 255);
    CHECK(h.triangles.size() == 506);
    CHECK(h.faces.size() > 490); // some faces have four points in one plane
    CHECK(as_double(h.properties.mass) == test::about(33.51, 0.03));
    CHECK(make_hull(on_sphere(256, 2)).error().message == "hull has 256 corners, it may have 255");
}

TEST_CASE("a rotated and quantised box keeps its 6 faces") {
    oracle::RandomReal random(5);
    for (int i = 0; i < 300; ++i) {
        const Points points = rotated_box(random, random.log_uniform(0.05, 40));
        const Hull h = hull_of(points);
        require_good(h, points);
        REQUIRE(h.vertices.size() == 8);
        REQUIRE(h.faces.size() == 6);
        REQUIRE(h.edges.size() == 12);
        for (const Hull::Face& f : h.faces) REQUIRE(f.count == 4);
    }
}

TEST_CASE("a baked hull does not depend on the order of its points") {
    oracle::RandomReal random(7);
    Points points = on_sphere(60, 1);
    for (const LengthVec3& p : box_corners(0.6, 0.6, 0.6)) points.push_back(p);
    const AssetBytes bytes = bake_hull(points).value();
    for (int i = 0; i < 20; ++i) {
        for (std::size_t k = points.size(); k > 1; --k)
            std::swap(points[k - 1], points[random.below(static_cast<std::uint32_t>(k))]);
        CHECK(bake_hull(points).value() == bytes);
    }
    points[0].x += Length::step(); // planted
    CHECK(bake_hull(points).value() != bytes);
}

TEST_CASE("make_hull() handles points of a small grid although many share a plane or a line or a place") {
    oracle::RandomReal random(11);
    for (int i = 0; i < 3000; ++i) {
        const std::uint32_t side = 2 + random.below(4), count = 4 + random.below(40);
        Points points;
        for (std::uint32_t k = 0; k < count; ++k) {
            const double x = random.below(side), y = random.below(side), z = random.below(side);
            points.push_back(point(x / 4, y / 4, z / 4));
        }
        Result<Hull> made = make_hull(points);
        if (!made) {
            const std::string& why = made.error().message;
            REQUIRE_MESSAGE((why == "hull has all its points in one plane" ||
                             why == "hull has all its points on one line" ||
                             why == "hull has all its points in one place"),
                            why);
            continue;
        }
        require_good(*made, points);
    }
}

TEST_CASE("make_hull() rejects points without volume and reports the reason") {
    CHECK(make_hull(Points{point(0, 0, 0), point(1, 0, 0), point(0, 1, 0)}).error().message ==
          "hull has fewer than four points");
    CHECK(make_hull(Points(5, point(1, 1, 1))).error().message == "hull has all its points in one place");
    CHECK(make_hull(Points{point(0, 0, 0), point(1, 1, 1), point(2, 2, 2), point(3, 3, 3)}).error().message ==
          "hull has all its points on one line");
    CHECK(make_hull(Points{point(0, 0, 0), point(1, 0, 1), point(0, 1, 1), point(1, 1, 2)}).error().message ==
          "hull has all its points in one plane");
    CHECK(make_hull(box_corners(0.001, 1, 1)).error().message ==
          "hull is 1999 um thick across one of its faces, it must be at least 5000 um");
    CHECK(make_hull(box_corners(101, 1, 1)).error().message ==
          "hull has a corner further than 100 m from the origin");
}

TEST_CASE("hulls of the extreme sizes of 5 mm and 200 m are correct") {
    for (double size : {0.0025, 0.1, 100.0}) {
        const Points points = box_corners(size, size, size);
        const Hull h = hull_of(points);
        require_good(h, points);
        CHECK(h.faces.size() == 6);
        const double third = size * size * 2 / 3;
        CHECK(as_double(h.properties.gyration_squared.x.x) == test::about(third, 1e-4));
        CHECK(as_double(mass_properties(Solid{.geometry = {}, .hull = &h}, 100_r).mass) ==
              test::about(800 * size * size * size, 1e-4));
    }
    oracle::RandomReal random(13);
    for (int i = 0; i < 100; ++i) {
        Points points;
        for (int k = 0; k < 100; ++k)
            points.push_back(
                point(random.uniform(-100, 100), random.uniform(-100, 100), random.uniform(-100, 100)));
        require_good(hull_of(points), points);
    }
}

TEST_CASE("a prism whose ends are uneven by less than the tolerance has flat ends") {
    oracle::RandomReal random(29);
    for (int sides : {5, 12, 30}) {
        Points points;
        for (int k = 0; k < sides; ++k)
            for (double y : {-0.5, 0.5}) {
                const double a = 6.283185307179586 * k / sides;
                points.push_back(point(std::cos(a), y + random.uniform(-1e-5, 1e-5), std::sin(a)));
            }
        const Hull h = hull_of(points);
        require_good(h, points);
        CHECK(h.vertices.size() == static_cast<std::size_t>(2 * sides));
        CHECK(h.faces.size() == static_cast<std::size_t>(sides + 2));
        int ends = 0;
        for (const Hull::Face& f : h.faces) ends += f.count == sides ? 1 : 0;
        CHECK(ends == 2);
    }
}

TEST_CASE("merged faces of finely rounded shapes stay convex polygons") {
    oracle::RandomReal random(31);
    for (int i = 0; i < 100; ++i) { // a shallow dome: neighbours differ by about the tolerance
        const double height = random.log_uniform(0.0005, 0.05);
        Points points = box_corners(1, 0.3, 1);
        for (int k = 0; k < 150; ++k) {
            const double x = random.uniform(-0.99, 0.99), z = random.uniform(-0.99, 0.99);
            points.push_back(point(x, 0.3 + height * (2 - x * x - z * z), z));
        }
        const Hull h = hull_of(points);
        require_good(h, points);
        for (const Hull::Face& f : h.faces) {
            for (std::size_t k = 0; k < f.count; ++k) {
                const auto at = [&](std::size_t c) {
                    return as_double(h.vertices[h.loops[f.first + c % f.count]]);
                };
                const D3 edge = at(k + 1) - at(k);
                const D3 inward = cross(as_double(f.normal), edge) * (1 / norm(edge));
                for (std::size_t c = 0; c < f.count; ++c) REQUIRE(dot(inward, at(c) - at(k)) > -6e-4);
            }
        }
    }
}
