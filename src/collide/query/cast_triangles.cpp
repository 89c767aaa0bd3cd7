// Rays against meshes and height fields.
//
// The signs of three volumes, each of the line and an edge, decide whether the line crosses a triangle. They
// are exact integers, and the two triangles at an edge compute the same volume with opposite signs. A line
// through an edge or a corner therefore hits every triangle there and never slips through.
//
// source: Segura and Feito, An Algorithm for Determining Intersection Segment-Polygon in 3D, 1998 (signed volumes)
#include "collide/query/cast_line.h"
#include "shapes/mesh/face.h"

namespace lockstone::collide {
namespace {

/// Needs |x| < 2^86 and |y| < 2^40.
Wide product(Wide x, std::int64_t y) {
    const std::int64_t high = static_cast<std::int64_t>((x >> 40).low_bits());
    const std::int64_t low = static_cast<std::int64_t>(x.low_bits() & ((std::uint64_t{1} << 40) - 1));
    return (Wide::product(high, y) << 40) + Wide::product(low, y);
}

struct Wide3 {
    Wide x, y, z;
};
Wide3 cross_wide(Long3 a, Long3 b) {
    return {Wide::product(a[1], b[2]) - Wide::product(a[2], b[1]),
            Wide::product(a[2], b[0]) - Wide::product(a[0], b[2]),
            Wide::product(a[0], b[1]) - Wide::product(a[1], b[0])};
}
/// The components of b are below 2^40 and those of a below 2^82: the sum stays below 2^124.
Wide dot_wide(Wide3 a, Long3 b) { return product(a.x, b[0]) + product(a.y, b[1]) + product(a.z, b[2]); }

bool is_zero(Wide w) { return w.high_bits() == 0 && w.low_bits() == 0; }

/// The line with its origin moved near the triangles: one origin for all triangles of a solid.
struct Anchored {
    Long3 origin_24, way_24;
    std::int64_t at_30; ///< distance of the new origin along the line
    std::int64_t length_30;
};

/// A line seen along its way: a projection along the line onto the plane of the two axes on which it moves less.
class AlongLine {
  public:
    explicit AlongLine(Long3 way_24) {
        for (int i = 1; i < 3; ++i)
            if (absolute(way_24[i]) > absolute(way_24[main])) main = i;
        for (int k = 0; k < 2; ++k) {
            side[k] = (main + 1 + k) % 3;
            slope_30[k] = divide_shifted(way_24[side[k]], way_24[main], 30);
        }
    }
    /// True when the line certainly passes beside the triangle, whose corners count from a point of the line. False
    /// when this is unknown: near an edge, and beyond 32 m.
    bool misses(const Long3 (&corner_24)[3]) const {
        const Long3 &p = corner_24[0], &q = corner_24[1], &r = corner_24[2];
        if (((absolute(p[0]) | absolute(p[1]) | absolute(p[2]) | absolute(q[0]) | absolute(q[1]) |
              absolute(q[2]) | absolute(r[0]) | absolute(r[1]) | absolute(r[2])) >>
             29) != 0)
            return false;
        const std::int64_t x[3] = {along(p, 0), along(q, 0), along(r, 0)};
        if (is_beside(x)) return true;
        const std::int64_t y[3] = {along(p, 1), along(q, 1), along(r, 1)};
        if (is_beside(y)) return true;
        // The line passes on different sides of two edges.
        const std::int64_t most = absolute(x[0]) | absolute(x[1]) | absolute(x[2]) | absolute(y[0]) |
                                  absolute(y[1]) | absolute(y[2]);
        const std::int64_t error = 8 * error_24 * (most + 1);
        const std::int64_t a = x[0] * y[1] - x[1] * y[0], b = x[1] * y[2] - x[2] * y[1],
                           c = x[2] * y[0] - x[0] * y[2];
        return smaller(a, smaller(b, c)) < -error && larger(a, larger(b, c)) > error;
    }

  private:
    static constexpr std::int64_t error_24 = 2; ///< of a projected coordinate

    std::int64_t along(const Long3& corner_24, int k) const {
        return corner_24[side[k]] - (slope_30[k] * corner_24[main] >> 30);
    }
    static bool is_beside(const std::int64_t (&x)[3]) {
        return smaller(x[0], smaller(x[1], x[2])) > error_24 || larger(x[0], larger(x[1], x[2])) < -error_24;
    }

