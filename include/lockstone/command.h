// Definitions, ids and commands: everything that can change a world from outside.
//
// Every public mutator of World builds one of these commands and hands it to World::apply. A journal attached there
// sees the whole story of a world; applying the same commands between the same ticks gives the same bits.
#pragma once

#include "lockstone/field.h"
#include "lockstone/joint.h"
#include "lockstone/play/character.h"
#include "lockstone/play/vehicle.h"
#include "lockstone/shape.h"

#include <array>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <variant>

namespace lockstone {

enum class BodyKind : std::uint32_t {
    static_,   ///< never moves but by command; infinite mass
    kinematic, ///< moves at its velocity, pushed by nothing
    dynamic,   ///< moves under forces and contacts
};

/// Bits of BodyDef::locks: motion along or about a world axis that never happens. Velocity given along or about it is dropped.
enum AxisLock : std::uint32_t {
    lock_linear_x = 1,
    lock_linear_y = 2,
    lock_linear_z = 4,
    lock_angular_x = 8,
    lock_angular_y = 16,
    lock_angular_z = 32,
    lock_planar_xy = lock_linear_z | lock_angular_x | lock_angular_y, ///< 2D play in the x-y plane
};

struct BodyDef {
    BodyKind kind = BodyKind::dynamic;
    std::uint32_t locks = 0;                ///< AxisLock bits
    Transform pose = Transform::identity(); ///< of the body's origin [m]
    Vec3 linear_velocity{};                 ///< of the centre of mass [m/s], |v| <= 500
    Vec3 angular_velocity{};                ///< [rad/s], each component within 4095
    Real linear_damping{};                  ///< [1/s], 0..1000: v decays as exp(-damping t) to first order
    Real angular_damping{};                 ///< [1/s], 0..1000
    Real gravity_scale = Real(1);           ///< times the world's gravity, -100..100
    Real drag_scale = Real(1);              ///< times the drag of fluids, 0..100
    Real mass{};                            ///< [kg]; 0: from the shapes' densities. 1e-3..1e9
    std::uint32_t gyroscopic = 1; ///< 0: skip the gyroscopic term (angular velocity kept instead of momentum)
    std::uint32_t enable_fields = 1; ///< 0: force fields do not act on it
    /// 1: never passes through dynamic bodies either, and reports each sensor that it crosses within a tick (sensor_begin and sensor_end
    /// of the same tick). Costs a sweep in each tick in which the body is fast.
    std::uint32_t bullet = 0;
    /// 0: a dynamic body starts asleep, without velocity; create_shape, and what is made beside it and does not move, leave it so.
    /// Other commands wake it, and what comes. Until then it has no contacts: it does not notice that what it stands on goes.
    /// In a world without sleeping it starts awake.
    std::uint32_t awake = 1;
    std::uint64_t user_key = 0; ///< the game's own; hashed, never read
};

/// How a pair's coefficient follows from those of its two shapes. Of two different rules the one further down holds.
enum class Mix : std::uint32_t { geometric_mean, average, minimum, multiply, maximum };

/// Where on a shape something touches it.
struct SurfacePart {
    /// Triangle of MeshDef::triangles; cell of a height field, row * (columns - 1) + column; part of a compound; else 0
    std::uint32_t source;
    /// Of the triangle or cell; where that is 0, and of other shapes, ShapeDef::material
    std::uint32_t material;
    friend bool operator==(const SurfacePart&, const SurfacePart&) = default;
};
template <class V> constexpr void describe(SurfacePart& p, V&& v) {
    v("source", p.source), v("material", p.material);
}

struct ShapeDef {
    Geometry geometry = sphere(0.5_r);
    Transform local = Transform::identity(); ///< the shape's frame in the body's; within 64 m of the origin
    Real density = Real(1000);               ///< [kg/m^3], 0.01..1e5
    Real friction = 0.6_r;                   ///< Coulomb coefficient, 0..4
    Real restitution{};                      ///< 0..1
    /// [m], 0..1: a pair's larger one, times the normal force, is the torque that brakes turning against each other
    Real rolling_resistance{};
    Vec3 surface_velocity{}; ///< of a conveyor's surface, in the shape's axes [m/s], each within 100
    Mix friction_mix = Mix::geometric_mean;
    Mix restitution_mix = Mix::maximum;
    std::uint32_t material = 0;       ///< the game's own name for what it is made of; hashed, never read
    std::uint32_t category = 1;       ///< bits it is
    std::uint32_t mask = 0xffffffffu; ///< bits it meets: a pair needs category & mask both ways
    std::int32_t group = 0;           ///< same group: positive always meet, negative never
    std::uint32_t sensor = 0;         ///< 1: reports overlaps, touches nothing
    std::uint32_t one_way =
        0; ///< 1: stops only what comes from the side of its local +y; the rest passes until it
           ///< is out again
    std::uint64_t user_key = 0;
};

// ---- commands ------------------------------------------------------------------------------------------------

/// A large definition in memory of its own, so that every command is not as large as the largest. A value all the same: a copy
/// has another. Reached by * and ->; what was moved from has none until it is assigned to.
template <class T> class Indirect {
  public:
    constexpr Indirect() : value(new T{}) {}
    constexpr Indirect(const T& of) : value(new T(of)) {}
    constexpr Indirect(const Indirect& other) : value(other.value != nullptr ? new T(*other) : nullptr) {}
    constexpr Indirect(Indirect&& other) noexcept : value(std::exchange(other.value, nullptr)) {}
    constexpr Indirect& operator=(Indirect other) noexcept {
        std::swap(value, other.value);
        return *this;
    }
    constexpr ~Indirect() { delete value; }

    constexpr T& operator*() { return *value; }
    constexpr const T& operator*() const { return *value; }
    constexpr T* operator->() { return value; }
    constexpr const T* operator->() const { return value; }

  private:
    T* value;
};

struct CreateBody {
    BodyDef def;
};
struct DestroyBody {
    BodyId body;
};
struct CreateShape {
    BodyId body;
    ShapeDef def;
};
struct DestroyShape {
    ShapeId shape;
};
struct CreateField {
    FieldDef def;
};
struct DestroyField {
    FieldId field;
};
struct SetPose {
    BodyId body;
    Transform pose;
};
struct SetVelocity {
    BodyId body;
    Vec3 linear, angular;
};
/// Forces and torques act for the next tick only. Force at the centre of mass [N], torque [N m].
struct AddForce {
    BodyId body;
    Vec3 force, torque;
};
/// Force [N] at a world point [m].
struct AddForceAt {
    BodyId body;
    Vec3 force, point;
};
/// Linear impulse [N s] at the centre of mass and angular impulse [N m s]: velocity changes at once.
struct AddImpulse {
    BodyId body;
    Vec3 linear, angular;
};
struct AddImpulseAt {
    BodyId body;
    Vec3 impulse, point;
};
/// A setting of a command that may leave it as it is: what the game does not name does not change.
template <class T> struct Change {
    using Given = std::conditional_t<sizeof(T) % 8 == 0, std::uint64_t, std::uint32_t>; ///< fills the row
    T value{};
    Given given = 0; ///< 1: from now on it is `value`; 0: it stays

    constexpr Change() = default;
    constexpr Change(T to) : value(to), given(1) {}
    constexpr T or_else(T now) const { return given != 0 ? value : now; }
};
/// See BodyDef for units and limits.
struct SetBodyParameters {
    BodyId body;
    Change<Real> linear_damping{}, angular_damping{}, gravity_scale{};
    Change<std::uint32_t> locks{}, gyroscopic{}, bullet{}, enable_fields{};
    Change<Real> drag_scale{};
};
/// See ShapeDef.
struct SetMaterial {
    ShapeId shape;
    Change<Real> friction{}, restitution{}, rolling_resistance{};
    Change<Vec3> surface_velocity{};
};
/// What a shape is and meets; see ShapeDef.
struct SetFilter {
    ShapeId shape;
    Change<std::uint32_t> category{}, mask{};
    Change<std::int32_t> group{};
};
/// Whether two bodies may touch at all; 1 is where every pair starts. Ends with either body.
struct SetPairFilter {
    BodyId a, b;
    std::uint32_t collide; ///< 0 or 1
};
/// Overrides what follows from the shapes, until it is called with a mass of 0. What it does not name is from then on
/// what it was, whatever becomes of the shapes.
struct SetMass {
    BodyId body;
    Change<Real> mass{};      ///< [kg], 1e-3..1e9; 0: all from the shapes again, and the rest is ignored
    Change<Vec3> center{};    ///< of mass, from the body's origin in its axes [m], within 64
    Change<Vec3> gyration{};  ///< principal radii of gyration, sqrt(inertia / mass) [m], 0.001..100
    Change<Quat> principal{}; ///< turns the body's axes into the principal axes
};
struct SetGravity {
    Vec3 gravity;
};
struct WakeBody {
    BodyId body;
};
struct CreateJoint {
    Indirect<JointDef> def;
};
struct DestroyJoint {
    JointId joint;
};
/// Limits, spring, motor and friction of one axis, anew.
struct SetJointAxis {
    JointId joint;
    std::uint32_t index; ///< JointAxisIndex
    std::uint32_t reserved;
    JointAxis axis;
};
/// Where a joint holds its bodies: moves a mouse joint's target, turns a motor joint's.
struct SetJointFrames {
    JointId joint;
    Transform frame_a, frame_b; ///< as in JointDef
};
struct CreateVehicle {
    Indirect<VehicleDef> def;
};
struct DestroyVehicle {
    VehicleId vehicle;
};
struct SetVehicleInput {
    VehicleId vehicle;
    VehicleInput input;
};
/// Makes its body and its shape too.
struct CreateCharacter {
    CharacterDef def;
};
/// With its body and all that belongs to that.
struct DestroyCharacter {
    CharacterId character;
};
/// Holds until the next one.
struct SetCharacterInput {
    CharacterId character;
    CharacterInput input;
};
/// A field as it is to be from now on.
struct SetField {
    FieldId field;
    FieldDef def;
};
/// Velocities change at once, and what is hit wakes.
struct Explode {
    ExplosionDef def;
};
/// A piece of a row of a game column, at most 64 bytes in canonical order. World::write cuts longer rows up.
struct WriteGame {
    std::uint32_t column; ///< of the game schema
    std::uint32_t size;   ///< bytes used of data
    BodyId body;          ///< null for records
    std::uint64_t offset; ///< of the first byte in the canonical row
    std::array<std::uint8_t, 64> data;
};

using Command =
    std::variant<CreateBody, DestroyBody, CreateShape, DestroyShape, CreateField, DestroyField, SetPose,
                 SetVelocity, AddForce, AddForceAt, AddImpulse, AddImpulseAt, SetBodyParameters, SetMaterial,
                 SetGravity, WriteGame, SetFilter, SetPairFilter, SetMass, CreateJoint, DestroyJoint,
                 SetJointAxis, SetJointFrames, WakeBody, CreateVehicle, DestroyVehicle, SetVehicleInput,
                 CreateCharacter, DestroyCharacter, SetCharacterInput, SetField, Explode>;
static_assert(sizeof(Command) <= 224, "a large definition goes into an Indirect");
/// Name of a command's kind, as in FORMAT.md and diffs: "create_body".
const char* name_of(const Command& command);

// ---- field lists: the wire order of every command ---------------------------------------------------------------

template <class V> constexpr void describe(AssetId& id, V&& v) { v("value", id.value); }
template <class V> constexpr void describe(Geometry& g, V&& v) {
    v("kind", g.kind), v("radius", g.radius), v("half_extent", g.half_extent), v("scale", g.scale);
    v("asset", g.asset);
}
template <class V> constexpr void describe(BodyDef& d, V&& v) {
    field(v, "kind", d.kind, in(0, 2));
    field(v, "locks", d.locks, BitsOf{63, "AxisLock"});
    field(v, "pose", d.pose, PoseIn{Real(1000000000)});
    field(v, "linear_velocity", d.linear_velocity, LongAtMost{Real(500), "500 m/s"});
    field(v, "angular_velocity", d.angular_velocity, EachIn{Real(4095), "rad/s"});
    field(v, "linear_damping", d.linear_damping, in(0_r, 1000_r, " 1/s"));
    field(v, "angular_damping", d.angular_damping, in(0_r, 1000_r, " 1/s"));
    field(v, "gravity_scale", d.gravity_scale, in(-100_r, 100_r));
    field(v, "drag_scale", d.drag_scale, in(0_r, 100_r));
    v("mass", d.mass);
    field(v, "gyroscopic", d.gyroscopic, no_or_yes);
    field(v, "enable_fields", d.enable_fields, no_or_yes);
    field(v, "bullet", d.bullet, no_or_yes);
    field(v, "awake", d.awake, no_or_yes);
    v("user_key", d.user_key);
}
template <class V> constexpr void describe(ShapeDef& d, V&& v) {
    v("geometry", d.geometry);
    field(v, "local", d.local, PoseIn{Real(64)});
    field(v, "density", d.density, in(0.01_r, 100000_r, " kg/m^3"));
    field(v, "friction", d.friction, in(0_r, 4_r));
    field(v, "restitution", d.restitution, in(0_r, 1_r));
    field(v, "rolling_resistance", d.rolling_resistance, in(0_r, 1_r, " m"));
    field(v, "surface_velocity", d.surface_velocity, EachIn{Real(100), "m/s"});
    field(v, "friction_mix", d.friction_mix, in(0, 4));
    field(v, "restitution_mix", d.restitution_mix, in(0, 4));
    v("material", d.material), v("category", d.category), v("mask", d.mask), v("group", d.group);
    field(v, "sensor", d.sensor, no_or_yes);
    field(v, "one_way", d.one_way, no_or_yes);
    v("user_key", d.user_key);
}
template <class V> constexpr void describe(CreateBody& c, V&& v) { v("def", c.def); }
template <class V> constexpr void describe(DestroyBody& c, V&& v) { v("body", c.body); }
template <class V> constexpr void describe(CreateShape& c, V&& v) { v("body", c.body), v("def", c.def); }
template <class V> constexpr void describe(DestroyShape& c, V&& v) { v("shape", c.shape); }
template <class V> constexpr void describe(CreateField& c, V&& v) { v("def", c.def); }
template <class V> constexpr void describe(DestroyField& c, V&& v) { v("field", c.field); }
template <class V> constexpr void describe(SetPose& c, V&& v) { v("body", c.body), v("pose", c.pose); }
template <class V> constexpr void describe(SetVelocity& c, V&& v) {
    v("body", c.body), v("linear", c.linear), v("angular", c.angular);
}
template <class V> constexpr void describe(AddForce& c, V&& v) {
    v("body", c.body), v("force", c.force), v("torque", c.torque);
}
template <class V> constexpr void describe(AddForceAt& c, V&& v) {
    v("body", c.body), v("force", c.force), v("point", c.point);
}
template <class V> constexpr void describe(AddImpulse& c, V&& v) {
    v("body", c.body), v("linear", c.linear), v("angular", c.angular);
}
template <class V> constexpr void describe(AddImpulseAt& c, V&& v) {
    v("body", c.body), v("impulse", c.impulse), v("point", c.point);
}
template <class T, class V> constexpr void describe(Change<T>& c, V&& v) {
    v("value", c.value), v("given", c.given);
}
template <class V> constexpr void describe(SetBodyParameters& c, V&& v) {
    v("body", c.body), v("linear_damping", c.linear_damping), v("angular_damping", c.angular_damping);
    v("gravity_scale", c.gravity_scale), v("locks", c.locks), v("gyroscopic", c.gyroscopic);
    v("bullet", c.bullet), v("enable_fields", c.enable_fields), v("drag_scale", c.drag_scale);
}
template <class V> constexpr void describe(SetMaterial& c, V&& v) {
    v("shape", c.shape), v("friction", c.friction), v("restitution", c.restitution);
    v("rolling_resistance", c.rolling_resistance), v("surface_velocity", c.surface_velocity);
}
template <class V> constexpr void describe(SetFilter& c, V&& v) {
    v("shape", c.shape), v("category", c.category), v("mask", c.mask), v("group", c.group);
}
template <class V> constexpr void describe(SetPairFilter& c, V&& v) {
    v("a", c.a), v("b", c.b), v("collide", c.collide);
}
template <class V> constexpr void describe(SetMass& c, V&& v) {
    v("body", c.body), v("mass", c.mass), v("center", c.center), v("gyration", c.gyration);
    v("principal", c.principal);
}
template <class V> constexpr void describe(WakeBody& c, V&& v) { v("body", c.body); }
template <class V> constexpr void describe(CreateJoint& c, V&& v) { v("def", *c.def); }
template <class V> constexpr void describe(DestroyJoint& c, V&& v) { v("joint", c.joint); }
template <class V> constexpr void describe(SetJointAxis& c, V&& v) {
    v("joint", c.joint), v("index", c.index), v("reserved", c.reserved), v("axis", c.axis);
}
template <class V> constexpr void describe(SetJointFrames& c, V&& v) {
    v("joint", c.joint), v("frame_a", c.frame_a), v("frame_b", c.frame_b);
}
template <class V> constexpr void describe(CreateVehicle& c, V&& v) { v("def", *c.def); }
template <class V> constexpr void describe(DestroyVehicle& c, V&& v) { v("vehicle", c.vehicle); }
template <class V> constexpr void describe(SetVehicleInput& c, V&& v) {
    v("vehicle", c.vehicle), v("input", c.input);
}
template <class V> constexpr void describe(CreateCharacter& c, V&& v) { v("def", c.def); }
template <class V> constexpr void describe(DestroyCharacter& c, V&& v) { v("character", c.character); }
template <class V> constexpr void describe(SetCharacterInput& c, V&& v) {
    v("character", c.character), v("input", c.input);
}
template <class V> constexpr void describe(SetField& c, V&& v) { v("field", c.field), v("def", c.def); }
template <class V> constexpr void describe(Explode& c, V&& v) { v("def", c.def); }
template <class V> constexpr void describe(SetGravity& c, V&& v) { v("gravity", c.gravity); }
template <class V> constexpr void describe(WriteGame& c, V&& v) {
    v("column", c.column), v("size", c.size), v("body", c.body), v("offset", c.offset), v("data", c.data);
}

} // namespace lockstone
