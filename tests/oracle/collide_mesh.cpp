// Contacts with meshes and height fields against double precision: the reference tests every triangle alone, without
// trees, culling or clipping. Cores are outside of the surface; tests/law/collide/collide_triangles.cpp tests how deep
// cores are pushed out.
#include "lockstone/math/math.h"
#include "oracle/mesh_scenes.h"

#include <cstdio>

using namespace lockstone;
using namespace mesh_scenes;
using oracle::as_double;
using oracle::RandomReal;

namespace {

const Length margin = as_fixed<Length>(0.02);
constexpr double margin_m = 0.02;

/// A convex core in double precision: its support mapping from the definition.
struct DoubleConvex {
    DoubleConvex(const shapes::Solid& b, const collide::RelativePose& pose)
        : kind(b.geometry.kind), radius(as_double(b.geometry.radius)),
          half(as_double(b.geometry.half_extent)),
          center(as_double(pose.position)), axes{as_double(pose.rotation.x), as_double(pose.rotation.y),
                                                 as_double(pose.rotation.z)} {
        if (kind == ShapeKind::hull)
            for (const LengthVec3& v : b.hull->vertices) corners.push_back(place(as_double(v)));
    }
    explicit DoubleConvex(const shapes::Triangle& t)
        : kind(ShapeKind::hull), corners{as_double(t.corner[0]), as_double(t.corner[1]),
                                         as_double(t.corner[2])} {}

    D3 support_point(D3 n) const {
        const D3 d{oracle::dot(axes[0], n), oracle::dot(axes[1], n), oracle::dot(axes[2], n)};
        const auto end = [](double x, double h) { return x < 0 ? -h : h; };
        const double flat = std::hypot(d.x, d.z);
        const D3 rim = flat > 0 ? D3{half.x * d.x / flat, 0, half.x * d.z / flat} : D3{half.x, 0, 0};
        switch (kind) {
        case ShapeKind::sphere:
            return center;
        case ShapeKind::capsule:
            return center + axes[1] * end(d.y, half.y);
        case ShapeKind::box:
            return place({end(d.x, half.x), end(d.y, half.y), end(d.z, half.z)});
        case ShapeKind::cylinder:
            return place({rim.x, end(d.y, half.y), rim.z});
        case ShapeKind::cone:
            return place(d.y * 2 * half.y > half.x * flat ? D3{0, half.y, 0} : D3{rim.x, -half.y, rim.z});
        default:
            return *std::max_element(corners.begin(), corners.end(),
                                     [&](D3 a, D3 b) { return oracle::dot(a, n) < oracle::dot(b, n); });
        }
    }
    D3 place(D3 p) const { return center + axes[0] * p.x + axes[1] * p.y + axes[2] * p.z; }
    double support(D3 n) const { return oracle::dot(n, support_point(n)); }

