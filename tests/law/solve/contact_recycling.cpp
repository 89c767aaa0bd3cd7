// Recycled manifolds. Their error against fresh manifolds is within the bound that solve/contacts/contact_memory.h
// states, on faces, edges and corners, and they are recycled as often as that bound allows.
#include "lockstone/math/math.h"
#include "oracle/double_shapes.h"
#include "solve/contacts/contact_memory.h"
#include "support/pair_lanes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>

using namespace lockstone;
using namespace lockstone::collide;
using oracle::as_double;
using oracle::as_fixed;
using solve::ContactMemory;

namespace {

constexpr Length margin = decimal<Length>("0.02");

struct Chance {
    std::mt19937_64 engine{7};
    double operator()(double low, double high) {
        return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
    }
    UnitVec3 direction() {
        for (;;) {
            const double x = (*this)(-1, 1), y = (*this)(-1, 1), z = (*this)(-1, 1),
                         n = x * x + y * y + z * z;
            if (n < 0.01 || n > 1) continue;
            return normalized(UnitVec3{as_fixed<Unit>(x), as_fixed<Unit>(y), as_fixed<Unit>(z)});
        }
    }
};

struct Pair {
    const char* what;
    shapes::Solid a, b;
    double distance;                                     ///< between the centres at first
    bool (*is_corner)(std::uint32_t feature, bool of_a); ///< the points with the tightest bound
};

/// Returns whether the feature is a corner of the box whose face does not give the normal. `of_a`: the normal is of A's
/// face.
bool box_corner(std::uint32_t f, bool of_a) { return f >> 16 == (of_a ? 2u : 1u); }
bool any(std::uint32_t, bool) { return true; }
bool none(std::uint32_t, bool) { return false; }

struct Library {
    AssetLibrary assets;
    Chance chance;

    shapes::Solid hull(double size) {
        std::vector<LengthVec3> points;
        for (int i = 0; i < 18; ++i) {
            const UnitVec3 d = chance.direction();
            const auto at = [&](Unit u) { return as_fixed<Length>(size * as_double(u)); };
            points.push_back({at(d.x), at(d.y), at(d.z)});
        }
        const AssetId id = assets.add(bake_hull(points)).value();
        return {assets.geometry(id).value(), assets.find(id)->hull.get()};
    }
    /// A flat floor of 4 x 4 squares of 1 m.
    shapes::Solid floor() {
        std::vector<Vec3> corners;
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (std::uint32_t i = 0; i < 25; ++i)
            corners.push_back({Real(static_cast<int>(i % 5) - 2), 0_r, Real(static_cast<int>(i / 5) - 2)});
        for (std::uint32_t i = 0; i < 20; ++i) {
            if (i % 5 == 4) continue;
            triangles.push_back({i, i + 5, i + 1}), triangles.push_back({i + 1, i + 5, i + 6});
        }
        const AssetId id = assets.add(bake_mesh({.vertices = corners, .triangles = triangles})).value();
        shapes::Solid solid{assets.geometry(id).value()};
        solid.mesh = assets.find(id)->mesh.get();
        return solid;
    }
};

ContactMemory memory_of(const Manifold& m, const RelativePose& pose, Quat rotation) {
    ContactMemory out{};
    out.flags = m.on_face != 0 ? solve::contact_on_face : 0u;
    out.count = m.count;
    for (std::uint32_t k = 0; k < m.count; ++k)
        out.points[k] = {m.points[k].position, m.points[k].feature, m.points[k].separation, {}};
    out.made_position = pose.position, out.made_rotation = rotation;
    out.normal = m.normal, out.margin = margin;
    return out;
}

struct Worst {
    int kept = 0, compared = 0;
    double corner = 0, least = 0;
};

class Trial {
  public:
    Trial(const Pair& of, Chance& random) : pair(of), chance(random) {
        const shapes::Extent e = shapes::extent_of(pair.b);
        reach = length(max(abs(e.lower), abs(e.upper)));
        thinnest = shapes::inner_radius(pair.b);
        if (pair.a.geometry.kind < ShapeKind::compound)
            thinnest = min(thinnest, shapes::inner_radius(pair.a));
    }

