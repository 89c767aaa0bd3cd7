// Manifolds of the pairs that are near, and with them the contact table of this tick.
#include "sim/phases.h"

#include "lockstone/math.h"

#include <algorithm>

namespace lockstone::sim {

namespace {

constexpr Separation touching_gap = decimal<Separation>("0.005"); ///< [m]: nearer counts as touching

/// The rows and shapes of a contact, in the order the narrow phase wants them.
struct Couple {
    const ShapeRow *a, *b;
    std::uint32_t body_a, body_b;
    const Scratch::Shape *at_a, *at_b;
    collide::RelativePose pose;
    Quat rotation; ///< of the pose
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

Couple couple_of(const Data& w, const ContactKey& key) {
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    Couple c{};
    c.a = &shapes[w.row_of(key.a)], c.b = &shapes[w.row_of(key.b)];
    c.at_a = &w.scratch.shape[key.a.index - 1], c.at_b = &w.scratch.shape[key.b.index - 1];
    c.flipped = goes_after(*c.a, *c.at_a, *c.b, *c.at_b);
    if (c.flipped) std::swap(c.a, c.b), std::swap(c.at_a, c.at_b);
    c.body_a = w.row_of(c.a->body);
    c.body_b = w.row_of(c.b->body);
    c.rotation = conjugate(c.at_a->pose.rotation) * c.at_b->pose.rotation;
    c.pose = c.a->geometry.kind == ShapeKind::plane ? collide::plane_relative_pose(c.at_a->pose, c.at_b->pose)
                                                    : collide::relative_pose(c.at_a->pose, c.at_b->pose);
    c.margin = c.at_a->margin + c.at_b->margin;
    c.sensor = (c.a->sensor | c.b->sensor) != 0;
    return c;
}

ContactMemory memory_of(const Couple& c, const collide::Manifold& manifold, std::uint32_t flags) {
    ContactMemory memory{};
    memory.flags = flags;
    memory.count = manifold.count;
    memory.normal = manifold.normal;
    for (std::uint32_t k = 0; k < manifold.count; ++k) {
        const collide::ManifoldPoint& p = manifold.points[k];
        memory.points[k].position = p.position;
        memory.points[k].feature = p.feature;
        memory.points[k].separation = p.separation;
    }
    memory.made_position = c.pose.position;
    memory.made_rotation = c.rotation;
    memory.margin = c.margin;
    return memory;
}

/// Whether the contact goes through a one-way shape: it did when they met, or it comes from the wrong side now.
bool passes(const Couple& c, std::span<const ContactMemory> old, UnitVec3 normal) {
    for (const ContactMemory& m : old)
        if (m.count != 0) return (m.flags & dynamics::contact_passing) != 0;
    const auto wrong_side = [](const ShapeRow& shape, const Scratch::Shape& at, UnitVec3 out) {
        return shape.one_way != 0 && dot<Unit>(to_rotation(at.pose.rotation).y, out) < half(unit_one);
    };
    return wrong_side(*c.a, *c.at_a, normal) || wrong_side(*c.b, *c.at_b, -normal);
}

Real mixed(Mix rule_a, Mix rule_b, Real a, Real b) {
    switch (std::max(rule_a, rule_b)) {
    case Mix::geometric_mean:
        return a == b ? a : sqrt(a * b);
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
SpeedVec3 surface_velocity(const Couple& c) {
    const auto of = [](const ShapeRow& shape, const Scratch::Shape& at) {
        return shape.surface_velocity == Vec3{} ? Vec3{} : rotate(at.pose.rotation, shape.surface_velocity);
    };
    return to<Speed>(of(*c.b, *c.at_b) - of(*c.a, *c.at_a));
}

/// Closing speed of the two bodies at a point, along the normal.
Speed approach_speed(const Data& w, const dynamics::Contact& c, const dynamics::ContactPoint& p) {
    const std::span<const Velocity> v = w.state.rows(w.m.body_velocity);
    const SpeedVec3 at_a = v[c.body_a].linear + cross<Speed>(v[c.body_a].angular, p.lever_a);
    const SpeedVec3 at_b = v[c.body_b].linear + cross<Speed>(v[c.body_b].angular, p.lever_b);
    return -dot<Speed>(at_b - at_a, c.normal);
}

/// One manifold as the solver wants it, with the separations of this tick; tells `seen` of its deepest point.
void add_contact(Data& w, const Couple& c, std::uint32_t row, const ContactMemory& memory,
                 const dynamics::Shift& shift, Separation& deepest, Scratch::Seen& seen) {
    const std::span<const Transform> poses = w.state.rows(w.m.body_pose);
    const Rotation axes = to_rotation(c.at_a->pose.rotation);
    const LengthVec3 from_a = to<Length>(c.at_b->pose.position - poses[c.body_a].position);
    const LengthVec3 from_b = to<Length>(c.at_b->pose.position - poses[c.body_b].position);
    dynamics::Contact contact{};
    contact.body_a = c.body_a;
    contact.body_b = c.body_b;
    contact.memory = row;
    contact.count = memory.count;
    contact.normal = lockstone::mul<Unit>(axes, memory.normal);
    for (std::uint32_t k = 0; k < memory.count; ++k) {
        const LengthVec3 arm = lockstone::mul<Length>(axes, memory.points[k].position);
        const Separation separation = dynamics::separation_after(memory, k, shift);
        contact.points[k] = {arm + from_a, arm + from_b, separation};
        if (separation >= deepest) continue;
        deepest = separation;
        seen.point = c.at_b->pose.position + to<Real>(arm);
        seen.normal = c.flipped ? -contact.normal : contact.normal;
        seen.approach = approach_speed(w, contact, contact.points[k]);
    }
    if (c.sensor || (memory.flags & dynamics::contact_passing) != 0) return;
    contact.friction =
        to<Jacobian>(mixed(c.a->friction_mix, c.b->friction_mix, c.a->friction, c.b->friction));
    contact.restitution =
        to<Unit>(mixed(c.a->restitution_mix, c.b->restitution_mix, c.a->restitution, c.b->restitution));
    contact.rolling = to<Unit>(max(c.a->rolling_resistance, c.b->rolling_resistance));
    contact.surface_velocity = surface_velocity(c);
    w.scratch.contacts.push_back(contact);
}

/// The rows of one pair, into `rows`: those of the last tick while the shapes stand to each other as they did, else
/// new ones. At least one row, which may have no points. Returns how many.
std::uint32_t manifolds_of(Data& w, const Couple& c, std::span<const ContactMemory> old,
                           dynamics::Shift& shift, std::array<ContactMemory, collide::Manifolds::max>& rows) {
    Scratch& s = w.scratch;
    if (!old.empty() && ((old[0].flags & dynamics::contact_flipped) != 0) == c.flipped &&
        dynamics::still_good(old[0], c.pose.position, c.rotation, c.at_b->reach, c.margin, shift)) {
        std::ranges::copy(old, rows.begin());
        return static_cast<std::uint32_t>(old.size());
    }
    shift = {};
    std::uint32_t flags = (c.flipped ? dynamics::contact_flipped : 0u);
    if (c.sensor) flags |= dynamics::contact_sensor;
    if ((c.flipped ? c.a : c.b)->sensor != 0) flags |= dynamics::contact_sensor_is_b;
    collide::collide(c.at_a->solid, c.at_b->solid, c.pose, c.margin, s.narrow, s.manifolds);
    if (s.manifolds.count == 0) {
        rows[0] = memory_of(c, {}, flags);
        return 1;
    }
    const Rotation axes = to_rotation(c.at_a->pose.rotation);
    if ((c.a->one_way | c.b->one_way) != 0 &&
        passes(c, old, lockstone::mul<Unit>(axes, s.manifolds.items[0].normal)))
        flags |= dynamics::contact_passing;
    std::uint32_t taken = 0;
    for (std::uint32_t i = 0; i < s.manifolds.count; ++i) {
        rows[i] = memory_of(c, s.manifolds.items[i], flags);
        dynamics::carry_impulses(old, taken, rows[i]);
    }
    return s.manifolds.count;
}

} // namespace

void collide(Data& w) {
    Scratch& s = w.scratch;
    s.contacts.clear(), s.seen.clear(), s.keys.clear(), s.memories.clear();
    std::array<ContactMemory, collide::Manifolds::max> rows;
    std::uint64_t dropped = 0;
    for (const Scratch::Near& near : s.near) {
        const Couple c = couple_of(w, near.key);
        const std::span<const ContactMemory> old =
            std::span(s.old_memories).subspan(near.old_first, near.old_count);
        const bool was_touching = !old.empty() && (old[0].flags & dynamics::contact_touching) != 0;
        dynamics::Shift shift{};
        const std::uint32_t count = manifolds_of(w, c, old, shift, rows);
        if (count > w.state.capacity(w.m.contacts) - s.keys.size()) {
            dropped += count;
            if (was_touching) s.ended.push_back({near.key, old[0].flags});
            continue;
        }
        Scratch::Seen seen{};
        seen.first_row = static_cast<std::uint32_t>(s.keys.size());
        seen.row_count = count;
        seen.was_touching = was_touching;
        Separation deepest = Separation::max();
        for (std::uint32_t i = 0; i < count; ++i) {
            if (rows[i].count != 0) add_contact(w, c, seen.first_row + i, rows[i], shift, deepest, seen);
            s.keys.push_back(near.key);
            s.memories.push_back(rows[i]);
        }
        seen.overlaps = deepest <= (c.sensor ? Separation{} : touching_gap) &&
                        (rows[0].flags & dynamics::contact_passing) == 0;
        s.seen.push_back(seen);
    }
    w.state.resize(w.m.contacts, static_cast<std::uint32_t>(s.keys.size()));
    std::ranges::copy(s.keys, w.state.rows(w.m.contact_key).begin());
    std::ranges::copy(s.memories, w.state.rows(w.m.contact_memory).begin());
    w.state.rows(w.m.faults)[0].contacts_dropped += dropped;
}

} // namespace lockstone::sim
