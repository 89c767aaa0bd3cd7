// Every convex kind against every other, in random and designed poses, judged in double precision and compared with FCL
// 0.7 (libccd's GJK and EPA).
//
// The judges of convex_double.h prove an answer right or wrong from the definitions; FCL is the second opinion by other
// authors. Its distances are iterated to 1e-6 and its depths are those of a portal refinement, not the least ones, so a
// disagreement is held against us when our own answer is not proved, or when FCL's direction parts the shapes sooner.
#include "oracle/convex_scenes.h"

#include <doctest/doctest.h>

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

#include <cstdio>
#include <optional>

using namespace oracle;
using namespace lockstone;

namespace {

const Length margin = quantize<Length>(0.02);

/// FCL's cylinders, cones and capsules run along z, ours along y: x y z -> z x y.
fcl::Transform3d transform_of(const DoubleCore& s) {
    const bool turned = s.kind == ShapeKind::capsule || s.is_smooth();
    fcl::Transform3d t = fcl::Transform3d::Identity();
    for (int column = 0; column < 3; ++column) {
        const D3& axis = s.axes[turned ? (column + 2) % 3 : column];
        t.linear().col(column) = fcl::Vector3d(axis.x, axis.y, axis.z);
    }
    t.translation() = fcl::Vector3d(s.center.x, s.center.y, s.center.z);
    return t;
}

std::shared_ptr<fcl::CollisionGeometryd> fcl_hull(const Solid& s) {
    auto vertices = std::make_shared<std::vector<fcl::Vector3d>>();
    for (const LengthVec3& v : s.hull->vertices)
        vertices->emplace_back(to_double(v.x), to_double(v.y), to_double(v.z));
    auto faces = std::make_shared<std::vector<int>>();
    for (const auto& t : s.hull->triangles) faces->insert(faces->end(), {3, t[0], t[1], t[2]});
    return std::make_shared<fcl::Convexd>(vertices, static_cast<int>(s.hull->triangles.size()), faces);
}

/// The cores, but a sphere and a capsule whole: FCL has no points and segments.
std::shared_ptr<fcl::CollisionGeometryd> fcl_shape(const Solid& s, const DoubleCore& d) {
    switch (d.kind) {
    case ShapeKind::sphere:
        return std::make_shared<fcl::Sphered>(d.radius);
    case ShapeKind::capsule:
        return std::make_shared<fcl::Capsuled>(d.radius, 2 * d.half.y);
    case ShapeKind::cylinder:
        return std::make_shared<fcl::Cylinderd>(d.half.x, 2 * d.half.y);
    case ShapeKind::cone:
        return std::make_shared<fcl::Coned>(d.half.x, 2 * d.half.y);
    case ShapeKind::box:
        return std::make_shared<fcl::Boxd>(2 * d.half.x, 2 * d.half.y, 2 * d.half.z);
    default:
        return fcl_hull(s);
    }
}

/// What FCL says of the shapes, without the rounding of what is not a sphere or capsule.
struct FclAnswer {
    bool hit = false;
    double distance = 0;          ///< when apart
    std::vector<D3> directions{}; ///< of its contacts
};

/// Nothing when it throws. libccd's search in FCL ends the process by an assertion on some simplices of shapes that
/// all but touch: those are left to FCL's own.
std::optional<FclAnswer> ask_fcl(const ConvexScene& s, const DoubleCore& a, const DoubleCore& b,
                                 bool touching) {
    const fcl::GJKSolverType solver = touching ? fcl::GST_INDEP : fcl::GST_LIBCCD;
    fcl::CollisionRequestd collision(8, true);
    fcl::DistanceRequestd distance(false, false);
    collision.gjk_solver_type = distance.gjk_solver_type = solver;
    fcl::CollisionObjectd object_a(fcl_shape(s.a, a), transform_of(a)),
        object_b(fcl_shape(s.b, b), transform_of(b));
    FclAnswer answer;
    try {
        fcl::CollisionResultd contacts;
        answer.hit = fcl::collide(&object_a, &object_b, collision, contacts) > 0;
        for (std::size_t i = 0; i < contacts.numContacts(); ++i) {
            const fcl::Vector3d& n = contacts.getContact(i).normal;
            answer.directions.push_back({n.x(), n.y(), n.z()});
        }
        if (answer.hit) return answer;
        fcl::DistanceResultd result;
        answer.distance = fcl::distance(&object_a, &object_b, distance, result);
        return answer;
    } catch (const std::exception&) { return std::nullopt; }
}

/// The part of the radii that FCL sees.
double radius_in_fcl(const DoubleCore& s) {
    return s.kind == ShapeKind::sphere || s.kind == ShapeKind::capsule ? s.radius : 0;
}

/// The routines of plain spheres, capsules and boxes let points slide a little; collide_double.cpp judges them.
bool has_own_routine(const Solid& s) {
    const Geometry& g = s.geometry;
    return g.kind == ShapeKind::sphere || g.kind == ShapeKind::capsule ||
           (g.kind == ShapeKind::box && g.radius == Length{});
}

/// Empty when the manifold goes with the signed separation `truth` of the shapes, which has been proved.
std::string judge_manifold(const ConvexScene& s, const DoubleCore& a, const DoubleCore& b, double truth,
                           const collide::Manifold& m) {
    std::ostringstream why;
    const double tolerance = 3e-7 + 3 * core_tolerance(a, b), reach = to_double(margin),
                 radii = a.radius + b.radius;
    const bool smooth = a.is_smooth() || b.is_smooth();
    if (m.count == 0) {
        if (truth < reach - tolerance) why << "no point for a separation of " << truth << "; ";
        return why.str();
    }
    if (truth > reach + tolerance) why << "a point for shapes " << truth << " apart; ";
    const D3 n = to_double(m.normal);
    if (std::abs(norm(n) - 1) > 4e-9) why << "a normal of length " << norm(n) << "; ";
    const double along = separation_along(a, b, n) - radii, bias = 0.0005;
    const double slack =
        tolerance + deep_slack(a, b, truth + radii) + (smooth ? 2.5e-4 * std::abs(truth + radii) + 5e-7 : 0);
    const bool own = has_own_routine(s.a) && has_own_routine(s.b);
    if (!own && (along < truth - bias - slack || along > truth + slack))
        why << "along its normal " << along << ", truly " << truth << "; ";
    for (std::uint32_t k = 0; k < m.count && along > -15; ++k) {
        const double separation = to_double(m.points[k].separation);
        if (separation > reach + 1e-7) why << "point " << k << " beyond the margin: " << separation << "; ";
        if (separation < along - slack)
            why << "point " << k << " is " << separation << ", the shapes " << along << "; ";
        for (std::uint32_t l = 0; l < k; ++l)
            if (m.points[l].feature == m.points[k].feature)
                why << "points " << l << " and " << k << " share a feature; ";
        if (own || norm(to_double(m.points[k].position)) > 127) continue; // positions end at 128 m
        const D3 p = to_double(m.points[k].position) + b.center;
        const double off_a = a.outside(p - n * (separation / 2)) - a.radius,
                     off_b = b.outside(p + n * (separation / 2)) - b.radius;
        if (std::max(off_a, off_b) > 1.5 * bias + slack)
            why << "point " << k << " is " << off_a << " and " << off_b << " off; ";
    }
    return why.str();
}

collide::Manifold manifold_of(const ConvexScene& s) {
    collide::NarrowScratch scratch;
    collide::Manifolds all;
    collide::collide(s.a, s.b, s.pose, margin, scratch, all);
    return all.count == 0 ? collide::Manifold{} : all.items[0];
}

struct Tally {
    int poses = 0, apart = 0, overlaps = 0, wrong = 0;
    int fcl_asked = 0, fcl_throws = 0, fcl_misses = 0, fcl_agrees = 0, fcl_differs = 0;
    double fcl_square = 0;
    std::string first;
};

/// Our answer has been proved, so a hit or distance that differs is FCL's; its directions are tried against ours.
std::string compare_with_fcl(const ConvexScene& s, const DoubleCore& a, const DoubleCore& b,
                             const CoreAnswer& ours, Tally& t) {
    const double mine = ours.distance - radius_in_fcl(a) - radius_in_fcl(b);
    const std::optional<FclAnswer> theirs = ask_fcl(s, a, b, std::abs(mine) < 1e-3);
    ++t.fcl_asked;
    if (!theirs) {
        ++t.fcl_throws;
        return {};
    }
    if (theirs->hit != (mine < 0) && std::abs(mine) > 1e-5) ++t.fcl_misses;
    if (!theirs->hit && mine > 0) {
        const double off = mine - theirs->distance;
        t.fcl_square += std::abs(off) > 1e-4 ? 0 : off * off;
        ++(std::abs(off) > 1e-4 ? t.fcl_differs : t.fcl_agrees);
    }
    if (!ours.overlap || !theirs->hit) return {};
    SeparationSearch search(a, b);
    for (const D3& n : theirs->directions) search.consider_both(n);
    const double slack = a.is_smooth() || b.is_smooth() ? -2.5e-4 * ours.distance : 0;
    const double allowed = 1e-6 * (1 - ours.distance) + slack + deep_slack(a, b, ours.distance);
    if (theirs->directions.empty() || search.separation() <= ours.distance + allowed) return {};
    return "FCL's direction parts them by " + std::to_string(-search.separation()) + "; ";
}

void run_scene(const ConvexScene& s, Random& random, int effort, Tally& t) {
    const DoubleCore a(s.a), b(s.b, s.pose);
    const CoreAnswer answer = ask(s.a, s.b, s.pose);
    std::string why = judge(a, b, answer, random, effort);
    why += judge_manifold(s, a, b, answer.distance - a.radius - b.radius, manifold_of(s));
    if (s.is_ordinary) why += compare_with_fcl(s, a, b, answer, t);
    ++t.poses;
    ++(answer.overlap ? t.overlaps : t.apart);
    if (!why.empty() && t.wrong++ < 1) t.first = "pose " + std::to_string(t.poses) + ": " + why;
}

Tally run_pair(ConvexKind kind_a, ConvexKind kind_b, const HullPool& pool, int random_poses,
               int designed_poses) {
    Tally t;
    Random random(0xacce55 + static_cast<std::uint64_t>(kind_a) * 64 + static_cast<std::uint64_t>(kind_b));
    for (int i = 0; i < random_poses; ++i)
        run_scene(random_scene(random, pool, kind_a, kind_b), random, 3, t);
    for (int i = 0; i < designed_poses; ++i)
        run_scene(designed_scene(random, pool, kind_a, kind_b), random, 3, t);
    std::printf("  %-9s %-9s %7d %7d %8d   %7d %6d %6d %7d  %8.1e   %5d\n", name_of(kind_a), name_of(kind_b),
                t.poses, t.apart, t.overlaps, t.fcl_asked, t.fcl_throws, t.fcl_misses, t.fcl_differs,
                std::sqrt(t.fcl_square / std::max(1, t.fcl_agrees)), t.wrong);
    return t;
}

} // namespace

