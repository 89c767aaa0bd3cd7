// The state rows that the solver reads and writes. Formats: lockstone/math/formats.h.
#pragma once

#include "lockstone/command.h"

#include <array>
#include <cstddef>
#include <span>

namespace lockstone::solve {

/// The identity of a body, and its links to other rows.
struct BodyInfo {
    BodyId id;
    std::uint64_t user_key;
    BodyKind kind;
    std::uint32_t first_shape; ///< shape slot + 1 of the newest shape, 0: none
    std::uint32_t first_joint; ///< joint slot + 1 of the newest joint, 0: none
    std::uint32_t traits;      ///< row of the table of BodyTraits
};

/// Mass data; computed from the shapes when they change.
struct BodyMass {
    Real mass;      ///< [kg]; 0: no mass, impulses do not move the body
    Vec3 center;    ///< centre of mass relative to the body's origin, in the body's axes [m]
    Vec3 gyration;  ///< principal gyration radii [m]
    Quat principal; ///< rotation from the body's axes to the principal axes
};

/// The properties of a body that commands and shapes set; the solver only reads them. Bodies with equal properties
/// share one row.
struct BodyTraits {
    BodyMass mass;
    Real linear_damping, angular_damping; ///< [1/s]
    Real gravity_scale, drag_scale;
    Real mass_override;         ///< [kg], 0: the mass comes from the shapes
    std::uint32_t locks;        ///< AxisLock bits
    std::uint8_t gyroscopic;    ///< 0 or 1
    std::uint8_t enable_fields; ///< 0 or 1
    std::uint8_t bullet;        ///< 0 or 1
    std::uint8_t mass_fixed;    ///< 1: a command set the mass
};

/// Masses by row of the body columns.
struct MassView {
    std::span<const BodyInfo> info;
    std::span<const BodyTraits> traits;

    std::size_t size() const { return info.size(); }
    const BodyMass& operator[](std::size_t row) const { return traits[info[row].traits].mass; }
};

/// Velocity of the centre of mass [m/s], and angular velocity [rad/s].
struct Velocity {
    SpeedVec3 linear, angular;
    friend constexpr bool operator==(const Velocity&, const Velocity&) = default;
};

/// The rest of a body, and its sleeping island.
struct BodySleep {
    std::uint32_t still_ticks; ///< consecutive still ticks, see Stillness in tick/islands.cpp
    /// Body slot + 1 of the sleeping island's first body, 0: awake; kept until the wake event is reported
    std::uint32_t island;
    std::uint32_t next; ///< body slot + 1 of the next body of the sleeping island, in a ring; 0: awake
    /// Sum of the displacements of the still ticks, each times the tick rate [tick m/s, tick rad/s]
    Velocity moved;
};
/// Starts the count of still ticks again.
constexpr void restart(BodySleep& sleep) {
    sleep.still_ticks = 0;
    sleep.moved = {};
}

/// Forces that commands sum up for the next tick, which removes the row.
struct BodyForce {
    Vec3 force, torque; ///< [N], [N m] about the centre of mass
};

/// Forces by row of the body columns.
struct ForceView {
    std::span<const std::uint32_t> pushes; ///< by row of the body columns: row + 1 in `forces`, 0: none
    std::span<const BodyForce> forces;

