#include "scenes/props.h"

#include "lockstone/math/math.h"

#include <array>

namespace lockstone::scenes_detail {
namespace {

using Corners = std::vector<LengthVec3>;

LengthVec3 corner(Vec3 direction, Real size) { return to<Length>(direction * size); }

/// A gem: flat above, pointed below, eight facets around.
Corners gem(Real size) {
    Corners out;
    for (int i = 0; i < 8; ++i) {
        const Real angle = two_pi * Real(i) / 8_r;
        out.push_back(corner({0.92_r * cos(angle), 0.25_r, 0.92_r * sin(angle)}, size));
        out.push_back(corner({0.6_r * cos(angle), 0.5_r, 0.6_r * sin(angle)}, size));
    }
    out.push_back(corner({0_r, -1_r, 0_r}, size));
    return out;
}

/// An icosahedron from three golden rectangles, each perpendicular to the others.
Corners icosahedron(Real size) {
    constexpr Real near = 0.5257_r, far = 0.8506_r; // 1 and the golden ratio, scaled to length 1
    Corners out;
    for (const Real a : {-near, near})
        for (const Real b : {-far, far})
            for (const Vec3 p : {Vec3{0_r, a, b}, Vec3{a, b, 0_r}, Vec3{b, 0_r, a}})
                out.push_back(corner(p, size));
    return out;
}

Corners wedge(Real size) {
    Corners out;
    for (const Real z : {-0.45_r, 0.45_r})
        for (const Vec3 p : {Vec3{-0.75_r, -0.4_r, z}, Vec3{0.75_r, -0.4_r, z}, Vec3{-0.75_r, 0.4_r, z}})
            out.push_back(corner(p, size));
    return out;
}

Corners tetrahedron(Real size) {
    constexpr Real a = 0.577_r;
    return {corner({a, a, a}, size), corner({a, -a, -a}, size), corner({-a, a, -a}, size),
            corner({-a, -a, a}, size)};
}

/// Corners on an ellipsoid. Every scene gets the same rock.
Corners rock(Real size) {
    Random random = Random::seeded(40);
    Corners out;
    while (out.size() < 40) {
        const Vec3 p{random.range(-1_r, 1_r), random.range(-1_r, 1_r), random.range(-1_r, 1_r)};
        const Real length_squared = dot(p, p);
        if (length_squared > 1_r || length_squared < 0.1_r) continue;
        const Vec3 direction = p / sqrt(length_squared);
        out.push_back(corner({direction.x, 0.7_r * direction.y, 0.85_r * direction.z}, size));
    }
    return out;
}

} // namespace

std::vector<Geometry> bake_props(Shelf& shelf, Real size) {
    std::vector<Geometry> out;
    for (const Corners& corners : {gem(size), icosahedron(size), wedge(size), tetrahedron(size), rock(size)})
        out.push_back(shelf.add(bake_hull(corners)));
    const auto of = [&](Real share) { return share * size; };
    out.push_back(cylinder(of(0.6_r), of(0.7_r)));
    out.push_back(cone(of(0.75_r), of(0.6_r)));
    out.push_back(capsule(of(0.45_r), of(0.5_r)));
    out.push_back(rounded(box(of(0.55_r), of(0.4_r), of(0.4_r)), of(0.12_r)));
    out.push_back(rounded(cylinder(of(0.6_r), of(0.3_r)), of(0.12_r)));
    out.push_back(rounded(cone(of(0.55_r), of(0.5_r)), of(0.12_r)));
    return out;
}

Quat random_turn(Random& random) {
    const Real a = random.range(-pi, pi), b = random.range(-1_r, 1_r), c = random.range(-pi, pi);
    return from_euler({a, b, c});
}

} // namespace lockstone::scenes_detail
