// Times of impact of turning shapes, by conservative advancement. Each step measures the gap along the normal
// of the closest points. The gap closes no faster than the approach of the bodies along that normal plus the
// speed that turning adds.
//
// source: Mirtich, Impulse-based Dynamic Simulation, 1996; Zhang, Redon, Lee, Kim, Continuous Collision Detection for
// Articulated Models using Taylor Models and Temporal Culling, 2007 (motion bound of a turning body along a direction)
#include "collide/query/cast_pieces.h"
#include "collide/swept_box.h"

#include <algorithm>

namespace lockstone::collide {
namespace {

constexpr std::int64_t anything_30 = std::int64_t{1} << 60;
constexpr int advances_max = 256;
constexpr std::int64_t stop_gap_30 = std::int64_t{stop_gap.raw} << 6;
/// A gap below this counts as touching at the start. It is larger than the gap at which a sweep stops, so that
/// a stopped shape counts as touching in the next tick.
constexpr std::int64_t touching_gap_30 = stop_gap_30 + stop_gap_30 / 4;
/// A bound of the rounding errors of gaps and approaches, for tests by a plane or an extent that replace
/// closest points.
constexpr std::int64_t roundings = 1024;

/// Rotation of a body during its motion: about one axis, at most at `rate`.
struct Spin {
    Long3 axis_30;        ///< zero: not known accurately
    std::int64_t rate_30; ///< [rad per motion]
};

/// With half-angle a between the quaternions p and q, the rate of nlerp is at most 4 tan(a / 2), and
/// tan(a / 2) = |p - q| / |p + q|.
Spin spin_of(const Sweep& s) {
    if (s.from.rotation == s.to.rotation) return {Long3{}, 0};
    const Quat p = s.from.rotation, q = s.to.rotation;
    const std::int64_t a[4] = {p.x.raw, p.y.raw, p.z.raw, p.w.raw},
                       b[4] = {q.x.raw, q.y.raw, q.z.raw, q.w.raw};
    std::uint64_t apart = 0, together = 0;
    for (int i = 0; i < 4; ++i) {
        apart += static_cast<std::uint64_t>((a[i] - b[i]) * (a[i] - b[i]));
        together += static_cast<std::uint64_t>((a[i] + b[i]) * (a[i] + b[i]));
    }
    const std::int64_t chord = isqrt(std::min(apart, together)) + 1, sum = isqrt(std::max(apart, together));
    const Quat turn = q * conjugate(p);
    constexpr std::int64_t known = 1 << 12; // the axis of a smaller turn is mostly rounding error
    const Long3 axis = chord > known ? direction_of_30({turn.x.raw, turn.y.raw, turn.z.raw}).unit : Long3{};
    return {axis, divide_shifted(4 * chord, sum, 30) + 8};
}

std::int64_t length_of(Long3 v) {
    return static_cast<std::int64_t>(
               isqrt(Wide::product(v[0], v[0]) + Wide::product(v[1], v[1]) + Wide::product(v[2], v[2]))) +
           1;
}
std::int64_t times_30(std::int64_t a, std::int64_t b) { return narrow_rounded(Wide::product(a, b), 30); }

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

/// A convex part of B, or the ball or the point in its core.
struct Mover {
    const shapes::Solid* solid;
    Transform place; ///< pose of the part in the frame of B's centre of mass
    bool is_ball;
    Coordinate radius;     ///< of the ball
    Vec3 center;           ///< of the ball, in the part's frame
    std::int64_t reach_30; ///< distance of the core's points from B's centre of mass, at most
    Vec3 shift;            ///< world: displacement of the mover for the test
    int thin_bits = 0;     ///< the test uses the radius of the rounding divided by 2^thin_bits

