// Triangles of every shape, for drawing and for tests.
#include "lockstone/math/math.h"
#include "shapes/asset/asset.h"
#include "shapes/hull/hull.h"
#include "shapes/mesh/height_field.h"
#include "shapes/mesh/mesh.h"

#include <algorithm>

namespace lockstone {
namespace {

using shapes::Solid;

/// One side of the profile of a solid of revolution around y: distances from the axis and heights, from the
/// lowest upward.
struct ProfilePoint {
    Real distance, height;
};
using Profile = std::vector<ProfilePoint>;

class Soup {
  public:
    explicit Soup(int steps) : round(std::clamp(steps, 1, 64)) {}

    std::uint32_t vertex(Vec3 p) {
        soup.vertices.push_back(p);
        return static_cast<std::uint32_t>(soup.vertices.size() - 1);
    }
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) { soup.triangles.push_back({a, b, c}); }

    /// Adds an arc of a circle around (distance, height), with angles in radians from the horizontal; both ends
    /// included.
    void add_arc(Profile& profile, ProfilePoint center, Real radius, Real from, Real to) const {
        for (int i = 0; i <= round; ++i) {
            const Real angle = from + (to - from) * i / Real(round);
            profile.push_back({center.distance + radius * cos(angle), center.height + radius * sin(angle)});
        }
    }
    /// Adds the solid of revolution of a profile that starts and ends on the axis.
    void revolve(const Profile& profile) {
        const std::uint32_t around = static_cast<std::uint32_t>(4 * round);
        const std::uint32_t bottom = vertex({Real{}, profile.front().height, Real{}});
        const std::uint32_t rings = static_cast<std::uint32_t>(profile.size() - 2);
        for (std::uint32_t r = 0; r < rings; ++r)
            for (std::uint32_t k = 0; k < around; ++k) {
                const Real angle = two_pi * k / Real(around);
                const ProfilePoint p = profile[r + 1];
                vertex({p.distance * cos(angle), p.height, p.distance * sin(angle)});
            }
        const std::uint32_t top = vertex({Real{}, profile.back().height, Real{}});
        const auto at = [&](std::uint32_t ring, std::uint32_t k) {
            return bottom + 1 + ring * around + k % around;
        };
        for (std::uint32_t k = 0; k < around; ++k) {
            triangle(bottom, at(0, k), at(0, k + 1));
            for (std::uint32_t r = 0; r + 1 < rings; ++r) {
                triangle(at(r, k), at(r + 1, k), at(r + 1, k + 1));
                triangle(at(r, k), at(r + 1, k + 1), at(r, k + 1));
            }
            triangle(top, at(rings - 1, k + 1), at(rings - 1, k));
        }
    }

    /// Adds a box with a grid on each face. With a radius, the grid's points are points of the core moved
    /// outward by it.
    void add_box(Vec3 half, Real radius) {
        const int cells = radius > Real{} ? 2 * round + 1 : 1;
        for (int face = 0; face < 6; ++face) {
            const int a = face / 2, b = (a + 1) % 3, c = (a + 2) % 3;
            const Real side = face % 2 == 0 ? Real(-1) : Real(1);
            const std::uint32_t first = static_cast<std::uint32_t>(soup.vertices.size());
            const std::uint32_t row = static_cast<std::uint32_t>(cells) + 1;
            for (int i = 0; i <= cells; ++i)
                for (int j = 0; j <= cells; ++j)
                    vertex(box_point(half, radius, {a, b, c}, side, i, j, cells));
            for (std::uint32_t i = 0; i + 1 < row; ++i)
                for (std::uint32_t j = 0; j + 1 < row; ++j) {
                    const std::uint32_t p = first + i * row + j, q = p + row;
                    const bool outward = face % 2 != 0;
                    triangle(p, outward ? q : q + 1, outward ? q + 1 : q);
                    triangle(p, outward ? q + 1 : p + 1, outward ? p + 1 : q + 1);
                }
        }
    }

    void add(const TriangleSoup& other, const Transform& local) {
        const std::uint32_t first = static_cast<std::uint32_t>(soup.vertices.size());
        for (const Vec3& p : other.vertices) vertex(local * p);
        for (const auto& t : other.triangles) triangle(first + t[0], first + t[1], first + t[2]);
    }
    const int round;
    TriangleSoup soup;