    int main = 0, side[2];
    std::int64_t slope_30[2]; ///< at most 1
};

/// n / d with 60 fraction bits. Returns false when it is outside of +-2.
bool quotient_60(Wide n, Wide d, std::int64_t& out) {
    const Wide positive = d.is_negative() ? Wide::from(0) - d : d;
    const auto high = static_cast<std::uint64_t>(positive.high_bits());
    const int bits = high != 0 ? 64 + bit_length(high) : bit_length(positive.low_bits());
    const auto fitted = [bits](Wide w) {
        return saturate_to_int64(bits > 60 ? w >> (bits - 60) : w << (60 - bits));
    };
    // A numerator of more than 61 bits makes the quotient too large. This test comes first, because the left
    // shift must not lose bits.
    const Wide twice = positive << 1;
    if (twice < n || twice < Wide::from(0) - n) return false;
    out = divide_shifted(fitted(n), fitted(d), 60);
    return true;
}

/// Intersects the line with a triangle. The front is the side to which the normal points.
bool meets(const Anchored& line, const AlongLine& along, const shapes::Face& triangle, bool two_sided,
           std::int64_t& at_30, bool& from_front) {
    Long3 corner[3];
    for (int i = 0; i < 3; ++i) corner[i] = raw(triangle.corner[i]) - line.origin_24;
    if (along.misses(corner)) return false;
    Wide volume[3];
    bool any_positive = false, any_negative = false;
    for (int i = 0; i < 3; ++i) {
        volume[i] = dot_wide(cross_wide(corner[i], corner[(i + 1) % 3]), line.way_24);
        if (volume[i].is_negative())
            any_negative = true;
        else if (!is_zero(volume[i]))
            any_positive = true;
    }
    // The line is beside the triangle or parallel to its plane.
    if (any_positive == any_negative) return false;
    from_front = any_negative;
    if (!from_front && !two_sided) return false;
    const Wide slope = volume[0] + volume[1] + volume[2];
    const Wide height = dot_wide(cross_wide(corner[0], corner[1]), corner[2]);
    std::int64_t part_60 = 0;
    if (!quotient_60(height, slope, part_60)) return false;
    constexpr std::int64_t rounding_30 = 32;
    at_30 = line.at_30 + times_60(line.length_30, part_60);
    return at_30 >= -rounding_30 && at_30 <= line.length_30 + rounding_30;
}

shapes::Extent extent_of_piece(const Line& line, std::int64_t from_30, std::int64_t to_30) {
    constexpr std::int64_t guard_24 = 4;
    const Long3 a = shifted(point_30(line, from_30), 6), b = shifted(point_30(line, to_30), 6);
    Long3 low{}, high{};
    for (int i = 0; i < 3; ++i) {
        low[i] = smaller(a[i], b[i]) - guard_24;
        high[i] = larger(a[i], b[i]) + guard_24;
    }
    return {coordinates(low), coordinates(high)};
}

/// Initial length of a piece of the line, so that its box meets a handful of triangles.
std::int64_t piece_length_30(const shapes::Solid& solid, const shapes::Extent& extent) {
    const Long3 size = raw(extent.upper) - raw(extent.lower);
    const std::int64_t widest = larger(size[0], larger(size[1], size[2]));
    const std::int64_t per_side = 1 + isqrt(std::uint64_t{shapes::triangle_count(solid)});
    return larger(up(widest, 6) / per_side * 4, std::int64_t{1} << 20);
}

} // namespace

bool cast_ray_triangles(const shapes::Solid& solid, const Line& line, NarrowScratch& scratch, CastHit& hit) {
    const shapes::Extent extent = shapes::extent_of(solid);
    const Span span = span_of_box(line, extent);
    if (span.empty() || line.length_30 == 0) return false;
    const std::int64_t middle = span.enter_30 + (span.exit_30 - span.enter_30) / 2;
    const Anchored anchored{shifted(point_30(line, middle), 6), line.way_24, middle, line.length_30};
    const AlongLine along(anchored.way_24);
    const bool two_sided = shapes::is_two_sided(solid);
    const std::int64_t first_piece = piece_length_30(solid, extent);
    std::int64_t piece = first_piece, best = 0;
    bool found = false;
    for (std::int64_t from = span.enter_30; from <= span.exit_30 && !(found && best <= from);) {
        const std::int64_t to_30 = smaller(from + piece, span.exit_30);
        scratch.triangles.clear();
        shapes::find_triangles(solid, extent_of_piece(line, from, to_30), scratch.triangles);
        for (const std::uint32_t index : scratch.triangles) {
            const shapes::Face triangle = shapes::face_at(solid, index);
            std::int64_t at = 0;
            bool from_front = true;
            if (!meets(anchored, along, triangle, two_sided, at, from_front)) continue;
            if (found && (at > best || (at == best && index >= hit.feature))) continue;
            found = true;
            best = at;
            const Long3 normal = raw(triangle.normal);
            hit = hit_at(line, at, from_front ? normal : -normal, index);
        }
        from = to_30 + 1;
        if (scratch.triangles.size() < 4)
            piece = smaller(piece * 2, first_piece * 8);
        else if (scratch.triangles.size() > 32)
            piece = larger(piece / 2, first_piece / 4 + 1);
    }
    return found;
}

} // namespace lockstone::collide