    ShapeKind kind;
    double radius = 0;
    D3 half{}, center{};
    D3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    std::vector<D3> corners;
};
double separation_along(const DoubleConvex& a, const DoubleConvex& b, D3 n) {
    return -b.support(n * -1.0) - a.support(n);
}

/// The point nearest to the origin of the hull of up to four points, found by trying all subsets.
struct NearestPoint {
    D3 at;
    std::vector<D3> kept;
};
/// The nearest point of the affine hull; returns false when the points are dependent.
bool affine_nearest(const std::vector<D3>& p, D3& at) {
    const std::size_t n = p.size();
    if (n == 1) return at = p[0], true;
    // Gram matrix of the edges from p[0], solved by elimination.
    double m[3][4] = {};
    for (std::size_t i = 1; i < n; ++i) {
        for (std::size_t j = 1; j < n; ++j) m[i - 1][j - 1] = oracle::dot(p[i] - p[0], p[j] - p[0]);
        m[i - 1][3] = -oracle::dot(p[i] - p[0], p[0]);
    }
    const std::size_t size = n - 1;
    for (std::size_t k = 0; k < size; ++k) {
        std::size_t pivot = k;
        for (std::size_t i = k + 1; i < size; ++i)
            if (std::abs(m[i][k]) > std::abs(m[pivot][k])) pivot = i;
        if (std::abs(m[pivot][k]) < 1e-22) return false;
        std::swap(m[k], m[pivot]);
        for (std::size_t i = 0; i < size; ++i) {
            if (i == k) continue;
            const double f = m[i][k] / m[k][k];
            for (std::size_t j = k; j < 4; ++j) m[i][j] -= f * m[k][j];
        }
    }
    double first = 1;
    at = {0, 0, 0};
    for (std::size_t k = 0; k < size; ++k) {
        const double w = m[k][3] / m[k][k];
        if (w < 0) return false;
        first -= w;
        at = at + p[k + 1] * w;
    }
    if (first < 0) return false;
    at = at + p[0] * first;
    return true;
}
NearestPoint nearest_of(const std::vector<D3>& points) {
    NearestPoint best{{1e9, 0, 0}, {}};
    for (unsigned set = 1; set < 1u << points.size(); ++set) {
        std::vector<D3> part;
        for (std::size_t i = 0; i < points.size(); ++i)
            if ((set >> i & 1u) != 0) part.push_back(points[i]);
        D3 at;
        if (affine_nearest(part, at) && oracle::norm(at) < oracle::norm(best.at)) best = {at, part};
    }
    return best;
}

/// Distance of two cores, 0 when they overlap.
/// source: Gilbert, Johnson, Keerthi, 1988, with the simplex solved by brute force.
double distance(const DoubleConvex& a, const DoubleConvex& b) {
    std::vector<D3> simplex{b.support_point({1, 0, 0}) - a.support_point({-1, 0, 0})};
    NearestPoint nearest{};
    for (int i = 0; i < 300; ++i) {
        nearest = nearest_of(simplex);
        const double length = oracle::norm(nearest.at);
        if (length < 1e-10) return 0;
        const D3 d = nearest.at * (-1 / length);
        const D3 next = b.support_point(d) - a.support_point(d * -1.0);
        if (oracle::dot(next, d) + length < 1e-11) return length;
        simplex = nearest.kept;
        simplex.push_back(next);
        if (simplex.size() > 4) simplex.erase(simplex.begin());
    }
    return oracle::norm(nearest.at);
}

/// A triangle of the mesh near a place, in double precision.
struct NearTriangle {
    shapes::Triangle triangle;
    DoubleConvex core;
    bool slightly_bent; ///< has a convex edge that counts as flat
};

bool is_slightly_bent(const shapes::Triangle& t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
        const D3 edge = as_double(t.corner[(k + 1) % 3]) - as_double(t.corner[k]);
        D3 out = oracle::cross(edge, as_double(t.normal));
        out = out * (1 / oracle::norm(out));
        if ((t.sharp >> k & 1u) == 0 && oracle::dot(out, as_double(t.beyond[k])) > 1e-6) return true;
    }
    return false;
}

std::vector<NearTriangle> triangles_about(const shapes::Solid& solid, D3 at, double reach) {
    std::vector<NearTriangle> out;
    for (std::uint32_t i = 0; i < shapes::triangle_count(solid); ++i) {
        const shapes::Triangle t = shapes::triangle_at(solid, i);
        bool near = true;
        for (int axis = 0; axis < 3; ++axis) {
            double low = 1e9, high = -1e9;
            for (const CoordinateVec3& c : t.corner) {
                low = std::min(low, as_double(c[axis]));
                high = std::max(high, as_double(c[axis]));
            }
            near = near && low < at[axis] + reach && high > at[axis] - reach;
        }
        if (near) out.push_back({t, DoubleConvex(t), is_slightly_bent(t)});
    }
    return out;
}

/// Returns whether a point is on the front side of the nearest triangle. Among equally near ones, the one with the
/// greatest height difference decides.
bool is_outside(const std::vector<NearTriangle>& triangles, D3 point) {
    DoubleConvex core(primitive(sphere(1_r)), {Rotation::identity(), CoordinateVec3{}});
    core.center = point;
    double least = 1e9, height = 1;
    for (const NearTriangle& t : triangles) {
        const double d = distance(t.core, core);
        const double above =
            oracle::dot(as_double(t.triangle.normal), point - as_double(t.triangle.corner[0]));
        if (d > least + 1e-9 || (d > least - 1e-9 && std::abs(above) < std::abs(height))) continue;
        least = d;
        height = above;
    }
    return height > 0;
}

