#include "shapes/shown_area.h"

#include "lockstone/math/math.h"
#include "shapes/submerged.h"

namespace lockstone::shapes {
namespace {

/// The sine of the angle between a direction and the y axis.
Real across(UnitVec3 d) {
    return sqrt(SumOfProducts<Unit, Unit>{}.add(d.x, d.x).add(d.z, d.z).round<Real>());
}

/// Sums the projections of the triangles that face the direction.
struct Shadow {
    UnitVec3 d;
    Real twice_area{};
    Vec3 moment{}; ///< first moment of twice the area

    void add(Vec3 a, Vec3 b, Vec3 c) {
        const Vec3 ab = b - a, ac = c - a;
        const Real shown = dot<Real>(cross<Real>(ab, ac), d);
        if (shown <= Real{}) return;
        twice_area += shown;
        const Vec3 middle = (a + b + c) / Real(3);
        moment += middle * shown;
    }
    ShownArea result() const {
        if (twice_area == Real{}) return {};
        return {half(twice_area), moment / twice_area};
    }
};

ShownArea cone_area(const Geometry& g, UnitVec3 d) {
    const Real r = to<Real>(g.half_extent.x + g.radius), h = to<Real>(g.half_extent.y + g.radius);
    constexpr std::size_t sides = 16;
    constexpr Real out[5] = {1.0130015563_r, 0.9358914042_r, 0.7163002698_r, 0.3876589125_r, Real{}};
    std::array<Vec3, sides> base{};
    for (std::size_t k = 0; k < sides; ++k) {
        const Real far = out[k % 4] * r, near = out[4 - k % 4] * r;
        const Real x[4] = {far, -near, -far, near}, z[4] = {-near, -far, near, far};
        base[k] = {x[k / 4], -h, z[k / 4]};
    }
    Shadow shadow{d};
    for (std::size_t k = 0; k < sides; ++k) shadow.add(base[k], base[(k + 1) % sides], {Real{}, h, Real{}});
    for (std::size_t k = 1; k + 1 < sides; ++k) shadow.add(base[0], base[k + 1], base[k]);
    return shadow.result();
}

ShownArea hull_area(const Hull& hull, Real radius, UnitVec3 d) {
    Shadow shadow{d};
    for (const auto& t : hull.triangles)
        shadow.add(to<Real>(hull.vertices[t[0]]), to<Real>(hull.vertices[t[1]]),
                   to<Real>(hull.vertices[t[2]]));
    ShownArea shown = shadow.result();
    if (radius == Real{}) return shown;
    const Real reach = half(to<Real>(length(hull.extent.upper - hull.extent.lower)));
    const Real grown = Real(1) + radius / reach;
    shown.area = shown.area * grown * grown;
    return shown;
}

} // namespace

ShownArea shown_area(const Solid& convex, UnitVec3 d) {
    const Geometry& g = convex.geometry;
    if (convex.hull == nullptr && g.scale != scale_one) {
        const std::int32_t factor = factor_of(g);
        const ShownArea small = shown_area(at_scale_one(convex), d);
        return {small.area * (factor * factor), small.center * Real(factor)};
    }
    const Real r = to<Real>(g.radius);
    if (convex.hull != nullptr) return hull_area(*convex.hull, r, d);
    const Vec3 h = to<Real>(g.half_extent) + Vec3{r, r, r};
    switch (g.kind) {
    case ShapeKind::sphere:
        return {pi * r * r, Vec3{}};
    case ShapeKind::capsule:
        return {pi * r * r + mul<Real>(r * to<Real>(g.half_extent.y) * 4, across(d)), Vec3{}};
    case ShapeKind::cylinder:
        return {mul<Real>(pi * h.x * h.x, abs(d.y)) + h.x * h.y * 4 * across(d), Vec3{}};
    case ShapeKind::cone:
        return cone_area(g, d);
    default: // a box
        return {(mul<Real>(h.y * h.z, abs(d.x)) + mul<Real>(h.x * h.z, abs(d.y)) +
                 mul<Real>(h.x * h.y, abs(d.z))) *
                    4,
                Vec3{}};
    }
}

} // namespace lockstone::shapes
