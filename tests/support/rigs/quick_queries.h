// Quick paths of queries beside plain ones: boxes that move through a crowd, and shapes that are cast at triangles. For
// the tests and for the planted faults.
#pragma once

#include "collide/broad/broad_phase.h"
#include "collide/query/cast.h"
#include "shapes/asset/asset.h"
#include "support/sim_scenes.h"
#include "support/split_mix.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace lockstone::test {

/// A box with random sides of up to `size` steps, around a place.
inline collide::Bounds drawn_bounds(SplitMix& random, const double (&at)[3], double size) {
    collide::Bounds bounds{};
    for (int i = 0; i < 3; ++i) {
        const double half = drawn(random, 0, size / 2);
        bounds.lower[i] = Bound::from_raw(static_cast<std::int32_t>(at[i] - half));
        bounds.upper[i] = Bound::from_raw(static_cast<std::int32_t>(at[i] + half));
    }
    return bounds;
}

/// A crowd of boxes in a broad phase, with a wide tree.
struct WideCrowd {
    static constexpr std::uint32_t count = 300;
    double room, size;
    collide::BroadPhase phase;
    std::vector<collide::Bounds> boxes;
    const collide::WideTree* wide = nullptr;

    explicit WideCrowd(SplitMix& random)
        : room(std::exp2(drawn(random, 14, 26))), size(room * drawn(random, 0.01, 0.2)),
          phase(count, Bound::from_raw(static_cast<std::int32_t>(size / 10))), boxes(count) {
        for (std::uint32_t i = 0; i < count; ++i) put(random, i);
    }
    void place(SplitMix& random, double (&at)[3], double most) const {
        for (double& x : at) x = drawn(random, -most, most);
    }
    void put(SplitMix& random, std::uint32_t i) {
        double at[3];
        place(random, at, room);
        boxes[i] = drawn_bounds(random, at, random.one_in(20) ? room : size);
        phase.set(i, boxes[i], random.one_in(3));
    }
    void prepare() {
        phase.update_trees();
        wide = nullptr;
        for (int i = 0; i < 100 && wide == nullptr; ++i) wide = phase.prepare_query();
    }
    /// A box that moves a long or a short way, or only along some axes.
    std::array<collide::Bounds, 2> draw_way(SplitMix& random) const {
        double from[3], to[3];
        place(random, from, random.one_in(4) ? 3 * room : room), place(random, to, room);
        const std::uint32_t still = random.below(8); // bits of the axes along which it does not move
        const double share = random.one_in(4) ? 0.01 : 1;
        const collide::Bounds begin = drawn_bounds(random, from, random.one_in(2) ? 4 : size);
        collide::Bounds end = begin;
        for (int i = 0; i < 3; ++i) {
            if ((still >> i & 1u) != 0) continue;
            const auto way = Bound::from_raw(static_cast<std::int32_t>((to[i] - from[i]) * share));
            end.lower[i] += way, end.upper[i] += way;
        }
        return {begin, end};
    }
};

/// Moves boxes through a crowd. Returns a sentence if a query of the wide tree does not give the proxies that a test of
/// each gives. `found`: their number.
inline std::string wide_tree_fault(std::uint64_t seed, std::size_t& found) {
    SplitMix random(seed);
    WideCrowd crowd(random);
    collide::BroadPhase::Asker asker;
    std::vector<std::uint32_t> wanted, overlapping;
    for (int k = 0; k < 200; ++k) {
        if (k % 50 == 49) crowd.put(random, random.below(WideCrowd::count));
        if (k % 50 == 49 || k == 0) crowd.prepare();
        if (crowd.wide == nullptr) return "there is no wide tree";
        const auto [begin, end] = crowd.draw_way(random);
        const collide::SweptBox box(begin, end);
        wanted.clear(), overlapping.clear();
        for (std::uint32_t i = 0; i < WideCrowd::count; ++i) {
            if (box.may_meet(crowd.boxes[i])) wanted.push_back(i);
            if (collide::overlap(begin, crowd.boxes[i])) overlapping.push_back(i);
        }
        const std::string where = "seed " + std::to_string(seed) + ", box " + std::to_string(k);
        crowd.phase.query(box, crowd.wide, asker);
        if (asker.proxies != wanted)
            return where + " meets " + std::to_string(wanted.size()) + ", not " +
                   std::to_string(asker.proxies.size());
        crowd.phase.query(begin, crowd.wide, asker);
        if (asker.proxies != overlapping) return where + " overlaps others";
        found += wanted.size();
    }
    return {};
}

