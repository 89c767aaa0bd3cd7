// A plane against everything: the pose's height and the shape's lowest points.
#include "collide/integer.h"

namespace lockstone::collide {
namespace {

constexpr UnitVec3 plane_normal{Unit{}, unit_one, Unit{}};

/// A point of B `surface_30` above the plane, whose core is at `core_30`.
void add_above_plane(Manifold& out, Long3 core_30, std::int64_t surface_30, Length margin,
                     std::uint32_t feature) {
    add_point(out, {core_30[0], surface_30 >> 1, core_30[2]}, surface_30, margin, feature);
}

} // namespace

void collide_plane_sphere(const Geometry&, const Geometry& b, const RelativePose& pose, Length margin,
                          Manifold& out) {
    const Long3 center = up(raw(pose.position), 6);
    out.normal = plane_normal;
    add_above_plane(out, center, center[1] - up(b.radius.raw, 6), margin, 1);
}

void collide_plane_capsule(const Geometry&, const Geometry& b, const RelativePose& pose, Length margin,
                           Manifold& out) {
    const Long3 center = up(raw(pose.position), 30), half = raw(pose.rotation.y) * b.half_extent.y.raw;
    out.normal = plane_normal;
    const Long3 low = shifted(center - half, 24), high = shifted(center + half, 24);
    add_above_plane(out, low, low[1] - up(b.radius.raw, 6), margin, 1);
    if (b.half_extent.y > Length{}) add_above_plane(out, high, high[1] - up(b.radius.raw, 6), margin, 2);
}

/// The four corners of the face that looks down most: the lowest corner is always one of them.
void collide_plane_box(const Geometry&, const Geometry& b, const RelativePose& pose, Length margin,
                       Manifold& out) {
    const Long3 axes[3] = {raw(pose.rotation.x), raw(pose.rotation.y), raw(pose.rotation.z)};
    const Long3 half = raw(b.half_extent);
    int down = 0;
    for (int i = 1; i < 3; ++i)
        if (absolute(axes[i][1]) > absolute(axes[down][1])) down = i;
    const int u = (down + 1) % 3, v = (down + 2) % 3;
    const bool flipped = axes[down][1] < 0; // then the positive side looks down
    const Long3 face = up(raw(pose.position), 30) + axes[down] * (flipped ? half[down] : -half[down]);
    out.normal = plane_normal;
    for (std::uint32_t k = 0; k < 4; ++k) {
        const Long3 corner = shifted(face + axes[u] * ((k & 1u) != 0 ? half[u] : -half[u]) +
                                         axes[v] * ((k & 2u) != 0 ? half[v] : -half[v]),
                                     24);
        const std::uint32_t id = (flipped ? 1u << down : 0u) | (k & 1u) << u | (k >> 1) << v;
        add_above_plane(out, corner, corner[1], margin, corner_feature_b(id));
    }
}

} // namespace lockstone::collide
