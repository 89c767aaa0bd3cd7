// A face that is cached from the last tick separates two shapes as well as any direction does, and every instruction
// set finds the same furthest corner of a hull.
#include "collide/convex/convex.h"
#include "lockstone/math/math.h"
#include "oracle/double_shapes.h"
#include "shapes/hull/hull.h"
#include "shapes/hull/support_kernel.h"
#include "solve/kernels/kernels.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using namespace lockstone;
using namespace lockstone::collide;
using oracle::as_fixed;
using oracle::D3;

namespace {

shapes::Solid hull_of(AssetLibrary& library, const std::vector<LengthVec3>& points) {
    const AssetId id = library.add(bake_hull(points)).value();
    return {library.geometry(id).value(), library.find(id)->hull.get()};
}

/// A hull with corners on a ball [m]; block() is a cube, which has several furthest corners along some directions.
shapes::Solid stone(AssetLibrary& library, oracle::RandomReal& random, std::uint32_t corners, double size) {
    std::vector<LengthVec3> points;
    for (std::uint32_t i = 0; i < corners; ++i) {
        const D3 d = random.direction();
        points.push_back(
            {as_fixed<Length>(size * d.x), as_fixed<Length>(size * d.y), as_fixed<Length>(size * d.z)});
    }
    return hull_of(library, points);
}
shapes::Solid block(AssetLibrary& library, double size) {
    std::vector<LengthVec3> points;
    for (int i = 0; i < 8; ++i) {
        const auto side = [&](int axis) { return as_fixed<Length>((i >> axis & 1) != 0 ? size : -size); };
        points.push_back({side(0), side(1), side(2)});
    }
    return hull_of(library, points);
}

std::vector<const shapes::SupportKernel*> kernels() {
    std::vector<const shapes::SupportKernel*> found;
    for (const Simd level : {Simd::scalar, Simd::sse41, Simd::avx2, Simd::avx512, Simd::neon, Simd::wasm128})
        if (const solve::Kernels* of_level = solve::kernels_of(level)) found.push_back(of_level->hulls);
    return found;
}

std::uint32_t furthest_by(const shapes::SupportKernel& kernel, const shapes::Hull& hull,
                          const std::int32_t (&direction)[3]) {
    return kernel.furthest(hull.lanes.data(), static_cast<std::uint32_t>(hull.lanes.size() / 3), direction);
}

/// The first of the furthest corners.
std::uint32_t furthest_of(const shapes::Hull& hull, const std::int32_t (&n)[3]) {
    const auto along = [&](const LengthVec3& v) {
        return std::int64_t{n[0]} * v.x.raw + std::int64_t{n[1]} * v.y.raw + std::int64_t{n[2]} * v.z.raw;
    };
    const auto best = std::ranges::max_element(hull.vertices, {}, along);
    return static_cast<std::uint32_t>(best - hull.vertices.begin());
}

} // namespace

TEST_CASE("every instruction set finds the same furthest corner of a hull and the same reach along an axis") {
    AssetLibrary library;
    oracle::RandomReal random(31);
    std::vector<shapes::Solid> solids{block(library, 0.5), block(library, 99.9)};
    for (std::uint32_t corners = 4; corners <= 40; corners += 3)
        solids.push_back(stone(library, random, corners, corners % 2 == 0 ? 0.4 : 90));
    const auto all = kernels();
    REQUIRE(all.size() >= 1);
    int ties = 0;
    for (const shapes::Solid& solid : solids)
        for (int i = 0; i < 500; ++i) {
            std::int32_t rows[3][3];
            for (auto& row : rows) {
                const D3 d = random.direction();
                row[0] = as_fixed<Unit>(d.x).raw, row[1] = as_fixed<Unit>(d.y).raw,
                row[2] =
                    random.below(3) == 0 ? 0 : as_fixed<Unit>(d.z).raw; // two corners of a block are furthest
                ties += row[2] == 0;
            }
            for (const shapes::SupportKernel* kernel : all) {
                std::int64_t low[3], high[3];
                kernel->reach(solid.hull->lanes.data(),
                              static_cast<std::uint32_t>(solid.hull->lanes.size() / 3), rows, low, high);
                for (int r = 0; r < 3; ++r) {
                    REQUIRE(furthest_by(*kernel, *solid.hull, rows[r]) == furthest_of(*solid.hull, rows[r]));
                    const shapes::Reach reach = shapes::reach_along(
                        solid.hull->vertices,
                        {Unit::from_raw(rows[r][0]), Unit::from_raw(rows[r][1]), Unit::from_raw(rows[r][2])});
                    REQUIRE(low[r] == reach.low_54);
                    REQUIRE(high[r] == reach.high_54);
                }
            }
        }
    CHECK(ties > 1000);
}

