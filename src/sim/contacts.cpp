// Manifolds of the pairs that are near, made anew or used again, and the contacts that the solver takes.
#include "collide/integer.h"
#include "lockstone/math.h"
#include "sim/phases.h"
#include "sim/surface.h"

#include <algorithm>

namespace lockstone::sim {

namespace {

using collide::Long3, collide::raw;

constexpr Separation touching_gap = decimal<Separation>("0.005"); ///< [m]: nearer counts as touching

/// The columns that every pair looks at, found once for many.
struct View {
    const Data& w;
    std::span<const ShapeRow> shapes;
    std::span<const Slot> shape_slots, body_slots;
    std::span<const Transform> poses;
    std::span<const Velocity> velocities;
    std::span<const ContactMemory> old; ///< the contact table of the last tick
    std::uint32_t awake;
    bool has_movers; ///< some contacts may be left to characters
    Unit half_tick;  ///< [s]

    explicit View(const Data& data)
        : w(data), shapes(w.state.rows(w.m.shape)), shape_slots(w.state.rows(w.m.shape_slot)),
          body_slots(w.state.rows(w.m.body_slot)), poses(w.state.rows(w.m.body_pose)),
          velocities(w.state.rows(w.m.body_velocity)), old(w.state.rows(w.m.contact_memory)),
          awake(w.header().bodies_awake), has_movers(!w.scratch.characters.order_of_body.empty()),
          half_tick(Unit::from_raw(unit_one.raw /
                                   (2 * static_cast<std::int32_t>(w.state.rows(w.m.config)[0].tick_rate)))) {}
    const ShapeRow& shape(ShapeId living) const { return shapes[shape_slots[living.index - 1].row]; }
    std::uint32_t row_of(BodyId living) const { return body_slots[living.index - 1].row; }
};

/// The rows and shapes of a contact, in the order the narrow phase wants them.
struct Couple {
    const ShapeRow *a, *b;
    std::uint32_t body_a, body_b;
    const Scratch::Shape *at_a, *at_b;
    dynamics::Placing placing; ///< of B in A's frame
    Length margin;
    bool flipped, sensor;
};

/// Whether shape b is the narrow phase's A: the greater kind is, of equal kinds the larger. Of two convex shapes one that
/// is larger than a lever can be comes first whatever its kind, as contact points are told from B's origin.
bool goes_after(const ShapeRow& a, const Scratch::Shape& at_a, const ShapeRow& b,
                const Scratch::Shape& at_b) {
    const ShapeKind ka = a.geometry.kind, kb = b.geometry.kind;
    const bool are_convex = ka <= ShapeKind::hull && kb <= ShapeKind::hull;
    const bool is_huge = max(at_a.reach, at_b.reach) > Coordinate(128);
    if (ka == kb || (are_convex && is_huge)) return at_a.reach < at_b.reach;
    return ka < kb;
}

/// conjugate(a) b of two rotations, whose products are below 2^61.
Quat turn_between(Quat a, Quat b) {
    const std::int64_t x = a.x.raw, y = a.y.raw, z = a.z.raw, w = a.w.raw;
    const auto part = [&](std::int64_t sum) {
        return Unit::from_raw(saturate_to_int32(shift_right_rounded(sum, Unit::fraction_bits)));
    };
    return {part(w * b.x.raw - x * b.w.raw - y * b.z.raw + z * b.y.raw),
            part(w * b.y.raw + x * b.z.raw - y * b.w.raw - z * b.x.raw),
            part(w * b.z.raw - x * b.y.raw + y * b.x.raw - z * b.w.raw),
            part(w * b.w.raw + x * b.x.raw + y * b.y.raw + z * b.z.raw)};
}

Couple couple_of(const View& v, const Scratch::Near& near) {
    Couple c;
    c.a = &v.shape(near.key.a), c.b = &v.shape(near.key.b);
    c.at_a = &v.w.scratch.shape[near.key.a.index - 1], c.at_b = &v.w.scratch.shape[near.key.b.index - 1];
    c.flipped = goes_after(*c.a, *c.at_a, *c.b, *c.at_b);
    if (c.flipped) std::swap(c.a, c.b), std::swap(c.at_a, c.at_b);
    c.body_a = v.row_of(c.a->body);
    c.body_b = v.row_of(c.b->body);
    c.placing.position =
        c.a->geometry.kind == ShapeKind::plane
            ? collide::plane_relative_pose(c.at_a->pose, c.at_b->pose).position
            : collide::into_frame(c.at_a->axes, c.at_b->pose.position - c.at_a->pose.position);
    c.placing.rotation = turn_between(c.at_a->pose.rotation, c.at_b->pose.rotation);
    c.placing.reach = c.at_b->reach;
    c.placing.thinnest = c.at_b->inner;
    if (c.a->geometry.kind < ShapeKind::compound) c.placing.thinnest = min(c.placing.thinnest, c.at_a->inner);
    c.margin = near.margin;
    c.sensor = (c.a->sensor | c.b->sensor) != 0;
    return c;
}

/// Makes the manifolds of a pair; `apart` is a hint, and becomes the next one.
void make_manifolds(const Couple& c, UnitVec3& apart, collide::NarrowScratch& scratch,
                    collide::Manifolds& out) {
    const collide::RelativePose pose{to_rotation(c.placing.rotation), c.placing.position};
    collide::collide(c.at_a->solid, c.at_b->solid, pose, c.margin, apart, scratch, out);
    apart = out.apart;
}

ContactMemory memory_of(const Couple& c, const collide::Manifold& manifold, std::uint32_t flags) {
    ContactMemory memory{};
    memory.flags = flags | (manifold.on_face != 0 ? dynamics::contact_on_face : 0u);
    memory.count = manifold.count;
    // Only shapes of many pieces say which of them it is.
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
    memory.made_position = c.placing.position;
    memory.made_rotation = c.placing.rotation;
    memory.margin = c.margin;
    return memory;
}

/// Whether the contact goes through a one-way shape: it did when they met, or it comes from the wrong side now.
bool passes(const Couple& c, std::span<const ContactMemory> old, UnitVec3 normal) {
    for (const ContactMemory& m : old)
        if (m.count != 0) return (m.flags & dynamics::contact_passing) != 0;
    const auto wrong_side = [](const ShapeRow& shape, const Scratch::Shape& at, UnitVec3 out) {
        return shape.one_way != 0 && dot<Unit>(at.axes.y, out) < half(unit_one);
    };
    return wrong_side(*c.a, *c.at_a, normal) || wrong_side(*c.b, *c.at_b, -normal);
}

Real mixed(Mix rule_a, Mix rule_b, Real a, Real b, Scratch::NarrowWorker::Mean& mean) {
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

/// What the surfaces of b and a do against each other besides the bodies' motion, world axes.
SpeedVec3 surface_velocity(const Couple& c, const Touch& a, const Touch& b) {
    if (a.velocity == Vec3{} && b.velocity == Vec3{}) return {};
    const auto of = [](const Touch& touch, const Scratch::Shape& at) {
        return touch.velocity == Vec3{} ? Vec3{} : rotate(at.pose.rotation, touch.velocity);
    };
    return to<Speed>(of(b, *c.at_b) - of(a, *c.at_a));
}

/// Closing speed of the two bodies at a point, along the normal.
Speed approach_speed(const View& v, const Couple& c, UnitVec3 normal, const dynamics::ContactPoint& p) {
    const Velocity &a = v.velocities[c.body_a], &b = v.velocities[c.body_b];
    const SpeedVec3 at_a = a.linear + cross<Speed>(a.angular, p.lever_a);
    const SpeedVec3 at_b = b.linear + cross<Speed>(b.angular, p.lever_b);
    return -dot<Speed>(at_b - at_a, normal);
}

bool has_corners(const ShapeRow& shape) {
    const ShapeKind kind = shape.geometry.kind;
    return (kind == ShapeKind::box || kind == ShapeKind::hull) && shape.geometry.radius == Length{};
}

/// What all contacts of a pair have in common: how the points of their manifolds become levers.
///   at the start of the tick   rB = R p + b,  rA = rB + k          R: A's axes, b and k from the centres of the bodies
/// Levers are moved on to the middle of the tick: a point between corners and faces goes with them, and levers of its
/// start would let what falls over gain its speed half a tick late. Round shapes roll over their points instead. On a
/// ground (A) the corners are B's; between two bodies the point goes as the mean of both:
///   goes on a ground           vB + wB x rB                        rB += (goes - vB) h,  rA += (goes - vA) h
///   between two bodies         (vA + wA x rA + vB + wB x rB) / 2   h: half a tick
/// Either is rB += U x rB + c and rA = rB + k + (vB - vA) h, so R and b take all of it, once for all points.
class PairFrame {
  public:
    PairFrame(const View& v, const Couple& couple)
        : c(couple), column_x(raw(c.at_a->axes.x)), column_y(raw(c.at_a->axes.y)),
          column_z(raw(c.at_a->axes.z)), base_b(way(v.poses[c.body_b].position, c.at_b->pose.position)),
          to_a(way(v.poses[c.body_a].position, c.at_b->pose.position) - base_b) {
        const bool on_ground = c.a->geometry.kind > ShapeKind::compound;
        if (has_corners(*c.b) && (on_ground || has_corners(*c.a))) advance(v, on_ground);
    }

    UnitVec3 normal(const ContactMemory& memory) const {
        const Rotation& axes = c.at_a->axes;
        const Long3 n = raw(memory.normal);
        const auto part = [&](int i) { // of unit vectors: below 2^61
            const std::int64_t sum = axes.x[i].raw * n[0] + axes.y[i].raw * n[1] + axes.z[i].raw * n[2];
            return Unit::from_raw(saturate_to_int32(shift_right_rounded(sum, Unit::fraction_bits)));
        };
        return {part(0), part(1), part(2)};
    }
    Vec3 world(const dynamics::ContactPointMemory& p) const {
        return c.at_b->pose.position + to<Real>(lockstone::mul<Length>(c.at_a->axes, p.position));
    }
    dynamics::ContactPoint point(const dynamics::ContactPointMemory& p, Separation separation) const {
        // Columns are shorter than 1 + 1/4, so the products stay below 2^62.
        const std::int64_t x = p.position.x.raw, y = p.position.y.raw, z = p.position.z.raw;
        dynamics::ContactPoint out;
        for (int i = 0; i < 3; ++i) {
            const std::int64_t at_b =
                base_b[i] + shift_right_rounded(column_x[i] * x + column_y[i] * y + column_z[i] * z, 30);
            out.lever_b[i] = Length::from_raw(saturate_to_int32(at_b));
            out.lever_a[i] = Length::from_raw(saturate_to_int32(at_b + to_a[i]));
        }
        out.separation = separation;
        return out;
    }

    const Couple& c;

  private:
    static constexpr std::int64_t turn_max_30 = std::int64_t{1}
                                                << 27; ///< beyond, a chord is no arc any more [rad]

    static Long3 cross_30(Long3 a, Long3 b) {
        return {(a[1] * b[2] - a[2] * b[1]) >> 30, (a[2] * b[0] - a[0] * b[2]) >> 30,
                (a[0] * b[1] - a[1] * b[0]) >> 30};
    }
    /// From one place to another [m], 24 fraction bits. Most shapes stand in the middle of their body.
    static Long3 way(const Vec3& from, const Vec3& to) {
        if (from == to) return {};
        return raw(lockstone::to<Length>(to - from));
    }
    static std::int64_t widest(Long3 x) {
        return std::max(collide::absolute(x[0]), std::max(collide::absolute(x[1]), collide::absolute(x[2])));
    }

    void advance(const View& v, bool on_ground) {
        const Velocity &a = v.velocities[c.body_a], &b = v.velocities[c.body_b];
        const std::int64_t h_30 = v.half_tick.raw;
        Long3 turn, turn_a, gone; // b against a
        for (int i = 0; i < 3; ++i) {
            turn[i] = (b.angular[i].raw * h_30) >> Speed::fraction_bits;
            turn_a[i] = on_ground ? 0 : (a.angular[i].raw * h_30) >> Speed::fraction_bits;
            gone[i] = ((std::int64_t{b.linear[i].raw} - a.linear[i].raw) * h_30) >> 25; // 24 fraction bits
        }
        if (widest(turn) > turn_max_30 || widest(turn_a) > turn_max_30) return;
        Long3 by{};
        if (!on_ground) {
            const Long3 of_a = cross_30(turn_a, to_a);
            const std::int64_t most = std::min(c.at_a->reach, c.at_b->reach).raw >> 3;
            if (widest(of_a) > most || widest(gone) > most) return;
            turn = collide::shifted(turn + turn_a, 1);
            by = collide::shifted(of_a - gone, 1);
        }
        base_b = base_b + by + cross_30(turn, base_b);
        to_a = to_a + gone;
        for (Long3* column : {&column_x, &column_y, &column_z}) *column = *column + cross_30(turn, *column);
    }

    Long3 column_x, column_y, column_z, base_b, to_a; ///< 30 and 24 fraction bits
};

/// Stores the deepest point of a pair that did not touch until now.
void store_deepest(const View& v, const PairFrame& f, UnitVec3 normal,
                   const dynamics::ContactPointMemory& deepest, Scratch::ContactResult& result) {
    result.point = f.world(deepest);
    result.normal = f.c.flipped ? -normal : normal;
    result.approach = approach_speed(v, f.c, normal, f.point(deepest, deepest.separation));
}

/// One manifold as the solver wants it.
void add_contact(const View& v, const PairFrame& f, std::uint32_t row, const ContactMemory& memory,
                 UnitVec3 normal, const std::array<Separation, 4>& separations, Scratch::NarrowWorker& worker,
                 std::vector<dynamics::Contact>& contacts) {
    const Couple& c = f.c;
    dynamics::Contact& contact = contacts.emplace_back();
    // What rests is the solver's still body.
    contact.body_a = std::min(c.body_a, v.awake);
    contact.body_b = std::min(c.body_b, v.awake);
    contact.memory = row;
    contact.count = memory.count;
    contact.normal = normal;
    for (std::uint32_t k = 0; k < memory.count; ++k)
        contact.points[k] = f.point(memory.points[k], separations[k]);
    const Touch a = touch_of(*c.a, c.at_a->solid, memory.piece_a),
                b = touch_of(*c.b, c.at_b->solid, memory.piece_b);
    contact.friction =
        to<Jacobian>(mixed(c.a->friction_mix, c.b->friction_mix, a.friction, b.friction, worker.mean));
    contact.restitution = to<Unit>(
        mixed(c.a->restitution_mix, c.b->restitution_mix, a.restitution, b.restitution, worker.mean));
    contact.rolling = to<Unit>(max(a.rolling, b.rolling));
    contact.surface_velocity = surface_velocity(c, a, b);
}

/// New rows of a pair, in the worker; none when there are no points.
std::uint32_t make_rows(const Couple& c, std::span<const ContactMemory> old, UnitVec3& apart,
                        Scratch::NarrowWorker& worker) {
    make_manifolds(c, apart, worker.narrow, worker.manifolds);
    if (worker.manifolds.count == 0) return 0;
    std::uint32_t flags = (c.flipped ? dynamics::contact_flipped : 0u);
    if (c.sensor) flags |= dynamics::contact_sensor;
    if ((c.flipped ? c.a : c.b)->sensor != 0) flags |= dynamics::contact_sensor_is_b;
    if ((c.a->one_way | c.b->one_way) != 0 &&
        passes(c, old, lockstone::mul<Unit>(c.at_a->axes, worker.manifolds.items[0].normal)))
        flags |= dynamics::contact_passing;
    dynamics::Taken taken;
    for (std::uint32_t i = 0; i < worker.manifolds.count; ++i) {
        worker.rows[i] = memory_of(c, worker.manifolds.items[i], flags);
        dynamics::carry_impulses(old, taken, worker.rows[i]);
    }
    return worker.manifolds.count;
}

using NearChunk = Scratch::NearChunk;

/// The contacts of a pair's rows, and how near the two are.
void use_rows(const View& v, const Couple& c, std::span<const ContactMemory> rows,
              const dynamics::Shift& shift, Scratch::NarrowWorker& worker, NearChunk& chunk,
              Scratch::ContactResult& result) {
    const PairFrame frame(v, c);
    const bool passing = (rows[0].flags & dynamics::contact_passing) != 0;
    Separation deepest = Separation::max();
    for (std::uint32_t i = 0; i < rows.size(); ++i) {
        const UnitVec3 normal = frame.normal(rows[i]);
        const std::array<Separation, 4> separations = dynamics::separations_after(rows[i], shift);
        for (std::uint32_t k = 0; k < rows[i].count; ++k) {
            if (separations[k] >= deepest) continue;
            deepest = separations[k];
            result.deepest_row = i;
            if (!result.was_touching) store_deepest(v, frame, normal, rows[i].points[k], result);
        }
        if (!c.sensor && !passing && !(v.has_movers && is_movers_contact(v.w, c.a->body, c.b->body, normal)))
            add_contact(v, frame, result.first_row + i, rows[i], normal, separations, worker, chunk.contacts);
    }
    result.overlaps = deepest <= (c.sensor ? Separation{} : touching_gap) && !passing;
}

/// The rows and contacts of one pair, at the end of the chunk's: those of the last tick while the shapes stand to each
/// other as they did, else new ones. Writes to the chunk, the worker and the pair's hint alone. `next_row` counts the rows
/// of the chunk.
void collide_pair(const View& v, std::uint32_t index, Scratch::Near& near, Scratch::NarrowWorker& worker,
                  NearChunk& chunk, std::uint32_t& next_row) {
    const Couple c = couple_of(v, near);
    const std::span<const ContactMemory> old = v.old.subspan(near.old_first, near.old_count);
    dynamics::Shift shift{};
    Scratch::ContactResult result{};
    result.near = index;
    result.first_row = next_row;
    result.was_touching = !old.empty() && (old[0].flags & dynamics::contact_touching) != 0;
    result.is_kept = !old.empty() && ((old[0].flags & dynamics::contact_flipped) != 0) == c.flipped &&
                     dynamics::still_good(old, c.placing, c.margin, shift);
    result.row_count = result.is_kept ? near.old_count : make_rows(c, old, near.apart, worker);
    if (result.row_count == 0) {
        if (!result.was_touching) return;
        result.flags = old[0].flags;
    } else {
        const std::span<const ContactMemory> rows =
            result.is_kept ? old : std::span<const ContactMemory>(worker.rows).first(result.row_count);
        result.flags = rows[0].flags;
        use_rows(v, c, rows, shift, worker, chunk, result);
        if (!result.is_kept) chunk.memories.insert(chunk.memories.end(), rows.begin(), rows.end());
    }
    next_row += result.row_count;
    chunk.results.push_back(result);
}

} // namespace

bool has_contact_points(Data& w, const Scratch::Near& near) {
    UnitVec3 hint = near.apart;
    make_manifolds(couple_of(View(w), near), hint, w.scratch.narrow, w.scratch.manifolds);
    return w.scratch.manifolds.count != 0;
}

void collide(Data& w) {
    Scratch& s = w.scratch;
    const std::uint32_t pairs = static_cast<std::uint32_t>(s.near.size());
    const std::uint32_t chunk_size = pairs_per_chunk(w), chunk_count = (pairs + chunk_size - 1) / chunk_size;
    while (s.near_chunks.size() < chunk_count) {
        NearChunk& chunk = s.near_chunks.emplace_back();
        chunk.memories.reserve(chunk_size / 2);
        chunk.contacts.reserve(chunk_size), chunk.results.reserve(chunk_size);
    }
    if (s.narrow_workers.size() < base::worker_count(w.tasks))
        s.narrow_workers.resize(base::worker_count(w.tasks));
    const View view(w);
    base::for_chunks(w.tasks, pairs, chunk_size,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t worker) {
                         NearChunk& chunk = s.near_chunks[first / chunk_size];
                         chunk.memories.clear(), chunk.results.clear(), chunk.contacts.clear();
                         std::uint32_t next_row = 0;
                         for (std::uint32_t i = first; i < last; ++i)
                             collide_pair(view, i, s.near[i], s.narrow_workers[worker], chunk, next_row);
                     });
    place_contacts(w);
}

} // namespace lockstone::sim
