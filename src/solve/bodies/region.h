// The regions where fields act.
#pragma once

#include "lockstone/field.h"
#include "lockstone/math/math.h"

namespace lockstone::solve {

/// True if a point [m] lies in a region or on its border. Exact up to 1e9 m away, where coordinates saturate.
inline bool contains(const Region& region, Vec3 point) {
    if (region.kind == RegionKind::everywhere) return true;
    const Vec3 p = point - region.pose.position, h = region.half_extent;
    if (region.kind == RegionKind::sphere) return length(p) <= h.x;
    const Vec3 local = abs(rotate_inverse(region.pose.rotation, p));
    return local.x <= h.x && local.y <= h.y && local.z <= h.z;
}

} // namespace lockstone::solve
