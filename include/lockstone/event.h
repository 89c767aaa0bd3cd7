// Events and contact points of a tick: arrays to read after it, in a documented total order.
#pragma once

#include "lockstone/command.h"

#include <tuple>

namespace lockstone {

/// Kind of an event. A tick has at most one event of a kind for each pair of shapes, joint, body or
/// character, and at most one contacts_dropped.
enum class EventKind : std::uint32_t {
    contact_begin, ///< two shapes touch that did not touch in the last tick
    contact_end,   ///< two shapes no longer touch, or one was destroyed
    sensor_begin,  ///< shape_b entered the sensor shape_a
    sensor_end,    ///< shape_b left the sensor shape_a; for a bullet perhaps in the tick in which it entered
    joint_break,   ///< the load of a joint exceeded break_force or break_torque; the joint is destroyed
    body_wake,     ///< body_a was asleep at the end of the last tick and is awake
    body_sleep,    ///< body_a fell asleep at the end of this tick
    character_landed, ///< the character of body_a landed on body_b; approach_speed is along its up direction
    /// contacts_max was reached and touching pairs were dropped, the last in pair order: these bodies pass
    /// through each other. World::faults() counts the pairs. Increase the limit. All other fields except
    /// `tick` are null.
    contacts_dropped,
};

/// An event of a tick. Ids may be dead: check them by World::is_alive().
struct Event {
    EventKind kind;         ///< selects the fields below that are set
    std::uint32_t reserved; ///< 0
    ShapeId shape_a,        ///< contacts: the smaller id; sensors: the sensor; character_landed: the capsule
        shape_b;            ///< the other shape
    BodyId body_a,          ///< body of shape_a (null: shape destroyed), or the body of the event
        body_b;             ///< body of shape_b as body_a, or the second body of the joint
    JointId joint;          ///< joint_break: the destroyed joint; else null
    /// Contact point, or centre of mass of body_b for joint_break, world [m]; else zero.
    Vec3 point;
    UnitVec3 normal;      ///< from a to b; zero for end and sensor events
    SurfacePart part_a,   ///< touched part of shape_a; zero except for contact_begin and sensor_begin
        part_b;           ///< touched part of shape_b, as part_a
    Speed approach_speed; ///< closing speed along the normal before the solver [m/s], positive: approach
    std::uint64_t tick;   ///< World::tick_count() before the tick of the event
};
/// Field list of Event; see lockstone/row.h.
template <class V> constexpr void describe(Event& e, V&& v) {
    v("kind", e.kind), v("reserved", e.reserved), v("shape_a", e.shape_a), v("shape_b", e.shape_b);
    v("body_a", e.body_a), v("body_b", e.body_b), v("joint", e.joint), v("point", e.point),
        v("normal", e.normal);
    v("part_a", e.part_a), v("part_b", e.part_b);
    v("approach_speed", e.approach_speed), v("tick", e.tick);
}

/// Total order of the events of a tick: by kind, shape_a, shape_b, joint, body_a, body_b. World::events(),
/// sessions and recordings use it. No two events of a tick are equal in it.
inline bool precedes(const Event& left, const Event& right) {
    return std::tie(left.kind, left.shape_a, left.shape_b, left.joint, left.body_a, left.body_b) <
           std::tie(right.kind, right.shape_a, right.shape_b, right.joint, right.body_a, right.body_b);
}

/// A contact point of the last tick, for drawing and reports. Its shapes may be dead.
struct ContactPoint {
    ShapeId shape_a,       ///< the shape with the smaller id
        shape_b;           ///< the other shape
    Vec3 point;            ///< at the start of the tick, world [m]
    UnitVec3 normal;       ///< from a to b
    Separation separation; ///< gap at the start of the tick [m], negative: overlap
    /// Normal impulse of the last substep, and of elastic impacts in the tick, divided by the reduced mass of the
    /// bodies [m/s]
    Speed impulse;
    SurfacePart part_a, ///< touched part of shape_a
        part_b;         ///< touched part of shape_b
};

} // namespace lockstone
