#include "solve/contacts/contact.h"

#include "lockstone/math/math.h"

#include <algorithm>

namespace lockstone::solve {

/// The frame (pole, from) turned along the shortest arc from the pole to the normal: from - (pole + n) (n . from) / (1
/// + n . pole). It is continuous except opposite the pole, a direction that scenes do not use.
Tangents tangents_of(UnitVec3 normal) {
    constexpr std::int64_t one = std::int64_t{1} << 30;
    constexpr const std::int32_t(&pole)[3] = tangent_pole, (&from)[3] = tangent_from;
    const std::int64_t n[3] = {normal.x.raw, normal.y.raw, normal.z.raw};
    std::int64_t along = 0, off = 0;
    for (int i = 0; i < 3; ++i) along += n[i] * pole[i], off += n[i] * from[i];
    along = shift_right_rounded(along, 30);
    UnitVec3 first;
    if (along < tangent_pole_limit)
        first = normalized(UnitVec3{Unit{}, -normal.z, normal.y});
    else {
        const std::int64_t share = divide_shifted(shift_right_rounded(off, 30), one + along, 30); // below 16
        for (int i = 0; i < 3; ++i)
            first[i] = Unit::from_raw(static_cast<std::int32_t>(
                std::clamp(from[i] - shift_right_rounded((pole[i] + n[i]) * share, 30), -one, one)));
    }
    return {first, cross<Unit>(normal, first)};
}

} // namespace lockstone::solve
