// The bodies are handled in sequence: first those that are not bullets, then the bullets, by row. Each is swept
// against motions that are final: those of static and kinematic bodies and, for a bullet, of all dynamic bodies
// handled before it. So for any two of these bodies there is a motion from the poses before to the poses after in
// which they do not pass through each other.
// Bodies that are not bullets are not swept against each other, so workers share them; the poses are written when all
// are known.
//
// A body that was hit by a moving body is carried along by it for the rest of the tick.
#include "tick/sweep.h"

#include "base/parallel.h"
#include "base/prefetch.h"
#include "collide/query/motion.h"
#include "tick/sweeper.h"

#include <algorithm>

namespace lockstone::sim {
namespace {

/// An upper bound of relative_motion() of a body against the world, without square roots: the rate of a rotation is
/// at most 2.9 times the length of the quaternion's change, and no length is above the sum of its components.
class CoarseMotion {
    const Transform &from, &to;
    std::int64_t moved; ///< [m], Real

    static constexpr std::int64_t rounding = 1 << 9;
    static std::int64_t apart(std::int64_t x, std::int64_t y) { return x < y ? y - x : x - y; }

  public:
    CoarseMotion(const Transform& before, const Transform& after)
        : from(before), to(after), moved(sum_apart(before.position, after.position)) {}

    static std::int64_t sum_apart(const Vec3& x, const Vec3& y) { // each is below 2^49
        return apart(x.x.raw, y.x.raw) + apart(x.y.raw, y.y.raw) + apart(x.z.raw, y.z.raw);
    }
    static constexpr std::int64_t reach_max = std::int64_t{1024} << Real::fraction_bits;

