// Primitives that are large by Geometry::scale.
#pragma once

#include "lockstone/shape.h"

namespace lockstone::test {

/// The geometry with its sizes as they are and with this `scale` on all axes. scaled() would multiply the sizes.
constexpr Geometry with_scale(Geometry geometry, Real factor) {
    const Length f = to<Length>(factor);
    geometry.scale = {f, f, f};
    return geometry;
}

} // namespace lockstone::test