/// Triangles that are near each other, as one mesh and one by one.
struct Shards {
    AssetLibrary library;
    std::vector<Vec3> corners;         ///< three of each triangle
    std::vector<shapes::Solid> solids; ///< the whole, then each triangle

    explicit Shards(SplitMix& random) {
        const auto corner = [&](double x, double y, double z, double wide) {
            corners.push_back({scene::real(x + drawn(random, -wide, wide)),
                               scene::real(y + drawn(random, -wide, wide)),
                               scene::real(z + drawn(random, -wide, wide))});
        };
        const double wide = drawn(random, 0.3, 1.5);
        for (int i = 0; i < 60; ++i) {
            const double x = drawn(random, -3, 3), y = drawn(random, -1, 1), z = drawn(random, -3, 3);
            for (int k = 0; k < 3; ++k) corner(x, y, z, wide);
        }
        add(corners);
        for (std::size_t i = 0; i < corners.size(); i += 3)
            add({corners.begin() + static_cast<std::ptrdiff_t>(i),
                 corners.begin() + static_cast<std::ptrdiff_t>(i + 3)});
    }
    void add(const std::vector<Vec3>& of) {
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (std::uint32_t i = 0; i < of.size(); i += 3) triangles.push_back({i, i + 1, i + 2});
        const AssetId id =
            library.add(bake_mesh({.vertices = of, .triangles = triangles, .two_sided = true})).value();
        solids.push_back({library.geometry(id).value()});
        solids.back().mesh = library.find(id)->mesh.get();
    }
};

inline Unit drawn_unit(SplitMix& random) {
    return Unit::from_raw(static_cast<std::int32_t>(random.below(2u << 30)) - unit_one.raw);
}

/// A convex solid of a random kind.
inline Geometry drawn_convex(SplitMix& random) {
    const auto side = [&random] { return scene::real(drawn(random, 0.1, 0.6)); };
    const Vec3 half{side(), side(), side()};
    switch (random.below(4)) {
    case 0:
        return capsule(half.x, half.y);
    case 1:
        return cylinder(half.x, half.y);
    case 2:
        return rounded(box(half.x, half.y, half.z), 0.05_r);
    default:
        return box(half.x, half.y, half.z);
    }
}

inline bool is_same_place(const collide::CastHit& a, const collide::CastHit& b) {
    return a.distance == b.distance && a.fraction == b.fraction && a.point == b.point && a.normal == b.normal;
}

/// True if a solid overlaps another one on its way, before a fraction of it.
inline bool passes_through(const shapes::Solid& solid, const shapes::Solid& moving,
                           const collide::RelativePose& pose, CoordinateVec3 way, Unit until) {
    collide::NarrowScratch scratch;
    for (int part = 0; part < 24; ++part) {
        const Unit at = Unit::from_raw((unit_one.raw / 24) * part);
        if (at.raw > until.raw - (1 << 12)) break;
        collide::Nearest nearest{};
        const CoordinateVec3 here = pose.position + scale<Coordinate>(way, at);
        if (collide::nearest_points(solid, moving, {pose.rotation, here}, Coordinate(1), scratch, nearest) &&
            nearest.normal == UnitVec3{})
            return true;
    }
    return false;
}

inline Quat drawn_turn(SplitMix& random) {
    if (random.one_in(3)) return Quat::identity();
    const Unit x = drawn_unit(random), y = drawn_unit(random), z = drawn_unit(random);
    return normalized(Quat{x, y, z, unit_one});
}

