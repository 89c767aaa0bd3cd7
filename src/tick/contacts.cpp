// Manifolds of the near pairs, computed or reused from the last tick, and the contacts for the solver.
#include "tick/contacts.h"

#include "base/parallel.h"
#include "base/prefetch.h"
#include "collide/integer.h"
#include "lockstone/math/math.h"
#include "scene/surface.h"
#include "solve/contacts/contact_order.h"
#include "tick/closing_points.h"
#include "tick/passing_shapes.h"

#include <algorithm>

namespace lockstone::sim {

namespace {

using collide::Long3, collide::raw;

constexpr Separation touching_gap = decimal<Separation>("0.005"); ///< [m]: up to this, two shapes touch

/// The columns that the work on every pair reads, looked up once.
struct View {
    const Model& w;
    const PlacedShapes& placed;
    const CharacterScratch* movers; ///< null: characters handle no contacts themselves
    const solve::PairKernel& kernel;
    const base::Paths& paths;
    std::span<const ShapeTraits> traits;
    std::span<const Slot> body_slots;
    std::span<const Transform> poses;
    std::span<const Velocity> velocities;
    std::span<const ContactMemory> old; ///< the contact table of the last tick
    std::uint32_t awake;
    Unit half_tick; ///< [s]

    View(const Model& model, const PlacedShapes& shapes_placed, const CharacterScratch* characters,
         std::span<const ContactMemory> table, const ContactScratch& scratch)
        : w(model), placed(shapes_placed), movers(characters), kernel(*scratch.pair_kernel),
          paths(scratch.paths), traits(w.state.rows(w.m.shape_traits.row)),
          body_slots(w.state.rows(w.m.body_slot)), poses(w.state.rows(w.m.body_pose)),
          velocities(w.state.rows(w.m.body_velocity)), old(table), awake(w.header().bodies_awake),
          half_tick(Unit::from_raw(unit_one.raw / (2 * static_cast<std::int32_t>(w.config().tick_rate)))) {}
    BodyId body(std::uint32_t row) const { return w.state.rows(w.m.body_info)[row].id; }
};

/// Two near shapes, in the order that the narrow phase requires.
struct CandidatePair {
    const ShapeTraits *a, *b;
    std::uint32_t body_a, body_b;
    const PlacedShapes::Shape *at_a, *at_b;
    Length margin;
    bool flipped, sensor;
};

/// Returns true if shape b becomes the narrow phase's A. A is the shape of the greater kind, or of equal kinds the
/// larger shape. If one of two convex shapes is larger than a lever can be, the larger one becomes A whatever its
/// kind, since contact points are stored relative to B's origin.
bool goes_after(const PlacedShapes::Shape& a, const PlacedShapes::Shape& b) {
    const ShapeKind ka = a.filter.kind, kb = b.filter.kind;
    const bool are_convex = ka <= ShapeKind::hull && kb <= ShapeKind::hull;
    const bool is_huge = max(a.reach, b.reach) > Coordinate(128);
    if (ka == kb || (are_convex && is_huge)) return a.reach < b.reach;
    return ka < kb;
}

void find_candidate(const View& v, const NearPair& near, CandidatePair& c) {
    const PlacedShapes::Shape &a = v.placed.shape[near.key.a.index - 1],
                              &b = v.placed.shape[near.key.b.index - 1];
    c.flipped = goes_after(a, b);
    c.at_a = c.flipped ? &b : &a, c.at_b = c.flipped ? &a : &b;
    c.a = &v.traits[c.at_a->filter.traits], c.b = &v.traits[c.at_b->filter.traits];
    c.body_a = v.body_slots[c.at_a->filter.body].row, c.body_b = v.body_slots[c.at_b->filter.body].row;
    c.margin = near.margin;
    // Few shapes are sensors or in a group. For the others, `is_plain` saves the read of the traits rows, which are
    // not in the cache.
    c.sensor = !(a.filter.is_plain && b.filter.is_plain) && (c.a->sensor | c.b->sensor) != 0;
}

// ---- pairs in lanes ---

using solve::PairContact;
using solve::PairLane;
using solve::PairPlace;

bool has_corners(const ShapeTraits& shape) {
    const ShapeKind kind = shape.geometry.kind;
    return (kind == ShapeKind::box || kind == ShapeKind::hull) && shape.geometry.radius == Length{};
}

/// The vector between two positions [m]. Written component by component: a copy of all three components would stall
/// on the stores that wrote them.
void set_way(const Vec3& from, const Vec3& to, std::int64_t (&way)[3]) {
    for (int i = 0; i < 3; ++i) way[i] = (to[i] - from[i]).raw;
}
/// The vector between two positions as lengths. Zero for most shapes, as their origin is the centre of mass of their
/// body.
void set_base(const Vec3& from, const Vec3& to, std::int64_t (&base)[3]) {
    for (std::int64_t& x : base) x = 0;
    if (from == to) return;
    for (int i = 0; i < 3; ++i) base[i] = lockstone::to<Length>(to[i] - from[i]).raw;
}

collide::PlacedSolid placed(const PlacedShapes::Shape& s) { return {s.solid, s.axes, s.pose.position}; }

/// Returns true if the direction that separated two shapes when they were last compared still does. Then they have no
/// contact points.
bool are_still_parted(const CandidatePair& c, const NearPair& near) {
    if (near.old_count != 0 || near.apart == UnitVec3{}) return false;
    return collide::are_parted(placed(*c.at_a), placed(*c.at_b), near.apart, near.margin);
}

/// Fills in the values that all manifolds of a pair share. `rows`: the pair's rows of the last tick.
void fill_pair(const View& v, const CandidatePair& c, std::span<const ContactMemory> rows, PairLane& lane) {
    constexpr auto mask = [](bool set) { return set ? -1 : 0; };
    const Transform &a = c.at_a->pose, &b = c.at_b->pose;
    const bool is_plane = c.a->geometry.kind == ShapeKind::plane,
               on_ground = c.a->geometry.kind > ShapeKind::compound;
    const Length thinnest =
        c.a->geometry.kind < ShapeKind::compound ? min(c.at_a->inner, c.at_b->inner) : c.at_b->inner;
    set_way(a.position, b.position, lane.way.v);
    set_way(v.poses[c.body_a].position, b.position, lane.way.u);
    set_base(v.poses[c.body_b].position, b.position, lane.kept.u);
    if (is_plane) {
        const Long3 given = raw(collide::plane_relative_position(c.at_a->axes.y, a.position, b.position));
        for (int i = 0; i < 3; ++i) lane.given.v[i] = given[i];
    }
    lane.rotation_a = &a.rotation, lane.rotation_b = &b.rotation, lane.axes_a = &c.at_a->axes;
    lane.velocity_a = &v.velocities[c.body_a], lane.velocity_b = &v.velocities[c.body_b];
    // A shape that reaches beyond 128 m gets new manifolds in every tick.
    const bool fits = c.at_b->reach.raw <= Length::max().raw;
    lane.reach = fits ? static_cast<std::int32_t>(c.at_b->reach.raw) : 0;
    lane.limit = fits ? solve::recycling_limit(rows, c.at_b->reach, thinnest).raw : -1;
    lane.step_max = static_cast<std::int32_t>(
        std::min<std::int64_t>(min(c.at_a->reach, c.at_b->reach).raw >> 3, Length::max().raw));
    lane.advances = mask(has_corners(*c.b) && (on_ground || has_corners(*c.a)));
    lane.on_ground = mask(on_ground), lane.is_given = mask(is_plane);
    if (rows.empty()) return;
    lane.made_rotation = &rows[0].made_rotation;
    for (int i = 0; i < 3; ++i) lane.kept.v[i] = rows[0].made_position[i].raw;
}

void add_rows(const PairLane& pair, std::span<const ContactMemory> rows, PairWindow& window) {
    for (const ContactMemory& row : rows) window.rows[window.count++] = {&pair, &row};
}

/// Computes places, contacts and validity flags of the window's rows from `first` on.
void find_rows(const View& v, solve::PairWork work, PairWindow& window, std::uint32_t first) {
    if (window.count == first) return;
    v.kernel.find({work, window.rows.data() + first, window.count - first, v.half_tick,
                   window.places.data() + first, window.contacts.data() + first,
                   window.serves.data() + first});
}

// ---- manifolds ---

CoordinateVec3 position_of(const PairPlace& place) {
    return {Coordinate::from_raw(place.position[0]), Coordinate::from_raw(place.position[1]),
            Coordinate::from_raw(place.position[2])};
}

/// Hints for the narrow phase: the last manifolds of a pair, and the direction that separated it.
collide::PairHints hints_of(std::span<const ContactMemory> old, UnitVec3 apart) {
    if (old.empty()) return {apart, {}, 0};
    const bool on_face = (old[0].flags & solve::contact_on_face) != 0;
    return {apart, old[0].normal, on_face ? 0 : old[0].points[0].feature};
}

/// The relative motion of a pair's bodies at the origin of a shape.
PairMotion motion_at(const View& v, const CandidatePair& c, Vec3 origin) {
    return {v.velocities[c.body_a], v.velocities[c.body_b],
            lockstone::to<Length>(origin - v.poses[c.body_a].position),
            lockstone::to<Length>(origin - v.poses[c.body_b].position)};
}

/// Two convex shapes that pass each other keep only points deeper than `graze`. The test runs in the frame of the
/// body that turns more.
void let_pass(const View& v, const CandidatePair& c, collide::Manifolds& manifolds) {
    const Length rim_a = rim_of(*c.at_a), rim_b = rim_of(*c.at_b);
    const bool is_b = rim_b <= rim_a;
    const PairMotion motion = motion_at(v, c, (is_b ? c.at_b : c.at_a)->pose.position);
    const Length graze = min(decimal<Length>("0.002"), half(half(min(c.at_a->inner, c.at_b->inner))));
    if (pass_each_other(placed(*c.at_a), placed(*c.at_b), manifolds.items[0].normal,
                        {motion.at_b, motion.turning, is_b ? rim_b : rim_a}, graze, v.half_tick))
        keep_deep_points(manifolds, to<Separation>(-graze));
}

/// Drops points that cannot touch within twice `half_time`.
void leave_out_far_points(const View& v, const CandidatePair& c, Unit half_time,
                          collide::Manifolds& manifolds) {
    const std::span<const collide::Manifold> made(manifolds.items, manifolds.count);
    const bool are_convex = c.a->geometry.kind < ShapeKind::compound;
    if (std::ranges::any_of(made, has_far_points))
        keep_closing_points(motion_at(v, c, c.at_b->pose.position), c.at_a->axes, half_time, are_convex,
                            manifolds);
    if (are_convex && !c.sensor && manifolds.count != 0) let_pass(v, c, manifolds);
}

/// The distance within which the narrow phase makes points. The margin of a thin shape ends at its inner radius,
/// because the sweep stops anything that moves faster. But an impact at one end of a plate turns the plate, and the
/// other end then comes down within the same tick, at up to twice its speed. The contact needs those points too:
/// without them the plate sinks into the floor.
Length point_margin(const View& v, const CandidatePair& c) {
    if (c.margin == margin_least || c.sensor || !(is_thin(*c.at_a) || is_thin(*c.at_b))) return c.margin;
    const Velocity &a = v.velocities[c.body_a], &b = v.velocities[c.body_b];
    const Real time = to<Real>(v.half_tick) * Real(2);
    const auto turns = [&](const Velocity& of, const PlacedShapes::Shape& shape) {
        return to<Real>(length(of.angular)) * to<Real>(rim_of(shape)) * time;
    };
    const Real moves = to<Real>(ahead_of(b.linear - a.linear, v.w.config().tick_rate)) + turns(a, *c.at_a) +
                       turns(b, *c.at_b),
               extent =
                   to<Real>(c.a->geometry.kind == ShapeKind::plane ? rim_of(*c.at_b)
                                                                   : min(rim_of(*c.at_a), rim_of(*c.at_b)));
    return max(c.margin, to<Length>(to<Real>(margin_least) + min(moves, extent) * Real(2)));
}

/// Puts the points of gaps onto the surface of the thinner shape, if a shape is thin.
void put_on_thin(const CandidatePair& c, collide::Manifolds& manifolds) {
    const bool thin_a = is_thin(*c.at_a), thin_b = is_thin(*c.at_b);
    if (!thin_a && !thin_b) return;
    const bool on_b = thin_b && (!thin_a || c.at_b->inner <= c.at_a->inner);
    for (std::uint32_t i = 0; i < manifolds.count; ++i) put_on_surface(on_b, manifolds.items[i]);
}

/// Computes the manifolds of a pair. `apart` is a hint, which the function updates for the next tick. `old`: the
/// pair's rows of the last tick.
void make_manifolds(const View& v, const CandidatePair& c, const PairPlace& place, UnitVec3& apart,
                    std::span<const ContactMemory> old, NarrowWorker& worker) {
    collide::Manifolds& out = worker.manifolds;
    const collide::RelativePose pose{to_rotation(place.rotation), position_of(place)};
    const auto collide_within = [&](Length margin) {
        collide::collide(c.at_a->solid, c.at_b->solid, pose, margin, hints_of(old, apart), worker.narrow,
                         out);
    };
    // The pair's own margin decides whether there is a contact, because an axis that separates the shapes by more
    // than the margin is only a hint, and hints must not change results. A point of the wider margin may be nearer,
    // along the normal of its manifold, than the two shapes are.
    collide_within(c.margin);
    const Length farther = out.count == 0 ? c.margin : point_margin(v, c);
    const bool looks_farther = farther > c.margin;
    if (looks_farther) collide_within(farther);
    if (c.margin > margin_least)
        leave_out_far_points(v, c, looks_farther ? v.half_tick + v.half_tick : v.half_tick, out);
    if (c.margin > margin_least) put_on_thin(c, out);
    apart = out.apart;
}

void fill_memory(const CandidatePair& c, const PairPlace& place, const collide::Manifold& manifold,
                 std::uint32_t flags, ContactMemory& memory) {
    memory.flags = flags | (manifold.on_face != 0 ? solve::contact_on_face : 0u);
    memory.count = manifold.count;
    // Only shapes of several pieces have a piece index.
    if (c.a->geometry.kind >= ShapeKind::compound && c.a->geometry.kind <= ShapeKind::mesh)
        memory.piece_a = manifold.piece_a;
    if (c.b->geometry.kind == ShapeKind::compound) memory.piece_b = manifold.piece_b;
    memory.normal = manifold.normal;
    for (std::uint32_t k = 0; k < manifold.count; ++k) {
        const collide::ManifoldPoint& p = manifold.points[k];
        memory.points[k].position = p.position;
        memory.points[k].feature = p.feature;
        memory.points[k].separation = p.separation;
    }
    memory.made_position = position_of(place);
    memory.made_rotation = place.rotation;
    memory.margin = c.margin;
}

/// Returns true if the contact passes through a one-way shape: it already did in the last tick, or the other shape
/// now comes from the side that lets it through.
bool passes(const CandidatePair& c, std::span<const ContactMemory> old, UnitVec3 normal) {
    for (const ContactMemory& m : old)
        if (m.count != 0) return (m.flags & solve::contact_passing) != 0;
    const auto wrong_side = [](const ShapeTraits& shape, const PlacedShapes::Shape& at, UnitVec3 out) {
        return shape.one_way != 0 && dot<Unit>(at.axes.y, out) < half(unit_one);
    };
    return wrong_side(*c.a, *c.at_a, normal) || wrong_side(*c.b, *c.at_b, -normal);
}

Real mixed(Mix rule_a, Mix rule_b, Real a, Real b, NarrowWorker::Mean& mean) {
    const Mix rule = std::max(rule_a, rule_b);
    if (a == b && rule != Mix::multiply) return a;
    switch (rule) {
    case Mix::geometric_mean:
        if (mean.a != a || mean.b != b) mean = {a, b, sqrt(a * b)};
        return mean.value;
    case Mix::average:
        return half(a + b);
    case Mix::minimum:
        return min(a, b);
    case Mix::multiply:
        return a * b;
    case Mix::maximum:
        break;
    }
    return max(a, b);
}

/// The surface velocity of b relative to a, without the motion of the bodies; world axes.
SpeedVec3 surface_velocity(const CandidatePair& c, const Touch& a, const Touch& b) {
    if (a.velocity == Vec3{} && b.velocity == Vec3{}) return {};
    const auto of = [](const Touch& touch, const PlacedShapes::Shape& at) {
        return touch.velocity == Vec3{} ? Vec3{} : rotate(at.pose.rotation, touch.velocity);
    };
    return to<Speed>(of(b, *c.at_b) - of(a, *c.at_a));
}

/// Closing speed of the two bodies at a point, along the normal.
Speed approach_speed(const View& v, const CandidatePair& c, UnitVec3 normal, const solve::ContactPoint& p) {
    const Velocity &a = v.velocities[c.body_a], &b = v.velocities[c.body_b];
    const SpeedVec3 at_a = a.linear + cross<Speed>(a.angular, p.lever_a);
    const SpeedVec3 at_b = b.linear + cross<Speed>(b.angular, p.lever_b);
    return -dot<Speed>(at_b - at_a, normal);
}

/// Stores the deepest point of a pair that did not touch in the last tick.
void store_deepest(const View& v, const CandidatePair& c, const solve::ContactPointMemory& memory,
                   const PairContact& contact, const solve::ContactPoint& point, ContactResult& result) {
    result.point = c.at_b->pose.position + to<Real>(lockstone::mul<Length>(c.at_a->axes, memory.position));
    result.normal = c.flipped ? -contact.normal : contact.normal;
    result.approach = approach_speed(v, c, contact.normal, point);
}

/// Converts one manifold to a contact of the solver.
void add_contact(const View& v, const CandidatePair& c, std::uint32_t row, const ContactMemory& memory,
                 const PairContact& found, NarrowWorker& worker, NearChunk& chunk) {
    solve::Contact& contact = chunk.contacts.emplace_back();
    // A body that is not awake maps to the solver's still body.
    contact.body_a = std::min(c.body_a, v.awake);
    contact.body_b = std::min(c.body_b, v.awake);
    contact.memory = row;
    contact.count = memory.count;
    contact.normal = found.normal;
    for (std::uint32_t k = 0; k < memory.count; ++k) {
        contact.points[k] = found.points[k];
        contact.points[k].impulse = memory.points[k].normal;
    }
    contact.tangent_1 = memory.tangent_1, contact.tangent_2 = memory.tangent_2, contact.twist = memory.twist;
    const Touch a = touch_of(*c.a, *c.at_a, memory.piece_a), b = touch_of(*c.b, *c.at_b, memory.piece_b);
    contact.friction =
        to<Jacobian>(mixed(c.a->friction_mix, c.b->friction_mix, a.friction, b.friction, worker.mean));
    contact.restitution = to<Unit>(
        mixed(c.a->restitution_mix, c.b->restitution_mix, a.restitution, b.restitution, worker.mean));
    contact.rolling = to<Unit>(max(a.rolling, b.rolling));
    contact.surface_velocity = surface_velocity(c, a, b);
    chunk.heads.push_back(solve::head_of(contact));
}

/// Appends new rows of a pair to the chunk's rows. Returns their number, 0 if there are no points.
std::uint32_t make_rows(const View& v, const CandidatePair& c, const PairPlace& place,
                        std::span<const ContactMemory> old, UnitVec3& apart, NarrowWorker& worker,
                        NearChunk& chunk) {
    make_manifolds(v, c, place, apart, old, worker);
    if (worker.manifolds.count == 0) return 0;
    std::uint32_t flags = (c.flipped ? solve::contact_flipped : 0u);
    if (c.sensor) flags |= solve::contact_sensor;
    if ((c.flipped ? c.a : c.b)->sensor != 0) flags |= solve::contact_sensor_is_b;
    if ((c.a->one_way | c.b->one_way) != 0 &&
        passes(c, old, lockstone::mul<Unit>(c.at_a->axes, worker.manifolds.items[0].normal)))
        flags |= solve::contact_passing;
    solve::Taken taken;
    for (std::uint32_t i = 0; i < worker.manifolds.count; ++i) {
        ContactMemory& memory = chunk.memories.emplace_back();
        fill_memory(c, place, worker.manifolds.items[i], flags, memory);
        solve::carry_impulses(old, taken, memory);
    }
    return worker.manifolds.count;
}

/// Makes the contacts of a pair's rows, and finds its deepest point.
void use_rows(const View& v, const CandidatePair& c, std::span<const ContactMemory> rows,
              const PairContact* found, NarrowWorker& worker, NearChunk& chunk, ContactResult& result) {
    const bool passing = (rows[0].flags & solve::contact_passing) != 0;
    Separation deepest = Separation::max();
    std::uint32_t deepest_point = 0;
    for (std::uint32_t i = 0; i < rows.size(); ++i) {
        for (std::uint32_t k = 0; k < rows[i].count; ++k)
            if (const Separation s = found[i].points[k].separation; s < deepest)
                deepest = s, result.deepest_row = i, deepest_point = k;
        if (!c.sensor && !passing &&
            !(v.movers != nullptr &&
              is_movers_contact(v.w, *v.movers, v.body(c.body_a), v.body(c.body_b), found[i].normal)))
            add_contact(v, c, result.first_row + i, rows[i], found[i], worker, chunk);
    }
    result.is_touching = deepest <= (c.sensor ? Separation{} : touching_gap) && !passing;
    if (result.was_touching) return;
    const PairContact& at = found[result.deepest_row];
    store_deepest(v, c, rows[result.deepest_row].points[deepest_point], at, at.points[deepest_point], result);
}

/// A pair of a window.
struct WindowPair {
    NearPair* near;
    CandidatePair shapes;
    std::span<const ContactMemory> old; ///< its rows of the last tick
    std::uint32_t row;                  ///< first of the rows in use, in the window
    std::uint32_t fresh;                ///< first of its new rows, in the chunk
    std::uint32_t row_count;            ///< number of rows in use
    bool is_kept;                       ///< the rows in use are those of the last tick
    bool was_touching;                  ///< when the last tick ended
};

/// Keeps the rows of the last tick if the kernel found them valid for the current relative pose, else makes new rows.
void choose_rows(const View& v, NarrowWorker& worker, NearChunk& chunk, WindowPair& pair) {
    const CandidatePair& c = pair.shapes;
    const bool had = !pair.old.empty();
    pair.was_touching = had && touched(pair.old[0]);
    pair.is_kept = had && ((pair.old[0].flags & solve::contact_flipped) != 0) == c.flipped &&
                   solve::covers(pair.old[0], c.margin) && worker.window.serves[pair.row] != 0;
    pair.fresh = static_cast<std::uint32_t>(chunk.memories.size());
    pair.row_count = pair.is_kept ? pair.near->old_count
                                  : make_rows(v, c, worker.window.places[pair.row], pair.old,
                                              pair.near->apart, worker, chunk);
}

/// Computes the relative poses of all pairs, and which rows of the last tick are still valid.
void place_pairs(const View& v, std::span<WindowPair> pairs, PairWindow& window) {
    for (std::size_t i = 0; i < pairs.size(); ++i)
        fill_pair(v, pairs[i].shapes, pairs[i].old, window.pairs[i]);
    window.count = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (pairs[i].old.empty()) continue;
        pairs[i].row = window.count;
        add_rows(window.pairs[i], pairs[i].old, window);
    }
    find_rows(v, solve::PairWork::recycle, window, 0);
    const std::uint32_t without = window.count;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (!pairs[i].old.empty()) continue;
        pairs[i].row = window.count;
        window.rows[window.count++] = {&window.pairs[i], nullptr};
    }
    find_rows(v, solve::PairWork::place, window, without);
}

