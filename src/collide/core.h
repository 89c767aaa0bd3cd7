// A convex core prepared for many support queries, and the Minkowski difference of two cores in scaled
// integers. Shared by GJK and EPA.
#pragma once

#include "collide/convex/convex.h"

namespace lockstone::collide {

constexpr Long3 cross(Long3 a, Long3 b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
constexpr Wide wide_dot(Long3 a, Long3 b) {
    return Wide::product(a[0], b[0]) + Wide::product(a[1], b[1]) + Wide::product(a[2], b[2]);
}
/// True when no component needs more than `bits` bits and a sign.
constexpr bool is_within(const Long3& a, int bits) {
    const std::int64_t any = (a[0] ^ (a[0] >> 63)) | (a[1] ^ (a[1] >> 63)) | (a[2] ^ (a[2] >> 63));
    return any >> bits == 0;
}
/// a . n, rounded, for a unit vector n with 30 fraction bits. Fast for a up to 2^31, where the sum of products
/// is below 2^63.
constexpr std::int64_t dot_unit(const Long3& a, const Long3& n_30) {
    return is_within(a, 31) ? shift_right_rounded(dot(a, n_30), 30) : narrow_rounded(wide_dot(a, n_30), 30);
}
/// n x, rounded; fast for x up to 2^31.
constexpr Long3 times_unit(const Long3& n_30, std::int64_t x) {
    if ((x ^ (x >> 63)) >> 31 == 0) return shifted(n_30 * x, 30);
    const auto part = [&](int i) { return narrow_rounded(Wide::product(n_30[i], x), 30); };
    return {part(0), part(1), part(2)};
}
constexpr int sign_of(Wide x) { return x.is_negative() ? -1 : x == Wide::from(0) ? 0 : 1; }
constexpr std::int64_t widest(Long3 a) {
    return larger(absolute(a[0]), larger(absolute(a[1]), absolute(a[2])));
}
constexpr bool is_zero(Long3 a) { return (a[0] | a[1] | a[2]) == 0; }
constexpr bool is_same(Long3 a, Long3 b) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }
/// A vector of equal direction whose widest component is in [2^(bits - 1), 2^bits). Zero stays zero.
/// |a| < 2^63.
constexpr Long3 with_bits(Long3 a, int bits) {
    // Has as many bits as the widest component.
    const std::int64_t any = absolute(a[0]) | absolute(a[1]) | absolute(a[2]);
    const int shift = bits - bit_length(static_cast<std::uint64_t>(any));
    if (shift >= 0) return is_zero(a) ? a : up(a, shift);
    return {a[0] >> -shift, a[1] >> -shift, a[2] >> -shift};
}
/// a x b in 128 bits, then reduced to `bits` bits; exact before that. |a|, |b| < 2^62.
Long3 cross_with_bits(Long3 a, Long3 b, int bits);

/// Position of a corner of a hull. The three products are below 2^62 for |v| < 2^32, so there is no overflow.
inline Long3 corner_of(const Convex& shape, std::uint32_t corner) {
    const Long3 v = raw(shape.hull->vertices[corner]), origin_30 = up(shape.center_24, 6);
    if (shape.upright) return origin_30 + up(v, 6);
    const auto part = [&](int i) {
        return shift_right_rounded(
            shape.axes_30[0][i] * v[0] + shape.axes_30[1][i] * v[1] + shape.axes_30[2][i] * v[2], 24);
    };
    return origin_30 + Long3{part(0), part(1), part(2)};
}

/// True when the core has discs: their lowest point moves along the rim when the shape turns a little.
constexpr bool has_discs(const Convex& shape) {
    return shape.core == Convex::Core::cylinder || shape.core == Convex::Core::cone;
}

/// The shape moved along a unit direction.
Convex moved_along(const Convex& shape, Long3 unit_30, std::int64_t by_24);

/// A convex core with its vectors multiplied out. Each query on a hull starts at the corner where the last one
/// ended. This saves steps. It changes no result except which of several equally far corners is returned.
class Core {
  public:
    explicit Core(const Convex& shape);

