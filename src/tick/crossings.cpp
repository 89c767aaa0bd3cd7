// Detects bullets that enter and leave a sensor within one tick.
//
// The narrow phase compares poses at the start of a tick only, so it reports no passage that is over before the next
// tick. Games mark a body as a bullet so that no passage of it is lost. So the shapes of bullets are swept against
// the sensors near their path, with the poses at the end of the tick: a bullet that a wall stopped does not enter a
// sensor behind the wall.
#include "collide/query/cast_line.h"
#include "scene/surface.h"
#include "tick/sweeper.h"

namespace lockstone::sim {
namespace {

/// A pair of a sensor and a shape; one of the two belongs to a bullet.
struct Crossing {
    const ShapeRow &other, &shape; ///< `shape` belongs to the bullet
    std::uint32_t other_row, row;  ///< of their bodies
    Sweep theirs, way;
};

ContactKey key_of(const Crossing& c) {
    const ShapeId a = c.other.id, b = c.shape.id;
    return a.index < b.index ? ContactKey{a, b} : ContactKey{b, a};
}

bool touches_at_start(const ContactList& contacts, const ContactKey& key) {
    const auto is_before = [](const ContactKey& left, const ContactKey& right) {
        return left.a.index != right.a.index ? left.a.index < right.a.index : left.b.index < right.b.index;
    };
    const auto at = std::lower_bound(contacts.keys.begin(), contacts.keys.end(), key, is_before);
    if (at == contacts.keys.end() || *at != key) return false;
    return (contacts.memories[static_cast<std::size_t>(at - contacts.keys.begin())].flags &
            solve::contact_touching) != 0;
}

bool has_event(std::span<const Event> events, const Event& e) {
    return std::ranges::any_of(events, [&](const Event& old) {
        return (old.kind == EventKind::sensor_begin || old.kind == EventKind::sensor_end) &&
               old.shape_a == e.shape_a && old.shape_b == e.shape_b;
    });
}

Sweep reversed(const Sweep& s) { return {s.to, s.from, s.local}; }

/// The fraction of the tick at which the bullet enters, if it enters and leaves within the tick.
std::optional<Unit> entry_of(const Sweeper& s, const Crossing& c, collide::NarrowScratch& scratch) {
    const shapes::Solid &a = s.solid(c.other), &b = s.solid(c.shape);
    const Unit entry = collide::time_of_impact(a, c.theirs, b, c.way, Length{}, scratch);
    if (entry == Unit{} || entry == unit_one) return std::nullopt;
    const Unit exit = collide::time_of_impact(a, reversed(c.theirs), b, reversed(c.way), Length{}, scratch);
    if (exit == Unit{}) return std::nullopt; // the next tick reports the entry
    return entry;
}

SpeedVec3 velocity_at(const Sweeper& s, std::uint32_t row, Vec3 arm) {
    const Velocity& v = s.w.state.rows(s.w.m.body_velocity)[row];
    return v.linear + cross<Speed>(v.angular, to<Length>(arm));
}

/// The event of an entry.
Event entered(const Sweeper& s, const Crossing& c, Unit entry, collide::NarrowScratch& scratch) {
    const bool is_sensor = s.traits(c.other).sensor != 0;
    const Transform at_a = collide::pose_at(c.theirs, entry), at_b = collide::pose_at(c.way, entry);
    constexpr Coordinate limit = decimal<Coordinate>("0.01");
    collide::Nearest on_other{}, on_shape{};
    collide::nearest_points(s.solid(c.other), s.solid(c.shape), collide::relative_pose(at_a, at_b), limit,
                            scratch, on_other);
    if (!collide::has_triangles(s.solid(c.other)))
        collide::nearest_points(s.solid(c.shape), s.solid(c.other), collide::relative_pose(at_b, at_a), limit,
                                scratch, on_shape);
    Event e{};
    e.kind = EventKind::sensor_begin;
    e.shape_a = c.other.id, e.shape_b = c.shape.id;
    e.body_a = c.other.body, e.body_b = c.shape.body;
    e.point = at_a.position + rotate(at_a.rotation, to<Real>(on_other.on_a));
    const UnitVec3 normal = lockstone::mul<Unit>(to_rotation(at_a.rotation), on_other.normal);
    const Vec3 center_a = collide::body_pose_at(c.theirs, entry).position,
               center_b = collide::body_pose_at(c.way, entry).position;
    e.approach_speed = -dot<Speed>(
        velocity_at(s, c.row, e.point - center_b) - velocity_at(s, c.other_row, e.point - center_a), normal);
    e.part_a = part_of(s.w, s.placed, c.other.id, on_other.feature_a);
    e.part_b = part_of(s.w, s.placed, c.shape.id, on_shape.feature_a);
    if (!is_sensor)
        std::swap(e.shape_a, e.shape_b), std::swap(e.body_a, e.body_b), std::swap(e.part_a, e.part_b);
    e.tick = s.w.header().tick;
    return e;
}

/// The end event of a passage that began in the same tick. Like every end event it has no point and no parts.
Event left(const Event& begin) {
    Event e{};
    e.kind = EventKind::sensor_end;
    e.shape_a = begin.shape_a, e.shape_b = begin.shape_b;
    e.body_a = begin.body_a, e.body_b = begin.body_b;
    e.tick = begin.tick;
    return e;
}

/// Calls visit(shape) for each shape of a body, sensors included.
template <class Visit> void for_each_shape_and_sensor(const Sweeper& s, std::uint32_t row, Visit&& visit) {
    for (std::uint32_t slot = s.info[row].first_shape; slot != 0;) {
        const ShapeRow& shape = s.shapes[s.slots[slot - 1].row];
        slot = shape.next_shape;
        visit(shape);
    }
}

/// The greatest motion of any point of an awake body in the tick, sensors included [m].
Real motion_of_all(const Sweeper& s, std::uint32_t rows) {
    Real most{};
    for (std::uint32_t row = 0; row < rows; ++row) {
        if (s.pose_before(row) == s.pose[row]) continue;
        for_each_shape_and_sensor(s, row, [&](const ShapeRow& shape) {
            if (s.traits(shape).geometry.kind == ShapeKind::plane) return;
            most = max(most, collide::relative_motion(still, s.sweep(row, shape), s.reach(row, shape)));
        });
    }
    return most;
}

/// Calls visit(crossing) for each pair of a sensor and another shape whose relative motion is long enough for a
/// passage.
template <class Visit>
void for_each_candidate(const Sweeper& s, std::uint32_t row, SweepScratch& scratch, const Visit& visit) {
    const Transform &begin = s.pose_before(row), &end = s.pose[row];
    for_each_shape_and_sensor(s, row, [&](const ShapeRow& shape) {
        const shapes::Solid& solid = s.solid(shape);
        if (collide::has_triangles(solid) || solid.geometry.kind == ShapeKind::plane) return;
        collide::BroadPhase::Asker& near = scratch.workers[0].near;
        const Sweep way = find_near(s, {row, begin, end, Unit{}, Model::dead, end.position - begin.position},
                                    shape, Among::all, near);
        for (const std::uint32_t slot : near.proxies) {
            const ShapeRow& other = s.shapes[s.slots[slot].row];
            const std::uint32_t other_row = s.w.row_of(other.body);
            if ((s.traits(other).sensor != 0) == (s.traits(shape).sensor != 0) ||
                s.traits(other).geometry.kind == ShapeKind::plane)
                continue;
            const bool is_seen_twice = s.info[other_row].kind == BodyKind::dynamic &&
                                       s.is_bullet(other_row) && other_row < row &&
                                       s.pose_before(other_row) != s.pose[other_row];
            if (is_seen_twice || !may_meet(s.w, shape, other)) continue;
            const Sweep theirs = s.sweep(other_row, other);
            // Between two poses without overlap lies a motion longer than the inner radius of the shape.
            if (collide::relative_motion(theirs, way, s.reach(row, shape)) <= to<Real>(s.at(shape).inner))
                continue;
            visit(Crossing{other, shape, other_row, row, theirs, way});
        }
    });
}

} // namespace

void find_crossings(const Model& w, const PlacedShapes& placed, const PosesBefore& before,
                    const ContactList& contacts, NarrowWorker& narrow, SweepScratch& scratch,
                    std::vector<Event>& events) {
    Sweeper s(w, placed, before);
    const auto is_one = [](const auto& traits) { return traits.bullet != 0; };
    if (std::ranges::none_of(s.mass.traits, is_one)) return;
    if (std::ranges::none_of(s.shape_traits, [](const ShapeTraits& traits) { return traits.sensor != 0; }))
        return;
    const std::uint32_t rows = w.header().bodies_awake;
    s.motion_max = motion_of_all(s, rows);
    const std::size_t published = events.size();
    for (std::uint32_t row = 0; row < rows; ++row) {
        if (s.info[row].kind != BodyKind::dynamic || !s.is_bullet(row) || s.pose_before(row) == s.pose[row])
            continue;
        for_each_candidate(s, row, scratch, [&](const Crossing& c) {
            if (touches_at_start(contacts, key_of(c))) return;
            const std::optional<Unit> entry = entry_of(s, c, narrow.narrow);
            if (!entry) return;
            const Event begin = entered(s, c, *entry, narrow.narrow);
            if (has_event(std::span(events).first(published), begin)) return;
            events.push_back(begin), events.push_back(left(begin));
        });
    }
}

} // namespace lockstone::sim
