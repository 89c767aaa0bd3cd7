// source: Ericson, Real-Time Collision Detection, 4.2.6 (bounds of a rotated box from |R|)
#include "collide/bounds.h"

namespace lockstone::collide {
namespace {

/// What the roundings of the rotation and of the narrow phase can add up to for shapes of 100 m: 1 um.
constexpr std::int64_t guard = 16; // Length steps

/// Half the width of the shape along each world axis, rounded up, in Length steps.
Vector3<Fixed<std::int64_t, 24>> half_width(const Geometry& g, const Quat& rotation) {
    const Rotation r = to_rotation(rotation);
    const auto along = [&](Unit rx, Unit ry, Unit rz) {
        const std::int64_t sum = static_cast<std::int64_t>(magnitude(rx.raw)) * g.half_extent.x.raw +
                                 static_cast<std::int64_t>(magnitude(ry.raw)) * g.half_extent.y.raw +
                                 static_cast<std::int64_t>(magnitude(rz.raw)) * g.half_extent.z.raw;
        constexpr std::int64_t up = (std::int64_t{1} << Unit::fraction_bits) - 1;
        return Fixed<std::int64_t, 24>::from_raw(((sum + up) >> Unit::fraction_bits) + g.radius.raw);
    };
    return {along(r.x.x, r.y.x, r.z.x), along(r.x.y, r.y.y, r.z.y), along(r.x.z, r.y.z, r.z.z)};
}

} // namespace

Bounds bounds_of(const Geometry& g, const Transform& pose, Length margin, int shift) {
    if (g.kind == ShapeKind::plane) {
        const Vector3<Bound> low{Bound::min(), Bound::min(), Bound::min()},
            high{Bound::max(), Bound::max(), Bound::max()};
        return {low, high};
    }
    const Vector3<Fixed<std::int64_t, 24>> h = half_width(g, pose.rotation);
    const int drop = Real::fraction_bits - Bound::fraction_bits + shift;
    const auto reach = [&](Fixed<std::int64_t, 24> half_width) {
        return (half_width.raw + margin.raw + guard) << (Real::fraction_bits - Length::fraction_bits);
    };
    const auto low = [&](Real p, Fixed<std::int64_t, 24> width) {
        return Bound::from_raw(saturate_to_int32(sub_saturated(p.raw, reach(width)) >> drop));
    };
    const auto high = [&](Real p, Fixed<std::int64_t, 24> width) { // ceil: one above the floor
        return Bound::from_raw(saturate_to_int32((add_saturated(p.raw, reach(width)) >> drop) + 1));
    };
    return {{low(pose.position.x, h.x), low(pose.position.y, h.y), low(pose.position.z, h.z)},
            {high(pose.position.x, h.x), high(pose.position.y, h.y), high(pose.position.z, h.z)}};
}

} // namespace lockstone::collide