TEST_CASE("planted fault: the check reports a search that returns the last of two equally far corners") {
    AssetLibrary library;
    const shapes::Solid cube = block(library, 0.5);
    const std::int32_t up[3] = {0, 1 << 30, 0};
    std::vector<LengthVec3> reversed(cube.hull->vertices.rbegin(), cube.hull->vertices.rend());
    shapes::Hull turned = *cube.hull;
    turned.vertices = reversed;
    const std::uint32_t last = 7 - furthest_of(turned, up); // planted: the last of equal corners
    for (const shapes::SupportKernel* kernel : kernels()) CHECK(furthest_by(*kernel, *cube.hull, up) != last);
}

namespace {

/// Pairs that touched by a face, or by edges, then moved by up to 3 cm and turned by up to a twentieth. Compares the
/// cached face or edges with the result of a new search.
class KeptManifolds {
  public:
    KeptManifolds() {
        const auto all = kernels();
        for (std::uint32_t i = 0; i < 6; ++i) {
            solids.push_back(stone(library, random, 8 + 5 * i, 0.3 + 0.1 * i));
            solids.back().kernel = i % 2 == 0 ? all.back() : nullptr;
        }
        solids.push_back(block(library, 0.4));
        solids.push_back({rounded(box(0.3_r, 0.2_r, 0.4_r), 0.05_r)});
    }

    void look(bool on_face) {
        shapes::Solid a = solids[random.below(8)], b = solids[random.below(8)];
        if (a.geometry.kind < b.geometry.kind) std::swap(a, b);
        RelativePose pose = touching_pose(a, b);
        const UnitVec3 before = collided(a, b, pose, {});
        const std::uint32_t name = manifolds.items[0].points[0].feature;
        if (manifolds.count == 0 || (manifolds.items[0].on_face != 0) != on_face) return;
        if (!on_face && (name >> 17) == 0x7fff) return; // a corner
        move(pose);
        const UnitVec3 found = collided(a, b, pose, {});
        const Manifold searched = manifolds.items[0];
        const std::uint32_t points = manifolds.count;
        const UnitVec3 kept = collided(a, b, pose, {{}, before, on_face ? 0 : name});
        ++looked_at;
        compare_points(searched, manifolds.items[0]);
        changed += kept != before;
        parted += points == 0;
        unlike += (manifolds.count == 0) != (points == 0);
        if (points == 0 || manifolds.count == 0) return;
        const std::int64_t best = separation(a, b, pose, found);
        worse += separation(a, b, pose, kept) < best - allowed(a, b);
        // Planted: the last normal without an update for the new pose.
        worse_planted += separation(a, b, pose, before) < best - allowed(a, b);
    }

    int looked_at = 0, changed = 0, parted = 0, unlike = 0, worse = 0, worse_planted = 0;
    int alike = 0, same_bits = 0; ///< single points of the same two edges; those with equal bits
    std::int64_t farthest_24 = 0; ///< the largest distance between such points