    /// The bound for points within `reach` of the centre of mass [m], Real.
    Real of(std::int64_t reach) const {
        if (reach == 0) return Real::from_raw(moved + rounding);
        if (reach > reach_max) return Real::max();
        return within(reach);
    }
    /// At least that bound, for a reach up to reach_max.
    Real within(std::int64_t reach) const {
        const Quat p = from.rotation, q = to.rotation;
        const std::int64_t turn_30 = apart(p.x.raw, q.x.raw) + apart(p.y.raw, q.y.raw) +
                                     apart(p.z.raw, q.z.raw) + apart(p.w.raw, q.w.raw);
        // Below 2^35 times 2^27.
        const std::int64_t by_turn = (3 * turn_30 + 1) * ((reach >> 16) + 1) >> 14;
        return Real::from_raw(moved + by_turn + rounding);
    }
};

/// Returns true if a shape moves so far that it has to be swept. The limit is higher against a shape that does not
/// move, as nothing comes towards the body. It is far lower for a bullet against moving shapes: a bullet that turns
/// so fast that its contacts do not hold it would sink in bit by bit. The lower limit does not apply to a sphere,
/// whose rotation moves no surface.
bool is_fast(Real motion, const PlacedShapes::Shape& shape, bool against_static, bool bullet) {
    const Real inner = to<Real>(shape.inner);
    const bool may_turn_in = bullet && shape.solid.geometry.kind != ShapeKind::sphere;
    return motion > (against_static ? half(inner) : may_turn_in ? inner / Real(64) : inner / Real(4));
}

/// The first shape that stops a body: the fraction of the path, and the row of the other body.
struct Stop {
    Unit fraction = unit_one;
    std::uint32_t row = Model::dead;
    std::uint32_t shape = 0; ///< the shape of the stopped body, as an index
};

/// Returns true if the motion of the body in row `other` is final and that body may stop this one.
bool is_swept_against(const Sweeper& s, std::uint32_t row, std::uint32_t other) {
    if (s.info[other].kind != BodyKind::dynamic) return true;
    if (!s.is_bullet(row) || other == row) return false;
    return !s.is_bullet(other) || other < row;
}

/// Returns true if a one-way surface lets the motion `moved` through: it stops only motion against its +y, from
/// above. `moved`: the motion of the other body relative to the wall's.
bool passes_one_way(const Sweeper& s, const ShapeRow& wall, Vec3 moved) {
    if (s.traits(wall).one_way == 0) return false;
    return dot<Real>(axes_of(s.at(wall)).y, moved) >= Real{};
}

/// Calls visit(wall, row of its body, paths of its body and of the shape's body) for the shapes that may stop this one.
template <class Visit>
void for_each_wall(const Sweeper& s, const Way& whole, const ShapeRow& shape,
                   collide::BroadPhase::Asker& near, Visit&& visit) {
    const std::uint32_t row = whole.row;
    const Sweep way = find_near(s, whole, shape, Among::all, near);
    std::uint32_t slow = Model::dead; // the last body against which the shape is not fast
    for (const std::uint32_t slot : near.proxies) {
        const ShapeRow& wall = s.shapes[s.slots[slot].row];
        const std::uint32_t other = s.w.row_of(wall.body);
        if (s.traits(wall).sensor != 0 || other == whole.except || other == slow ||
            !is_swept_against(s, row, other) || !may_meet(s.w, shape, wall))
            continue;
        const Vec3 moved = s.pose[other].position - s.pose_before(other).position;
        if (passes_one_way(s, wall, whole.moved - moved) || passes_one_way(s, shape, moved - whole.moved))
            continue;
        Sweep theirs = s.sweep(other, wall);
        theirs.from = collide::body_pose_at(theirs, whole.begin);
        const collide::Ways ways(theirs, way);
        if (!is_fast(collide::relative_motion(ways, s.reach(row, shape)), s.at(shape), s.stands_still(other),
                     s.is_bullet(row))) {
            slow = other;
            continue;
        }
        visit(wall, other, ways);
    }
}

/// The scratch memory of a worker.
struct Hand {
    SweepScratch::Worker& own;
    collide::NarrowScratch& narrow;
};

/// The first stop of any of the body's shapes, given the directions in `touching`.
Stop first_stop(const Sweeper& s, const Way& way, const Hand& hand) {
    Stop stop;
    const auto held = s.info[way.row].first_joint != 0 ? collide::Held::by_joints : collide::Held::not_at_all;
    s.for_each_shape(way.row, [&](const ShapeRow& shape) {
        for_each_wall(s, way, shape, hand.own.near,
                      [&](const ShapeRow& wall, std::uint32_t other, const collide::Ways& ways) {
                          const Unit fraction = collide::stop_fraction(s.solid(wall), ways, s.solid(shape),
                                                                       hand.own.touching, held, hand.narrow);
                          if (fraction < stop.fraction) stop = {fraction, other, shape.id.index};
                      });
    });
    return stop;
}

/// Stores in `touching` the directions of the contacts that the body has at the start.
void find_touching(const Sweeper& s, const Way& way, const Hand& hand) {
    hand.own.touching.clear();
    s.for_each_shape(way.row, [&](const ShapeRow& shape) {
        for_each_wall(s, way, shape, hand.own.near,
                      [&](const ShapeRow& wall, std::uint32_t, const collide::Ways& ways) {
                          collide::touching_directions(s.solid(wall), ways, s.solid(shape), hand.narrow,
                                                       hand.own.touching);
                      });
    });
}

/// Finds where the body is stopped. The contacts at the start can only turn a stop into none, so the function looks
/// for them only after it found a stop.
Stop find_stop(const Sweeper& s, const Way& way, const Hand& hand) {
    hand.own.touching.clear();
    const Stop stop = first_stop(s, way, hand);
    if (stop.row == Model::dead) return stop;
    find_touching(s, way, hand);
    return hand.own.touching.empty() ? stop : first_stop(s, way, hand);
}

/// Changes the end of a path so that the core of a shape does not come nearer to the touched surfaces while the body
/// turns. Otherwise a body that is stuck and held by its core would never turn out.
Transform about_core(const Sweeper& s, std::uint32_t row, std::uint32_t shape, const Transform& from,
                     const Transform& to, std::span<const UnitVec3> touching) {
    const ShapeRow& of = s.shapes[s.slots[shape - 1].row];
    const collide::Sweep way = s.sweep(row, of);
    const Vec3 core = way.local.position + rotate(way.local.rotation, shapes::core_center(s.solid(of)));
    Vec3 by_turn = rotate(to.rotation, core) - rotate(from.rotation, core),
         rest = to.position - from.position;
    for (const UnitVec3 out : touching) {
        const Real into = dot<Real>(rest + by_turn, out);
        if (into < Real{}) rest -= lockstone::scale<Real>(out, into);
    }
    return {from.position + rest, to.rotation};
}

/// Continues the motion of a body that a motionless shape stopped at `at`, along that shape. If the body stayed where
/// it first touches, its joints would leave a limb behind, and a sliding body would stumble.
Transform slide_on(const Sweeper& s, std::uint32_t row, const Transform& from, const Transform& to,
                   const Transform& at, Unit fraction, const Hand& hand) {
    const Vec3 whole = to.position - from.position, done = at.position - from.position;
    const Way onwards{row, at, {at.position + whole, to.rotation}, fraction, Model::dead, done};
    find_touching(s, onwards, hand);
    Vec3 rest = to.position - at.position;
    for (int round = 0; round < 2; ++round)
        for (const UnitVec3 out : hand.own.touching) {
            const Real into = dot<Real>(rest, out);
            if (into < Real{}) rest -= lockstone::scale<Real>(out, into);
        }
    if (hand.own.touching.empty() || rest == Vec3{}) return at;
    const Transform end{at.position + rest, to.rotation};
    const Stop again = find_stop(s, {row, at, end, fraction, Model::dead, done}, hand);
    if (again.fraction > Unit{} || fraction > Unit{})
        return collide::body_pose_at({at, end, Transform::identity()}, again.fraction);
    find_touching(s, onwards, hand);
    const Transform turned = about_core(s, row, again.shape, at, end, hand.own.touching);
    const Stop last = find_stop(s, {row, at, turned, fraction, Model::dead, done}, hand);
    return collide::body_pose_at({at, turned, Transform::identity()}, last.fraction);
}

/// Returns the pose at which the body was stopped, if it was, carried on with the body that stopped it: by
/// translation, or, where translation would let that body turn through this one, by rotation too.
std::optional<Transform> sweep_body(const Sweeper& s, std::uint32_t row, const Hand& hand) {
    const Transform from = s.pose_before(row), to = s.pose[row];
    const Stop stop = find_stop(s, {row, from, to, Unit{}, Model::dead, to.position - from.position}, hand);
    if (stop.row == Model::dead) return std::nullopt;
    const Transform at = collide::body_pose_at({from, to, Transform::identity()}, stop.fraction);
    const Sweep theirs{s.pose_before(stop.row), s.pose[stop.row], Transform::identity()};
    if (theirs.from == theirs.to) return slide_on(s, row, from, to, at, stop.fraction, hand);
    const Transform met = collide::body_pose_at(theirs, stop.fraction);
    const Vec3 moved = at.position - from.position;
    Transform end{at.position + (theirs.to.position - met.position), at.rotation};
    const bool turns = theirs.from.rotation != theirs.to.rotation;
    Stop again;
    if (!turns) again = find_stop(s, {row, at, end, stop.fraction, Model::dead, moved}, hand);
    if (turns || again.row == stop.row) {
        const Transform relative{inverse_mul(met, at.position), conjugate(met.rotation) * at.rotation};
        end = {theirs.to * relative.position, normalized(theirs.to.rotation * relative.rotation)};
        again = find_stop(s, {row, at, end, stop.fraction, stop.row, moved}, hand);
    }
    return collide::body_pose_at({at, end, Transform::identity()}, again.fraction);
}

/// Returns true if any shape is near the path of a body.
bool may_be_stopped(const Sweeper& s, std::uint32_t row, Among among, const Hand& hand) {
    const Transform &from = s.pose_before(row), &to = s.pose[row];
    bool any = false;
    s.for_each_shape(row, [&](const ShapeRow& shape) {
        if (any) return;
        find_near(s, {row, from, to, Unit{}, Model::dead, to.position - from.position}, shape, among,
                  hand.own.near);
        any = !hand.own.near.proxies.empty();
    });
    return any;
}

/// Flags: the body is fast against motionless shapes, or against moving ones. They are whole words, since each shape
/// updates them one by one and they are then read together.
class Haste {
    const Sweeper& s;
    bool bullet;
    Real others; ///< the greatest motion of moving shapes towards it
    unsigned still = 0, moving = 0;