    void run(Worst& worst) {
        if (!touch()) return;
        std::vector<ContactMemory> rows;
        for (std::uint32_t i = 0; i < made.count; ++i)
            rows.push_back(memory_of(made.items[i], pose, rotation));
        // The bound of a length is up to 1.12 times the length.
        const double on_face = std::max(0.0001, std::min(0.001, as_double(thinnest) / 128));
        const double limit = std::min(made.items[0].on_face != 0 ? on_face : 0.0001, as_double(reach) / 256);
        const double most = limit * chance(0.3, 1), part = chance(0, 1);
        move(most * part, most * (1 - part) / as_double(reach));
        const tests::Recycled again =
            tests::recycle(rows, {pose.position, rotation, reach, thinnest, margin});
        if (!again.serves) return;
        ++worst.kept;
        Manifolds fresh;
        collide::collide(pair.a, pair.b, pose, margin, scratch, fresh);
        REQUIRE(fresh.count > 0);
        for (std::size_t r = 0; r < rows.size(); ++r) {
            std::array<Separation, 4> separations{};
            for (std::uint32_t k = 0; k < rows[r].count; ++k)
                separations[k] = again.contacts[r].points[k].separation;
            for (std::uint32_t i = 0; i < fresh.count; ++i)
                compare(rows[r], separations, fresh.items[i], worst);
        }
    }

  private:
    /// Moves B to within some millimetres of A.
    bool touch() {
        const UnitVec3 from = chance.direction();
        const bool upright = pair.a.geometry.kind > ShapeKind::compound;
        rotation = from_axis_angle(chance.direction(),
                                   as_fixed<Real>(chance(0, 1) < 0.5 ? chance(-0.02, 0.02) : chance(-3, 3)));
        const auto at = [&](Unit u) { return as_fixed<Coordinate>(pair.distance * as_double(u)); };
        pose.position = upright ? CoordinateVec3{as_fixed<Coordinate>(chance(-0.4, 0.4)),
                                                 as_fixed<Coordinate>(pair.distance),
                                                 as_fixed<Coordinate>(chance(-0.4, 0.4))}
                                : CoordinateVec3{at(from.x), at(from.y), at(from.z)};
        if (pair.a.geometry.kind == ShapeKind::plane) pose.position.x = pose.position.z = Coordinate{};
        const double wanted = chance(-0.001, 0.004);
        for (int round = 0; round < 8; ++round) {
            pose.rotation = to_rotation(rotation);
            collide::collide(pair.a, pair.b, pose, Length(2), scratch, made);
            if (made.count == 0) return false;
            const Manifold& m = made.items[0];
            double least = 1e9;
            for (std::uint32_t k = 0; k < m.count; ++k)
                least = std::min(least, as_double(m.points[k].separation));
            if (std::abs(least - wanted) < 1e-6) break;
            for (int i = 0; i < 3; ++i)
                pose.position[i] -= as_fixed<Coordinate>((least - wanted) * as_double(m.normal[i]));
        }
        collide::collide(pair.a, pair.b, pose, margin, scratch, made);
        return made.count > 0;
    }
    void move(double by, double turn) {
        const UnitVec3 way = chance.direction(), axis = chance.direction();
        for (int i = 0; i < 3; ++i) pose.position[i] += as_fixed<Coordinate>(by * as_double(way[i]));
        if (pair.a.geometry.kind == ShapeKind::plane) pose.position.x = pose.position.z = Coordinate{};
        rotation = normalized(from_axis_angle(axis, as_fixed<Real>(turn)) * rotation);
        pose.rotation = to_rotation(rotation);
    }
    void compare(const ContactMemory& row, const std::array<Separation, 4>& separations,
                 const Manifold& fresh, Worst& worst) const {
        const bool on_face = (row.flags & solve::contact_on_face) != 0;
        const UnitVec3 off = row.normal - fresh.normal;
        const double angle = std::sqrt(as_double(dot<Real>(off, off)));
        // The fresh manifold uses another face or another pair of edges, so there is no value to compare with.
        if (angle > (on_face ? 0.004 : 0.3) || (fresh.on_face != 0) != on_face) return;
        const auto is_axis = [](Unit u) { return abs(u) >= unit_one - Unit::from_raw(4); };
        const bool of_a = is_axis(row.normal.x) || is_axis(row.normal.y) || is_axis(row.normal.z);
        double least = 1e9, least_fresh = 1e9;
        for (std::uint32_t i = 0; i < fresh.count; ++i)
            least_fresh = std::min(least_fresh, as_double(fresh.points[i].separation));
        for (std::uint32_t k = 0; k < row.count; ++k) {
            least = std::min(least, as_double(separations[k]));
            for (std::uint32_t i = 0; i < fresh.count; ++i) {
                if (row.points[k].feature != fresh.points[i].feature) continue;
                const double error =
                    std::abs(as_double(separations[k]) - as_double(fresh.points[i].separation));
                ++worst.compared;
                if (on_face && pair.is_corner(row.points[k].feature, of_a))
                    worst.corner = std::max(worst.corner, error);
            }
        }
        worst.least = std::max(worst.least, std::abs(least - least_fresh));
    }

