// Every convex kind against every other and against planes, in random and designed poses, judged in double precision
// and compared with FCL 0.7 (libccd's GJK and EPA).
//
// The judges of convex_double.h prove an answer right or wrong from the definitions; FCL is a second opinion by other
// authors. Its distances are iterated to 1e-6 and its depths come from a portal refinement, so they are not the least
// ones. A disagreement therefore counts as our error only when our own answer is not proved, or when FCL's direction
// separates the shapes with a shorter move.
//
// LOCKSTONE_LONG=1 takes 110,000 poses a pair; LOCKSTONE_SHARD=2/5 every fifth pair from the second on.
#include "oracle/convex_fcl.h"
#include "oracle/convex_plane.h"

#include <doctest/doctest.h>

#include <cstdio>

using namespace oracle;
using namespace lockstone;

namespace {

const Length margin = as_fixed<Length>(0.02);

/// The routines of plain spheres, capsules and boxes let points slide a little. collide_double.cpp judges them.
bool has_own_routine(const Solid& s) {
    const Geometry& g = s.geometry;
    return g.kind == ShapeKind::sphere || g.kind == ShapeKind::capsule ||
           (g.kind == ShapeKind::box && g.radius == Length{});
}

/// Returns an error sentence unless the manifold agrees with the proved signed separation `truth` of the shapes.
std::string judge_manifold(const ConvexScene& s, const DoubleCore& a, const DoubleCore& b, double truth,
                           const collide::Manifold& m) {
    std::ostringstream why;
    const double tolerance = 3e-7 + 3 * core_tolerance(a, b), reach = as_double(margin),
                 radii = a.radius + b.radius;
    const bool smooth = a.is_smooth() || b.is_smooth();
    if (m.count == 0) {
        if (truth < reach - tolerance) why << "no point for a separation of " << truth << "; ";
        return why.str();
    }
    if (truth > reach + tolerance) why << "a point for shapes " << truth << " apart; ";
    const D3 n = as_double(m.normal);
    if (std::abs(norm(n) - 1) > 4e-9) why << "a normal of length " << norm(n) << "; ";
    const double along = separation_along(a, b, n) - radii, bias = 0.0005;
    const double slack =
        tolerance + deep_slack(a, b, truth + radii) + (smooth ? 2.5e-4 * std::abs(truth + radii) + 5e-7 : 0);
    const bool own = has_own_routine(s.a) && has_own_routine(s.b);
    if (!own && (along < truth - bias - slack || along > truth + slack))
        why << "along its normal " << along << ", truly " << truth << "; ";
    for (std::uint32_t k = 0; k < m.count && along > -15; ++k) {
        const double separation = as_double(m.points[k].separation);
        if (separation > reach + 1e-7) why << "point " << k << " beyond the margin: " << separation << "; ";
        if (separation < along - slack)
            why << "point " << k << " is " << separation << ", the shapes " << along << "; ";
        for (std::uint32_t l = 0; l < k; ++l)
            if (m.points[l].feature == m.points[k].feature)
                why << "points " << l << " and " << k << " share a feature; ";
        if (own || norm(as_double(m.points[k].position)) > 127) continue; // positions end at 128 m
        const D3 p = as_double(m.points[k].position) + b.center;
        const double off_a = a.outside(p - n * (separation / 2)) - a.radius,
                     off_b = b.outside(p + n * (separation / 2)) - b.radius;
        // A hull's facets are merged into one face if that moves no corner by more than 2^-12 of the hull's size.
        const auto faceted = [](const Solid& of) {
            if (of.hull == nullptr) return 0.0;
            const D3 size = as_double(of.hull->extent.upper - of.hull->extent.lower);
            return std::ldexp(std::max({size.x, size.y, size.z}), -12);
        };
        if (off_a > 1.5 * bias + slack + faceted(s.a) || off_b > 1.5 * bias + slack + faceted(s.b))
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
    std::vector<std::string> complaints; ///< the first few
};

/// One pair of kinds, and the data to make and judge its poses.
struct Pair {
    ConvexKind a, b;
    const HullPool& pool;
    FclHulls& fcl;
    RandomReal random;
    Tally tally{};

    Pair(ConvexKind first, ConvexKind second, const HullPool& hulls, FclHulls& of_fcl)
        : a(first), b(second), pool(hulls), fcl(of_fcl),
          random(0xacce55 + static_cast<std::uint64_t>(a) * 64 + static_cast<std::uint64_t>(b)) {}

    bool is_plane() const { return a == ConvexKind::plane; }
    void run(int random_poses, int designed_poses);
    void print() const;

  private:
    std::string judge_scene(const ConvexScene& s);
    std::string compare_with_fcl(const ConvexScene& s, const DoubleCore& first, const DoubleCore& second,
                                 const CoreAnswer& ours);
    std::string compare_plane_with_fcl(const ConvexScene& s, const DoubleCore& second, double truth);
    bool has_answer(const std::optional<FclAnswer>& theirs) {
        ++tally.fcl_asked;
        tally.fcl_throws += !theirs;
        return theirs.has_value();
    }
    void count_distance(double off) {
        tally.fcl_square += std::abs(off) > 1e-4 ? 0 : off * off;
        ++(std::abs(off) > 1e-4 ? tally.fcl_differs : tally.fcl_agrees);
    }
};

/// Our answer has been proved, so a different hit or distance is FCL's error. The function also tries FCL's directions.
std::string Pair::compare_with_fcl(const ConvexScene& s, const DoubleCore& first, const DoubleCore& second,
                                   const CoreAnswer& ours) {
    const double mine = ours.distance - radius_in_fcl(first) - radius_in_fcl(second);
    const std::optional<FclAnswer> theirs = ask_fcl(fcl, s, first, second, std::abs(mine) < 1e-3);
    if (!has_answer(theirs)) return {};
    tally.fcl_misses += theirs->hit != (mine < 0) && std::abs(mine) > 1e-5;
    if (!theirs->hit && mine > 0) count_distance(mine - theirs->distance);
    if (!ours.overlap || !theirs->hit) return {};
    SeparationSearch search(first, second);
    for (const D3& n : theirs->directions) search.consider_both(n);
    const double slack = first.is_smooth() || second.is_smooth() ? -2.5e-4 * ours.distance : 0;
    const double allowed = 1e-6 * (1 - ours.distance) + slack + deep_slack(first, second, ours.distance);
    if (theirs->directions.empty() || search.separation() <= ours.distance + allowed) return {};
    return "FCL's direction parts them by " + std::to_string(-search.separation()) + "; ";
}

/// FCL computes half-spaces in closed form: hit and depth must agree. But FCL treats a disc within 5e-4 rad of lying
/// flat as flat, loses digits near that angle, and treats every cone whose apex is below its middle as one on its side.
std::string Pair::compare_plane_with_fcl(const ConvexScene& s, const DoubleCore& second, double truth) {
    double lost = 1e-7;
    if (second.is_smooth()) {
        const double upright = second.axes[1].y, slant = std::hypot(second.axes[1].x, second.axes[1].z);
        if (slant < 7e-4 || (second.kind == ShapeKind::cone && upright < 0)) return {};
        lost += 8e-9 / slant;
    }
    const double mine = truth + second.radius - radius_in_fcl(second), allowed = 1e-8 + lost * second.reach();
    const std::optional<FclAnswer> theirs = ask_fcl(fcl, s, DoubleCore(s.a), second, false);
    if (!has_answer(theirs)) return {};
    if (theirs->hit != (mine < 0))
        return std::abs(mine) > allowed ? "FCL sees it otherwise at " + std::to_string(mine) + "; " : "";
    if (!theirs->hit) return {};
    const double off = mine + theirs->depth;
    count_distance(off);
    if (std::abs(off) <= allowed) return {};
    return "FCL finds a depth of " + std::to_string(theirs->depth) + ", not " + std::to_string(-mine) + "; ";
}

std::string Pair::judge_scene(const ConvexScene& s) {
    const DoubleCore first(s.a), second(s.b, s.pose);
    if (is_plane()) {
        const double truth = height_above_plane(second);
        ++(truth < 0 ? tally.overlaps : tally.apart);
        return judge_plane(second, as_double(margin), manifold_of(s)) +
               (s.is_ordinary ? compare_plane_with_fcl(s, second, truth) : "");
    }
    const CoreAnswer answer = ask(s.a, s.b, s.pose);
    ++(answer.overlap ? tally.overlaps : tally.apart);
    std::string why = judge(first, second, answer, random, 3);
    why += judge_manifold(s, first, second, answer.distance - first.radius - second.radius, manifold_of(s));
    return s.is_ordinary ? why + compare_with_fcl(s, first, second, answer) : why;
}

void Pair::run(int random_poses, int designed_poses) {
    for (int i = 0; i < random_poses + designed_poses; ++i) {
        const bool designed = i >= random_poses;
        const std::string why = judge_scene(is_plane() ? plane_scene(random, pool, b, designed)
                                            : designed ? designed_scene(random, pool, a, b)
                                                       : random_scene(random, pool, a, b));
        ++tally.poses;
        if (!why.empty() && tally.wrong++ < 5)
            tally.complaints.push_back(std::string(name_of(a)) + " and " + name_of(b) + ", pose " +
                                       std::to_string(i) + ": " + why);
    }
}

void Pair::print() const {
    const Tally& t = tally;
    std::printf("  %-9s %-9s %7d %7d %8d   %7d %6d %6d %7d  %8.1e   %5d\n", name_of(a), name_of(b), t.poses,
                t.apart, t.overlaps, t.fcl_asked, t.fcl_throws, t.fcl_misses, t.fcl_differs,
                std::sqrt(t.fcl_square / std::max(1, t.fcl_agrees)), t.wrong);
    std::fflush(stdout);
}

/// All pairs, planes first; with LOCKSTONE_SHARD=i/n every n-th from the i-th on.
std::vector<std::pair<ConvexKind, ConvexKind>> pairs_to_run() {
    std::vector<std::pair<ConvexKind, ConvexKind>> all, chosen;
    for (int b = 0; b < convex_kinds; ++b) all.emplace_back(ConvexKind::plane, static_cast<ConvexKind>(b));
    for (int a = 0; a < convex_kinds; ++a)
        for (int b = 0; b < convex_kinds; ++b) {
            const auto kind_a = static_cast<ConvexKind>(a), kind_b = static_cast<ConvexKind>(b);
            if (core_kind(kind_a) > core_kind(kind_b) || (core_kind(kind_a) == core_kind(kind_b) && a >= b))
                all.emplace_back(kind_a, kind_b);
        }
    unsigned shard = 1, shards = 1;
    if (const char* text = std::getenv("LOCKSTONE_SHARD"); text != nullptr)
        REQUIRE(std::sscanf(text, "%u/%u", &shard, &shards) == 2);
    REQUIRE((shard >= 1 && shard <= shards));
    for (std::size_t i = shard - 1; i < all.size(); i += shards) chosen.push_back(all[i]);
    return chosen;
}

} // namespace

TEST_CASE("manifolds of every pair of convex kinds are right in every pose and close to FCL's results") {
    const bool whole = std::getenv("LOCKSTONE_LONG") != nullptr;
    const HullPool pool(77);
    FclHulls fcl;
    REQUIRE(pool.all().size() > 30);
    std::printf(
        "convex shapes, %zu hulls; ~ is rounded\n"
        "  A         B           poses   apart  overlap   FCL asked throws misses differs  rms[m]   wrong\n",
        pool.all().size());
    int poses = 0;
    std::vector<std::string> complaints;
    for (const auto& [a, b] : pairs_to_run()) {
        Pair pair(a, b, pool, fcl);
        pair.run(whole ? 100'000 : 300, whole ? 10'000 : 200);
        pair.print();
        const Tally& t = pair.tally;
        INFO(std::string(name_of(a)), " and ", std::string(name_of(b)));
        CHECK(t.wrong == 0);
        CHECK(t.apart > 20);
        CHECK(t.overlaps > 20);
        poses += t.poses;
        complaints.insert(complaints.end(), t.complaints.begin(), t.complaints.end());
    }
    std::printf("%d poses; disagreements above tolerance: %s\n", poses, complaints.empty() ? "none" : "");
    for (const std::string& line : complaints) std::printf("  %s\n", line.c_str());
}

namespace {

/// Damage to a pair or to its manifold. plant() returns false if the damage does not apply.
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
    // Only where that corner changes the distance by more than the preference for faces.
    return std::abs(ask(s.a, s.b, s.pose).distance - truth.distance) > 0.002;
}
bool leave(ConvexScene&, shapes::Hull&) { return true; }

} // namespace