TEST_CASE("every pair of convex kinds is right in every pose, and near FCL's opinion") {
    const bool whole = std::getenv("LOCKSTONE_LONG") != nullptr;
    const HullPool pool(77);
    REQUIRE(pool.all().size() > 30);
    std::printf(
        "convex shapes, %zu hulls; ~ is rounded\n"
        "  A         B           poses   apart  overlap   FCL asked throws misses differs  rms[m]   wrong\n",
        pool.all().size());
    for (int a = 0; a < convex_kinds; ++a)
        for (int b = 0; b < convex_kinds; ++b) {
            const auto kind_a = static_cast<ConvexKind>(a), kind_b = static_cast<ConvexKind>(b);
            if (core_kind(kind_a) < core_kind(kind_b) || (core_kind(kind_a) == core_kind(kind_b) && a < b))
                continue;
            const Tally t = run_pair(kind_a, kind_b, pool, whole ? 100'000 : 300, whole ? 10'000 : 200);
            INFO(std::string(name_of(kind_a)), " and ", std::string(name_of(kind_b)), ", ", t.first);
            CHECK(t.wrong == 0);
            CHECK(t.apart > 20);
            CHECK(t.overlaps > 20);
        }
}

namespace {

/// Damage to a pair or to what comes out for it. False: it does not apply.
struct Fault {
    const char* what;
    bool (*plant)(ConvexScene&, shapes::Hull& spare);
    void (*spoil)(collide::Manifold&);
    int planted = 0, noticed = 0;
};

bool swell(ConvexScene& s, shapes::Hull&) {
    s.b.geometry.radius += decimal<Length>("0.0001");
    return s.b.geometry.radius > decimal<Length>("0.0002");
}
/// Moves the corner of B that is nearest to A into the hull.
bool lose_corner(ConvexScene& s, shapes::Hull& spare) {
    if (s.b.hull == nullptr) return false;
    spare = *s.b.hull;
    const DoubleCore a(s.a), b(s.b, s.pose);
    const CoreAnswer truth = ask(s.a, s.b, s.pose);
    std::size_t lowest = 0;
    for (std::size_t k = 1; k < b.points.size(); ++k)
        if (dot(b.points[k], truth.normal) < dot(b.points[lowest], truth.normal)) lowest = k;
    spare.vertices[lowest] = spare.interior;
    s.b.hull = &spare;
    // Only where that corner matters by more than a face's preference.
    return std::abs(ask(s.a, s.b, s.pose).distance - truth.distance) > 0.002;
}
bool leave(ConvexScene&, shapes::Hull&) { return true; }

} // namespace

