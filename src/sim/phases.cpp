#include "sim/phases.h"

#include "lockstone/math.h"

#include <algorithm>
#include <tuple>

namespace lockstone::sim {

namespace {

constexpr Length margin_base = decimal<Length>("0.01"); ///< [m]: contacts are made this far ahead of touching
constexpr Separation touching_gap = decimal<Separation>("0.005"); ///< [m]: nearer counts as touching

Transform shape_pose(const ShapeRow& shape, const Transform& body, const BodyMass& mass) {
    return {body.position + rotate(body.rotation, shape.local.position - mass.center),
            normalized(body.rotation * shape.local.rotation)};
}

Length inner_radius(const Geometry& g) {
    if (g.kind == ShapeKind::box) return min(g.half_extent.x, min(g.half_extent.y, g.half_extent.z));
    return g.radius;
}

/// Contacts of a fast body are found before it arrives, as far ahead as its own size, so it lands on surfaces.
Length margin_of(const Geometry& g, const Velocity& velocity, std::uint32_t tick_rate) {
    const Speed speed = length(velocity.linear);
    const Length ahead = to<Length>(
        Real::from_raw(divide_shifted(speed.raw, tick_rate, Real::fraction_bits - Speed::fraction_bits)));
    return margin_base + min(ahead, inner_radius(g));
}

void set_proxy(Data& w, const ShapeRow& shape, std::uint32_t body_row) {
    Scratch& s = w.scratch;
    const std::uint32_t slot = shape.id.index - 1;
    const BodyKind kind = w.state.rows(w.m.body_info)[body_row].kind;
    const Config& config = w.state.rows(w.m.config)[0];
    s.shape_pose[slot] =
        shape_pose(shape, w.state.rows(w.m.body_pose)[body_row], w.state.rows(w.m.body_mass)[body_row]);
    s.shape_margin[slot] =
        kind == BodyKind::static_
            ? margin_base
            : margin_of(shape.geometry, w.state.rows(w.m.body_velocity)[body_row], config.tick_rate);
    if (shape.geometry.kind == ShapeKind::plane) {
        // Before a restore this slot and generation may have held a shape with bounds.
        if (s.proxy_generation[slot] != 0) s.broad_phase.remove(slot);
        s.proxy_generation[slot] = 0;
        return;
    }
    s.broad_phase.set(slot,
                      collide::bounds_of(shape.geometry, s.shape_pose[slot], s.shape_margin[slot],
                                         static_cast<int>(config.bounds_shift)),
                      kind == BodyKind::static_);
    s.proxy_generation[slot] = shape.id.generation;
}

void drop_dead_proxies(Data& w) {
    Scratch& s = w.scratch;
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    for (std::uint32_t slot = 0; slot < s.proxy_generation.size(); ++slot) {
        if (s.proxy_generation[slot] == 0) continue;
        if (slot < slots.size() && slots[slot].alive != 0 &&
            slots[slot].generation == s.proxy_generation[slot])
            continue;
        s.broad_phase.remove(slot);
        s.proxy_generation[slot] = 0;
    }
    s.planes.clear();
    for (std::uint32_t slot = 0; slot < slots.size(); ++slot)
        if (slots[slot].alive != 0 &&
            w.state.rows(w.m.shape)[slots[slot].row].geometry.kind == ShapeKind::plane)
            s.planes.push_back(slot);
}

/// Whether two shapes may meet: a pure function of the state.
bool may_meet(const ShapeRow& a, const BodyInfo& body_a, const ShapeRow& b, const BodyInfo& body_b) {
    if (a.body == b.body || (a.sensor != 0 && b.sensor != 0)) return false;
    const bool any_dynamic = body_a.kind == BodyKind::dynamic || body_b.kind == BodyKind::dynamic;
    const bool any_moves = body_a.kind != BodyKind::static_ || body_b.kind != BodyKind::static_;
    if (!any_dynamic && !(any_moves && (a.sensor | b.sensor) != 0)) return false;
    if (a.group != 0 && a.group == b.group) return a.group > 0;
    return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

/// Whether bounds reach below a plane.
bool reaches(const collide::Bounds& bounds, const Transform& plane, std::uint32_t shift) {
    const UnitVec3 n = to_rotation(plane.rotation).y;
    const auto lowest = [](Unit along, Bound lower, Bound upper) { return along.raw > 0 ? lower : upper; };
    const Vector3<Bound> corner{lowest(n.x, bounds.lower.x, bounds.upper.x),
                                lowest(n.y, bounds.lower.y, bounds.upper.y),
                                lowest(n.z, bounds.lower.z, bounds.upper.z)};
    const auto metres = [shift](Bound b) { return Real::from_raw(std::int64_t{b.raw} << (16 + shift)); };
    const Vec3 p = Vec3{metres(corner.x), metres(corner.y), metres(corner.z)} - plane.position;
    return dot<Real>(n, p) <= to<Real>(margin_base);
}

void find_plane_pairs(Data& w) {
    Scratch& s = w.scratch;
    const std::uint32_t shift = w.state.rows(w.m.config)[0].bounds_shift;
    const std::size_t before = s.pairs.size();
    for (std::uint32_t plane : s.planes)
        for (const ShapeRow& shape : w.state.rows(w.m.shape)) {
            const std::uint32_t slot = shape.id.index - 1;
            if (shape.geometry.kind == ShapeKind::plane) continue;
            if (w.state.rows(w.m.body_info)[w.row_of(shape.body)].kind == BodyKind::static_) continue;
            if (reaches(s.broad_phase.bounds(slot), s.shape_pose[plane], shift))
                s.pairs.push_back({std::min(plane, slot), std::max(plane, slot)});
        }
    if (s.pairs.size() != before) std::sort(s.pairs.begin(), s.pairs.end());
}

/// The rows and shapes of a contact, in the order the narrow phase wants them.
struct Couple {
    const ShapeRow *a, *b;
    std::uint32_t body_a, body_b;
    bool flipped;
};

Length largest(const Geometry& g) { return max(g.half_extent.x, max(g.half_extent.y, g.half_extent.z)); }

Couple couple_of(const Data& w, const ContactKey& key) {
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    Couple c{&shapes[w.row_of(key.a)], &shapes[w.row_of(key.b)], 0, 0, false};
    const ShapeKind ka = c.a->geometry.kind, kb = c.b->geometry.kind;
    // The greater kind first, of equal kinds the larger: its frame is the manifold's.
    c.flipped = ka < kb || (ka == kb && largest(c.a->geometry) < largest(c.b->geometry));
    if (c.flipped) std::swap(c.a, c.b);
    c.body_a = w.row_of(c.a->body);
    c.body_b = w.row_of(c.b->body);
    return c;
}

/// The manifold of a couple in world axes. Returns false when they are apart.
struct WorldManifold {
    dynamics::Contact contact;
    Vec3 deepest;
    Separation separation;
};

bool manifold_of(const Data& w, const Couple& c, WorldManifold& out) {
    const Scratch& s = w.scratch;
    const std::uint32_t slot_a = c.a->id.index - 1, slot_b = c.b->id.index - 1;
    const Transform &pose_a = s.shape_pose[slot_a], &pose_b = s.shape_pose[slot_b];
    collide::Manifold manifold;
    Vec3 origin = pose_a.position;
    collide::RelativePose relative{};
    if (c.a->geometry.kind == ShapeKind::plane) {
        const collide::PlaneView view = collide::plane_view(pose_a, pose_b);
        relative = view.pose;
        origin = view.origin;
    } else {
        relative = collide::relative_pose(pose_a, pose_b);
    }
    collide::collide(c.a->geometry, c.b->geometry, relative, s.shape_margin[slot_a] + s.shape_margin[slot_b],
                     manifold);
    if (manifold.count == 0) return false;

    const Rotation axes = to_rotation(pose_a.rotation);
    const std::span<const Transform> poses = w.state.rows(w.m.body_pose);
    const LengthVec3 from_a = to<Length>(origin - poses[c.body_a].position);
    const LengthVec3 from_b = to<Length>(origin - poses[c.body_b].position);
    out.contact.count = manifold.count;
    out.contact.normal = lockstone::mul<Unit>(axes, manifold.normal);
    for (std::uint32_t k = 0; k < manifold.count; ++k) {
        const collide::ManifoldPoint& p = manifold.points[k];
        const LengthVec3 arm = lockstone::mul<Length>(axes, p.position);
        out.contact.points[k] = {arm + from_a, arm + from_b, p.separation, p.feature, p.position};
        if (k == 0 || p.separation < out.separation) {
            out.separation = p.separation;
            out.deepest = origin + to<Real>(arm);
        }
    }
    return true;
}

Real mixed_friction(Real a, Real b) { return a == b ? a : sqrt(a * b); }

/// Closing speed of the two bodies at a point, along the normal.
Speed approach_speed(const Data& w, const dynamics::Contact& c, const dynamics::ContactPoint& p) {
    const std::span<const Velocity> v = w.state.rows(w.m.body_velocity);
    const SpeedVec3 at_a = v[c.body_a].linear + cross<Speed>(v[c.body_a].angular, p.lever_a);
    const SpeedVec3 at_b = v[c.body_b].linear + cross<Speed>(v[c.body_b].angular, p.lever_b);
    return -dot<Speed>(at_b - at_a, c.normal);
}

} // namespace

void update_bounds(Data& w) {
    Scratch& s = w.scratch;
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    if (s.structure_stale) drop_dead_proxies(w);
    for (const ShapeRow& shape : w.state.rows(w.m.shape)) {
        const std::uint32_t row = w.row_of(shape.body);
        if (info[row].kind == BodyKind::static_ && !s.structure_stale) continue;
        set_proxy(w, shape, row);
    }
    s.structure_stale = false;
}

void find_pairs(Data& w) {
    Scratch& s = w.scratch;
    s.broad_phase.find_pairs(s.pairs);
    find_plane_pairs(w);

    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    const std::span<const ContactKey> old_keys = w.state.rows(w.m.contact_key);
    const std::span<const ContactMemory> old_memories = w.state.rows(w.m.contact_memory);
    const auto order = [](const ContactKey& k) { return std::pair(k.a.index, k.b.index); };

    s.keys.clear(), s.memories.clear(), s.ended.clear();
    std::size_t old = 0;
    const auto retire = [&](std::size_t i) {
        if (old_memories[i].flags & dynamics::contact_touching)
            s.ended.push_back({old_keys[i], old_memories[i].flags});
    };
    std::uint64_t dropped = 0;
    for (const collide::ProxyPair& pair : s.pairs) {
        const ShapeRow &a = shapes[slots[pair.a].row], &b = shapes[slots[pair.b].row];
        if (!may_meet(a, info[w.row_of(a.body)], b, info[w.row_of(b.body)])) continue;
        if (s.keys.size() == w.state.capacity(w.m.contacts)) {
            ++dropped;
            continue;
        }
        const ContactKey key{a.id, b.id};
        while (old < old_keys.size() && order(old_keys[old]) < order(key)) retire(old++);
        ContactMemory memory{};
        if (old < old_keys.size() && order(old_keys[old]) == order(key)) {
            if (old_keys[old] == key)
                memory = old_memories[old];
            else
                retire(old);
            ++old;
        }
        s.keys.push_back(key);
        s.memories.push_back(memory);
    }
    while (old < old_keys.size()) retire(old++);
    w.state.rows(w.m.faults)[0].contacts_dropped += dropped;
    w.state.resize(w.m.contacts, static_cast<std::uint32_t>(s.keys.size()));
    std::ranges::copy(s.keys, w.state.rows(w.m.contact_key).begin());
    std::ranges::copy(s.memories, w.state.rows(w.m.contact_memory).begin());
}

void collide(Data& w) {
    Scratch& s = w.scratch;
    const std::span<const ContactKey> keys = w.state.rows(w.m.contact_key);
    const std::span<ContactMemory> memories = w.state.rows(w.m.contact_memory);
    s.contacts.clear(), s.contact_origin.clear();
    s.seen.assign(keys.size(), {});
    for (std::uint32_t i = 0; i < keys.size(); ++i) {
        Scratch::Seen& seen = s.seen[i];
        seen.contact = dynamics::no_contact;
        const Couple c = couple_of(w, keys[i]);
        const bool sensor = (c.a->sensor | c.b->sensor) != 0;
        const bool sensor_is_b = (c.flipped ? c.a : c.b)->sensor != 0;
        memories[i].flags = (memories[i].flags & dynamics::contact_touching) |
                            (sensor ? dynamics::contact_sensor : 0u) |
                            (sensor_is_b ? dynamics::contact_sensor_is_b : 0u);
        WorldManifold manifold{};
        if (!manifold_of(w, c, manifold)) {
            memories[i].count = 0;
            memories[i].points = {};
            continue;
        }
        manifold.contact.body_a = c.body_a;
        manifold.contact.body_b = c.body_b;
        seen.flipped = c.flipped;
        seen.normal = c.flipped ? -manifold.contact.normal : manifold.contact.normal;
        seen.point = manifold.deepest;
        seen.overlaps = manifold.separation <= (sensor ? Separation{} : touching_gap);
        seen.approach = approach_speed(w, manifold.contact, manifold.contact.points[0]);
        if (sensor) continue;
        manifold.contact.memory = i;
        manifold.contact.friction = to<Jacobian>(mixed_friction(c.a->friction, c.b->friction));
        manifold.contact.restitution = to<Unit>(max(c.a->restitution, c.b->restitution));
        seen.contact = static_cast<std::uint32_t>(s.contacts.size());
        s.contacts.push_back(manifold.contact);
        s.contact_origin.push_back(w.state.rows(w.m.body_pose)[c.body_a].position);
    }
}

namespace {

/// Bodies of destroyed shapes are null.
Event event_of(const Data& w, const ContactKey& key, std::uint32_t flags, bool begin) {
    const bool sensor = (flags & dynamics::contact_sensor) != 0;
    const bool swap = (flags & dynamics::contact_sensor_is_b) != 0;
    const auto body = [&](ShapeId id) {
        const std::uint32_t row = w.row_of(id);
        return row == Data::dead ? BodyId{} : w.state.rows(w.m.shape)[row].body;
    };
    Event e{};
    e.kind = sensor ? (begin ? EventKind::sensor_begin : EventKind::sensor_end)
                    : (begin ? EventKind::contact_begin : EventKind::contact_end);
    e.shape_a = swap ? key.b : key.a;
    e.shape_b = swap ? key.a : key.b;
    e.body_a = body(e.shape_a);
    e.body_b = body(e.shape_b);
    e.tick = w.header().tick;
    return e;
}

bool was_hit(const ContactMemory& memory) {
    for (std::uint32_t k = 0; k < memory.count; ++k)
        if (memory.points[k].normal.raw > 0) return true;
    return false;
}

void publish_contact_points(Data& w) {
    const Scratch& s = w.scratch;
    const std::span<const ContactKey> keys = w.state.rows(w.m.contact_key);
    const std::span<const ContactMemory> memories = w.state.rows(w.m.contact_memory);
    w.contact_points.clear();
    for (std::size_t i = 0; i < s.contacts.size(); ++i) {
        const dynamics::Contact& c = s.contacts[i];
        for (std::uint32_t k = 0; k < c.count; ++k)
            w.contact_points.push_back(
                {keys[c.memory].a, keys[c.memory].b, s.contact_origin[i] + to<Real>(c.points[k].lever_a),
                 s.seen[c.memory].normal, c.points[k].separation, memories[c.memory].points[k].normal});
    }
}

} // namespace

void publish_events(Data& w) {
    Scratch& s = w.scratch;
    const std::span<const ContactKey> keys = w.state.rows(w.m.contact_key);
    const std::span<ContactMemory> memories = w.state.rows(w.m.contact_memory);
    w.events.clear();
    for (const Scratch::Ended& ended : s.ended)
        w.events.push_back(event_of(w, ended.key, ended.flags, false));
    for (std::uint32_t i = 0; i < keys.size(); ++i) {
        const Scratch::Seen& seen = s.seen[i];
        const bool sensor = (memories[i].flags & dynamics::contact_sensor) != 0;
        const bool before = (memories[i].flags & dynamics::contact_touching) != 0;
        const bool now = seen.overlaps || (!sensor && was_hit(memories[i]));
        if (now)
            memories[i].flags |= dynamics::contact_touching;
        else
            memories[i].flags &= ~std::uint32_t{dynamics::contact_touching};
        if (now == before) continue;
        Event e = event_of(w, keys[i], memories[i].flags, now);
        if (now) {
            e.point = seen.point;
            if (!sensor) e.normal = seen.normal;
            e.approach_speed = seen.approach;
        }
        w.events.push_back(e);
    }
    std::sort(w.events.begin(), w.events.end(), [](const Event& x, const Event& y) {
        return std::tie(x.kind, x.shape_a, x.shape_b) < std::tie(y.kind, y.shape_a, y.shape_b);
    });
    publish_contact_points(w);
}

} // namespace lockstone::sim