    const BodyForce& operator[](std::size_t row) const {
        static constexpr BodyForce none{};
        // 0 becomes the largest number, which is no row. A push whose force was removed refers to no row either.
        const std::uint32_t at = pushes[row] - 1;
        return at < forces.size() ? forces[at] : none;
    }
};

/// The pair of a contact, in slot order: a.index < b.index. A pair with several manifolds has one row for each, and
/// these rows are adjacent.
struct ContactKey {
    ShapeId a, b;
    friend constexpr bool operator==(const ContactKey&, const ContactKey&) = default;
};

/// One point of a manifold, and the impulse per substep that holds it, divided by the reduced mass of the two bodies.
struct ContactPointMemory {
    /// From shape B's origin, in shape A's axes [m]; identifies the point in the next tick when its feature has changed
    LengthVec3 position;
    std::uint32_t feature;
    Separation separation; ///< when the manifold was made [m]
    Speed normal;          ///< impulse along the normal [m/s]
};

/// Flags of a contact. Flags of the pair are equal in all its rows, except contact_touching.
enum ContactFlags : std::uint32_t {
    /// of the pair, in its first row; only sim::touched() and settle_touching() read it
    contact_touching = 1,
    contact_sensor = 2,      ///< of the pair: one of the shapes is a sensor
    contact_sensor_is_b = 4, ///< of the pair: the sensor is the key's b
    contact_flipped = 8,     ///< of the pair: the manifold's shape A is the key's b
    /// of the pair: the shapes pass through each other, since one is one-way, until they are apart
    contact_passing = 16,
    contact_on_face = 32, ///< of the row: collide::Manifold::on_face
    contact_hit = 64, ///< of the row: it stopped its bodies in this tick; cleared when the events are written
};

/// The data that a contact keeps from tick to tick: the manifold, the relative pose when it was made, and the impulses.
/// While the relative pose of the shapes stays the same, the manifold is recycled, so all of this is state. The tick
/// works on these rows; the state stores them as ContactRow, ContactPointMemory and ContactMore: model/contact_rows.h.
struct alignas(64) ContactMemory {
    std::uint32_t flags;          ///< ContactFlags
    std::uint32_t count;          ///< points in use; the others are zero
    CoordinateVec3 made_position; ///< of B's origin in A's frame when the manifold was made [m]
    Quat made_rotation;           ///< B's axes in A's axes when the manifold was made
    UnitVec3 normal;              ///< from A to B, in A's axes
    Length margin;                ///< speculative margin when the manifold was made [m]
    Speed tangent_1, tangent_2;   ///< friction impulse per substep along the tangents of tangents_of() [m/s]
    Length twist;                 ///< friction impulse about the normal [m^2/s]
    SpeedVec3 rolling;            ///< angular impulse against rolling, world axes, as in solve::Rolling
    // For shapes of several pieces; see collide::Manifold.
    std::uint32_t piece_a;                    ///< triangle or part of A
    std::uint32_t piece_b;                    ///< part of B
    std::array<ContactPointMemory, 4> points; ///< last member: most contacts have few
};

/// The data that the state stores of every ContactMemory. Its points are the next `count` rows of the table of points,
/// and its rare data is the next row of ContactMore, where contact_has_more is set: the rows of the three tables have
/// the same order. The layout from made_rotation to twist is that of ContactMemory.
struct ContactRow {
    std::uint16_t flags;      ///< ContactFlags, contact_has_more
    std::uint16_t count;      ///< points, 1 to 4
    LengthVec3 made_position; ///< modulo 256 m: see ContactMore::beyond
    Quat made_rotation;
    UnitVec3 normal;
    Length margin;
    Speed tangent_1, tangent_2;
    Length twist;
};
inline constexpr std::uint16_t contact_has_more = 128; ///< the contact has a row of ContactMore

/// Rare data of contacts: of large distances, of surfaces with rolling resistance, and of shapes of several pieces.
struct ContactMore {
    /// Multiples of 256 m to add to made_position, which is within 128 m along each axis
    std::array<std::int32_t, 3> beyond;
    SpeedVec3 rolling;
    std::uint32_t piece_a, piece_b;
};

/// A joint as commands made or changed it, and its position in the lists of its bodies.
struct JointRow {
    JointId id;
    JointDef def;
    std::uint32_t next_a, next_b; ///< next joint of body A, of body B: slot + 1, 0: last
};

/// Impulses of one axis per substep, lambda (1/mA + 1/mB) [m/s] or [m^2/s].
struct JointAxisImpulses {
    Real spring;       ///< impulse of the spring or of the lock
    Real motor;        ///< impulse of the motor and of friction
    Real lower, upper; ///< impulses of the limits: lower at least zero, upper at most zero
};

/// The impulses that a joint keeps from tick to tick, and its forces in the last tick.
struct JointMemory {
    std::array<JointAxisImpulses, joint_axis_count> axis;
    Real swing;         ///< impulse of the cone, at most zero
    Real twist;         ///< angle about x including whole turns; for gears and racks their error
    Vec3 force, torque; ///< on B at its frame [N], [N m]: means over the tick
};

template <class V> constexpr void describe(BodyInfo& b, V&& v) {
    v("id", b.id), v("user_key", b.user_key), v("kind", b.kind), v("first_shape", b.first_shape);
    v("first_joint", b.first_joint), v("traits", b.traits);
}
template <class V> constexpr void describe(BodyMass& m, V&& v) {
    v("mass", m.mass), v("center", m.center), v("gyration", m.gyration), v("principal", m.principal);
}
template <class V> constexpr void describe(BodyTraits& t, V&& v) {
    v("mass", t.mass), v("linear_damping", t.linear_damping), v("angular_damping", t.angular_damping);
    v("gravity_scale", t.gravity_scale), v("drag_scale", t.drag_scale);
    v("mass_override", t.mass_override), v("locks", t.locks), v("gyroscopic", t.gyroscopic);
    v("enable_fields", t.enable_fields), v("bullet", t.bullet), v("mass_fixed", t.mass_fixed);
}
template <class V> constexpr void describe(Velocity& x, V&& v) {
    v("linear", x.linear), v("angular", x.angular);
}
template <class V> constexpr void describe(BodySleep& s, V&& v) {
    v("still_ticks", s.still_ticks), v("island", s.island), v("next", s.next), v("moved", s.moved);
}
template <class V> constexpr void describe(BodyForce& f, V&& v) {
    v("force", f.force), v("torque", f.torque);
}
template <class V> constexpr void describe(ContactKey& k, V&& v) { v("a", k.a), v("b", k.b); }
template <class V> constexpr void describe(ContactRow& r, V&& v) {
    v("flags", r.flags), v("count", r.count), v("made_position", r.made_position);
    v("made_rotation", r.made_rotation), v("normal", r.normal), v("margin", r.margin);
    v("tangent_1", r.tangent_1), v("tangent_2", r.tangent_2), v("twist", r.twist);
}
template <class V> constexpr void describe(ContactPointMemory& p, V&& v) {
    v("position", p.position), v("feature", p.feature), v("separation", p.separation), v("normal", p.normal);
}
template <class V> constexpr void describe(ContactMore& m, V&& v) {
    v("beyond", m.beyond), v("rolling", m.rolling), v("piece_a", m.piece_a), v("piece_b", m.piece_b);
}
template <class V> constexpr void describe(JointRow& r, V&& v) {
    v("id", r.id), v("def", r.def), v("next_a", r.next_a), v("next_b", r.next_b);
}
template <class V> constexpr void describe(JointAxisImpulses& a, V&& v) {
    v("spring", a.spring), v("motor", a.motor), v("lower", a.lower), v("upper", a.upper);
}
template <class V> constexpr void describe(JointMemory& m, V&& v) {
    v("axis", m.axis), v("swing", m.swing), v("twist", m.twist), v("force", m.force), v("torque", m.torque);
}

static_assert(StateRow<JointRow> && StateRow<JointMemory>);
static_assert(StateRow<BodyInfo> && StateRow<BodyTraits> && StateRow<Velocity> && StateRow<BodyForce> &&
              StateRow<BodySleep>);
static_assert(StateRow<ContactKey> && StateRow<ContactRow> && StateRow<ContactPointMemory> &&
              StateRow<ContactMore>);
static_assert(sizeof(ContactRow) == 60 && sizeof(ContactPointMemory) == 24 && sizeof(ContactMore) == 32);
static_assert(sizeof(Transform) + sizeof(Velocity) == 64, "the hot motion state of a body is one cache line");

} // namespace lockstone::solve