    Transform pose(const Sweep& b, Unit fraction) const {
        const Transform body = body_pose_at(b, fraction);
        return {body.position + rotate(body.rotation, place.position) + shift,
                normalized(body.rotation * place.rotation)};
    }
    Convex shape(const Rotation& rotation) const {
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
};

Transform place_in_body(const Sweep& b, const Transform* part) {
    return part == nullptr ? b.local
                           : Transform{b.local.position + rotate(b.local.rotation, part->position),
                                       normalized(b.local.rotation * part->rotation)};
}

std::int64_t length_30(Vec3 v) { return shift_right_rounded(length(v).raw, 2) + 1; }

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

/// The motions of both bodies, and bounds of their approach.
struct Ways {
    const Sweep &a, &b;
    Spin spin_a, spin_b;
    Long3 closing_30;      ///< displacement of A minus displacement of B
    std::int64_t speed_30; ///< its length
    std::int64_t apart_30; ///< a bound of the distance of the centres of mass during the motion

    Ways(const Sweep& sweep_a, const Sweep& sweep_b)
        : a(sweep_a), b(sweep_b), spin_a(spin_of(a)), spin_b(spin_of(b)), closing_30(way_30(a) - way_30(b)),
          speed_30(length_of(closing_30)), apart_30(length_30(b.from.position - a.from.position) + speed_30) {
    }

    /// A bound of the speed at which a gap along a direction from A to B (world) closes [m per motion]. A's
    /// turning can be seen as motion of A's points, or in A's frame as motion of B's points and of the
    /// direction; the smaller of both bounds holds.
    std::int64_t approach_30(const Mover& m, std::int64_t reach_a_30, Long3 direction_30) const {
        const std::int64_t sum =
            dot_dropped(closing_30, direction_30, 30) + turning_30(spin_b, direction_30, m.reach_30) + 4;
        if (spin_a.rate_30 == 0) return sum;
        const std::int64_t reach_b_30 = apart_30 + m.reach_30 + up(std::int64_t{m.radius.raw}, 6);
        return sum +
               smaller(turning_30(spin_a, direction_30, reach_a_30),
                       turning_30(spin_a, direction_30, reach_b_30) + times_30(spin_a.rate_30, speed_30));
    }
    /// As above, for any direction.
    std::int64_t approach_max_30(const Mover& m, std::int64_t reach_a_30) const {
        return speed_30 + times_30(spin_b.rate_30, m.reach_30) + 64 +
               smaller(times_30(spin_a.rate_30, reach_a_30),
                       times_30(spin_a.rate_30,
                                apart_30 + m.reach_30 + up(std::int64_t{m.radius.raw}, 6) + speed_30));
    }
    /// Distance of an obstacle's points from A's centre of mass, at most; 0 when A does not turn.
    std::int64_t reach_of(const Obstacle& o) const {
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
        for (const CoordinateVec3& corner : o.triangle->corner)
            most = larger(most, length_30(to<Real>(corner)));
        return most + length_30(a.local.position);
    }
};

struct Measured {
    Between gap;
    Long3 direction_30; ///< world, from A to B
};

/// Pose and shape of a mover at one time, for all pieces of A.
struct Standing {
    Rotation axes;     ///< orientation of A
    Rotation rotation; ///< orientation of the mover in A's frame
    Long3 place_24;
    Convex shape;

