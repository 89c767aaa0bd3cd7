// Balls that are cast at triangles repeatedly: the triangles that a cast caches change no later hit.
#include "collide/query/cast_line.h"
#include "oracle/mesh_scenes.h"

#include <algorithm>
#include <cmath>

using namespace lockstone;
using namespace mesh_scenes;

namespace {

bool same(const collide::CastHit& a, const collide::CastHit& b) {
    return a.distance == b.distance && a.fraction == b.fraction && a.point == b.point &&
           a.normal == b.normal && a.feature == b.feature;
}

/// A ball that wanders over a ground. It is cast down a metre from each place, with the cache of earlier casts and
/// without.
struct Wanderer {
    const Owned& ground;
    collide::NearFaces near = {};
    collide::NarrowScratch scratch = {};
    int hits = 0, differing = 0;

    void cast(D3 from, Length radius) {
        const collide::RelativePose pose = pose_at(from, Quat::identity());
        const CoordinateVec3 way{Coordinate{}, Coordinate(-1), Coordinate{}};
        collide::CastHit expected{};
        const bool meets = collide::cast_shape(ground.solid, primitive(sphere(to<Real>(radius))), pose, way,
                                               scratch, expected);
        collide::Line line{};
        REQUIRE(collide::make_line(pose.position, way, line));
        collide::CastHit hit{};
        const bool found = collide::cast_ball(ground.solid, line, radius.raw, &near, scratch, hit);
        if (found != meets || (found && !same(hit, expected))) ++differing;
        if (meets) ++hits;
    }
};

/// Wanders around a place and checks that the casts hit and agree.
void wander(const Owned& ground, std::uint64_t seed, double place = 0) {
    oracle::RandomReal random(seed);
    Wanderer w{ground};
    D3 at{place, 0, place};
    const Length radius = as_fixed<Length>(0.35);
    for (int i = 0; i < 400; ++i) {
        for (double* x : {&at.x, &at.z})
            *x = std::clamp(*x + random.uniform(-0.3, 0.3), place - 6, place + 6);
        w.cast({at.x, random.uniform(0.2, 1.2), at.z}, radius);
    }
    CHECK(w.differing == 0);
    CHECK(w.hits > 100);
}

} // namespace

TEST_CASE("a ball cast hits the same triangles with any cache of earlier casts and without one") {
    const auto flat = [](double, double) { return 0.0; };
    const auto rough = [](double x, double z) { return 0.3 * std::sin(2 * x) * std::cos(3 * z); };
    wander(mesh(grid(-8, -8, 1, 16, 16, 0, 0, flat)), 1);
    wander(mesh(grid(-8, -8, 1, 16, 16, 0.3, 2, rough)), 2);
    wander(mesh(grid(-8, -8, 0.25, 64, 64, 0.3, 3, rough), true), 3); // more triangles than the cache holds
    const LengthVec3 scale{as_fixed<Length>(1.5), as_fixed<Length>(0.5), as_fixed<Length>(1.25)};
    wander(mesh(grid(-8, -8, 1, 16, 16, 0.3, 4, rough), false, scale), 4);
    wander(height_field(33, 33, 0.5, [&](double x, double z) { return rough(x / 2, z / 2); }), 5, 8);
}
