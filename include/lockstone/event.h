// What a tick reports, as arrays fetched after it, in a documented total order.
#pragma once

#include "lockstone/command.h"

#include <tuple>

namespace lockstone {

/// The events of one tick come in the order of `precedes`. A tick has at most one event of a kind per pair of shapes, joint, body or
/// character, and at most one contacts_dropped.
enum class EventKind : std::uint32_t {
    contact_begin, ///< two shapes touch that did not touch after the last tick
    contact_end,   ///< they no longer do, or one of them was destroyed
    sensor_begin,  ///< shape_b entered the sensor shape_a
    sensor_end, ///< shape_b left it. A bullet may enter and leave within one tick: then both events are of this tick
    joint_break, ///< a joint bore more than its break_force or break_torque and is gone
    body_wake,   ///< body_a was asleep when the last tick ended
    body_sleep,  ///< body_a fell asleep at the end of this tick
    character_landed, ///< a character, body_a, came down on body_b and stands; approach_speed: how fast, along its up
    /// Pairs that touch were dropped, the last in pair order, since contacts_max was reached: bodies fall through each
    /// other. All else of the event is null; World::faults counts the pairs. Give the world a higher limit.
    contacts_dropped,
};

struct Event {
    EventKind kind;
    std::uint32_t reserved;
    ShapeId shape_a, shape_b; ///< shape_a < shape_b for contacts; the sensor first for sensors
    /// Null where an end event's shape was destroyed, a dead id where the body was: ask is_alive.
    BodyId body_a, body_b;
    JointId joint;              ///< of joint_break, dead by then; else null
    Vec3 point;                 ///< world [m]; zero for end events
    UnitVec3 normal;            ///< from a to b; zero for end and sensor events
    SurfacePart part_a, part_b; ///< where they touch; zero but for contact_begin and sensor_begin
    Speed approach_speed;       ///< along the normal before the solve [m/s], positive when closing
    std::uint64_t tick;         ///< the tick that produced it: world.tick_count() before that tick
};
template <class V> constexpr void describe(Event& e, V&& v) {
    v("kind", e.kind), v("reserved", e.reserved), v("shape_a", e.shape_a), v("shape_b", e.shape_b);
    v("body_a", e.body_a), v("body_b", e.body_b), v("joint", e.joint), v("point", e.point),
        v("normal", e.normal);
    v("part_a", e.part_a), v("part_b", e.part_b);
    v("approach_speed", e.approach_speed), v("tick", e.tick);
}

/// The total order of the events of one tick: by kind, shape_a, shape_b, joint, body_a, body_b. World::events, sessions and recordings
/// use this order; no two events of one tick are equal in it.
inline bool precedes(const Event& left, const Event& right) {
    return std::tie(left.kind, left.shape_a, left.shape_b, left.joint, left.body_a, left.body_b) <
           std::tie(right.kind, right.shape_a, right.shape_b, right.joint, right.body_a, right.body_b);
}

/// A contact point, for drawing and reports. Its shapes may have been destroyed since the tick.
struct ContactPoint {
    ShapeId shape_a, shape_b;
    Vec3 point;
    UnitVec3 normal;       ///< a to b
    Separation separation; ///< [m] at the start of the tick
    Speed impulse;         ///< normal impulse over reduced mass, velocity units [m/s]
    SurfacePart part_a, part_b;
};

} // namespace lockstone