    static Standing at(const Ways& w, const Mover& m, Unit fraction, bool on_plane) {
        const Transform pose_a = pose_at(w.a, fraction), pose_b = m.pose(w.b, fraction);
        const RelativePose rel =
            on_plane ? plane_relative_pose(pose_a, pose_b) : relative_pose(pose_a, pose_b);
        return {to_rotation(pose_a.rotation), rel.rotation, raw(rel.position), m.shape(rel.rotation)};
    }
    /// As above, for a ball or point inside the mover.
    Standing of(const Mover& inside) const { return {axes, rotation, place_24, inside.shape(rotation)}; }
};

Long3 in_world(const Standing& s, Long3 direction_30) {
    return raw(lockstone::mul<Unit>(s.axes, unit_of_30(direction_30)));
}

Measured measure(const Standing& s, const Obstacle& o, std::int64_t limit_30) {
    const Between gap = between(o, s.shape, s.place_24, limit_30);
    return {gap, gap.overlap ? Long3{} : in_world(s, gap.normal_30)};
}
Measured measure(const Ways& w, const Obstacle& o, const Mover& m, Unit fraction, std::int64_t limit_30) {
    return measure(Standing::at(w, m, fraction, o.kind == Obstacle::Kind::plane), o, limit_30);
}

/// The first fraction before `until` at which the gap is `target`; 1 when there is none. `start`: the gap at
/// fraction 0 if it is known, measured with a limit at least as large as the one here.
Unit advance(const Ways& w, const Obstacle& o, const Mover& m, std::int64_t target_30, Unit until,
             const Measured* start = nullptr) {
    const std::int64_t close = target_30 + larger(target_30 / 8, 2048);
    const std::int64_t reach_a = w.reach_of(o), approach_max = w.approach_max_30(m, reach_a);
    std::int64_t t = 0;
    for (int i = 0; i < advances_max; ++i) {
        const Unit fraction = Unit::from_raw(static_cast<std::int32_t>(t));
        const std::int64_t reachable = times_30(approach_max, until.raw - t) + close;
        const Measured at = i == 0 && start != nullptr ? *start : measure(w, o, m, fraction, reachable);
        const std::int64_t distance = at.gap.distance_30;
        if (at.gap.overlap || distance <= (i == 0 ? target_30 : close)) return fraction;
        const std::int64_t approach = distance > reachable ? 0 : w.approach_30(m, reach_a, at.direction_30);
        // The quotient is below 2, so it fits.
        if (approach <= (distance - target_30) / 2) return unit_one;
        t += larger(1, divide_shifted(distance - target_30, approach, 30) - 1);
        if (t >= until.raw) return unit_one;
    }
    return Unit::from_raw(static_cast<std::int32_t>(t));
}

Bounds bounds_of(const shapes::Extent& e) {
    constexpr int drop = Coordinate::fraction_bits - Bound::fraction_bits;
    const auto low = [](Coordinate x) { return Bound::from_raw(saturate_to_int32(x.raw >> drop)); };
    const auto high = [](Coordinate x) { return Bound::from_raw(saturate_to_int32((x.raw >> drop) + 1)); };
    return {{low(e.lower.x), low(e.lower.y), low(e.lower.z)},
            {high(e.upper.x), high(e.upper.y), high(e.upper.z)}};
}

/// The points from `lower` to `upper` [m], in the frame of A's shape.
struct Box {
    Long3 lower_30, upper_30;
};

/// The bounds of a mover, including its rounding.
Box box_of(const Standing& s) {
    Box box{};
    const std::int64_t radius = up(std::int64_t{s.shape.radius.raw}, 6);
    for (int i = 0; i < 3; ++i) {
        Long3 along{};
        along[i] = one_30;
        const std::int64_t at = up(s.place_24[i], 6);
        box.lower_30[i] = at + support(s.shape, -along).at_30[i] - radius;
        box.upper_30[i] = at + support(s.shape, along).at_30[i] + radius;
    }
    return box;
}

/// State of a mover at the start, computed once for all pieces of A.
struct Start {
    Standing standing;
    CoordinateVec3 core; ///< centre of its core
    Box box;

    /// Only triangles and compounds read `core` and `box`.
    Start(const Ways& w, const Mover& m, const shapes::Solid& a)
        : standing(Standing::at(w, m, Unit{}, a.geometry.kind == ShapeKind::plane)), core{}, box{} {
        if (!has_triangles(a) && a.geometry.kind != ShapeKind::compound) return;
        box = box_of(standing);
        if (!has_triangles(a)) return;
        const Transform b = m.pose(w.b, Unit{});
        core = relative_pose(pose_at(w.a, Unit{}),
                             {b.position + rotate(b.rotation, shapes::core_center(*m.solid)), b.rotation})
                   .position;
    }
    /// True if the core's centre is behind a one-sided triangle.
    bool is_behind(const Obstacle& o) const {
        return o.kind == Obstacle::Kind::triangle && o.one_sided &&
               dot_dropped(raw(core - o.triangle->corner[0]), raw(o.triangle->normal), 30) < 0;
    }
};

/// The space that a part of B can reach during its motion, in the frame of A's shape.
struct Corridor {
    shapes::Extent extent;
    SweptBox box;

