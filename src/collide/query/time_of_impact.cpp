// Times of impact of turning shapes, by conservative advancement. Each step measures the gap along the normal
// of the closest points. The gap closes no faster than the approach of the bodies along that normal plus the
// speed that turning adds. It closes no faster either than along the straight line to the gap at the end along that
// normal, but for the bend of the paths.
//
// source: Mirtich, Impulse-based Dynamic Simulation, 1996; Zhang, Redon, Lee, Kim, Continuous Collision Detection for
// Articulated Models using Taylor Models and Temporal Culling, 2007 (motion bound of a turning body along a direction)
#include "collide/core.h"
#include "collide/mesh/triangles.h"
#include "collide/query/motion.h"
#include "collide/swept_box.h"

#include <algorithm>

namespace lockstone::collide {
namespace {

constexpr int advances_max = 256;
constexpr std::int64_t stop_gap_30 = std::int64_t{stop_gap.raw} << 6;
/// A gap below this counts as touching at the start. It is larger than the gap at which a sweep stops, so that
/// a stopped shape counts as touching in the next tick.
constexpr std::int64_t touching_gap_30 = stop_gap_30 + stop_gap_30 / 4;
/// A bound of the speed at which a gap along a direction from A closes from the time `at` to the end [m per motion].
/// The height of a point above a plane of A is at least that on the straight line between its heights at both times,
/// less c t (1 - t) / 2 for a second derivative of at most c; so is the least height of all points.
std::int64_t approach_to_end_30(const Ways& w, const Mover& m, const Ends& ends, const Standing& at,
                                Unit fraction, Long3 normal_30) {
    const std::int64_t curve = w.curve_30(m.reach_30), left = one_30 - fraction.raw;
    constexpr std::int64_t shortest = one_30 >> 12; // a bound of a shorter rest is mostly rounding
    if (curve == anything_30 || left < shortest) return anything_30;
    const std::int64_t nearer =
        ends.drop_30(at, normal_30) + times_30(curve, times_30(left, left)) / 2 + roundings;
    return left == one_30 ? nearer : divide_shifted(nearer, left, 30) + 1;
}

/// The first fraction before `until` at which the gap is `target`; 1 when there is none. `start`: the gap at
/// fraction 0 if it is known, measured with a limit at least as large as the one here.
Unit advance(const Ways& w, const Obstacle& o, const Mover& m, const Ends& ends, std::int64_t target_30,
             Unit until, const Measured* start = nullptr) {
    const std::int64_t close = target_30 + larger(target_30 / 8, 2048);
    const std::int64_t reach_a = w.reach_of(o), approach_max = w.approach_max_30(m, reach_a);
    std::int64_t t = 0;
    for (int i = 0; i < advances_max; ++i) {
        const Unit fraction = Unit::from_raw(static_cast<std::int32_t>(t));
        const std::int64_t reachable = times_30(approach_max, until.raw - t) + close;
        const std::optional<Standing> later = i == 0 ? std::nullopt : std::optional(ends.at(fraction));
        const Standing& now = i == 0 ? ends.first() : *later;
        const Measured at = i == 0 && start != nullptr ? *start : measure(now, o, reachable);
        const std::int64_t distance = at.gap.distance_30;
        if (at.gap.overlap || distance <= (i == 0 ? target_30 : close)) return fraction;
        if (distance > reachable) return unit_one;
        const std::int64_t approach =
            smaller(w.approach_30(m, reach_a, at.direction_30),
                    approach_to_end_30(w, m, ends, now, fraction, at.gap.normal_30));
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

/// The bounds of a mover, including its rounding. For a hull they are those of its own box.
Box box_of(const Standing& s, const Mover& m) {
    Box box{};
    if (s.shape.core == Convex::Core::hull) {
        const shapes::Extent e = extent_in(*m.solid, {s.rotation, coordinates(s.place_24)}, Length{});
        return {up(raw(e.lower), 6), up(raw(e.upper), 6)};
    }
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
    Ends ends;
    CoordinateVec3 core; ///< centre of its core
    Box box;

    /// Only triangles and compounds read `core` and `box`.
    Start(const Ways& w, const Mover& m, const shapes::Solid& a)
        : ends(w, m, a.geometry.kind == ShapeKind::plane), core{}, box{} {
        if (!has_triangles(a) && a.geometry.kind != ShapeKind::compound) return;
        box = box_of(ends.first(), m);
        if (!has_triangles(a)) return;
        const Transform b = m.pose(w.b, Unit{});
        core = relative_pose(ends.first_pose_a(),
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
        return {start.box, box_of(start.ends.last(), m), around};
    }
    const Long3 from = raw(relative_pose(start.ends.first_pose_a(), w.b.from).position);
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

/// A box in the axes of a core, cut out of it: the part of the core that can reach a piece.
struct CorePart {
    Long3 low_24, high_24; ///< from the core's centre, along its axes
    bool is_empty = false; ///< no point of the core can reach the piece

    /// The part of the core. `core` is that shape at any time.
    Convex of(Convex core) const {
        for (int i = 0; i < 3; ++i) {
            if (high_24[i] == core.half_24[i] && low_24[i] == -core.half_24[i]) continue;
            core.center_24 = core.center_24 + shifted(core.axes_30[i] * ((low_24[i] + high_24[i]) / 2), 30);
            core.half_24[i] = (high_24[i] - low_24[i] + 1) / 2 + 1;
        }
        return core;
    }
};
/// True if a core of a kind that can be cut is longer than that, from its centre along one of its axes.
bool is_longer(const Convex& core, std::int64_t near_24) {
    if (core.core == Convex::Core::box) return widest(core.half_24) > near_24;
    return (core.core == Convex::Core::segment || core.core == Convex::Core::cylinder) &&
           core.half_24[1] > near_24;
}
/// The points of such a core that can come within `near_24` of a triangle. The plane of the triangle says little about
/// the ends of a long core that are far from it.
CorePart part_near(const Standing& s, const shapes::Face& t, std::int64_t near_24) {
    const Convex& core = s.shape;
    CorePart part{-core.half_24, core.half_24};
    const Long3 middle = s.place_24 + core.center_24;
    const bool is_box = core.core == Convex::Core::box;
    for (int i = is_box ? 0 : 1; i < (is_box ? 3 : 2); ++i) {
        std::int64_t least = anything_30, most = -anything_30;
        for (const CoordinateVec3& corner : t.corner) {
            const std::int64_t at = dot_dropped(raw(corner) - middle, core.axes_30[i], 30);
            least = smaller(least, at), most = larger(most, at);
        }
        part.low_24[i] = larger(part.low_24[i], least - near_24);
        part.high_24[i] = smaller(part.high_24[i], most + near_24);
        part.is_empty = part.is_empty || part.low_24[i] > part.high_24[i];
    }
    return part;
}

/// The height of a mover above a side of an obstacle during its motion. A mover that stays above it needs no closest
/// points.
class Above {
  public:
    Above(const Ways& ways, const Ends& of, const Obstacle& obstacle, const Mover& mover)
        : w(ways), ends(of), o(obstacle), m(mover) {
        const bool is_box = o.kind == Obstacle::Kind::convex && o.place == nullptr &&
                            o.solid->geometry.kind == ShapeKind::box;
        if (!is_box && o.kind != Obstacle::Kind::triangle) return;
        const Standing& s = ends.first();
        const Side side =
            is_box ? side_of_box(o.solid->geometry, s.place_24) : side_of_triangle(*o.triangle, s.place_24);
        normal_30 = side.normal_30, above_30 = side.above_30;
        core_30 = above_30 + lowest_30(s.shape);
    }
    /// Leaves only the part of the core in place that can come within `near_24` of the triangle. False if that is the
    /// whole core.
    bool take_near_part(std::int64_t near_24) {
        const Standing& s = ends.first();
        if (o.kind != Obstacle::Kind::triangle || !is_longer(s.shape, near_24)) return false;
        part = part_near(s, *o.triangle, near_24);
        known_drop_30 = unknown_30;
        if (!part->is_empty) core_30 = above_30 + lowest_30(part->of(s.shape));
        return true;
    }
    /// True if the core with this radius of rounding starts apart from the obstacle.
    bool is_apart(std::int64_t radius_24) const { return room_30(radius_24) > 0; }
    /// True if it stays apart during the motion.
    bool keeps(std::int64_t radius_24) {
        if (part && part->is_empty) return true;
        const std::int64_t room = room_30(radius_24);
        if (room <= 0) return false;
        if (approach_30 == unknown_30)
            approach_30 = w.approach_30(m, w.reach_of(o), in_world(ends.first(), normal_30));
        return room > approach_30 || room > drop_30();
    }

  private:
    static constexpr std::int64_t unknown_30 = -anything_30;

    std::int64_t lowest_30(const Convex& core) const {
        return dot_dropped(support(core, -normal_30).at_30, normal_30, 30);
    }
    std::int64_t room_30(std::int64_t radius_24) const {
        return core_30 - up(radius_24, 6) - touching_gap_30 - roundings;
    }
    /// A bound of the decrease of the height, from the heights at both ends and the bend of the paths.
    std::int64_t drop_30() {
        if (known_drop_30 != unknown_30) return known_drop_30;
        const std::int64_t curve = w.curve_30(m.reach_30);
        if (curve == anything_30) return known_drop_30 = anything_30;
        const Standing &first = ends.first(), &last = ends.last();
        const std::int64_t moved = dot_dropped(up(last.place_24 - first.place_24, 6), normal_30, 30),
                           end = above_30 + moved + lowest_30(part ? part->of(last.shape) : last.shape);
        return known_drop_30 = larger(0, core_30 - end) + curve / 8 + roundings;
    }
    const Ways& w;
    const Ends& ends;
    const Obstacle& o;
    const Mover& m;
    Long3 normal_30{};
    std::int64_t above_30 = 0; ///< height of the shape's origin
    /// The core's gap to the side; very negative when there is no such side.
    std::int64_t core_30 = -anything_30;
    std::optional<CorePart> part;
    std::int64_t approach_30 = unknown_30; ///< a bound of the decrease of the gap during the motion
    std::int64_t known_drop_30 = unknown_30;
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
Unit core_stop(const Ways& w, const Ends& whole_ends, const Obstacle& o, const Mover& whole,
               Coordinate radius, Unit until) {
    for (const Mover& ball : {ball_of(whole, radius), ball_of(whole, Coordinate{})}) {
        const Ends ends = whole_ends.of(ball);
        if (Above(w, ends, o, ball).keeps(ball.radius.raw)) return unit_one;
        const Measured start = measure(ends.first(), o, anything_30);
        const std::int64_t distance = start.gap.distance_30;
        if (start.gap.overlap) continue;
        if (distance > core_gap_30)
            return advance(w, o, ball, ends, smaller(stop_gap_30, distance / 2), until, &start);
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
bool sinks_little(const Ways& w, const Ends& ends, const Obstacle& o, const Mover& whole) {
    Mover thin = whole;
    thin.thin_bits = dip_bits;
    if (whole.solid->geometry.radius == Length{}) return false;
    return advance(w, o, thin, ends.of(thin), stop_gap_30, unit_one) == unit_one;
}
/// True if a rounded shape, its rounding reduced to half, stays above one side of the piece. The core's centre
/// is then above that side by at least half of the inner radius, or the part of the core that can reach the piece does
/// not contain it.
bool is_told_to_pass(const Ends& ends, const Mover& whole, Above& above) {
    return whole.solid->geometry.radius != Length{} && above.keeps(ends.first().shape.radius.raw >> dip_bits);
}

/// True if the core's centre starts outside of a plane or a box and ends on the same side, no deeper than the
/// inner radius: contacts then push it out to that side. A stopped limb would be torn from its joints, and a
/// foot may sink by centimetres when a body comes down on it.
bool is_pushed_out(const Ends& ends, const Obstacle& o, const Mover& whole) {
    const bool is_plane = o.kind == Obstacle::Kind::plane;
    if (!is_plane &&
        (o.kind != Obstacle::Kind::convex || o.place != nullptr || o.solid->geometry.kind != ShapeKind::box))
        return false;
    const Mover centre = ball_of(whole, Coordinate{});
    const auto side_of = [&](const Standing& s) {
        const Long3 at = s.place_24 + shifted(support(s.shape, Long3{one_30, 0, 0}).at_30, 6);
        return is_plane ? Side{Long3{0, one_30, 0}, up(at[1], 6)} : side_of_box(o.solid->geometry, at);
    };
    const Side first = side_of(ends.first().of(centre)), last = side_of(ends.last().of(centre));
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
    const Ends& ends = begin.ends;
    const std::int64_t radius_24 = ends.first().shape.radius.raw;
    Above above(w, ends, o, whole);
    if (above.keeps(radius_24)) return unit_one;
    const std::int64_t near_24 = ((approach_max + touching_gap_30 + roundings) >> 6) + radius_24 + 1;
    if (above.take_near_part(near_24) && above.keeps(radius_24)) return unit_one;
    const bool is_limb = held == Held::by_joints;
    if (is_limb ? is_pushed_out(ends, o, whole) : is_told_to_pass(ends, whole, above)) return unit_one;
    const std::int64_t reachable = approach_max + 2 * touching_gap_30;
    const Measured at_start = measure(ends.first(), o, reachable);
    const Between& start = at_start.gap;
    if (!start.overlap && start.distance_30 > reachable) return unit_one;
    if (!is_limb && !start.overlap && start.distance_30 > touching_gap_30) {
        const Unit stop = advance(w, o, whole, ends, stop_gap_30, until, &at_start);
        if (stop == unit_one || sinks_little(w, ends, o, whole)) return unit_one;
        if (lift == Vec3{}) return stop;
        Mover lifted = whole;
        lifted.shift = lift;
        if (advance(w, o, lifted, Ends(w, lifted, o.kind == Obstacle::Kind::plane), stop_gap_30, unit_one) <
            unit_one)
            return stop;
    }
    return core_stop(w, ends, o, whole, is_limb ? Coordinate{} : core_radius(whole), until);
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
    return relative_motion(Ways(a, b), reach);
}

Real relative_motion(const Ways& w, Real reach) {
    const std::int64_t reach_30 = shift_right_rounded(reach.raw, 2);
    const std::int64_t turned =
        times_30(w.spin_b.rate_30, reach_30) + times_30(w.spin_a.rate_30, w.apart_30 + reach_30);
    const Real whole = Real::from_raw(up(w.speed_30 + turned, 2));
    const std::int64_t curve = w.curve_30(reach_30);
    if (w.spin_a.rate_30 == 0 || curve == anything_30) return whole;
    // In the frame of A, a point departs from the segment between its ends by at most curve / 8. The matrices of two
    // rotations differ by at most twice the difference of their quaternions.
    const auto in_a = [](const Transform& of_a, const Transform& of_b) {
        return Transform{inverse_mul(of_a, of_b.position), conjugate(of_a.rotation) * of_b.rotation};
    };
    const Transform first = in_a(w.a.from, w.b.from), last = in_a(w.a.to, w.b.to);
    const std::int64_t moved = length_30(last.position - first.position) +
                               times_30(2 * chords_of(first.rotation, last.rotation).apart_30 + 16, reach_30);
    return min(whole, Real::from_raw(up(moved + curve / 8 + roundings, 2)));
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
                first = min(first, advance(w, o, m, begin.ends, up(std::int64_t{target.raw}, 6), first));
            return first > Unit{};
        });
    });
    return first;
}

void touching_directions(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b,
                         const Sweep& sweep_b, NarrowScratch& scratch, std::vector<UnitVec3>& directions) {
    touching_directions(a, Ways(sweep_a, sweep_b), b, scratch, directions);
}

void touching_directions(const shapes::Solid& a, const Ways& w, const shapes::Solid& b,
                         NarrowScratch& scratch, std::vector<UnitVec3>& directions) {
    for_each_part(b, [&](const shapes::Solid& part, const Transform* place, std::uint32_t) {
        const Mover m = mover_of(part, place_in_body(w.b, place));
        const Start begin(w, m, a);
        const Corridor near(begin.box, begin.box, 2 * std::int64_t{stop_gap.raw});
        for_each_obstacle(a, near.extent, scratch, [&](const Obstacle& o) {
            if (begin.is_behind(o)) return;
            Measured start = measure(begin.ends.first(), o, touching_gap_30);
            if (!start.gap.overlap && start.gap.distance_30 > touching_gap_30) return;
            // The shape may overlap a little; then the centre of its core gives the direction.
            if (start.gap.overlap)
                start = measure(begin.ends.first().of(ball_of(m, Coordinate{})), o, anything_30);
            if (!start.gap.overlap) directions.push_back(unit_of_30(start.direction_30));
        });
    });
}

Unit stop_fraction(const shapes::Solid& a, const Sweep& sweep_a, const shapes::Solid& b, const Sweep& sweep_b,
                   std::span<const UnitVec3> touching, Held held, NarrowScratch& scratch) {
    return stop_fraction(a, Ways(sweep_a, sweep_b), b, touching, held, scratch);
}

Unit stop_fraction(const shapes::Solid& a, const Ways& w, const shapes::Solid& b,
                   std::span<const UnitVec3> touching, Held held, NarrowScratch& scratch) {
    const Vec3 lift = lift_of(touching);
    Unit first = unit_one;
    for_each_part(b, [&](const shapes::Solid& part, const Transform* place, std::uint32_t) {
        const Mover m = mover_of(part, place_in_body(w.b, place));
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