/// Returns an error sentence unless the manifolds are right for a shape outside of the mesh. `truth`: separation of the
/// nearest triangle; negative if only the rounding overlaps.
std::string check(const std::vector<NearTriangle>& triangles, const DoubleConvex& b, double bias,
                  double reach, const collide::Manifolds& m, double& truth) {
    bool bent = false;
    double least = 1e9;
    std::vector<double> distances;
    for (const NearTriangle& t : triangles) {
        distances.push_back(distance(t.core, b));
        least = std::min(least, distances.back());
        bent = bent || t.slightly_bent;
    }
    truth = least - b.radius;
    std::ostringstream why;
    if (triangles.empty()) return m.count == 0 ? "" : "contact with nothing; ";
    const double bend = bent ? 0.035 * reach : 0; // neighbours share flat edges, with normals of their own
    const double tolerance = 1e-6 + 1e-7 * reach, noise = 0.000123;
    if (m.count == 0) {
        if (truth < margin_m - tolerance - bend) why << "misses a gap of " << truth << "; ";
        return why.str();
    }
    if (truth > margin_m + tolerance) why << "a contact for a gap of " << truth << "; ";
    double deepest = 1;
    bool parted = false; // a normal separates the shape from a nearest triangle as well as the best one does
    for (std::uint32_t i = 0; i < m.count; ++i) {
        double own = 1;
        for (std::uint32_t k = 0; k < m.items[i].count; ++k)
            own = std::min(own, as_double(m.items[i].points[k].separation));
        if (i > 0 && own < deepest - 1e-9) why << "not the deepest first; ";
        deepest = std::min(deepest, own);
        const D3 n = as_double(m.items[i].normal);
        if (std::abs(oracle::norm(n) - 1) > 4e-9) why << "normal of length " << oracle::norm(n) << "; ";
        // All triangles count that are nearest up to the preferences.
        for (std::size_t t = 0; t < triangles.size(); ++t)
            parted = parted || (distances[t] < least + bias + noise + tolerance &&
                                separation_along(triangles[t].core, b, n) > least - bias - tolerance - bend);
    }
    if (deepest < truth - tolerance - bend * 0.1)
        why << "deepest point " << deepest << ", truth " << truth << "; ";
    if (deepest > truth + bias + tolerance + bend * 0.3)
        why << "deepest point " << deepest << " is above the truth, " << truth << "; ";
    if (!parted) why << "no normal parts the shape from the nearest triangle, truth " << truth << "; ";
    return why.str();
}

/// A closed surface about the origin with a varying radius; each of its poles has twelve triangles.
Soup boulder(RandomReal& random, double size, double roughness) {
    constexpr int around = 12, rings = 5;
    std::vector<D3> points;
    const auto place = [&](double latitude, double longitude) {
        const double r = size * (1 + random.uniform(-roughness, roughness));
        points.push_back(D3{std::cos(latitude) * std::cos(longitude), std::sin(latitude),
                            std::cos(latitude) * std::sin(longitude)} *
                         r);
    };
    for (int ring = 0; ring < rings; ++ring)
        for (int k = 0; k < around; ++k)
            place(-1.05 + 2.1 * ring / (rings - 1), 6.283185307179586 * k / around);
    place(-1.5707963, 0);
    place(1.5707963, 0);
    Soup s;
    s.vertices = points;
    const auto at = [](int ring, int k) { return static_cast<std::uint32_t>(ring * around + k % around); };
    for (int k = 0; k < around; ++k) {
        s.triangles.push_back({at(0, k), at(0, k + 1), rings * around});
        s.triangles.push_back({at(rings - 1, k + 1), at(rings - 1, k), rings * around + 1});
        for (int ring = 0; ring + 1 < rings; ++ring) {
            s.triangles.push_back({at(ring, k), at(ring + 1, k), at(ring, k + 1)});
            s.triangles.push_back({at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1)});
        }
    }
    return s;
}

Geometry shape_of(RandomReal& random, int kind, double size) {
    const auto real = [](double x) { return as_fixed<Real>(x); };
    const double x = random.uniform(0.3, 1), y = random.uniform(0.3, 1), z = random.uniform(0.3, 1);
    switch (kind) {
    case 0:
        return sphere(real(size));
    case 1:
        return capsule(real(size * x * 0.5), real(size * y));
    case 2:
        return box(real(size * x), real(size * y), real(size * z));
    case 3:
        return rounded(box(real(size * x), real(size * y), real(size * z)), real(size * 0.1));
    case 4:
        return cylinder(real(size * x), real(size * y));
    default:
        return cone(real(size * x), real(size * y));
    }
}
constexpr int kinds = 7;
constexpr const char* kind_names[kinds] = {"sphere",   "capsule", "box", "rounded box",
                                           "cylinder", "cone",    "hull"};