  private:
    void compare_points(const Manifold& searched, const Manifold& kept) {
        if (searched.count != 1 || kept.count != 1 || searched.on_face != 0 || kept.on_face != 0) return;
        if (searched.points[0].feature != kept.points[0].feature) return;
        ++alike;
        same_bits += searched.points[0].position == kept.points[0].position;
        const Long3 apart = raw(searched.points[0].position) - raw(kept.points[0].position);
        for (int i = 0; i < 3; ++i) farthest_24 = std::max(farthest_24, absolute(apart[i]));
    }
    /// Twice the bias with which `collide` prefers faces, and the distance that a hull's corners may have from their
    /// face's plane.
    static std::int64_t allowed(const shapes::Solid& a, const shapes::Solid& b) {
        const auto tolerance = [](const shapes::Solid& s) {
            return s.hull == nullptr ? 0 : std::int64_t{face_tolerance(*s.hull, Length::max()).raw} << 6;
        };
        return 2 * (std::int64_t{face_bias.raw} << 3) + tolerance(a) + tolerance(b) + 64;
    }
    static std::int64_t separation(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                                   UnitVec3 normal) {
        return separation_along_30(convex_of(a, Rotation::identity(), CoordinateVec3{}),
                                   convex_of(b, pose.rotation, pose.position), raw(normal));
    }
    UnitVec3 collided(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                      const PairHints& hints) {
        collide::collide(a, b, pose, decimal<Length>("0.02"), hints, scratch, manifolds);
        return manifolds.items[0].normal;
    }
    /// Overlaps of up to 4 cm to gaps of up to 2 cm, along a random direction.
    RelativePose touching_pose(const shapes::Solid& a, const shapes::Solid& b) {
        const D3 way = random.direction();
        rotation = random.rotation(0, 3);
        RelativePose pose{to_rotation(rotation), {}};
        const UnitVec3 n{as_fixed<Unit>(way.x), as_fixed<Unit>(way.y), as_fixed<Unit>(way.z)};
        const double gap =
            -static_cast<double>(separation(a, b, pose, n)) / (1 << 30) + random.uniform(-0.04, 0.02);
        pose.position = {as_fixed<Coordinate>(way.x * gap), as_fixed<Coordinate>(way.y * gap),
                         as_fixed<Coordinate>(way.z * gap)};
        return pose;
    }
    void move(RelativePose& pose) {
        const D3 step = random.direction(), axis = random.direction();
        const double by = random.uniform(0, 0.03), turn = random.uniform(0, 0.05);
        pose.position += {as_fixed<Coordinate>(by * step.x), as_fixed<Coordinate>(by * step.y),
                          as_fixed<Coordinate>(by * step.z)};
        rotation =
            integrate_rotation(rotation, Vec3{as_fixed<Real>(turn * axis.x), as_fixed<Real>(turn * axis.y),
                                              as_fixed<Real>(turn * axis.z)});
        pose.rotation = to_rotation(rotation);
    }

    AssetLibrary library;
    oracle::RandomReal random{32};
    std::vector<shapes::Solid> solids;
    Quat rotation;
    NarrowScratch scratch;
    Manifolds manifolds;
};

} // namespace

TEST_CASE("a cached face separates two shapes as well as the face that a new search finds") {
    KeptManifolds pairs;
    for (int i = 0; i < 60000; ++i) pairs.look(true);
    MESSAGE(pairs.looked_at, " faces, ", pairs.changed, " left for others, ", pairs.parted,
            " parted; without a look ", pairs.worse_planted, " would be worse");
    CHECK(pairs.looked_at > 5000);
    CHECK(pairs.changed > 500);
    CHECK(pairs.parted > 100);
    CHECK(pairs.unlike == 0);
    CHECK(pairs.worse == 0);
    CHECK(pairs.worse_planted > 500);
}

// The points of crossing edges come from rounded lengths of 24 fraction bits, three per coordinate, at an angle whose
// sine is at least a twelfth.
TEST_CASE("cached crossing edges separate two shapes as well as a new search does and have the same contact "
          "point") {
    KeptManifolds pairs;
    for (int i = 0; i < 60000; ++i) pairs.look(false);
    MESSAGE(pairs.looked_at, " pairs of edges, ", pairs.changed, " with another normal, ", pairs.parted,
            " parted, ", pairs.alike, " alike, ", pairs.same_bits, " of them bit for bit, farthest ",
            pairs.farthest_24, "; without a look ", pairs.worse_planted, " would be worse");
    CHECK(pairs.looked_at > 5000);
    CHECK(pairs.parted > 100);
    CHECK(pairs.alike > 1000);
    CHECK(pairs.farthest_24 <= 3 * 12);
    CHECK(pairs.unlike == 0);
    CHECK(pairs.worse == 0);
    CHECK(pairs.worse_planted > 500);
}