/// Appends the rows and contacts of some pairs to the chunk. Writes only to the chunk, the worker and the hints of
/// the pairs.
/// `next_row` counts the rows of the chunk.
void collide_window(const View& v, std::span<WindowPair> pairs, NarrowWorker& worker, NearChunk& chunk,
                    std::uint32_t& next_row) {
    PairWindow& window = worker.window;
    place_pairs(v, pairs, window);
    v.paths.take(pairs.size() == PairWindow::pairs_max, base::Path::window_partial, base::Path::window_full);
    for (WindowPair& pair : pairs) {
        choose_rows(v, worker, chunk, pair);
        v.paths.take(pair.is_kept, base::Path::manifold_made, base::Path::manifold_kept);
    }
    const auto rows_of = [&](const WindowPair& pair) {
        const std::span<const ContactMemory> made = chunk.memories;
        return pair.is_kept ? pair.old : made.subspan(pair.fresh, pair.row_count);
    };
    const std::uint32_t fresh = window.count;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (pairs[i].is_kept) continue;
        pairs[i].row = window.count;
        add_rows(window.pairs[i], rows_of(pairs[i]), window);
    }
    find_rows(v, solve::PairWork::fresh, window, fresh);
    for (const WindowPair& pair : pairs) {
        if (pair.row_count == 0 && !pair.was_touching) continue;
        ContactResult& result = chunk.results.emplace_back();
        result.key = pair.near->key;
        result.old_first = pair.near->old_first, result.old_count = pair.near->old_count;
        result.first_row = next_row, result.row_count = pair.row_count;
        result.is_kept = pair.is_kept, result.was_touching = pair.was_touching;
        const std::span<const ContactMemory> rows = rows_of(pair);
        result.flags = rows.empty() ? pair.old[0].flags : rows[0].flags;
        if (rows.empty()) continue;
        use_rows(v, pair.shapes, rows, window.contacts.data() + pair.row, worker, chunk, result);
        next_row += result.row_count;
    }
}

