// Convex cores: their placement, and their support mapping.
//
// source: van den Bergen, Collision Detection in Interactive 3D Environments, 4.3 (support mappings); hill
// climbing on a hull: Gottschalk, Lin, Manocha, 1996. Hill climbing ends at the furthest corner because the
// hull is exactly convex.
#include "collide/core.h"

#include "base/assert.h"
#include "shapes/hull/support_kernel.h"

namespace lockstone::collide {
namespace {

constexpr std::size_t hull_scan_max = 24; ///< hulls with at most so many corners test all of them

Long3 absolute3(Long3 a) { return {absolute(a[0]), absolute(a[1]), absolute(a[2])}; }

Convex::Core core_of(ShapeKind kind) {
    switch (kind) {
    case ShapeKind::sphere:
        return Convex::Core::point;
    case ShapeKind::capsule:
        return Convex::Core::segment;
    case ShapeKind::cylinder:
        return Convex::Core::cylinder;
    case ShapeKind::cone:
        return Convex::Core::cone;
    case ShapeKind::box:
        return Convex::Core::box;
    default:
        LOCKSTONE_ASSERT(kind == ShapeKind::hull, "no convex shape: kind ", static_cast<std::uint32_t>(kind));
        return Convex::Core::hull;
    }
}

} // namespace

Convex convex_of(const shapes::Solid& solid, const Rotation& rotation, CoordinateVec3 position) {
    const Geometry& g = solid.geometry;
    const Convex::Core core = core_of(g.kind);
    const std::int64_t factor = core == Convex::Core::hull ? 1 : g.scale.x.raw >> Length::fraction_bits;
    return {core,
            Coordinate::from_raw(g.radius.raw * factor),
            raw(position),
            {raw(rotation.x), raw(rotation.y), raw(rotation.z)},
            raw(g.half_extent) * factor,
            core == Convex::Core::hull ? solid.hull : nullptr,
            solid.kernel,
            rotation == Rotation::identity(),
            {}};
}

Convex convex_of_triangle(const Long3 (&corners_24)[3]) {
    constexpr std::int64_t one = std::int64_t{1} << 30;
    return {Convex::Core::triangle,
            Coordinate{},
            Long3{},
            {{one, 0, 0}, {0, one, 0}, {0, 0, one}},
            Long3{},
            nullptr,
            nullptr,
            true,
            {corners_24[0], corners_24[1], corners_24[2]}};
}

Convex moved_along(const Convex& shape, Long3 unit_30, std::int64_t by_24) {
    const Long3 move = times_unit(unit_30, by_24);
    Convex out = shape;
    out.center_24 = out.center_24 + move;
    for (Long3& corner : out.corners_24) corner = corner + move;
    return out;
}

Long3 cross_with_bits(Long3 a, Long3 b, int bits) {
    const Wide x[3] = {Wide::product(a[1], b[2]) - Wide::product(a[2], b[1]),
                       Wide::product(a[2], b[0]) - Wide::product(a[0], b[2]),
                       Wide::product(a[0], b[1]) - Wide::product(a[1], b[0])};
    int length = 0;
    for (const Wide& c : x) {
        const Wide m = c.is_negative() ? Wide::from(0) - c : c;
        const int n = m.high_bits() != 0 ? 64 + bit_length(static_cast<std::uint64_t>(m.high_bits()))
                                         : bit_length(m.low_bits());
        length = n > length ? n : length;
    }
    const auto part = [&](Wide c) {
        return static_cast<std::int64_t>(
            (length > bits ? c >> (length - bits) : c << (bits - length)).low_bits());
    };
    return {part(x[0]), part(x[1]), part(x[2])};
}

Core::Core(const Convex& convex) : shape(&convex), origin_30(up(convex.center_24, 6)) {
    if (convex.core == Convex::Core::hull || convex.core == Convex::Core::triangle) return;
    for (int i = 0; i < 3; ++i) extent_30[i] = along_30(convex.axes_30[i], convex.half_24[i]);
}

Core::Extent Core::extent() const {
    constexpr Long3 roundings{4, 4, 4};
    Extent found{origin_30, roundings};
    if (shape->core == Convex::Core::triangle) {
        Long3 low = shape->corners_24[0], high = low;
        for (const Long3& c : shape->corners_24)
            for (int i = 0; i < 3; ++i) low[i] = smaller(low[i], c[i]), high[i] = larger(high[i], c[i]);
        return {up(low + high, 5), up(high - low, 5) + roundings};
    }
    if (shape->core != Convex::Core::hull) {
        for (const Long3& half : extent_30) found.reach = found.reach + absolute3(half);
        return found;
    }
    const Long3 low = raw(shape->hull->extent.lower), high = raw(shape->hull->extent.upper);
    for (int i = 0; i < 3; ++i) {
        const Long3& axis = shape->axes_30[i];
        found.middle = found.middle + along_30(axis, (low[i] + high[i]) >> 1);
        found.reach = found.reach + absolute3(along_30(axis, (high[i] - low[i] + 3) >> 1));
    }
    return found;
}

/// The point furthest along a direction on the rim of a disc around y (x = z radius), from the disc's centre.
Long3 Core::support_rim(Long3 direction) const {
    const Long3 flat =
        with_bits({dot(shape->axes_30[0], direction), 0, dot(shape->axes_30[2], direction)}, 31);
    if (is_zero(flat)) return extent_30[0];
    const std::int64_t root =
        isqrt(static_cast<std::uint64_t>(flat[0] * flat[0]) + static_cast<std::uint64_t>(flat[2] * flat[2]));
    const std::int64_t x = divide_shifted(flat[0], root, 30), z = divide_shifted(flat[2], root, 30);
    const auto part = [&](int i) {
        return narrow_rounded(Wide::product(extent_30[0][i], x) + Wide::product(extent_30[2][i], z), 30);
    };
    return {part(0), part(1), part(2)};
}

static std::uint32_t furthest(const shapes::Hull& hull, const shapes::SupportKernel& kernel,
                              const Long3& local) {
    const std::int32_t direction[3] = {static_cast<std::int32_t>(local[0]),
                                       static_cast<std::int32_t>(local[1]),
                                       static_cast<std::int32_t>(local[2])};
    return kernel.furthest(hull.lanes.data(), static_cast<std::uint32_t>(hull.lanes.size() / 3), direction);
}

/// Hill climbing from corner to corner. |local| <= 2^32, |v| < 2^8 m = 2^32 steps, and components of v are
/// below 2^31.
static std::uint32_t climb(const shapes::Hull& hull, const Long3& local, std::uint32_t corner) {
    const auto along = [&](std::uint32_t k) { return dot(local, raw(hull.vertices[k])); };
    std::int64_t most = along(corner);
    while (true) {
        const std::uint32_t end = hull.first_neighbour[corner + 1];
        std::uint32_t best = corner;
        for (std::uint32_t k = hull.first_neighbour[corner]; k < end; ++k)
            if (const std::int64_t x = along(hull.neighbours[k]); x > most)
                best = hull.neighbours[k], most = x;
        if (best == corner) return corner;
        corner = best;
    }
}

/// The first of the furthest corners. Uses masks: the comparison is unpredictable, so a branch would be
/// mispredicted often.
static std::uint32_t scan(const shapes::Hull& hull, const Long3& local) {
    const auto along = [&](std::uint64_t k) { return dot(local, raw(hull.vertices[k])); };
    std::uint64_t best = 0, most = static_cast<std::uint64_t>(along(0));
    const std::uint64_t count = hull.vertices.size();
    for (std::uint64_t k = 1; k < count; ++k) {
        const std::int64_t x = along(k);
        const std::uint64_t more = x > static_cast<std::int64_t>(most) ? ~std::uint64_t{0} : 0;
        most ^= (most ^ static_cast<std::uint64_t>(x)) & more;
        best ^= (best ^ k) & more;
    }
    return static_cast<std::uint32_t>(best);
}

/// Starts the search at `corner` and stores the corner found there.
static inline SupportPoint support_of_hull(const Convex& shape, const Long3& direction,
                                           std::uint32_t& corner) {
    const shapes::Hull& hull = *shape.hull;
    Long3 local = direction;
    if (!shape.upright)
        for (int i = 0; i < 3; ++i) local[i] = shift_right_rounded(dot(shape.axes_30[i], direction), 30);
    if (hull.vertices.size() > hull_scan_max) {
        corner = climb(hull, local, corner);
    } else if (shape.kernel != nullptr && is_within(local, 31)) {
        corner = furthest(hull, *shape.kernel, local);
    } else {
        corner = scan(hull, local);
    }
    return {corner_of(shape, corner), corner};
}

SupportPoint Core::support(const Long3& direction) {
    if (shape->core == Convex::Core::hull) return support_of_hull(*shape, direction, corner);
    const auto towards = [&](int i, Long3 at) {
        return dot(shape->axes_30[i], direction) < 0 ? at - extent_30[i] : at + extent_30[i];
    };
    std::uint32_t id = 0;
    switch (shape->core) {
    case Convex::Core::point:
        return {origin_30, 0};
    case Convex::Core::segment:
        return {towards(1, origin_30), dot(shape->axes_30[1], direction) < 0 ? 0u : 2u};
    case Convex::Core::triangle: {
        for (std::uint32_t k = 1; k < 3; ++k)
            if (wide_dot(shape->corners_24[id] - shape->corners_24[k], direction).is_negative()) id = k;
        return {up(shape->corners_24[id], 6), id};
    }
    case Convex::Core::box:
        for (int i = 0; i < 3; ++i) id |= dot(shape->axes_30[i], direction) < 0 ? 0u : 1u << i;
        return {towards(0, towards(1, towards(2, origin_30))), id};
    case Convex::Core::cylinder:
        return {towards(1, origin_30) + support_rim(direction), id};
    case Convex::Core::cone: {
        const Long3 apex = origin_30 + extent_30[1], rim = origin_30 - extent_30[1] + support_rim(direction);
        const bool at_rim = wide_dot(apex - rim, direction).is_negative();
        return {at_rim ? rim : apex, at_rim ? 0u : 1u};
    }
    case Convex::Core::hull:
        break; // above
    }
    return {origin_30, 0};
}

Difference::Difference(const Cores& cores) : Cores(cores) {
    const Core::Extent of_a = a.extent(), of_b = b.extent();
    offset = of_a.middle - of_b.middle;
    std::int64_t reach = 0;
    for (int i = 0; i < 3; ++i) reach = larger(reach, absolute(offset[i]) + of_a.reach[i] + of_b.reach[i]);
    const int excess = bit_length(static_cast<std::uint64_t>(reach)) - 29;
    drop = excess > 0 ? excess : 0;
}

SupportPoint support(const Convex& shape, Long3 direction_30) {
    if (shape.core != Convex::Core::hull) return Core(shape).support(direction_30);
    std::uint32_t corner = 0;
    return support_of_hull(shape, direction_30, corner);
}

std::int64_t furthest_along_54(const shapes::Hull& hull, const shapes::SupportKernel* kernel, Long3 n_30) {
    const std::uint32_t corner =
        kernel != nullptr && is_within(n_30, 31) ? furthest(hull, *kernel, n_30) : scan(hull, n_30);
    return dot(n_30, raw(hull.vertices[corner]));
}

std::int64_t separation_along_30(const Convex& a, const Convex& b, Long3 normal_30) {
    const Long3 gap = support(b, -normal_30).at_30 - support(a, normal_30).at_30;
    return dot_unit(gap, normal_30);
}

bool within_distance(const Convex& a, const Convex& b, Length margin) {
    const std::int64_t limit_30 = up(a.radius.raw + b.radius.raw + margin.raw, 6);
    const Gap gap = closest_points_within(a, b, limit_30);
    return gap.overlap || gap.distance_30 < limit_30;
}

} // namespace lockstone::collide