  private:
    struct Axes {
        int a, b, c;
    };
    /// Point (i, j) of a face's grid. On a rounded face the first and the last `round` cells cover 45 degrees
    /// of rounding.
    Vec3 box_point(Vec3 half, Real radius, Axes axes, Real side, int i, int j, int cells) const {
        if (radius <= Real{}) {
            Vec3 p{};
            p[axes.a] = side * half[axes.a];
            p[axes.b] = i == 0 ? -half[axes.b] : half[axes.b];
            p[axes.c] = j == 0 ? -half[axes.c] : half[axes.c];
            return p;
        }
        const auto lean = [&](int k) { // tangent of the slope towards an edge
            const int from_middle = 2 * k < cells ? k - round : k - round - 1;
            return tan(half_pi * from_middle / Real(2 * round));
        };
        Vec3 direction{};
        direction[axes.a] = side;
        direction[axes.b] = lean(i);
        direction[axes.c] = lean(j);
        const UnitVec3 n = normalized(direction);
        Vec3 p = scale<Real>(n, radius);
        p[axes.a] += side * half[axes.a];
        p[axes.b] += 2 * i < cells ? -half[axes.b] : half[axes.b];
        p[axes.c] += 2 * j < cells ? -half[axes.c] : half[axes.c];
        return p;
    }
};

void add_round(Soup& soup, const Geometry& g, Real r, Vec3 half) {
    const Real q = half_pi, h = half.y, c = half.x;
    Profile profile;
    switch (g.kind) {
    case ShapeKind::sphere:
    case ShapeKind::capsule:
        if (h <= Real{}) {
            soup.add_arc(profile, {}, r, -q, Real{});
            profile.pop_back();
            soup.add_arc(profile, {}, r, Real{}, q);
        } else {
            soup.add_arc(profile, {Real{}, -h}, r, -q, Real{});
            soup.add_arc(profile, {Real{}, h}, r, Real{}, q);
        }
        break;
    case ShapeKind::cylinder:
        profile.push_back({Real{}, -h - r});
        if (r > Real{}) {
            soup.add_arc(profile, {c, -h}, r, -q, Real{});
            soup.add_arc(profile, {c, h}, r, Real{}, q);
        } else {
            profile.insert(profile.end(), {{c, -h}, {c, h}});
        }
        profile.push_back({Real{}, h + r});
        break;
    default: { // cone; its slant's normal has the angle of (2 h, c)
        const Real slant = atan2(c, h + h);
        profile.push_back({Real{}, -h - r});
        if (r > Real{}) {
            soup.add_arc(profile, {c, -h}, r, -q, slant);
            soup.add_arc(profile, {Real{}, h}, r, slant, q);
        } else {
            profile.insert(profile.end(), {{c, -h}, {Real{}, h}});
            break;
        }
        profile.pop_back();
        profile.push_back({Real{}, h + r});
    }
    }
    soup.revolve(profile);
}

/// For a rounded hull, places a polytope of directions at each corner and takes the hull of all points.
TriangleSoup hull_soup(const shapes::Hull& hull, Length radius) {
    TriangleSoup out;
    const auto add = [&out](std::span<const LengthVec3> vertices, const auto& triangles) {
        for (const LengthVec3& v : vertices) out.vertices.push_back(to<Real>(v));
        for (const auto& t : triangles) out.triangles.push_back({t[0], t[1], t[2]});
    };
    if (radius <= Length{}) {
        add(hull.vertices, hull.triangles);
    } else {
        const shapes::ConvexSurface surface = shapes::rounded_surface(hull, radius, Real(1));
        add(surface.vertices, surface.triangles);
    }
    return out;
}

TriangleSoup solid_soup(const Solid& solid, int round) {
    const Geometry& g = solid.geometry;
    Soup out(round);
    const Real factor = Real(g.scale.x.raw >> Length::fraction_bits);
    if (solid.hull != nullptr) return hull_soup(*solid.hull, g.radius);
    if (solid.compound != nullptr) {
        for (const auto& part : solid.compound->parts) out.add(solid_soup(part.solid, round), part.local);
    } else if (solid.mesh != nullptr) {
        for (const shapes::MeshVertex& v : solid.mesh->raw().vertices)
            out.vertex(to<Real>(shapes::scaled_by(position_of(v), g.scale)));
        for (const auto& t : solid.mesh->raw().triangles) out.triangle(t[0], t[1], t[2]);
    } else if (solid.height_field != nullptr) {
        const shapes::HeightField& field = *solid.height_field;
        for (std::uint32_t i = 0; i < field.sample_count(); ++i)
            out.vertex(to<Real>(shapes::scaled_by(field.sample(i), g.scale)));
        for (std::uint32_t i = 0; i < field.triangle_count(); ++i) {
            const auto t = field.samples_of(i);
            if (!field.is_hole(i)) out.triangle(t[0], t[1], t[2]);
        }
    } else if (g.kind == ShapeKind::box) {
        out.add_box(to<Real>(g.half_extent) * factor, to<Real>(g.radius) * factor);
    } else if (g.kind != ShapeKind::plane) {
        add_round(out, g, to<Real>(g.radius) * factor, to<Real>(g.half_extent) * factor);
    }
    return std::move(out.soup);
}

} // namespace

TriangleSoup triangulate(const Geometry& geometry, const AssetLibrary& library, int round) {
    using Borrowed = std::shared_ptr<const AssetLibrary>;
    shapes::SolidCache cache(Borrowed(Borrowed{}, &library)); // owns nothing
    const Result<Solid> solid = cache.resolve(geometry);
    return solid ? solid_soup(*solid, round) : TriangleSoup{};
}

} // namespace lockstone
