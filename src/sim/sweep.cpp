// Bodies are taken one after the other, first all that are no bullets, then the bullets, by row. Each is swept against ways
// that are final: of static and kinematic bodies, and for a bullet of all dynamic bodies taken before it. So for any
// two there is a motion from the poses before to the poses after in which they do not pass through each other.
//
// A body that was hit by a moving one is carried along by it for the rest of the tick.
#include "sim/sweep.h"

#include "collide/cast.h"
#include "lockstone/math.h"
#include "sim/phases.h"

#include <algorithm>

namespace lockstone::sim {
namespace {

using collide::Sweep;

struct Sweeper {
    Data& w;
    std::span<const Transform> pose;
    std::span<const BodyInfo> info;
    std::span<const BodyMass> mass;
    std::span<const ShapeRow> shapes;
    std::span<const Slot> slots;
    Real kinematic_motion_max{},
        motion_max{}; ///< of any point of a kinematic, of any moving body in this tick [m]

    explicit Sweeper(Data& data)
        : w(data), pose(data.state.rows(data.m.body_pose)), info(data.state.rows(data.m.body_info)),
          mass(data.state.rows(data.m.body_mass)), shapes(data.state.rows(data.m.shape)),
          slots(data.state.rows(data.m.shape_slot)) {}

    const shapes::Solid& solid(const ShapeRow& shape) const {
        return w.scratch.shape[shape.id.index - 1].solid;
    }
    Sweep sweep(std::uint32_t row, const ShapeRow& shape) const {
        return {
            pose_before(w, row), pose[row], {shape.local.position - mass[row].center, shape.local.rotation}};
    }
    /// Of its turning points from the centre of mass.
    Real reach(std::uint32_t row, const ShapeRow& shape) const {
        const Real offset = length(shape.local.position - mass[row].center);
        if (shape.geometry.kind == ShapeKind::sphere) return offset;
        return offset + to<Real>(w.scratch.shape[shape.id.index - 1].reach);
    }
    template <class Visit> void for_each_shape(std::uint32_t row, Visit&& visit) const {
        for (std::uint32_t slot = info[row].first_shape; slot != 0;) {
            const ShapeRow& shape = shapes[slots[slot - 1].row];
            slot = shape.next_shape;
            if (shape.sensor == 0 && shape.geometry.kind != ShapeKind::plane) visit(shape);
        }
    }
};

constexpr Sweep still{Transform::identity(), Transform::identity(), Transform::identity()};

Real motion_of(const Sweeper& s, std::uint32_t row) {
    if (pose_before(s.w, row) == s.pose[row]) return Real{};
    Real most{};
    s.for_each_shape(row, [&](const ShapeRow& shape) {
        const Real motion = collide::relative_motion(still, s.sweep(row, shape), s.reach(row, shape));
        most = max(most, motion);
    });
    return most;
}

/// No less than what relative_motion says of the body alone, without roots: a turn's rate is at most 2.9 times the length of
/// the quaternion's change.
Real coarse_motion(const Sweeper& s, std::uint32_t row, const ShapeRow& shape) {
    const Transform &a = pose_before(s.w, row), &b = s.pose[row];
    const Vec3 way = abs(b.position - a.position);
    const Quat p = a.rotation, q = b.rotation;
    const Real turn = abs(to<Real>(q.x) - to<Real>(p.x)) + abs(to<Real>(q.y) - to<Real>(p.y)) +
                      abs(to<Real>(q.z) - to<Real>(p.z)) + abs(to<Real>(q.w) - to<Real>(p.w));
    constexpr Real rounding = Real::from_raw(1 << 8);
    return way.x + way.y + way.z + (turn * 3 + rounding) * s.reach(row, shape) + rounding;
}

/// Against what stands still a shape may move further before it has to be swept: nothing comes towards it besides.
bool is_fast(Real motion, const shapes::Solid& solid, bool against_static) {
    const Real inner = to<Real>(shapes::inner_radius(solid));
    return motion > (against_static ? half(inner) : inner / Real(4));
}

/// What stops a body: the fraction of its way, and whose shape it was.
struct Stop {
    Unit fraction = unit_one;
    std::uint32_t row = Data::dead;
};

/// Whether the way of a body in row `other` is final and it stops this one.
bool is_swept_against(const Sweeper& s, std::uint32_t row, std::uint32_t other) {
    if (s.info[other].kind != BodyKind::dynamic) return true;
    if (s.info[row].bullet == 0 || other == row) return false;
    return s.info[other].bullet == 0 || other < row;
}

/// A one-way surface stops what moves against its +y and began above it.
bool passes_one_way(const Sweeper& s, const ShapeRow& shape, const ShapeRow& wall) {
    if (wall.one_way == 0) return false;
    const UnitVec3 up = to_rotation(s.w.scratch.shape[wall.id.index - 1].pose.rotation).y;
    const std::uint32_t row = s.w.row_of(shape.body), other = s.w.row_of(wall.body);
    const auto moved = [&](std::uint32_t r) { return s.pose[r].position - pose_before(s.w, r).position; };
    return dot<Real>(up, moved(row) - moved(other)) >= Real{};
}

/// The way of the body in a row, or a later part of it: then the others' ways begin at the same time.
struct Way {
    std::uint32_t row;
    Transform from, to; ///< of the centre of mass
    Unit begin;
    std::uint32_t except; ///< a row that is not looked at
};

/// visit(wall, row of its body, way of its body, way of the shape's body) for the shapes that may stop this one.
template <class Visit>
void for_each_wall(const Sweeper& s, const Way& whole, const ShapeRow& shape, Visit&& visit) {
    const std::uint32_t row = whole.row;
    Sweep way = s.sweep(row, shape);
    way.from = whole.from, way.to = whole.to;
    Scratch& scratch = s.w.scratch;
    const int shift = static_cast<int>(s.w.state.rows(s.w.m.config)[0].bounds_shift);
    const Real others = s.info[row].bullet != 0 ? s.motion_max : s.kinematic_motion_max;
    const Real around = length(way.local.position) + to<Real>(scratch.shape[shape.id.index - 1].reach) +
                        others + to<Real>(collide::stop_gap) * 2;
    const auto box = [&](Vec3 p) {
        constexpr int drop = Real::fraction_bits - Bound::fraction_bits;
        const auto low = [&](Real x) {
            return Bound::from_raw(saturate_to_int32((x - around).raw >> (drop + shift)));
        };
        const auto high = [&](Real x) {
            return Bound::from_raw(saturate_to_int32(((x + around).raw >> (drop + shift)) + 1));
        };
        return collide::Bounds{{low(p.x), low(p.y), low(p.z)}, {high(p.x), high(p.y), high(p.z)}};
    };
    scratch.broad_phase.query(collide::SweptBox(box(way.from.position), box(way.to.position)),
                              scratch.sweep.slots);
    scratch.sweep.slots.insert(scratch.sweep.slots.end(), scratch.planes.begin(), scratch.planes.end());
    for (const std::uint32_t slot : scratch.sweep.slots) {
        const ShapeRow& wall = s.shapes[s.slots[slot].row];
        const std::uint32_t other = s.w.row_of(wall.body);
        if (wall.sensor != 0 || other == whole.except || !is_swept_against(s, row, other) ||
            !may_meet(s.w, shape, wall))
            continue;
        if (passes_one_way(s, shape, wall) || passes_one_way(s, wall, shape)) continue;
        Sweep theirs = s.sweep(other, wall);
        theirs.from = collide::body_pose_at(theirs, whole.begin);
        if (!is_fast(collide::relative_motion(theirs, way, s.reach(row, shape)), s.solid(shape),
                     s.info[other].kind == BodyKind::static_))
            continue;
        visit(wall, other, theirs, way);
    }
}

/// Where the first of the body's shapes is stopped, with what is in `touching`.
Stop first_stop(const Sweeper& s, const Way& way) {
    Scratch& scratch = s.w.scratch;
    Stop stop;
    s.for_each_shape(way.row, [&](const ShapeRow& shape) {
        for_each_wall(s, way, shape,
                      [&](const ShapeRow& wall, std::uint32_t other, const Sweep& theirs, const Sweep& own) {
                          const Unit fraction =
                              collide::stop_fraction(s.solid(wall), theirs, s.solid(shape), own,
                                                     scratch.sweep.touching, scratch.narrow);
                          if (fraction < stop.fraction) stop = {fraction, other};
                      });
    });
    return stop;
}

/// Where the body is stopped. What it touches at the start can only make it pass what would stop it otherwise, so that is
/// looked for last.
Stop find_stop(const Sweeper& s, const Way& way) {
    Scratch& scratch = s.w.scratch;
    scratch.sweep.touching.clear();
    const Stop stop = first_stop(s, way);
    if (stop.row == Data::dead) return stop;
    s.for_each_shape(way.row, [&](const ShapeRow& shape) {
        for_each_wall(s, way, shape,
                      [&](const ShapeRow& wall, std::uint32_t, const Sweep& theirs, const Sweep& own) {
                          collide::touching_directions(s.solid(wall), theirs, s.solid(shape), own,
                                                       scratch.narrow, scratch.sweep.touching);
                      });
    });
    return scratch.sweep.touching.empty() ? stop : first_stop(s, way);
}

/// Sets the body's pose to where it was stopped, moved on with what stopped it: shifted, or when that lets it turn
/// through the body, turned too.
void sweep_body(const Sweeper& s, std::uint32_t row) {
    const Transform from = pose_before(s.w, row), to = s.pose[row];
    const Stop stop = find_stop(s, {row, from, to, Unit{}, Data::dead});
    if (stop.row == Data::dead) return;
    const Transform at = collide::body_pose_at({from, to, Transform::identity()}, stop.fraction);
    s.w.state.edit_row(s.w.m.body_pose, row) = at;
    const Sweep theirs{pose_before(s.w, stop.row), s.pose[stop.row], Transform::identity()};
    if (theirs.from == theirs.to) return;
    const Transform met = collide::body_pose_at(theirs, stop.fraction);
    Transform end{at.position + (theirs.to.position - met.position), at.rotation};
    Stop again = find_stop(s, {row, at, end, stop.fraction, Data::dead});
    if (again.row == stop.row) {
        const Transform relative{inverse_mul(met, at.position), conjugate(met.rotation) * at.rotation};
        end = {theirs.to * relative.position, normalized(theirs.to.rotation * relative.rotation)};
        again = find_stop(s, {row, at, end, stop.fraction, stop.row});
    }
    s.w.state.edit_row(s.w.m.body_pose, row) =
        collide::body_pose_at({at, end, Transform::identity()}, again.fraction);
}

} // namespace

void sweep_fast_bodies(Data& w) {
    Sweeper s(w);
    bool any_bullet = false;
    const std::uint32_t rows = w.header().bodies_awake;
    for (std::uint32_t row = 0; row < rows; ++row) {
        if (s.info[row].kind == BodyKind::kinematic)
            s.kinematic_motion_max = max(s.kinematic_motion_max, motion_of(s, row));
        any_bullet |= s.info[row].bullet != 0;
    }
    const auto may_be_fast = [&](std::uint32_t row, Real others) {
        bool fast = false;
        const bool all_stands_still = others == Real{};
        s.for_each_shape(row, [&](const ShapeRow& shape) {
            fast |= is_fast(coarse_motion(s, row, shape) + others, s.solid(shape), all_stands_still);
        });
        if (!fast) return false;
        fast = false;
        const Real motion = motion_of(s, row) + others;
        s.for_each_shape(
            row, [&](const ShapeRow& shape) { fast |= is_fast(motion, s.solid(shape), all_stands_still); });
        return fast;
    };
    for (std::uint32_t row = 0; row < rows; ++row)
        if (s.info[row].kind == BodyKind::dynamic && s.info[row].bullet == 0 &&
            may_be_fast(row, s.kinematic_motion_max))
            sweep_body(s, row);
    if (!any_bullet) return;
    for (std::uint32_t row = 0; row < rows; ++row) s.motion_max = max(s.motion_max, motion_of(s, row));
    for (std::uint32_t row = 0; row < rows; ++row)
        if (s.info[row].kind == BodyKind::dynamic && s.info[row].bullet != 0 &&
            may_be_fast(row, s.motion_max))
            sweep_body(s, row);
}

} // namespace lockstone::sim
