// Clips in normalized coordinates: u = (x - middle) / half extent is in [-1, 1], and ratios of volumes stay the
// same.
//
// The volume below the plane is the sum of the tetrahedra from a point o of the plane to the clipped triangles
// of the surface, each D / 6 with D = a . (b x c). The cut face is in the plane and adds nothing.
#include "shapes/submerged.h"

#include "lockstone/math/math.h"
#include "shapes/hull/hull.h"
#include "shapes/mass.h"

#include <algorithm>

namespace lockstone::shapes {
namespace {

constexpr int bits = 27; ///< fraction bits of u and of heights
constexpr std::int64_t one = std::int64_t{1} << bits;

/// A corner relative to o: at most 2.8 on each axis, because |u| <= 1.04 and |o| <= sqrt 3.
struct Corner {
    std::int64_t x[3]; ///< relative to o
    std::int64_t height;
};

struct Sums {
    std::int64_t volume = 0;     ///< sum of D, 27 fraction bits
    std::int64_t moment[3] = {}; ///< sum of D (a + b + c), 24 fraction bits

    /// |D| <= 3 * 2.8 * 16 < 2^7, so it is below 2^61 before rounding. A moment's term is below 2^34 * 2^28 before
    /// rounding. A thousand terms fit.
    void add(const Corner& a, const Corner& b, const Corner& c) {
        const auto cross = [&](int i, int j) {
            return shift_right_rounded(b.x[i] * c.x[j] - b.x[j] * c.x[i], bits);
        };
        const std::int64_t d =
            shift_right_rounded(a.x[0] * cross(1, 2) + a.x[1] * cross(2, 0) + a.x[2] * cross(0, 1), bits);
        volume += d;
        for (int i = 0; i < 3; ++i)
            moment[i] += shift_right_rounded(d * ((a.x[i] + b.x[i] + c.x[i]) >> 3), bits);
    }
};

/// The point where the plane cuts the edge between two corners on different sides.
Corner cut(const Corner& a, const Corner& b) {
    const std::int64_t t = (a.height << 30) / (a.height - b.height); // heights below 2^30
    Corner out{};
    for (int i = 0; i < 3; ++i) out.x[i] = a.x[i] + shift_right_rounded((b.x[i] - a.x[i]) * t, 30);
    return out;
}

void add_below(Sums& below, Corner a, Corner b, Corner c) {
    const int under = (a.height < 0) + (b.height < 0) + (c.height < 0);
    if (under == 0) return;
    if (under == 3) return below.add(a, b, c);
    // Rotates the corners until a is the only one on its side.
    while ((a.height < 0) != (under == 1) || (b.height < 0) == (under == 1) ||
           (c.height < 0) == (under == 1)) {
        const Corner first = a;
        a = b, b = c, c = first;
    }
    const Corner ab = cut(a, b), ac = cut(a, c);
    if (under == 1) return below.add(a, ab, ac);
    below.add(ab, b, c);
    below.add(ab, c, ac);
}

// ---- surfaces ------------------------------------------------------------------------------------------------------

using Point = std::array<std::int32_t, 3>;       ///< u
using FaceCorners = std::array<std::uint8_t, 3>; ///< counter-clockwise from outside

constexpr std::int32_t fixed(const char* text) {
    return static_cast<std::int32_t>(parse_decimal<I4F28>(text).value.raw >> (28 - bits));
}

/// A regular polygon with the area of the unit circle, in the x-z plane, from +x towards -z: counter-clockwise
/// from above.
template <std::size_t N> constexpr std::array<std::array<std::int32_t, 2>, N> ring() {
    constexpr std::array<std::int32_t, 5> quarter16{fixed("1.0130015562559769"), fixed("0.9358914042269778"),
                                                    fixed("0.7163002697811272"), fixed("0.3876589125392148"),
                                                    0};
    constexpr std::array<std::int32_t, 4> quarter12{fixed("1.0233267079464885"), fixed("0.8862269254527580"),
                                                    fixed("0.5116633539732443"), 0};
    constexpr std::size_t quarter = N / 4;
    std::array<std::array<std::int32_t, 2>, N> out{};
    for (std::size_t k = 0; k < N; ++k) {
        const std::size_t in = k % quarter;
        const std::int32_t far = N == 16 ? quarter16[in] : quarter12[in];
        const std::int32_t near = N == 16 ? quarter16[quarter - in] : quarter12[quarter - in];
        const std::int32_t x[4] = {far, -near, -far, near}, z[4] = {-near, -far, near, far};
        out[k] = {x[k / quarter], z[k / quarter]};
    }
    return out;
}

constexpr auto ring16 = ring<16>();
constexpr auto ring12 = ring<12>();

/// Rings of N corners in layers, closed at the bottom and the top by fans of triangles.
template <std::size_t N, std::size_t Rings> constexpr auto stacked() {
    std::array<FaceCorners, 2 * N*(Rings - 1) + 2 * (N - 2)> faces{};
    std::size_t count = 0;
    const auto at = [](std::size_t r, std::size_t k) { return static_cast<std::uint8_t>(r * N + k % N); };
    for (std::size_t r = 0; r + 1 < Rings; ++r)
        for (std::size_t k = 0; k < N; ++k) {
            faces[count++] = {at(r, k), at(r, k + 1), at(r + 1, k + 1)};
            faces[count++] = {at(r, k), at(r + 1, k + 1), at(r + 1, k)};
        }
    for (std::size_t k = 1; k + 1 < N; ++k) {
        faces[count++] = {at(0, 0), at(0, k + 1), at(0, k)};
        faces[count++] = {at(Rings - 1, 0), at(Rings - 1, k), at(Rings - 1, k + 1)};
    }
    return faces;
}

constexpr std::array<Point, 8> cube_points{{{-one, -one, -one},
                                            {one, -one, -one},
                                            {-one, one, -one},
                                            {one, one, -one},
                                            {-one, -one, one},
                                            {one, -one, one},
                                            {-one, one, one},
                                            {one, one, one}}};
constexpr std::array<FaceCorners, 12> cube_faces{{{0, 4, 6},
                                                  {0, 6, 2},
                                                  {1, 3, 7},
                                                  {1, 7, 5},
                                                  {0, 1, 5},
                                                  {0, 5, 4},
                                                  {2, 6, 7},
                                                  {2, 7, 3},
                                                  {0, 2, 3},
                                                  {0, 3, 1},
                                                  {4, 5, 7},
                                                  {4, 7, 6}}};

constexpr std::array<Point, 32> cylinder_points = [] {
    std::array<Point, 32> out{};
    for (std::size_t k = 0; k < 16; ++k) {
        const auto p = ring16[k];
        out[k] = {p[0], -static_cast<std::int32_t>(one), p[1]};
        out[k + 16] = {p[0], static_cast<std::int32_t>(one), p[1]};
    }
    return out;
}();
constexpr auto cylinder_faces = stacked<16, 2>();

constexpr std::array<Point, 17> cone_points = [] {
    std::array<Point, 17> out{};
    for (std::size_t k = 0; k < 16; ++k) out[k] = cylinder_points[k];
    out[16] = {0, static_cast<std::int32_t>(one), 0};
    return out;
}();
constexpr std::array<FaceCorners, 30> cone_faces = [] {
    std::array<FaceCorners, 30> out{};
    std::size_t count = 0;
    for (std::uint8_t k = 0; k < 16; ++k) out[count++] = {k, static_cast<std::uint8_t>((k + 1) % 16), 16};
    for (std::uint8_t k = 1; k < 15; ++k) out[count++] = {0, static_cast<std::uint8_t>(k + 1), k};
    return out;
}();

/// Rings of a half ball at 0, 30 and 60 degrees and almost at its pole, at 1.03 of the radius for the correct
/// volume.
struct Latitude {
    Real out, up; ///< in units of the radius
};
constexpr std::array<Latitude, 4> latitudes{{{Real(1), Real{}},
                                             {0.8932138548_r, 0.5156972595_r},
                                             {0.5156972595_r, 0.8932138548_r},
                                             {Real{}, 1.0313945190_r}}};
constexpr auto capsule_faces = stacked<12, 8>();
using CapsulePoints = std::array<Point, 96>;

CapsulePoints capsule_points(const Geometry& g) {
    CapsulePoints out{};
    const Real reach = to<Real>(g.half_extent.y + g.radius);
    for (std::size_t r = 0; r < 8; ++r) {
        const Latitude& at = latitudes[r < 4 ? 3 - r : r - 4];
        const Real up = (to<Real>(g.half_extent.y) + to<Real>(g.radius) * at.up) / reach;
        const std::int64_t y = shift_right_rounded(up.raw, Real::fraction_bits - bits);
        for (std::size_t k = 0; k < 12; ++k) {
            const auto p = ring12[k];
            out[r * 12 + k] = {static_cast<std::int32_t>(shift_right_rounded(p[0] * (at.out.raw >> 2), 30)),
                               static_cast<std::int32_t>(r < 4 ? -y : y),
                               static_cast<std::int32_t>(shift_right_rounded(p[1] * (at.out.raw >> 2), 30))};
        }
    }
    return out;
}

// ---- the part below ------------------------------------------------------------------------------------------------

/// The surface of a solid's core in normalized coordinates.
struct Surface {
    std::span<const Point> points;
    std::span<const FaceCorners> faces;
    Vec3 middle, half; ///< x = middle + half u
    Real rounding;     ///< [m]
};

/// Buffers for clipping, on the stack of each call; the largest hull has 255 corners.
struct Work {
    std::array<Point, 256> points;
    std::array<Corner, 256> corners;
};

Surface surface_of(const Solid& solid, Work& work, CapsulePoints& capsule) {
    const Geometry& g = solid.geometry;
    const Vec3 half = to<Real>(g.half_extent);
    const Real radius = to<Real>(g.radius);
    if (solid.hull != nullptr) {
        const Hull& hull = *solid.hull;
        const CoordinateVec3 sum = hull.extent.lower + hull.extent.upper,
                             size = hull.extent.upper - hull.extent.lower;
        const std::size_t count = std::min(hull.vertices.size(), work.points.size());
        Vec3 middle{}, reach{};
        for (int i = 0; i < 3; ++i) {
            middle[i] = lockstone::half(to<Real>(sum[i])), reach[i] = lockstone::half(to<Real>(size[i]));
            // (2 x - sum) / size: at most 2^56 plus rounding, because |2 x - sum| <= size, and size is not 0.
            const std::int64_t inverse = (std::int64_t{1} << 56) / std::max<std::int64_t>(size[i].raw, 1);
            for (std::size_t k = 0; k < count; ++k)
                work.points[k][static_cast<std::size_t>(i)] = static_cast<std::int32_t>(shift_right_rounded(
                    (2 * std::int64_t{hull.vertices[k][i].raw} - sum[i].raw) * inverse, 56 - bits));
        }
        return {std::span(work.points).first(count), hull.triangles, middle, reach, radius};
    }
    switch (g.kind) {
    case ShapeKind::capsule:
        capsule = capsule_points(g);
        return {capsule, capsule_faces, Vec3{}, {radius, half.y + radius, radius}, Real{}};
    case ShapeKind::cylinder:
        return {cylinder_points, cylinder_faces, Vec3{}, half, radius};
    case ShapeKind::cone:
        return {cone_points, cone_faces, Vec3{}, half, radius};
    default:
        return {cube_points, cube_faces, Vec3{}, half, radius};
    }
}

/// Volume and centre of a ball's cap of height s r, for radius r.
Submerged submerged_ball(Real radius, UnitVec3 n, Real offset) {
    const Real s = offset / radius + Real(1); // saturates for large offsets
    if (s <= Real{}) return {Unit{}, Vec3{}};
    if (s >= Real(2)) return {unit_one, Vec3{}};
    const Real fraction = shift_right(s * s * (Real(3) - s), 2);
    const Real down = radius * (Real(2) - s) * (Real(2) - s) * 3 / (shift_right((Real(3) - s) * 16, 2));
    return {min(to<Unit>(fraction), unit_one), -lockstone::scale<Real>(n, down)};
}

/// The plane in normalized coordinates: a . u = b, with |a.x| + |a.y| + |a.z| = 1; 27 fraction bits.
struct Plane {
    std::int64_t a[3], b, low, high; ///< low, high: the least and greatest a . u of the surface
    std::int64_t side(const Point& p) const {
        return shift_right_rounded(a[0] * p[0] + a[1] * p[1] + a[2] * p[2], bits);
    }
};

Plane plane_of(const Surface& s, UnitVec3 n, Real offset, Real& size) {
    Vec3 along{};
    for (int i = 0; i < 3; ++i) along[i] = mul<Real>(s.half[i], n[i]);
    size = abs(along.x) + abs(along.y) + abs(along.z);
    Plane p{};
    for (int i = 0; i < 3; ++i) p.a[i] = divide_shifted(along[i].raw, size.raw, bits);
    const Real beta = clamp((offset - dot<Real>(s.middle, n)) / size, Real(-4), Real(4));
    p.b = shift_right_rounded(beta.raw, Real::fraction_bits - bits);
    p.low = 2 * one, p.high = -2 * one;
    for (const Point& u : s.points) {
        const std::int64_t h = p.side(u);
        p.low = std::min(p.low, h), p.high = std::max(p.high, h);
    }
    return p;
}

} // namespace

Vec3 volume_center(const Solid& convex) {
    if (convex.hull != nullptr) return convex.hull->properties.center;
    if (convex.geometry.kind != ShapeKind::cone) return Vec3{};
    return {Real{}, -half(to<Real>(convex.geometry.half_extent.y)) * factor_of(convex.geometry), Real{}};
}

Scaled volume_of(const Solid& convex) {
    if (convex.hull != nullptr)
        return convex.geometry.radius <= Length{}
                   ? convex.hull->volume
                   : rounded_volume(*convex.hull, scaled(convex.geometry.radius));
    Geometry at_one = convex.geometry;
    at_one.scale = scale_one;
    const std::int32_t factor = factor_of(convex.geometry);
    // A large density keeps the bits of small volumes. With 1 kg/m^3 the masses of 8e6 m^3 fit, with this
    // density those of up to 21,474 m^3.
    constexpr Real dense = Real(100000);
    const Real heavy = mass_of_primitive(at_one, dense).mass;
    const Scaled volume =
        heavy < Real::max() ? scaled(heavy) / scaled(dense) : scaled(mass_of_primitive(at_one, Real(1)).mass);
    return factor * factor * factor * volume;
}

Submerged submerged(const Solid& convex, UnitVec3 n, Real offset) {
    if (convex.hull == nullptr && convex.geometry.scale != scale_one) {
        const Real factor = Real(factor_of(convex.geometry));
        const Submerged small = submerged(at_scale_one(convex), n, offset / factor);
        return {small.fraction, small.center * factor};
    }
    if (convex.geometry.kind == ShapeKind::sphere)
        return submerged_ball(to<Real>(convex.geometry.radius), n, offset);
    Work work;
    CapsulePoints capsule;
    const Surface s = surface_of(convex, work, capsule);
    Real size{};
    Plane p = plane_of(s, n, offset, size);
    // In units of `size`: half the core's width along n, its middle, and the rounding on each side.
    const std::int64_t width = std::max<std::int64_t>((p.high - p.low) / 2, 1), middle = (p.high + p.low) / 2;
    const std::int64_t rounding =
        std::min(divide_shifted(s.rounding.raw, size.raw, bits), std::int64_t{1} << 34);
    p.b = middle + (p.b - middle) * width / (width + rounding); // 2^30 * 2^28
    if (p.b <= p.low) return {Unit{}, volume_center(convex)};
    if (p.b >= p.high) return {unit_one, volume_center(convex)};
    // The point of the plane nearest to the origin: a b / a^2, |a|^2 >= 1/3.
    const std::int64_t square =
        shift_right_rounded(p.a[0] * p.a[0] + p.a[1] * p.a[1] + p.a[2] * p.a[2], bits);
    const std::int64_t factor = divide_shifted(p.b, square, bits);
    std::int64_t foot[3];
    for (int i = 0; i < 3; ++i) foot[i] = shift_right_rounded(p.a[i] * factor, bits);
    for (std::size_t k = 0; k < s.points.size(); ++k) {
        Corner& c = work.corners[k];
        for (std::size_t i = 0; i < 3; ++i) c.x[i] = s.points[k][i] - foot[i];
        c.height = p.side(s.points[k]) - p.b;
    }
    Sums whole, below;
    for (const FaceCorners& f : s.faces) {
        whole.add(work.corners[f[0]], work.corners[f[1]], work.corners[f[2]]);
        add_below(below, work.corners[f[0]], work.corners[f[1]], work.corners[f[2]]);
    }
    if (below.volume <= 0 || whole.volume <= 0) return {Unit{}, volume_center(convex)};
    Submerged out{min(to<Unit>(Real::from_raw(divide_shifted(below.volume, whole.volume, 32))), unit_one),
                  {}};
    for (int i = 0; i < 3; ++i) {
        const std::int64_t from_foot = divide_shifted(below.moment[i], below.volume * 4, 30);
        const Real u = Real::from_raw((foot[i] + std::clamp(from_foot, -4 * one, 4 * one)) *
                                      (std::int64_t{1} << (32 - bits)));
        out.center[i] = s.middle[i] + s.half[i] * u;
    }
    if (rounding > 0) {
        const Real off = dot<Real>(out.center - s.middle, n) - Real::from_raw(middle * 32) * size;
        out.center += lockstone::scale<Real>(n, off * Real::from_raw(divide_shifted(rounding, width, 32)));
    }
    return out;
}

} // namespace lockstone::shapes
