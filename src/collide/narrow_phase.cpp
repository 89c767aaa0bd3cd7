#include "collide/narrow_phase.h"

#include "base/assert.h"
#include "collide/integer.h"

namespace lockstone::collide {
namespace {

using Routine = void (*)(const Geometry&, const Geometry&, const RelativePose&, Length, Manifold&);

/// By [a.kind][b.kind].
constexpr Routine routines[4][4] = {
    {collide_sphere_sphere, nullptr, nullptr, nullptr},
    {collide_capsule_sphere, collide_capsule_capsule, nullptr, nullptr},
    {collide_box_sphere, collide_box_capsule, collide_box_box, nullptr},
    {collide_plane_sphere, collide_plane_capsule, collide_plane_box, nullptr},
};

/// R^T d for a difference of world positions, rounded once to Length.
/// d is split in two so that all products fit 64 bits: d = high_24 + low_32, with 8 bits in the low part.
LengthVec3 into_frame(const Rotation& r, Vec3 d) {
    const Long3 d_32 = raw(d);
    constexpr std::int64_t reach = std::int64_t{256} << Real::fraction_bits;
    for (int i = 0; i < 3; ++i)
        if (d_32[i] > reach || d_32[i] < -reach) return {Length::max(), Length::max(), Length::max()};
    const Long3 high{d_32[0] >> 8, d_32[1] >> 8, d_32[2] >> 8};
    const Long3 low{d_32[0] & 255, d_32[1] & 255, d_32[2] & 255};
    const auto along = [&](Long3 axis) {
        return round_from<Length>(dot(high, axis) + (dot(low, axis) >> 8), 54);
    };
    return {along(raw(r.x)), along(raw(r.y)), along(raw(r.z))};
}

bool too_far(const LengthVec3& p) {
    const auto at_end = [](Length x) { return x == Length::max() || x <= -Length::max(); };
    return at_end(p.x) || at_end(p.y) || at_end(p.z);
}

} // namespace

RelativePose relative_pose(const Transform& a, const Transform& b) {
    return {to_rotation(conjugate(a.rotation) * b.rotation),
            into_frame(to_rotation(a.rotation), b.position - a.position)};
}

PlaneView plane_view(const Transform& plane, const Transform& b) {
    constexpr Real height_max = 120_r;
    const UnitVec3 normal = to_rotation(plane.rotation).y;
    const Real height = dot<Real>(normal, b.position - plane.position);
    const Length near = to<Length>(clamp(height, -height_max, height_max));
    return {{to_rotation(conjugate(plane.rotation) * b.rotation), {Length{}, near, Length{}}},
            b.position - scale<Real>(normal, near)};
}

void collide(const Geometry& a, const Geometry& b, const RelativePose& pose, Length margin, Manifold& out) {
    const auto kind_a = static_cast<std::uint32_t>(a.kind), kind_b = static_cast<std::uint32_t>(b.kind);
    LOCKSTONE_ASSERT(kind_a <= 3 && kind_b <= kind_a && kind_b != 3, "shape kinds ", kind_a, " and ", kind_b);
    out = Manifold{};
    if (too_far(pose.position)) return;
    routines[kind_a][kind_b](a, b, pose, margin, out);
}

} // namespace lockstone::collide