    /// The point furthest along a direction with components of at most 2^31; 30 fraction bits.
    SupportPoint support(const Long3& direction);
    /// The middle of the core's extent. On each axis no point of the core is further from it than `reach`. 30
    /// fraction bits.
    struct Extent {
        Long3 middle, reach;
    };
    Extent extent() const;
    bool is_smooth() const { return has_discs(*shape); }
    const Convex& convex() const { return *shape; }

  private:
    Long3 support_rim(Long3 direction) const;

    const Convex* shape;
    Long3 origin_30; ///< the shape's origin
    /// Half extents along the axes, except for hulls; cylinder and cone: x and z are the radius.
    Long3 extent_30[3]{};
    std::uint32_t corner = 0;
};

/// The separation of two cores along a direction, and the hull corners furthest along it.
struct SeparationAlong {
    std::int64_t separation_30;
    std::uint32_t corner_a, corner_b;
};

/// The two cores of a pair. Cheap to construct for boxes, and cheaper for hulls.
struct Cores {
    Core a, b;

    Cores(const Convex& first, const Convex& second) : a(first), b(second) {}
    /// Separation along a unit direction from A to B.
    SeparationAlong separation(const Long3& normal) {
        const SupportPoint p = a.support(normal), q = b.support(-normal);
        return {dot_unit(q.at_30 - p.at_30, normal), p.id, q.id};
    }
    std::int64_t separation_30(const Long3& normal) { return separation(normal).separation_30; }
    bool is_smooth() const { return a.is_smooth() || b.is_smooth(); }
};

/// A point of the difference A - B, in steps of 2^shift of 30 fraction bits, and the points of A and B that it
/// is the difference of.
struct Vertex {
    Long3 w;
    Long3 a_30, b_30;
};

/// The difference A - B, in steps such that no coordinate exceeds 2^29. Edges are then within 2^30, their cross
/// products within 2^61, and triple products fit 128 bits with room for one more factor.
class Difference : public Cores {
  public:
    explicit Difference(const Cores& cores);
    Difference(const Convex& first, const Convex& second) : Difference(Cores(first, second)) {}
    /// The point furthest along a direction with components of at most 2^31.
    Vertex support(const Long3& direction) {
        const Long3 p = a.support(direction).at_30, q = b.support(-direction).at_30;
        return {shifted(p - q, drop), p, q};
    }
    /// From B's middle to A's; 30 fraction bits.
    const Long3& between() const { return offset; }
    int shift() const { return drop; }

  private:
    Long3 offset;
    int drop;
};

/// A simplex of the difference whose point closest to the origin is in its interior; see gjk.cpp.
struct Simplex {
    Vertex v[4];
    int count = 0;
    Long3 direction{}; ///< from the origin to that point; the widest component has 30 bits
};

/// Runs GJK until it is known whether the difference contains the origin. True: the simplex (1 to 4 vertices)
/// contains it. False: the simplex is the closest one, or `beyond` is set and the distance is above the limit.
/// A negative `limit_30` means no limit. The search starts along the simplex's direction.
bool find_simplex(Difference& difference, std::int64_t limit_30, Simplex& simplex, bool& beyond);

/// As `closest_points_within`, but starts from a direction from B to A, and returns the final simplex. A
/// negative limit means no limit.
Gap find_gap(Difference& difference, std::int64_t limit_30, Long3 start, Simplex& simplex);

/// Computes the nearest points of the two cores from a simplex that does not contain the origin.
void set_points(const Simplex& simplex, Gap& gap);

/// The points where two overlapping cores touch once the least move has just separated them.
struct Touch {
    bool is_known = false;
    Long3 on_a_30{}, on_b_30{};
};
/// As `penetration`, starting from the simplex that `find_gap` returned.
Penetration find_move(Difference& difference, Simplex& simplex, Touch& touch);

} // namespace lockstone::collide
