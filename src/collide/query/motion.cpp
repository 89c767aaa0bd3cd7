#include "collide/query/motion.h"

#include <algorithm>

namespace lockstone::collide {
namespace {

/// With half-angle a between the quaternions p and q, the rate of nlerp is at most 4 tan(a / 2), and
/// tan(a / 2) = |p - q| / |p + q|.
Spin spin_of(const Sweep& s) {
    const Quat p = s.from.rotation, q = s.to.rotation;
    if (p == q) return {Long3{}, 0};
    const Chords chords = chords_of(p, q);
    const std::int64_t chord = chords.apart_30 + 1;
    const Quat turn = q * conjugate(p);
    constexpr std::int64_t known = 1 << 12; // the axis of a smaller turn is mostly rounding error
    const Long3 axis = chord > known ? direction_of_30({turn.x.raw, turn.y.raw, turn.z.raw}).unit : Long3{};
    return {axis, divide_shifted(4 * chord, chords.together_30, 30) + 8};
}

std::int64_t length_of(Long3 v) {
    return static_cast<std::int64_t>(
               isqrt(Wide::product(v[0], v[0]) + Wide::product(v[1], v[1]) + Wide::product(v[2], v[2]))) +
           1;
}

/// A bound of the speed along a unit direction at which turning moves a point within `reach` of the axis.
std::int64_t turning_30(const Spin& spin, Long3 direction_30, std::int64_t reach_30) {
    if (spin.rate_30 == 0) return 0;
    std::int64_t across = one_30;
    if ((spin.axis_30[0] | spin.axis_30[1] | spin.axis_30[2]) != 0) {
        const Long3 n = direction_30, k = spin.axis_30;
        const Long3 cross{n[1] * k[2] - n[2] * k[1], n[2] * k[0] - n[0] * k[2], n[0] * k[1] - n[1] * k[0]};
        // The axis is accurate to 2^-30 / the sine of the half turn: 2^-18 at worst.
        across = smaller(one_30, length_of(shifted(cross, 30)) + (1 << 13));
    }
    return times_30(times_30(across, spin.rate_30), reach_30) + 2;
}

Long3 way_30(const Sweep& s) { return shifted(raw(s.to.position - s.from.position), 2); }

} // namespace

Chords chords_of(Quat p, Quat q) {
    const std::int64_t a[4] = {p.x.raw, p.y.raw, p.z.raw, p.w.raw},
                       b[4] = {q.x.raw, q.y.raw, q.z.raw, q.w.raw};
    std::uint64_t minus = 0, plus = 0;
    for (int i = 0; i < 4; ++i) {
        minus += static_cast<std::uint64_t>((a[i] - b[i]) * (a[i] - b[i]));
        plus += static_cast<std::uint64_t>((a[i] + b[i]) * (a[i] + b[i]));
    }
    return {isqrt(std::min(minus, plus)), isqrt(std::max(minus, plus))};
}

Transform Mover::pose(const Sweep& b, Unit fraction) const {
    const Transform body = body_pose_at(b, fraction);
    return {body.position + rotate(body.rotation, place.position) + shift,
            normalized(body.rotation * place.rotation)};
}

Convex Mover::shape(const Rotation& rotation) const {
    if (!is_ball) {
        Convex all = convex_of(*solid, rotation, CoordinateVec3{});
        all.radius = Coordinate::from_raw(all.radius.raw >> thin_bits);
        return all;
    }
    Convex ball{};
    ball.core = Convex::Core::point;
    ball.radius = radius;
    ball.center_24 = raw(to<Coordinate>(lockstone::mul<Real>(rotation, center)));
    return ball;
}

Transform place_in_body(const Sweep& b, const Transform* part) {
    return part == nullptr ? b.local
                           : Transform{b.local.position + rotate(b.local.rotation, part->position),
                                       normalized(b.local.rotation * part->rotation)};
}

Mover mover_of(const shapes::Solid& part, const Transform& place) {
    // Turning does not move the rounding of a shape, only the core's points. For kinds whose core's reach is
    // not computed here, the whole shape counts.
    const Geometry& g = part.geometry;
    std::int64_t core = up(reach_24(part), 6);
    if (g.kind == ShapeKind::sphere) core = 0;
    if (g.kind == ShapeKind::capsule) core = up(std::int64_t{g.half_extent.y.raw} * (g.scale.x.raw >> 24), 6);
    return {&part, place, false, Coordinate{}, Vec3{}, length_30(place.position) + core, Vec3{}};
}

Mover ball_of(const Mover& whole, Coordinate radius) {
    Mover ball = whole;
    ball.is_ball = true;
    ball.radius = radius;
    ball.center = shapes::core_center(*whole.solid);
    ball.reach_30 = length_30(whole.place.position + rotate(whole.place.rotation, ball.center));
    return ball;
}

Ways::Ways(const Sweep& sweep_a, const Sweep& sweep_b)
    : a(sweep_a), b(sweep_b), spin_a(spin_of(a)), spin_b(spin_of(b)), closing_30(way_30(a) - way_30(b)),
      speed_30(length_of(closing_30)), apart_30(length_30(b.from.position - a.from.position) + speed_30) {}

std::int64_t Ways::approach_30(const Mover& m, std::int64_t reach_a_30, Long3 direction_30) const {
    const std::int64_t sum =
        dot_dropped(closing_30, direction_30, 30) + turning_30(spin_b, direction_30, m.reach_30) + 4;
    if (spin_a.rate_30 == 0) return sum;
    const std::int64_t reach_b_30 = apart_30 + m.reach_30 + up(std::int64_t{m.radius.raw}, 6);
    return sum + smaller(turning_30(spin_a, direction_30, reach_a_30),
                         turning_30(spin_a, direction_30, reach_b_30) + times_30(spin_a.rate_30, speed_30));
}

std::int64_t Ways::approach_max_30(const Mover& m, std::int64_t reach_a_30) const {
    return speed_30 + times_30(spin_b.rate_30, m.reach_30) + 64 +
           smaller(times_30(spin_a.rate_30, reach_a_30),
                   times_30(spin_a.rate_30,
                            apart_30 + m.reach_30 + up(std::int64_t{m.radius.raw}, 6) + speed_30));
}

// In a frame that turns at the rate a with the angular acceleration a', a point at x that moves at v has the
// acceleration of its own motion, a^2 x, 2 a v and a' x. With nlerp, all accelerations of a rotation by up to 1 rad
// are together at most 1.4 times the distance times the rate squared; 3/2 is used.
std::int64_t Ways::curve_30(std::int64_t reach_30) const {
    const std::int64_t rate_a = spin_a.rate_30, rate_b = spin_b.rate_30;
    if (rate_a > one_30 || rate_b > one_30) return anything_30;
    const auto turning = [](std::int64_t rate, std::int64_t reach) {
        const std::int64_t all = times_30(times_30(rate, rate), reach);
        return all + all / 2 + 4;
    };
    const std::int64_t own = rate_b == 0 ? 0 : turning(rate_b, reach_30);
    if (rate_a == 0) return own;
    return own + turning(rate_a, apart_30 + reach_30) +
           2 * times_30(rate_a, speed_30 + times_30(rate_b, reach_30)) + 4;
}

std::int64_t Ways::reach_of(const Obstacle& o) const {
    if (spin_a.rate_30 == 0) return 0;
    switch (o.kind) {
    case Obstacle::Kind::plane:
        return anything_30;
    case Obstacle::Kind::convex:
        return mover_of(*o.solid, place_in_body(a, o.place)).reach_30;
    default:
        break;
    }
    std::int64_t most = 0;
    for (const CoordinateVec3& corner : o.triangle->corner) most = larger(most, length_30(to<Real>(corner)));
    return most + length_30(a.local.position);
}

Standing Ends::at(Unit fraction) const {
    const Transform pose_a = a_is_still ? first_a : pose_at(w->a, fraction), pose_b = m->pose(w->b, fraction);
    const RelativePose rel = plane ? plane_relative_pose(pose_a, pose_b) : relative_pose(pose_a, pose_b);
    return {to_rotation(pose_a.rotation), rel.rotation, raw(rel.position), m->shape(rel.rotation)};
}

Long3 in_world(const Standing& s, Long3 direction_30) {
    return raw(lockstone::mul<Unit>(s.axes, unit_of_30(direction_30)));
}

std::int64_t Ends::drop_30(const Standing& now, Long3 normal_30) const {
    const Standing& then = last();
    const Long3 lowest = support(now.shape, -normal_30).at_30, later = support(then.shape, -normal_30).at_30;
    return dot_dropped(up(now.place_24 - then.place_24, 6) + lowest - later, normal_30, 30);
}

Measured measure(const Standing& s, const Obstacle& o, std::int64_t limit_30) {
    const Between gap = between(o, s.shape, s.place_24, limit_30);
    return {gap, gap.overlap ? Long3{} : in_world(s, gap.normal_30)};
}

} // namespace lockstone::collide