/// Casts solids past each other. Returns a sentence if one passes through the other. `hits`: the number of hits.
inline std::string cast_beside_fault(std::uint64_t seed, int& hits) {
    SplitMix random(seed);
    collide::NarrowScratch scratch;
    for (int k = 0; k < 40; ++k) {
        const shapes::Solid solid{drawn_convex(random)}, moving{drawn_convex(random)};
        CoordinateVec3 from{}, way{};
        for (int i = 0; i < 3; ++i) {
            from[i] = to<Coordinate>(scene::real(drawn(random, -1.5, 1.5)));
            if (!random.one_in(3)) way[i] = to<Coordinate>(scene::real(drawn(random, -2, 2)));
        }
        const collide::RelativePose pose{to_rotation(drawn_turn(random)), from};
        collide::CastHit hit{};
        const bool meets = collide::cast_shape(solid, moving, pose, way, scratch, hit);
        hits += meets ? 1 : 0;
        if (passes_through(solid, moving, pose, way, meets ? hit.fraction : unit_one))
            return "seed " + std::to_string(seed) + ", cast " + std::to_string(k) +
                   ": it passes through the other";
    }
    return {};
}

/// Casts solids at shards over short paths, which are searched in one piece. Returns a sentence if a cast does not give
/// the first hit of casts at each triangle, or if the solid overlaps a triangle on its way there. `hits`: their number.
inline std::string cast_order_fault(std::uint64_t seed, int& hits) {
    SplitMix random(seed);
    const Shards shards(random);
    collide::NarrowScratch scratch;
    for (int k = 0; k < 20; ++k) {
        const shapes::Solid moving{drawn_convex(random)};
        const auto coordinate = [&](double most) {
            return to<Coordinate>(scene::real(drawn(random, -most, most)));
        };
        const CoordinateVec3 from{coordinate(4), coordinate(3), coordinate(4)};
        CoordinateVec3 way{coordinate(0.4), coordinate(0.4), coordinate(0.4)};
        if (random.one_in(3)) way = {Coordinate{}, way.y, random.one_in(2) ? Coordinate{} : way.z};
        const collide::RelativePose pose{to_rotation(drawn_turn(random)), from};
        collide::CastHit hit{}, first{}, one{};
        const bool meets = collide::cast_shape(shards.solids[0], moving, pose, way, scratch, hit);
        bool any = false, is_one = false;
        for (std::size_t i = 1; i < shards.solids.size(); ++i) {
            if (!collide::cast_shape(shards.solids[i], moving, pose, way, scratch, one)) continue;
            is_one |= meets && is_same_place(one, hit);
            if (!any || one.distance < first.distance) first = one;
            any = true;
        }
        const std::string where = "seed " + std::to_string(seed) + ", cast " + std::to_string(k);
        if (meets != any || (meets && (hit.distance != first.distance || !is_one)))
            return where + ": the hit is not the first of all triangles";
        hits += meets ? 1 : 0;
        if (passes_through(shards.solids[0], moving, pose, way, meets ? hit.fraction : unit_one))
            return where + ": it passes through a triangle";
    }
    return {};
}

/// Casts rays through a point of each shard. Returns a sentence if a ray does not hit there or before.
inline std::string ray_order_fault(std::uint64_t seed) {
    SplitMix random(seed);
    const Shards shards(random);
    collide::NarrowScratch scratch;
    for (std::size_t i = 0; i < shards.corners.size(); i += 3) {
        const Real share = scene::real(drawn(random, 0.02, 0.96)),
                   other = (scene::real(0.98) - share) * scene::real(drawn(random, 0.02, 1));
        const Vec3 &a = shards.corners[i], &b = shards.corners[i + 1], &c = shards.corners[i + 2];
        const Vec3 target = a + scale<Real>(b - a, share) + scale<Real>(c - a, other);
        Vec3 from = target;
        for (int k = 0; k < 3; ++k)
            if (!random.one_in(3)) from[k] += scene::real(drawn(random, -6, 6));
        const CoordinateVec3 half = to<Coordinate>(target - from);
        collide::CastHit hit{};
        const bool meets =
            collide::cast_ray(shards.solids[0], to<Coordinate>(from), half + half, scratch, hit);
        const Vec3 across = cross<Real>(b - a, c - a);
        const Real area = length(across), steep = dot<Real>(across, target - from);
        if (area < scene::real(0.01) || abs(steep) < scene::real(0.001))
            continue; // it may pass along the triangle
        if (!meets || hit.fraction.raw > unit_one.raw / 2 + (1 << 14))
            return "seed " + std::to_string(seed) + ": a ray misses triangle " + std::to_string(i / 3);
    }
    return {};
}

} // namespace lockstone::test