Owned solid_of(RandomReal& random, int kind, double size) {
    if (kind < 6) return {nullptr, nullptr, primitive(shape_of(random, kind, size))};
    std::vector<LengthVec3> points;
    for (int i = 0; i < 14; ++i) points.push_back(to<Length>(real(random.vector(0.6 * size, size))));
    AssetLibrary library;
    const Result<AssetId> id = library.add(bake_hull(points));
    if (!id) FAIL(id.error().message);
    return own(std::move(library), *id);
}

struct Ground {
    Owned owned;
    double size; ///< shapes are placed within this distance of the middle
    D3 middle;
};

std::vector<Ground> grounds(RandomReal& random) {
    std::vector<Ground> out;
    const auto rough = [&](double, double) { return random.uniform(-0.3, 0.3); };
    out.push_back({mesh(grid(-8, -8, 1, 16, 16, 0.2, 5, rough)), 4, {0, 0, 0}});
    out.push_back({mesh(grid(-8, -8, 0.5, 32, 32, 0.2, 6,
                             [](double x, double z) { return 0.6 * std::sin(1.1 * x) * std::cos(0.9 * z); })),
                   4,
                   {0, 0, 0}});
    for (const double roughness : {0.02, 0.15, 0.3})
        out.push_back({mesh(boulder(random, 3, roughness)), 4, {0, 0, 0}});
    Soup needles; // 20 m long, 4 cm wide, like a washboard
    for (int i = -50; i < 50; ++i) {
        const auto edge = [](int k, double z) { return D3{0.04 * k, k % 2 == 0 ? 0.03 : 0, z}; };
        needles.add(edge(i, -10), edge(i, 10), edge(i + 1, 10), edge(i + 1, -10));
    }
    out.push_back({mesh(needles), 0.8, {0, 0, 0}});
    out.push_back(
        {height_field(17, 17, 1, [&](auto, auto) { return random.uniform(-0.4, 0.4); }), 4, {8, 0, 8}});
    return out;
}

struct Outcome {
    int poses = 0, hits = 0, wrong = 0;
    std::string first;
};

using Damage = void (*)(collide::Manifolds&);

/// A shape near a random place of the surface, moved along the normal there by `low` to `high` times its rounding (at
/// least 0.04 m) from touching.
struct Placement {
    double size, reach;
    Owned b;
    D3 at;
    collide::RelativePose pose;
    DoubleConvex core;
    std::vector<NearTriangle> near;

    bool is_apart() const {
        return std::all_of(near.begin(), near.end(),
                           [&](const NearTriangle& t) { return distance(t.core, core) > 1e-6; });
    }
};
Placement place(const Ground& ground, int kind, RandomReal& random, double low, double high) {
    const std::uint32_t count = shapes::triangle_count(ground.owned.solid);
    D3 on, n;
    do {
        const shapes::Triangle t = shapes::triangle_at(ground.owned.solid, random.below(count));
        const double u = random.uniform(0, 1), v = random.uniform(0, 1 - u);
        on = as_double(t.corner[0]) * (1 - u - v) + as_double(t.corner[1]) * u + as_double(t.corner[2]) * v;
        n = as_double(t.normal);
    } while (std::abs(on.x - ground.middle.x) > ground.size ||
             std::abs(on.z - ground.middle.z) > ground.size);
    const double size = random.log_uniform(0.05, 0.8);
    const Owned b = solid_of(random, kind, size);
    const Quat q = random.below(3) == 0 ? Quat::identity() : random.rotation(0, 3);
    const DoubleConvex turned(b.solid, {to_rotation(q), CoordinateVec3{}});
    const double radius = turned.radius;
    const D3 at =
        on + n * (turned.support(n * -1.0) + radius + random.uniform(low, high) * std::max(0.04, radius));
    const collide::RelativePose pose = pose_at(at, q);
    const double reach = 2 * size + radius;
    return {size,
            reach,
            b,
            at,
            pose,
            DoubleConvex(b.solid, pose),
            triangles_about(ground.owned.solid, at, reach + margin_m)};
}

/// Tests shapes whose cores are outside of the surface.
Outcome run(const Ground& ground, int kind, int poses, RandomReal& random, Damage damage = nullptr) {
    Outcome r;
    collide::NarrowScratch scratch;
    for (int tries = 0; r.poses < poses && tries < 50 * poses; ++tries) {
        const Placement p = place(ground, kind, random, -0.5, 1);
        if (!is_outside(p.near, p.at) || !p.is_apart()) continue;
        ++r.poses;
        collide::Manifolds m;
        collide::collide(ground.owned.solid, p.b.solid, p.pose, margin, scratch, m);
        if (damage != nullptr && m.count > 0) damage(m);
        double truth = 0;
        const double inner = as_double(shapes::inner_radius(p.b.solid));
        const std::string why = check(p.near, p.core, std::min(0.0005, inner / 64), p.reach, m, truth);
        r.hits += m.count > 0;
        if (!why.empty() && r.wrong++ == 0) {
            std::ostringstream out;
            out << "pose " << r.poses << " size " << p.size << " at " << p.at.x << ' ' << p.at.y << ' '
                << p.at.z << ": " << why;
            r.first = out.str();
        }
    }
    return r;
}

