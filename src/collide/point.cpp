// A point against a cylinder or cone, in closed form in the plane of the axis and the point.
//
// source: Ericson, Real-Time Collision Detection, 5.1 (closest points by regions).
#include "collide/point.h"

namespace lockstone::collide {
namespace {

constexpr std::int64_t one_30 = std::int64_t{1} << 30;

/// A place in the half plane through the axis: `rim` from the axis, `y` along it; 30 fraction bits.
struct Profile {
    std::int64_t rim, y;
};

/// What is nearest of a profile: the outward direction there, and how far out the point is along it.
struct Nearest {
    Profile normal; ///< unit
    std::int64_t distance;
};

Nearest off_corner(Profile from) {
    const Direction d = direction_of_30({from.rim, from.y, 0});
    return {{d.unit[0], d.unit[1]}, d.length};
}

Nearest nearest_of_cylinder(Profile p, std::int64_t radius, std::int64_t half) {
    const std::int64_t side = p.rim - radius, cap = absolute(p.y) - half,
                       up_or_down = p.y < 0 ? -one_30 : one_30;
    if (side > 0 && cap > 0) return off_corner({side, p.y < 0 ? -cap : cap});
    if (side > cap) return {{one_30, 0}, side};
    return {{0, up_or_down}, cap};
}

Nearest nearest_of_cone(Profile p, std::int64_t radius, std::int64_t half) {
    const Direction side = direction_of_30({2 * half, radius, 0}); // its outward normal
    const Profile n{side.unit[0], side.unit[1]};
    const auto along = [](Profile a, Profile b) {
        return narrow_rounded(Wide::product(a.rim, b.rim) + Wide::product(a.y, b.y), 30);
    };
    const std::int64_t off_side = along(n, {p.rim, p.y - half}), off_base = -half - p.y;
    if (off_side <= 0 && off_base <= 0)
        return off_side > off_base ? Nearest{n, off_side} : Nearest{{0, -one_30}, off_base};
    if (off_base > 0 && p.rim <= radius) return {{0, -one_30}, off_base};
    const Profile to_apex{-n.y, n.rim}; // from the rim of the base
    if (along(to_apex, {p.rim - radius, p.y + half}) <= 0) return off_corner({p.rim - radius, p.y + half});
    if (along(to_apex, {p.rim, p.y - half}) >= 0) return off_corner({p.rim, p.y - half});
    return {n, off_side};
}

} // namespace

bool has_point_form(const Convex& a, const Convex& b) {
    const auto is_round = [](const Convex& x) {
        return x.core == Convex::Core::cylinder || x.core == Convex::Core::cone;
    };
    return (is_round(a) && b.core == Convex::Core::point) || (a.core == Convex::Core::point && is_round(b));
}

PointForm point_form(const Convex& a, const Convex& b) {
    const bool swapped = a.core == Convex::Core::point;
    const Convex &round = swapped ? b : a, &point = swapped ? a : b;
    const Long3 at = up(point.center_24, 6), offset = at - up(round.center_24, 6);
    const auto local = [&](int i) { return narrow_rounded(wide_dot(round.axes_30[i], offset), 30); };
    const Direction flat = direction_of_30({local(0), 0, local(2)});
    const Long3 outward = flat.length == 0 ? Long3{one_30, 0, 0} : flat.unit; // on the axis: along local x
    const Profile p{flat.length, local(1)};
    const std::int64_t radius = up(round.half_24[0], 6), half = up(round.half_24[1], 6);
    const Nearest nearest = round.core == Convex::Core::cylinder ? nearest_of_cylinder(p, radius, half)
                                                                 : nearest_of_cone(p, radius, half);
    const Long3 n{shift_right_rounded(outward[0] * nearest.normal.rim, 30), nearest.normal.y,
                  shift_right_rounded(outward[2] * nearest.normal.rim, 30)};
    Long3 normal{};
    for (int i = 0; i < 3; ++i)
        normal[i] = shift_right_rounded(
            round.axes_30[0][i] * n[0] + round.axes_30[1][i] * n[1] + round.axes_30[2][i] * n[2], 30);
    Long3 on_round{};
    for (int i = 0; i < 3; ++i)
        on_round[i] = at[i] - narrow_rounded(Wide::product(normal[i], nearest.distance), 30);
    return {swapped ? -normal : normal, nearest.distance, swapped ? at : on_round, swapped ? on_round : at};
}

} // namespace lockstone::collide