    Corridor(Long3 from_24, Long3 to_24, std::int64_t around_24)
        : extent(swept_extent(from_24, to_24, around_24)),
          box(bounds_of(swept_extent(from_24, from_24, around_24)),
              bounds_of(swept_extent(to_24, to_24, around_24))) {}
    /// From one box to another, each grown by `around_24` on all sides.
    Corridor(const Box& from, const Box& to, std::int64_t around_24) : Corridor(Long3{}, Long3{}, 0) {
        const auto extent_of = [&](const Box& b) {
            return swept_extent(shifted(b.lower_30, 6), shifted(b.upper_30, 6), around_24);
        };
        const shapes::Extent first = extent_of(from), last = extent_of(to);
        extent = {min(first.lower, last.lower), max(first.upper, last.upper)};
        box = SweptBox(bounds_of(first), bounds_of(last));
    }

    /// False for triangles beside the path: the extent of a long path through a mesh meets many.
    bool may_meet(const Obstacle& o) const {
        if (o.kind != Obstacle::Kind::triangle) return true;
        const CoordinateVec3(&c)[3] = o.triangle->corner;
        return box.may_meet(bounds_of({min(c[0], min(c[1], c[2])), max(c[0], max(c[1], c[2]))}));
    }
};

/// A bound of how far a point that turns with B departs from the straight segment between its start and its end
/// [m]. A path whose second derivative is at most f departs from the segment by at most f / 8. For a point at
/// distance r from the axis and a turn of up to 1 rad, the derivative is at most 1.4 r rate^2, including the
/// uneven speed of nlerp. For larger turns the bound is the whole arc.
std::int64_t bend_30(const Ways& w, const Mover& m) {
    const std::int64_t rate = w.spin_b.rate_30;
    return times_30(m.reach_30, rate <= one_30 ? times_30(rate, rate) / 4 + 1 : rate) + 2;
}

/// Empty for an A of one piece: a part that meets the bounds of A meets the piece. When A does not turn, the
/// boxes of the part at both ends bound its motion. When A turns, the bound is a ball around B's centre of mass
/// that contains the part. It is not used in both cases because it would meet most triangles of a mesh below a
/// large compound.
Corridor corridor_of(const Ways& w, const Mover& m, const shapes::Solid& a, const Start& start,
                     Length margin) {
    if (!has_triangles(a) && a.geometry.kind != ShapeKind::compound) return {Long3{}, Long3{}, 0};
    if (w.spin_a.rate_30 == 0) {
        const std::int64_t around = ((bend_30(w, m) + roundings) >> 6) + margin.raw + 64;
        return {start.box, box_of(Standing::at(w, m, unit_one, false)), around};
    }
    const Long3 from = raw(relative_pose(pose_at(w.a, Unit{}), w.b.from).position);
    const Long3 to = raw(relative_pose(pose_at(w.a, unit_one), w.b.to).position);
    const std::int64_t turned = times_30(w.spin_a.rate_30, w.apart_30) >> 6;
    const std::int64_t around = (length_30(m.place.position) >> 6) + reach_24(*m.solid) + margin.raw;
    return {from, to, around + turned + 64};
}

/// A plane with the obstacle on its back side, in the frame of the obstacle's solid.
struct Side {
    Long3 normal_30;
    std::int64_t above_30; ///< height of the given point above it [m]
};
/// The plane of the triangle, turned so that the point is above it.
Side side_of_triangle(const shapes::Face& t, Long3 point_24) {
    const Long3 plane = raw(t.normal);
    const std::int64_t above = dot_dropped(up(point_24 - raw(t.corner[0]), 6), plane, 30);
    return {above < 0 ? -plane : plane, absolute(above)};
}
/// The face of the box above which the point is highest.
Side side_of_box(const Geometry& box, Long3 point_24) {
    const std::int64_t scale = box.scale.x.raw >> Length::fraction_bits;
    Side side{Long3{}, -anything_30};
    for (int i = 0; i < 3; ++i) {
        const std::int64_t half = (box.half_extent[i].raw + box.radius.raw) * scale;
        const std::int64_t above = up(absolute(point_24[i]) - half, 6);
        if (above <= side.above_30) continue;
        side = {Long3{}, above};
        side.normal_30[i] = point_24[i] < 0 ? -one_30 : one_30;
    }
    return side;
}

/// The height of a mover above a side of an obstacle at the start. A mover that stays above it during its
/// motion needs no closest points.
class Above {
  public:
    Above(const Ways& ways, const Standing& standing, const Obstacle& obstacle, const Mover& mover)
        : w(ways), s(standing), o(obstacle), m(mover) {
        const bool is_box = o.kind == Obstacle::Kind::convex && o.place == nullptr &&
                            o.solid->geometry.kind == ShapeKind::box;
        if (!is_box && o.kind != Obstacle::Kind::triangle) return;
        const Side side =
            is_box ? side_of_box(o.solid->geometry, s.place_24) : side_of_triangle(*o.triangle, s.place_24);
        normal_30 = side.normal_30;
        core_30 = side.above_30 + dot_dropped(support(s.shape, -normal_30).at_30, normal_30, 30);
    }
    /// True if the core with this radius of rounding starts apart from the obstacle.
    bool is_apart(std::int64_t radius_24) const { return room_30(radius_24) > 0; }
    /// True if it stays apart during the motion.
    bool keeps(std::int64_t radius_24) {
        if (!is_apart(radius_24)) return false;
        if (!is_known) approach_30 = w.approach_30(m, w.reach_of(o), in_world(s, normal_30));
        is_known = true;
        return room_30(radius_24) > approach_30;
    }