/// Handles the pairs [first, last) of `near`, one window after the other. Skips pairs that the direction of the last
/// tick still separates.
void collide_chunk(const View& v, std::uint32_t first, std::uint32_t last, std::span<NearPair> near,
                   NarrowWorker& worker, NearChunk& chunk) {
    chunk.memories.clear(), chunk.results.clear(), chunk.contacts.clear(), chunk.heads.clear();
    std::array<WindowPair, PairWindow::pairs_max> pairs;
    std::uint32_t next_row = 0;
    std::size_t count = 0;
    constexpr std::uint32_t ahead = 16;
    for (std::uint32_t i = first; i < last; ++i) {
        WindowPair& pair = pairs[count];
        if (i + ahead < last) {
            const NearPair& soon = near[i + ahead];
            if (soon.old_count != 0) base::prefetch(v.old[soon.old_first]);
        }
        find_candidate(v, near[i], pair.shapes);
        const bool is_parted = are_still_parted(pair.shapes, near[i]);
        v.paths.take(is_parted, base::Path::pair_looked_at, base::Path::pair_still_parted);
        if (is_parted) continue;
        base::prefetch(*pair.shapes.a), base::prefetch(*pair.shapes.b);
        pair.near = &near[i];
        pair.old = v.old.subspan(near[i].old_first, near[i].old_count);
        if (++count == pairs.size()) collide_window(v, pairs, worker, chunk, next_row), count = 0;
    }
    if (count != 0) collide_window(v, std::span(pairs).first(count), worker, chunk, next_row);
    chunk.row_count = next_row;
}

} // namespace