  public:
    Haste(const Sweeper& sweeper, std::uint32_t row)
        : s(sweeper), bullet(s.is_bullet(row)), others(bullet ? s.motion_max : s.kinematic_motion_max) {}
    void add(Real motion, const ShapeRow& shape) {
        still |= is_fast(motion, s.at(shape), true, bullet) ? 1u : 0u;
        if (others != Real{}) moving |= is_fast(motion + others, s.at(shape), false, bullet) ? 1u : 0u;
    }
    bool against_still() const { return still != 0; }
    bool any() const { return (still | moving) != 0; }
};

/// An upper bound of haste_of().
Haste coarse_haste_of(const Sweeper& s, std::uint32_t row) {
    Haste haste(s, row);
    const CoarseMotion coarse(s.pose_before(row), s.pose[row]);
    const Vec3& center = s.mass[row].center;
    s.for_each_shape(row, [&](const ShapeRow& shape) {
        const ShapeTraits& traits = s.traits(shape);
        const Vec3& local = traits.local.position;
        std::int64_t reach = local == center ? 0 : CoarseMotion::sum_apart(local, center);
        if (traits.geometry.kind != ShapeKind::sphere) reach += to<Real>(s.at(shape).reach).raw;
        haste.add(coarse.of(reach), shape);
    });
    return haste;
}
/// Returns true if a body that is not a bullet has at most one shape and that shape is certainly not fast, as is the
/// case for most bodies. Then coarse_haste_of() finds nothing either; it takes twice the steps.
bool is_surely_slow(const Sweeper& s, std::uint32_t row) {
    const std::uint32_t slot = s.info[row].first_shape;
    if (slot == 0) return true;
    const ShapeRow& shape = s.shapes[s.slots[slot - 1].row];
    const PlacedShapes::Shape& at = s.placed.shape[slot - 1];
    const Vec3 &local = s.traits(shape).local.position, &center = s.mass[row].center;
    constexpr int finer = Real::fraction_bits - Length::fraction_bits;
    static_assert(Coordinate::fraction_bits == Length::fraction_bits);
    const std::int64_t own_reach = at.filter.kind == ShapeKind::sphere ? 0 : at.reach.raw,
                       offset = local == center ? 0 : CoarseMotion::sum_apart(local, center);
    if (shape.next_shape != 0 || own_reach > CoarseMotion::reach_max >> finer) return false;
    const std::int64_t reach = offset + (own_reach << finer);
    if (reach > CoarseMotion::reach_max) return false;
    const std::int64_t motion = CoarseMotion(s.pose_before(row), s.pose[row]).within(reach).raw,
                       inner = std::int64_t{at.inner.raw} << finer, others = s.kinematic_motion_max.raw;
    return motion < inner / 2 && (others == 0 || motion < inner / 4 - others);
}
Haste haste_of(const Sweeper& s, std::uint32_t row) {
    Haste haste(s, row);
    const Real motion = motion_of(s, row);
    s.for_each_shape(row, [&](const ShapeRow& shape) { haste.add(motion, shape); });
    return haste;
}

/// Returns true if a body has to be swept. Most falling bodies are far from all other shapes, and a query of the
/// broad phase costs less than the exact motion. A body that is fast only against moving shapes queries only those.
/// The query of a bullet would find the bullet itself, so the function skips it.
bool is_to_sweep(const Sweeper& s, std::uint32_t row, const Hand& hand) {
    const Haste coarse = coarse_haste_of(s, row);
    if (!coarse.any()) return false;
    const Among among = coarse.against_still() ? Among::all : Among::driven;
    return (s.is_bullet(row) || may_be_stopped(s, row, among, hand)) && haste_of(s, row).any();
}

/// Prefetches the data that decides if the body in a row is fast.
void fetch_ahead(const Sweeper& s, std::uint32_t row) {
    if (row >= s.info.size() || s.info[row].first_shape == 0) return;
    const PlacedShapes::Shape& shape = s.placed.shape[s.info[row].first_shape - 1];
    base::prefetch(shape.reach), base::prefetch(shape.inner);
}

constexpr std::uint32_t sweeps_per_chunk = 16;

/// Removes the speed that gravity added for the part of the path that a stopped body did not go. The velocity of a
/// stopped body is kept. So a body that is stopped in each tick and that no contact holds would gain speed for ever,
/// and the contact that holds it at last would turn that speed into spin.
void take_fall_back(Model& w, const Sweeper& s, std::uint32_t row, const Transform& at) {
    const Vec3 gravity = w.header().gravity, whole = s.pose[row].position - s.pose_before(row).position;
    const Real fallen = dot<Real>(whole, gravity),
               left = dot<Real>(s.pose[row].position - at.position, gravity);
    if (fallen <= Real{} || left <= Real{}) return;
    const BodyTraits& traits = s.mass.traits[s.info[row].traits];
    const Real part = left >= fallen ? Real(1) : left / fallen,
               scale = part * traits.gravity_scale / Real(static_cast<std::int32_t>(w.config().tick_rate));
    SpeedVec3& velocity = w.state.edit_row(w.m.body_velocity, row).linear;
    velocity = to<Speed>(to<Real>(velocity) - gravity * scale);
}

/// Stores the pose of a stopped body, and its angular velocity so that the components along the axes of the body stay
/// the same. With the world components of the whole turn, the body would have another energy at the orientation where
/// it stopped; for a thin body up to thousands of times as much.
void stop_body(Model& w, const Sweeper& s, std::uint32_t row, const Transform& at) {
    const Quat meant = s.pose[row].rotation;
    const BodyTraits& traits = s.mass.traits[s.info[row].traits];
    const Vec3& radii = traits.mass.gyration;
    const bool is_round = radii.x == radii.y && radii.y == radii.z;
    if (at.rotation != meant && !is_round && traits.gyroscopic != 0 && traits.locks == 0) {
        SpeedVec3& spin = w.state.edit_row(w.m.body_velocity, row).angular;
        spin = to<Speed>(rotate(normalized(at.rotation * conjugate(meant)), to<Real>(spin)));
    }
    take_fall_back(w, s, row, at);
    w.state.edit_row(w.m.body_pose, row) = at;
}

/// Sweeps all bodies that are not bullets. They are swept only against static and kinematic bodies, whose poses do
/// not change here.
void sweep_plain_bodies(Model& w, const Sweeper& s, std::span<NarrowWorker> workers, SweepScratch& sweep,
                        Tasks* tasks) {
    const std::uint32_t rows = w.header().bodies_awake;
    for (SweepScratch::Worker& worker : sweep.workers) worker.stopped.clear();
    sweep.paths.take(base::is_shared(tasks, rows, sweeps_per_chunk), base::Path::sweep_by_one,
                     base::Path::sweep_by_workers);
    base::for_chunks(
        tasks, rows, sweeps_per_chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t worker) {
            const Hand hand{sweep.workers[worker], workers[worker].narrow};
            for (std::uint32_t row = first; row < last; ++row) {
                fetch_ahead(s, row + 2);
                if (s.info[row].kind != BodyKind::dynamic || s.is_bullet(row) || is_surely_slow(s, row))
                    continue;
                if (!is_to_sweep(s, row, hand)) continue;
                if (const std::optional<Transform> stopped = sweep_body(s, row, hand))
                    sweep.workers[worker].stopped.push_back({row, *stopped});
            }
        });
    const bool any_stops =
        std::ranges::any_of(sweep.workers, [](const auto& worker) { return !worker.stopped.empty(); });
    sweep.paths.take(any_stops, base::Path::sweep_stops_none, base::Path::sweep_stops_some);
    for (const SweepScratch::Worker& worker : sweep.workers)
        for (const StoppedBody& body : worker.stopped) stop_body(w, s, body.row, body.at);
}

/// Reserves room for the usual number of near shapes, so that the tick in which a body first becomes fast does not
/// allocate.
void make_workers(SweepScratch& sweep, std::uint32_t count) {
    constexpr std::size_t usual = 256;
    sweep.workers.resize(count);
    sweep.driven.reserve(usual);
    for (SweepScratch::Worker& worker : sweep.workers) {
        worker.near.open.reserve(usual), worker.near.proxies.reserve(usual);
        worker.touching.reserve(usual), worker.stopped.reserve(usual);
    }
}

} // namespace