  private:
    std::int64_t room_30(std::int64_t radius_24) const {
        return core_30 - up(radius_24, 6) - touching_gap_30 - roundings;
    }
    const Ways& w;
    const Standing& s;
    const Obstacle& o;
    const Mover& m;
    Long3 normal_30{};
    /// The core's gap to the side; very negative when there is no such side.
    std::int64_t core_30 = -anything_30;
    bool is_known = false;
    std::int64_t approach_30 = 0; ///< a bound of the decrease of the gap during the motion
};

/// True if a mover stays beside a triangle's extent during its motion.
bool stays_beside(const Start& start, const Obstacle& o, std::int64_t approach_max) {
    if (o.kind != Obstacle::Kind::triangle) return false;
    const CoordinateVec3(&c)[3] = o.triangle->corner;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t low = up(smaller(c[0][i].raw, smaller(c[1][i].raw, c[2][i].raw)), 6),
                           high = up(larger(c[0][i].raw, larger(c[1][i].raw, c[2][i].raw)), 6);
        if (larger(low - start.box.upper_30[i], start.box.lower_30[i] - high) >
            approach_max + touching_gap_30 + roundings)
            return true;
    }
    return false;
}

/// Half the inner radius.
Coordinate core_radius(const Mover& whole) {
    return Coordinate::from_raw(shapes::inner_radius(*whole.solid).raw / 2);
}

/// A core nearer than this at the start may not approach the piece. Without this limit each tick would halve
/// the remaining gap.
constexpr std::int64_t core_gap_30 = stop_gap_30 / 64;

/// How much nearer a ball comes along a direction from A; when A moves, a bound of that.
std::int64_t comes_nearer_30(const Ways& w, const Obstacle& o, const Mover& ball, Long3 direction_30) {
    if (w.a.from != w.a.to) return w.approach_30(ball, w.reach_of(o), direction_30);
    const auto center = [&](Unit fraction) {
        const Transform pose = ball.pose(w.b, fraction);
        return pose.position + rotate(pose.rotation, ball.center);
    };
    return dot_dropped(shifted(raw(center(Unit{}) - center(unit_one)), 2), direction_30, 30);
}

/// Stops the core at a piece: a ball of the given radius around the core's centre, or, where the ball overlaps
/// the piece at the start, the centre alone.
Unit core_stop(const Ways& w, const Standing& standing, const Obstacle& o, const Mover& whole,
               Coordinate radius, Unit until) {
    for (const Mover& ball : {ball_of(whole, radius), ball_of(whole, Coordinate{})}) {
        const Standing begin = standing.of(ball);
        if (Above(w, begin, o, ball).keeps(ball.radius.raw)) return unit_one;
        const Measured start = measure(begin, o, anything_30);
        const std::int64_t distance = start.gap.distance_30;
        if (start.gap.overlap) continue;
        if (distance > core_gap_30) return advance(w, o, ball, smaller(stop_gap_30, distance / 2), until);
        return comes_nearer_30(w, o, ball, start.direction_30) > distance / 4 ? Unit{} : unit_one;
    }
    return unit_one;
}

/// A displacement that lifts a shape by seam_height off the surfaces it touches. Each direction counts once.
Vec3 lift_of(std::span<const UnitVec3> touching) {
    Vec3 lift{};
    const Real height = to<Real>(seam_height);
    for (const UnitVec3& n : touching) {
        const Real missing = height - dot<Real>(n, lift);
        if (missing > Real{}) lift += scale<Real>(n, missing);
    }
    return lift;
}

/// True if a rounded shape never enters a piece by half of its rounding. It is then not stopped, because
/// contacts push it out. A shape that moves by less than half its inner radius is not swept, so it may become
/// as deep.
constexpr int dip_bits = 1;
bool sinks_little(const Ways& w, const Obstacle& o, const Mover& whole) {
    Mover thin = whole;
    thin.thin_bits = dip_bits;
    if (whole.solid->geometry.radius == Length{}) return false;
    return advance(w, o, thin, stop_gap_30, unit_one) == unit_one;
}
/// True if a rounded shape, its rounding reduced to half, stays above one side of the piece. The core's centre
/// is then above that side by at least half of the inner radius.
bool is_told_to_pass(const Standing& begin, const Mover& whole, Above& above) {
    return whole.solid->geometry.radius != Length{} && above.keeps(begin.shape.radius.raw >> dip_bits);
}

/// True if the core's centre starts outside of a plane or a box and ends on the same side, no deeper than the
/// inner radius: contacts then push it out to that side. A stopped limb would be torn from its joints, and a
/// foot may sink by centimetres when a body comes down on it.
bool is_pushed_out(const Ways& w, const Standing& standing, const Obstacle& o, const Mover& whole) {
    const bool is_plane = o.kind == Obstacle::Kind::plane;
    if (!is_plane &&
        (o.kind != Obstacle::Kind::convex || o.place != nullptr || o.solid->geometry.kind != ShapeKind::box))
        return false;
    const Mover centre = ball_of(whole, Coordinate{});
    const auto side_of = [&](const Standing& s) {
        const Long3 at = s.place_24 + shifted(support(s.shape, Long3{one_30, 0, 0}).at_30, 6);
        return is_plane ? Side{Long3{0, one_30, 0}, up(at[1], 6)} : side_of_box(o.solid->geometry, at);
    };
    const Side first = side_of(standing.of(centre)), last = side_of(Standing::at(w, centre, unit_one, false));
    const std::int64_t deepest = up(shapes::inner_radius(*whole.solid).raw, 6);
    // Beyond the middle of a box another side is nearer.
    return first.above_30 > 0 && last.above_30 >= -deepest &&
           dot_dropped(first.normal_30, last.normal_30, 30) > 0;
}

Unit piece_stop(const Ways& w, const Start& begin, const Obstacle& o, const Mover& whole, Vec3 lift,
                Held held, Unit until) {
    if (begin.is_behind(o)) return unit_one;
    const std::int64_t approach_max = w.approach_max_30(whole, w.reach_of(o));
    if (stays_beside(begin, o, approach_max)) return unit_one;
    Above above(w, begin.standing, o, whole);
    if (above.keeps(begin.standing.shape.radius.raw)) return unit_one;
    const bool is_limb = held == Held::by_joints;
    if (is_limb ? is_pushed_out(w, begin.standing, o, whole) : is_told_to_pass(begin.standing, whole, above))
        return unit_one;
    const std::int64_t reachable = approach_max + 2 * touching_gap_30;
    const Measured at_start = measure(begin.standing, o, reachable);
    const Between& start = at_start.gap;
    if (!start.overlap && start.distance_30 > reachable) return unit_one;
    if (!is_limb && !start.overlap && start.distance_30 > touching_gap_30) {
        const Unit stop = advance(w, o, whole, stop_gap_30, until, &at_start);
        if (stop == unit_one || sinks_little(w, o, whole)) return unit_one;
        if (lift == Vec3{}) return stop;
        Mover lifted = whole;
        lifted.shift = lift;
        if (advance(w, o, lifted, stop_gap_30, unit_one) < unit_one) return stop;
    }
    return core_stop(w, begin.standing, o, whole, is_limb ? Coordinate{} : core_radius(whole), until);
}

} // namespace

Transform body_pose_at(const Sweep& sweep, Unit fraction) {
    if (fraction <= Unit{}) return sweep.from;
    if (fraction >= unit_one) return sweep.to;
    return {sweep.from.position + scale<Real>(sweep.to.position - sweep.from.position, fraction),
            nlerp(sweep.from.rotation, sweep.to.rotation, to<Real>(fraction))};
}

Transform pose_at(const Sweep& sweep, Unit fraction) {
    const Transform body = body_pose_at(sweep, fraction);
    return {body.position + rotate(body.rotation, sweep.local.position),
            normalized(body.rotation * sweep.local.rotation)};
}

Real relative_motion(const Sweep& a, const Sweep& b, Real reach) {
    const Ways w(a, b);
    const std::int64_t reach_30 = shift_right_rounded(reach.raw, 2);
    const std::int64_t turned =
        times_30(w.spin_b.rate_30, reach_30) + times_30(w.spin_a.rate_30, w.apart_30 + reach_30);
    return Real::from_raw(up(w.speed_30 + turned, 2));
}

Unit time_of_impact(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b,
                    const Sweep& sweep_b, Length target, NarrowScratch& scratch) {
    const Ways w(sweep_a, sweep_b);
    Unit first = unit_one;
    for_each_part(b, [&](const shapes::Solid& part, const Transform* place, std::uint32_t) {
        const Mover m = mover_of(part, place_in_body(sweep_b, place));
        const Start begin(w, m, a);
        const Corridor corridor = corridor_of(w, m, a, begin, target);
        for_each_obstacle(a, corridor.extent, scratch, [&](const Obstacle& o) {
            if (first > Unit{} && corridor.may_meet(o))
                first = min(first, advance(w, o, m, up(std::int64_t{target.raw}, 6), first));
            return first > Unit{};
        });
    });
    return first;
}

void touching_directions(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b,
                         const Sweep& sweep_b, NarrowScratch& scratch, std::vector<UnitVec3>& directions) {
    const Ways w(sweep_a, sweep_b);
    for_each_part(b, [&](const shapes::Solid& part, const Transform* place, std::uint32_t) {
        const Mover m = mover_of(part, place_in_body(sweep_b, place));
        const Start begin(w, m, a);
        const Corridor near(begin.box, begin.box, 2 * std::int64_t{stop_gap.raw});
        for_each_obstacle(a, near.extent, scratch, [&](const Obstacle& o) {
            if (begin.is_behind(o)) return;
            Measured start = measure(begin.standing, o, touching_gap_30);
            if (!start.gap.overlap && start.gap.distance_30 > touching_gap_30) return;
            // The shape may overlap a little; then the centre of its core gives the direction.
            if (start.gap.overlap) start = measure(w, o, ball_of(m, Coordinate{}), Unit{}, anything_30);
            if (!start.gap.overlap) directions.push_back(unit_of_30(start.direction_30));
        });
    });
}

Unit stop_fraction(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b, const Sweep& sweep_b,
                   std::span<const UnitVec3> touching, Held held, NarrowScratch& scratch) {
    const Ways w(sweep_a, sweep_b);
    const Vec3 lift = lift_of(touching);
    Unit first = unit_one;
    for_each_part(b, [&](const shapes::Solid& part, const Transform* place, std::uint32_t) {
        const Mover m = mover_of(part, place_in_body(sweep_b, place));
        const Start begin(w, m, a);
        const Corridor corridor = corridor_of(w, m, a, begin, stop_gap + stop_gap);
        for_each_obstacle(a, corridor.extent, scratch, [&](const Obstacle& o) {
            if (first > Unit{} && corridor.may_meet(o))
                first = min(first, piece_stop(w, begin, o, m, lift, held, first));
            return first > Unit{};
        });
    });
    return first;
}

} // namespace lockstone::collide