bool has_contact_points(const Model& w, const PlacedShapes& placed, const NearPair& near,
                        ContactScratch& scratch) {
    const View view(w, placed, nullptr, {}, scratch);
    CandidatePair pair;
    find_candidate(view, near, pair);
    if (are_still_parted(pair, near)) return false;
    if (scratch.workers.empty()) scratch.workers.resize(1);
    NarrowWorker& worker = scratch.workers[0];
    PairWindow& window = worker.window;
    fill_pair(view, pair, {}, window.pairs[0]);
    window.rows[0] = {&window.pairs[0], nullptr};
    window.count = 1;
    find_rows(view, solve::PairWork::place, window, 0);
    UnitVec3 hint = near.apart;
    make_manifolds(view, pair, window.places[0], hint, {}, worker);
    return worker.manifolds.count != 0;
}

void collide(Model& w, const PlacedShapes& placed, const CharacterScratch& movers, NearPairs& near,
             ContactList& table, ContactScratch& s, FoundContacts& out, Tasks* tasks) {
    const std::uint32_t pairs = static_cast<std::uint32_t>(near.list.size());
    // One worker gets a single chunk of all pairs, so no chunks have to be joined.
    constexpr std::uint32_t pairs_per_chunk = 16;
    const std::uint32_t chunk_size = tasks != nullptr ? pairs_per_chunk : std::max(pairs, 1u),
                        chunk_count = (pairs + chunk_size - 1) / chunk_size;
    s.paths.take(base::is_shared(tasks, pairs, pairs_per_chunk), base::Path::collide_by_one,
                 base::Path::collide_by_workers);
    while (s.chunks.size() < chunk_count) {
        NearChunk& chunk = s.chunks.emplace_back();
        chunk.memories.reserve(chunk_size / 2);
        chunk.contacts.reserve(chunk_size), chunk.heads.reserve(chunk_size),
            chunk.results.reserve(chunk_size);
    }
    if (s.workers.size() < base::worker_count(tasks)) s.workers.resize(base::worker_count(tasks));
    const View view(w, placed, movers.order_of_body.empty() ? nullptr : &movers, table.memories, s);
    base::for_chunks(
        tasks, pairs, chunk_size, [&](std::uint32_t first, std::uint32_t last, std::uint32_t worker) {
            collide_chunk(view, first, last, near.list, s.workers[worker], s.chunks[first / chunk_size]);
        });
    place_contacts(w, near.is_cut, std::span(s.chunks).first(chunk_count), table, s, out, tasks);
}

} // namespace lockstone::sim