TEST_CASE("the manifold check detects a wrong radius and a flipped normal and a lost corner") {
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
    RandomReal random(0xfa17);
    constexpr ConvexKind others[] = {ConvexKind::round_hull, ConvexKind::hull, ConvexKind::box,
                                     ConvexKind::round_box};
    for (int i = 0; i < 1500; ++i) {
        const ConvexScene good = random_scene(random, pool, ConvexKind::hull, others[i % 4]);
        const DoubleCore a(good.a), b(good.b, good.pose);
        const CoreAnswer answer = ask(good.a, good.b, good.pose);
        const double truth = answer.distance - a.radius - b.radius;
        if (truth > 0.019 || truth < -15 || std::abs(truth) < 0.003 ||
            norm(as_double(manifold_of(good).points[0].position)) > 100)
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
        CHECK(f.noticed * 5 > f.planted * 3); // neighbours may hide a lost corner
    }
}

TEST_CASE("the plane check detects a wrong normal and depth and place and number of points") {
    struct {
        const char* what;
        void (*spoil)(collide::Manifold&);
        int noticed = 0;
    } faults[] = {{"a tilted normal", [](collide::Manifold& m) { m.normal.x += Unit::from_raw(1); }},
                  {"points 1 um too deep",
                   [](collide::Manifold& m) {
                       for (collide::ManifoldPoint& p : m.points)
                           p.separation -= decimal<Separation>("0.000001");
                   }},
                  {"a point 1 cm too high",
                   [](collide::Manifold& m) { m.points[0].position.y += decimal<Length>("0.01"); }},
                  {"a point half a metre off",
                   [](collide::Manifold& m) { m.points[0].position.x += decimal<Length>("0.5"); }},
                  {"one point where there are more", [](collide::Manifold& m) { m.count = 1; }},
                  {"no points", [](collide::Manifold& m) { m.count = 0; }}};
    const HullPool pool(77);
    RandomReal random(0xfa18);
    int planted = 0;
    for (int i = 0; i < 3000; ++i) {
        const ConvexScene s = plane_scene(random, pool, ConvexKind::box, true);
        const DoubleCore b(s.b, s.pose);
        const collide::Manifold good = manifold_of(s);
        if (good.count != 4 || height_above_plane(b) > 0.009 || b.reach() > 0.4 || b.reach() < 0.02) continue;
        REQUIRE(judge_plane(b, as_double(margin), good) == "");
        ++planted;
        for (auto& f : faults) {
            collide::Manifold m = good;
            f.spoil(m);
            f.noticed += judge_plane(b, as_double(margin), m).empty() ? 0 : 1;
        }
    }
    CHECK(planted > 100);
    for (const auto& f : faults) {
        INFO(std::string(f.what));
        CHECK(f.noticed * 10 > planted * 9); // if the points have nearly equal heights, one is enough
    }
}