TEST_CASE("a wrong radius, a flipped normal and a lost corner are noticed") {
    const auto flip = [](collide::Manifold& m) { m.normal = -m.normal; };
    const auto lift = [](collide::Manifold& m) {
        for (collide::ManifoldPoint& p : m.points) p.separation -= decimal<Separation>("0.002");
    };
    const auto shove = [](collide::Manifold& m) { m.points[0].position.x += decimal<Length>("0.5"); };
    const auto nothing = [](collide::Manifold&) {};
    Fault faults[] = {{"a radius 0.1 mm too large", swell, nothing},
                      {"a lost corner", lose_corner, nothing},
                      {"a flipped normal", leave, flip},
                      {"points 2 mm too deep", leave, lift},
                      {"a point half a metre off", leave, shove},
                      {"no points", leave, [](collide::Manifold& m) { m.count = 0; }}};
    const HullPool pool(77);
    Random random(0xfa17);
    constexpr ConvexKind others[] = {ConvexKind::round_hull, ConvexKind::hull, ConvexKind::box,
                                     ConvexKind::round_box};
    for (int i = 0; i < 1500; ++i) {
        const ConvexScene good = random_scene(random, pool, ConvexKind::hull, others[i % 4]);
        const DoubleCore a(good.a), b(good.b, good.pose);
        const CoreAnswer answer = ask(good.a, good.b, good.pose);
        const double truth = answer.distance - a.radius - b.radius;
        if (truth > 0.019 || truth < -15 || std::abs(truth) < 0.003 ||
            norm(to_double(manifold_of(good).points[0].position)) > 100)
            continue;
        if (deep_slack(a, b, answer.distance) > 0) continue;
        REQUIRE(judge_manifold(good, a, b, truth, manifold_of(good)) == "");
        for (Fault& f : faults) {
            shapes::Hull spare;
            ConvexScene bad = good;
            if (!f.plant(bad, spare)) continue;
            collide::Manifold m = manifold_of(bad);
            f.spoil(m);
            ++f.planted;
            f.noticed += judge_manifold(good, a, b, truth, m).empty() ? 0 : 1;
        }
    }
    for (const Fault& f : faults) {
        INFO(std::string(f.what), ": ", f.noticed, " of ", f.planted);
        CHECK(f.planted > 30);
        CHECK(f.noticed * 5 > f.planted * 3); // a lost corner may hide behind its neighbours
    }
}