/// Tests shapes whose cores cut the surface: each must have a point, no deeper than the shape's size.
Outcome run_overlapping(const Ground& ground, int kind, int poses, RandomReal& random) {
    Outcome r;
    collide::NarrowScratch scratch;
    for (int tries = 0; r.poses < poses && tries < 50 * poses; ++tries) {
        const Placement p = place(ground, kind, random, -8, 0);
        if (p.is_apart()) continue;
        ++r.poses;
        collide::Manifolds m;
        collide::collide(ground.owned.solid, p.b.solid, p.pose, margin, scratch, m);
        bool good = m.count > 0;
        for (std::uint32_t i = 0; i < m.count; ++i)
            for (std::uint32_t k = 0; k < m.items[i].count; ++k) {
                const double s = as_double(m.items[i].points[k].separation);
                good = good && s <= margin_m + 1e-6 && s > -2.5 * p.reach &&
                       oracle::norm(as_double(m.items[i].points[k].position)) < 2 * p.reach;
            }
        r.hits += m.count > 0;
        if (!good && r.wrong++ == 0) {
            std::ostringstream out;
            out << "pose " << r.poses << " size " << p.size << " at " << p.at.x << ' ' << p.at.y << ' '
                << p.at.z << ": " << m.count << " manifolds";
            r.first = out.str();
        }
    }
    return r;
}

int poses_each() { return std::getenv("LOCKSTONE_LONG") != nullptr ? 2500 : 60; }

} // namespace

TEST_CASE("contacts with meshes and height fields agree with every triangle in double") {
    RandomReal random(0x3e5);
    const std::vector<Ground> all = grounds(random);
    std::printf("triangles against double:\n  ground  shape         poses   hits  wrong\n");
    for (std::size_t g = 0; g < all.size(); ++g)
        for (int kind = 0; kind < kinds; ++kind) {
            const Outcome r = run(all[g], kind, poses_each(), random);
            std::printf("  %-7zu %-12s %6d %6d %6d\n", g, kind_names[kind], r.poses, r.hits, r.wrong);
            INFO("ground ", g, ", ", std::string(kind_names[kind]), ": ", r.wrong, " wrong, ", r.first);
            CHECK(r.wrong == 0);
            CHECK(r.hits > r.poses / 4);
        }
}

TEST_CASE("shapes whose cores cut a mesh or height field always have a contact") {
    RandomReal random(0x3e7);
    const std::vector<Ground> all = grounds(random);
    for (std::size_t g = 0; g < all.size(); ++g)
        for (int kind = 1; kind < kinds; ++kind) { // a ball's core is a point
            const Outcome r = run_overlapping(all[g], kind, poses_each(), random);
            INFO("ground ", g, ", ", std::string(kind_names[kind]), ": ", r.wrong, " wrong, ", r.first);
            CHECK(r.wrong == 0);
            CHECK(r.poses > 20);
        }
}

TEST_CASE("the comparison with every triangle reports planted faults") {
    const Damage faults[] = {
        [](collide::Manifolds& m) { m.count = 0; },
        [](collide::Manifolds& m) {
            for (std::uint32_t i = 0; i < m.count; ++i)
                for (std::uint32_t k = 0; k < m.items[i].count; ++k)
                    m.items[i].points[k].separation += as_fixed<Separation>(0.002);
        },
        [](collide::Manifolds& m) { m.items[0].points[0].separation -= as_fixed<Separation>(0.002); },
        [](collide::Manifolds& m) {
            for (std::uint32_t i = 0; i < m.count; ++i)
                m.items[i].normal = normalized(UnitVec3{unit_one, unit_one, Unit{}});
        },
    };
    RandomReal random(0x3e6);
    const std::vector<Ground> all = grounds(random);
    for (const Damage fault : faults)
        for (const std::size_t g : {std::size_t{0}, std::size_t{3}}) {
            const Outcome r = run(all[g], 2, 40, random, fault);
            CHECK(r.wrong > r.hits / 4);
        }
}