    const Pair& pair;
    Chance& chance;
    Coordinate reach{};
    Length thinnest{};
    RelativePose pose{};
    Quat rotation{};
    Manifolds made;
    NarrowScratch scratch;
};

} // namespace

TEST_CASE("the error of a reused manifold stays within the bound of its header") {
    Library library;
    const shapes::Solid unit_box{box(0.5_r, 0.5_r, 0.5_r)}, slab{box(1_r, 0.1_r, 0.6_r)},
        little{box(0.05_r, 0.02_r, 0.03_r)}, ball{sphere(0.4_r)}, bead{sphere(0.02_r)},
        pill{capsule(0.2_r, 0.3_r)}, drum{cylinder(0.3_r, 0.2_r)}, ground{plane()};
    const shapes::Solid stone = library.hull(0.5), pebble = library.hull(0.06), floor = library.floor();
    const Pair pairs[] = {{"box on box", unit_box, unit_box, 1.2, box_corner},
                          {"slab on box", slab, unit_box, 1.0, box_corner},
                          {"small on small", little, little, 0.1, box_corner},
                          {"small box on slab", slab, little, 0.6, box_corner},
                          {"hull on hull", stone, stone, 0.9, none},
                          {"small hull on hull", stone, pebble, 0.5, none},
                          {"box on plane", ground, slab, 0.5, any},
                          {"hull on plane", ground, stone, 0.5, any},
                          {"ball on plane", ground, ball, 0.5, any},
                          {"drum on plane", ground, drum, 0.4, none},
                          {"ball on box", unit_box, ball, 0.9, any},
                          {"bead on box", unit_box, bead, 0.55, any},
                          {"pill on box", unit_box, pill, 0.9, none},
                          {"ball and ball", ball, ball, 0.7, none},
                          {"pill and pill", pill, pill, 0.6, none},
                          {"pill and ball", pill, ball, 0.7, none},
                          {"ball on mesh", floor, ball, 0.5, any},
                          {"box on mesh", floor, slab, 0.5, none},
                          {"hull on mesh", floor, stone, 0.5, none},
                          {"pill on mesh", floor, pill, 0.5, none}};
    for (const Pair& pair : pairs) {
        CAPTURE(pair.what);
        Worst worst;
        for (int i = 0; i < 1000; ++i) Trial(pair, library.chance).run(worst);
        MESSAGE(std::string(pair.what), ": kept ", worst.kept, ", points compared ", worst.compared,
                ", corners ", worst.corner * 1e6, " um, the least separation ", worst.least * 1e6, " um");
        CHECK(worst.kept > 300);
        CHECK(worst.compared > 200);
        CHECK(worst.corner <= as_double(solve::recycling_error));
        // A point is kept beyond the edge of a face, by as much as it has moved.
        CHECK(worst.least <= as_double(solve::recycling_on_face));
    }
}

TEST_CASE("a manifold is not reused if its pair has moved or turned too far or is near from farther off") {
    ContactMemory row{};
    row.flags = solve::contact_on_face, row.count = 1, row.normal.y = unit_one;
    row.made_rotation = Quat::identity(), row.margin = margin;
    const auto serves = [&](double moved, double turned, Length ahead = margin) {
        const tests::PairStand now{{as_fixed<Coordinate>(moved), Coordinate{}, Coordinate{}},
                                   from_axis_angle({unit_one, Unit{}, Unit{}}, as_fixed<Real>(turned)),
                                   Coordinate(1),
                                   Length(1),
                                   ahead};
        return tests::recycle({&row, 1}, now).serves;
    };
    CHECK(serves(0.0009, 0));
    CHECK_FALSE(serves(0.0011, 0));
    CHECK(serves(0, 0.0009));
    CHECK_FALSE(serves(0, 0.0011));
    CHECK_FALSE(serves(0.0006, 0.0006));
    CHECK_FALSE(serves(0, 0, margin + Length::step()));
    row.flags = 0; // an edge gives the normal
    CHECK(serves(0.00009, 0));
    CHECK_FALSE(serves(0.00011, 0));
}
