// The motion of two bodies in a tick, bounds of the speed at which their shapes approach, and the gap between a part of
// B and a piece of A at one time of the motion. time_of_impact.cpp searches for the time at which they meet.
#pragma once

#include "collide/query/cast_pieces.h"

#include <optional>

namespace lockstone::collide {

/// No bound [m, 30 fraction bits].
inline constexpr std::int64_t anything_30 = std::int64_t{1} << 60;
/// A bound of the rounding errors of gaps and approaches, for tests by a plane, an extent or a direction that replace
/// closest points.
inline constexpr std::int64_t roundings = 1024;

inline std::int64_t times_30(std::int64_t a, std::int64_t b) {
    return narrow_rounded(Wide::product(a, b), 30);
}
inline std::int64_t length_30(Vec3 v) { return shift_right_rounded(length(v).raw, 2) + 1; }

/// The lengths of p - q and of p + q, the shorter one first: q and -q are one rotation.
struct Chords {
    std::int64_t apart_30, together_30;
};
Chords chords_of(Quat p, Quat q);

/// Rotation of a body during its motion: about one axis, at most at `rate`.
struct Spin {
    Long3 axis_30;        ///< zero: not known accurately
    std::int64_t rate_30; ///< [rad per motion]
};

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

    Transform pose(const Sweep& b, Unit fraction) const;
    Convex shape(const Rotation& rotation) const;
};
Transform place_in_body(const Sweep& b, const Transform* part);
Mover mover_of(const shapes::Solid& part, const Transform& place);
Mover ball_of(const Mover& whole, Coordinate radius);

/// The motions of both bodies, and bounds of their approach.
struct Ways {
    const Sweep &a, &b;
    Spin spin_a, spin_b;
    Long3 closing_30;      ///< displacement of A minus displacement of B
    std::int64_t speed_30; ///< its length
    std::int64_t apart_30; ///< a bound of the distance of the centres of mass during the motion

    Ways(const Sweep& sweep_a, const Sweep& sweep_b);

    /// A bound of the speed at which a gap along a direction from A to B (world) closes [m per motion]. A's
    /// turning can be seen as motion of A's points, or in A's frame as motion of B's points and of the
    /// direction; the smaller of both bounds holds.
    std::int64_t approach_30(const Mover& m, std::int64_t reach_a_30, Long3 direction_30) const;
    /// As above, for any direction.
    std::int64_t approach_max_30(const Mover& m, std::int64_t reach_a_30) const;
    /// A bound of the second derivative of the motion, in the frame of A, of points of B within `reach` of its centre of
    /// mass [m per motion^2].
    std::int64_t curve_30(std::int64_t reach_30) const;
    /// Distance of an obstacle's points from A's centre of mass, at most; 0 when A does not turn.
    std::int64_t reach_of(const Obstacle& o) const;
};

/// As relative_motion() in cast.h, for motions whose bounds are known.
Real relative_motion(const Ways& w, Real reach);
/// As stop_fraction() in cast.h.
Unit stop_fraction(const shapes::Solid& a, const Ways& w, const shapes::Solid& b,
                   std::span<const UnitVec3> touching, Held held, NarrowScratch& scratch);
/// As touching_directions() in cast.h.
void touching_directions(const shapes::Solid& a, const Ways& w, const shapes::Solid& b,
                         NarrowScratch& scratch, std::vector<UnitVec3>& directions);

/// Pose and shape of a mover at one time, for all pieces of A.
struct Standing {
    Rotation axes;     ///< orientation of A
    Rotation rotation; ///< orientation of the mover in A's frame
    Long3 place_24;
    Convex shape;

    /// As above, for a ball or point inside the mover.
    Standing of(const Mover& inside) const { return {axes, rotation, place_24, inside.shape(rotation)}; }
};
Long3 in_world(const Standing& s, Long3 direction_30);

/// A mover at the start of the motion and, computed on first use, at its end.
class Ends {
  public:
    /// `on_plane`: A is a plane. The ways and the mover must outlive it.
    Ends(const Ways& ways, const Mover& mover, bool on_plane)
        : w(&ways), m(&mover), first_a(pose_at(ways.a, Unit{})), a_is_still(ways.a.from == ways.a.to),
          plane(on_plane), start(at(Unit{})) {}
    /// As above, for a ball or point inside the mover, or for the mover with less rounding.
    Ends of(const Mover& inside) const { return Ends(*this, inside); }

    const Standing& first() const { return start; }
    const Standing& last() const {
        if (!end) end.emplace(at(unit_one));
        return *end;
    }
    Standing at(Unit fraction) const;
    /// The pose of the shape of A at the start.
    const Transform& first_pose_a() const { return first_a; }
    /// How much nearer the mover comes to A along a direction from A (in A's frame) between a time and the end.
    std::int64_t drop_30(const Standing& now, Long3 normal_30) const;

  private:
    Ends(const Ends& whole, const Mover& inside)
        : w(whole.w), m(&inside), first_a(whole.first_a), a_is_still(whole.a_is_still), plane(whole.plane),
          start(whole.start.of(inside)) {
        if (whole.end) end.emplace(whole.end->of(inside));
    }
    const Ways* w;
    const Mover* m;
    Transform first_a;
    bool a_is_still; ///< A has that pose during the whole motion
    bool plane;
    Standing start;
    mutable std::optional<Standing> end; ///< a cache: a function of the other members
};

struct Measured {
    Between gap;
    Long3 direction_30; ///< world, from A to B
};
Measured measure(const Standing& s, const Obstacle& o, std::int64_t limit_30);

} // namespace lockstone::collide