void sweep_fast_bodies(Model& w, PlacedShapes& placed, const PosesBefore& before,
                       std::span<NarrowWorker> narrow, SweepScratch& sweep, Tasks* tasks) {
    Sweeper s(w, placed, before);
    const bool any_bullet =
        std::ranges::any_of(s.mass.traits, [](const BodyTraits& traits) { return traits.bullet != 0; });
    const std::uint32_t rows = w.header().bodies_awake;
    sweep.driven.clear();
    for (std::uint32_t row = 0; row < rows; ++row) {
        if (s.info[row].kind == BodyKind::dynamic) continue;
        s.kinematic_motion_max = max(s.kinematic_motion_max, motion_of(s, row));
        s.for_each_shape(row, [&](const ShapeRow& shape) { sweep.driven.push_back(shape.id.index - 1); });
    }
    // A world of many bodies adds them in order.
    if (!std::ranges::is_sorted(sweep.driven)) std::sort(sweep.driven.begin(), sweep.driven.end());
    const std::uint32_t workers = base::worker_count(tasks);
    if (sweep.workers.size() < workers) make_workers(sweep, workers);
    s.driven = sweep.driven; // make_workers() may reallocate the list
    sweep.paths.take(sweep.driven.size() > driven_max, base::Path::driven_compared,
                     base::Path::driven_in_trees);
    sweep.paths.take(any_bullet, base::Path::sweep_without_bullets, base::Path::sweep_with_bullets);
    placed.broad_phase.update_trees();
    sweep_plain_bodies(w, s, narrow, sweep, tasks);
    if (!any_bullet) return;
    for (std::uint32_t row = 0; row < rows; ++row) s.motion_max = max(s.motion_max, motion_of(s, row));
    const Hand hand{sweep.workers[0], narrow[0].narrow};
    for (std::uint32_t row = 0; row < rows; ++row)
        if (s.info[row].kind == BodyKind::dynamic && s.is_bullet(row) && is_to_sweep(s, row, hand))
            if (const std::optional<Transform> stopped = sweep_body(s, row, hand))
                stop_body(w, s, row, *stopped);
}

} // namespace lockstone::sim
