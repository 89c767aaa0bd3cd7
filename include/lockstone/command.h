// Definitions and commands: everything that can change a world besides a tick and a restore.
//
// Every function that changes a World builds one of these commands and passes it to World::apply(). A journal
// receives all of them. Equal commands between equal ticks give equal bits.
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

/// Motion of a body.
enum class BodyKind : std::uint32_t {
    static_,   ///< moves by set_pose() only; infinite mass
    kinematic, ///< moves at its velocity; no force or contact changes it
    dynamic,   ///< moves under forces, contacts and joints
};

/// Bits of BodyDef::locks: disabled motion along or about a world axis. Velocity along or about it is set to
/// zero.
enum AxisLock : std::uint32_t {
    lock_linear_x = 1,                                                ///< no motion along x
    lock_linear_y = 2,                                                ///< no motion along y
    lock_linear_z = 4,                                                ///< no motion along z
    lock_angular_x = 8,                                               ///< no rotation about x
    lock_angular_y = 16,                                              ///< no rotation about y
    lock_angular_z = 32,                                              ///< no rotation about z
    lock_planar_xy = lock_linear_z | lock_angular_x | lock_angular_y, ///< 2D motion in the x-y plane
};

/// Definition of a body.
struct BodyDef {
    BodyKind kind = BodyKind::dynamic;      ///< static, kinematic or dynamic
    std::uint32_t locks = 0;                ///< AxisLock bits; 0: none
    Transform pose = Transform::identity(); ///< of the body's origin [m], within 1e9 on each axis
    Vec3 linear_velocity{};                 ///< of the centre of mass [m/s], |v| <= 500
    Vec3 angular_velocity{};                ///< [rad/s], each component within 4095
    /// [1/s], 0..1000: speed decays as exp(-damping t), to first order
    Real linear_damping{};
    Real angular_damping{};       ///< [1/s], 0..1000: as linear_damping
    Real gravity_scale = Real(1); ///< factor of the world's gravity, -100..100
    Real drag_scale = Real(1);    ///< factor of the drag of fluids, 0..100
    Real mass{};                  ///< [kg], 1e-3..1e9; 0: from the shapes. 1 kg without shapes
    /// 1: free rotation keeps angular momentum; 0: it keeps angular velocity (no gyroscopic torque).
    std::uint32_t gyroscopic = 1;
    std::uint32_t enable_fields = 1; ///< 0: force fields do not act on it
    /// 1: continuous collision against dynamic bodies too, and events for each sensor that it crosses within
    /// one tick. Costs a sweep in each tick in which the body is fast.
    std::uint32_t bullet = 0;
    /// 0: a dynamic body starts asleep; its velocity must be zero. create_shape() does not wake it, other
    /// commands on it and awake bodies that touch it do. Until it has been awake once it has no contacts, so
    /// it does not react when its support is removed. Ignored if the world has sleeping disabled.
    std::uint32_t awake = 1;
    std::uint64_t user_key = 0; ///< value for the game; hashed, not used
};

/// Rule that combines the coefficients of two shapes. If the two shapes have different rules, the later one
/// of this list applies.
enum class Mix : std::uint32_t {
    geometric_mean, ///< sqrt(a b)
    average,        ///< (a + b) / 2
    minimum,        ///< min(a, b)
    multiply,       ///< a b
    maximum         ///< max(a, b)
};

/// The part of a shape that is touched.
struct SurfacePart {
    /// Triangle: index into MeshDef::triangles. Height field: cell, row * (columns - 1) + column. Compound:
    /// part. Other shapes: 0.
    std::uint32_t source;
    /// Material of the triangle or cell; ShapeDef::material if that is 0 or the shape has neither.
    std::uint32_t material;
    /// Equal source and material.
    friend bool operator==(const SurfacePart&, const SurfacePart&) = default;
};
/// Field list of SurfacePart; see lockstone/row.h.
template <class V> constexpr void describe(SurfacePart& p, V&& v) {
    v("source", p.source), v("material", p.material);
}

/// Definition of a shape: geometry, surface and collision filter.
struct ShapeDef {
    Geometry geometry = sphere(0.5_r);       ///< kind and size; see lockstone/shape.h
    Transform local = Transform::identity(); ///< frame in the body's axes [m], within 64 on each axis
    Real density = Real(1000);               ///< [kg/m^3], 0.01..1e5; a sensor has no mass
    Real friction = 0.6_r;                   ///< Coulomb coefficient, 0..4
    Real restitution{};                      ///< coefficient of restitution, 0..1
    /// Lever of rolling resistance [m], 0..1. The pair's larger one times the normal force is the maximum
    /// torque against rolling.
    Real rolling_resistance{};
    /// Velocity of the surface relative to the body [m/s], shape axes, each component within 100: conveyor
    /// belts.
    Vec3 surface_velocity{};
    Mix friction_mix = Mix::geometric_mean; ///< rule for the friction of a pair
    Mix restitution_mix = Mix::maximum;     ///< rule for the restitution of a pair
    std::uint32_t material = 0;             ///< material number of the game; in events, hashed, not used
    std::uint32_t category = 1;             ///< category bits of this shape
    /// Categories that it collides with. Two shapes collide if each one's mask has a category bit of the
    /// other.
    std::uint32_t mask = 0xffffffffu;
    /// Two shapes with the same group other than 0: positive always collide, negative never. Categories,
    /// masks and pair filters do not apply to them.
    std::int32_t group = 0;
    std::uint32_t sensor = 0; ///< 1: reports overlaps and has no contacts; sensors do not see sensors
    /// 1: only contacts whose normal is within 60 degrees of the shape's local +y are solid. A shape that
    /// arrives from another side passes until it no longer touches.
    std::uint32_t one_way = 0;
    std::uint64_t user_key = 0; ///< value for the game; hashed, not used
};

// ---- commands ---------------------------------------------------------------------------------------------

/// A large definition on the heap, so that Command remains small. It behaves as a value: a copy has its own
/// memory. A moved-from object is empty until it is assigned to; do not dereference it.
template <class T> class Indirect {
  public:
    constexpr Indirect() : value(new T{}) {}              ///< A default value.
    constexpr Indirect(const T& of) : value(new T(of)) {} ///< A copy of `of`.
    /// A copy.
    constexpr Indirect(const Indirect& other) : value(other.value != nullptr ? new T(*other) : nullptr) {}
    /// Moves; `other` is empty afterwards.
    constexpr Indirect(Indirect&& other) noexcept : value(std::exchange(other.value, nullptr)) {}
    /// Replaces the value.
    constexpr Indirect& operator=(Indirect other) noexcept {
        std::swap(value, other.value);
        return *this;
    }
    constexpr ~Indirect() { delete value; }

    constexpr T& operator*() { return *value; }             ///< The value.
    constexpr const T& operator*() const { return *value; } ///< The value.
    constexpr T* operator->() { return value; }             ///< A member of the value.
    constexpr const T* operator->() const { return value; } ///< A member of the value.

  private:
    T* value;
};

/// See World::create_body().
struct CreateBody {
    BodyDef def; ///< the body
};
/// See World::destroy().
struct DestroyBody {
    BodyId body; ///< destroyed with its shapes and joints
};
/// See World::create_shape().
struct CreateShape {
    BodyId body;  ///< gets the shape
    ShapeDef def; ///< the shape
};
/// See World::destroy().
struct DestroyShape {
    ShapeId shape; ///< destroyed
};
/// See World::create_field().
struct CreateField {
    FieldDef def; ///< the force field
};
/// See World::destroy().
struct DestroyField {
    FieldId field; ///< destroyed
};
/// Teleports a body.
struct SetPose {
    BodyId body;    ///< changed
    Transform pose; ///< of its origin [m], within 1e9 on each axis
};
/// Sets both velocities of a body.
struct SetVelocity {
    BodyId body; ///< changed
    Vec3 linear, ///< of the centre of mass [m/s], at most 500 long
        angular; ///< [rad/s], each component within 4095
};
/// Adds a force and a torque for the next tick only.
struct AddForce {
    BodyId body; ///< pushed
    Vec3 force,  ///< at the centre of mass [N], each component within 2e9
        torque;  ///< [N m], each component within 2e9
};
/// Adds a force at a point for the next tick only.
struct AddForceAt {
    BodyId body; ///< pushed
    Vec3 force,  ///< [N], each component within 2e9
        point;   ///< world [m], within 1e9 on each axis
};
/// Changes the velocities of a body at once.
struct AddImpulse {
    BodyId body; ///< pushed
    Vec3 linear, ///< impulse at the centre of mass [N s], each component within 2e9
        angular; ///< angular impulse [N m s], each component within 2e9
};
/// Changes the velocities of a body at once, by an impulse at a point.
struct AddImpulseAt {
    BodyId body;  ///< pushed
    Vec3 impulse, ///< [N s], each component within 2e9
        point;    ///< world [m], within 1e9 on each axis
};
/// An optional new value of a setting. Default: the setting keeps its value.
template <class T> struct Change {
    /// Integer type of `given`, so that the row has no padding.
    using Given = std::conditional_t<sizeof(T) % 8 == 0, std::uint64_t, std::uint32_t>;
    T value{};       ///< the new value
    Given given = 0; ///< 1: set to `value`; 0: no change

    constexpr Change() = default;                   ///< No change.
    constexpr Change(T to) : value(to), given(1) {} ///< A change to `to`.
    /// The new value, or `now` without a change.
    constexpr T or_else(T now) const { return given != 0 ? value : now; }
};
/// Changes settings of a body. Units and ranges as in BodyDef.
struct SetBodyParameters {
    BodyId body;                   ///< changed
    Change<Real> linear_damping{}, ///< BodyDef::linear_damping
        angular_damping{},         ///< BodyDef::angular_damping
        gravity_scale{};           ///< BodyDef::gravity_scale
    Change<std::uint32_t> locks{}, ///< BodyDef::locks
        gyroscopic{},              ///< BodyDef::gyroscopic
        bullet{},                  ///< BodyDef::bullet
        enable_fields{};           ///< BodyDef::enable_fields
    Change<Real> drag_scale{};     ///< BodyDef::drag_scale
};
/// Changes the surface of a shape. Units and ranges as in ShapeDef.
struct SetMaterial {
    ShapeId shape;                   ///< changed
    Change<Real> friction{},         ///< ShapeDef::friction
        restitution{},               ///< ShapeDef::restitution
        rolling_resistance{};        ///< ShapeDef::rolling_resistance
    Change<Vec3> surface_velocity{}; ///< ShapeDef::surface_velocity
};
/// Changes the collision filter of a shape.
struct SetFilter {
    ShapeId shape;                    ///< changed
    Change<std::uint32_t> category{}, ///< ShapeDef::category
        mask{};                       ///< ShapeDef::mask
    Change<std::int32_t> group{};     ///< ShapeDef::group
};
/// Disables or enables contacts between two bodies. The setting ends when either body is destroyed. Shapes of
/// the same positive group still collide.
struct SetPairFilter {
    BodyId a,              ///< one body
        b;                 ///< the other body, not the same
    std::uint32_t collide; ///< 0: no contacts; 1: contacts, as at first
};
/// Overrides the mass properties of a dynamic body. Unset fields keep their present value. From then on
/// changes of the shapes do not affect any of them, until a mass of 0 is set.
struct SetMass {
    BodyId body;              ///< changed
    Change<Real> mass{};      ///< [kg], 1e-3..1e9; 0: ends the override, other fields are ignored
    Change<Vec3> center{};    ///< centre of mass in the body's frame [m], within 64 on each axis
    Change<Vec3> gyration{};  ///< principal radii of gyration, sqrt(inertia / mass) [m], 0.001..100
    Change<Quat> principal{}; ///< rotation from the body's axes to the principal axes, of unit length
};
/// See World::set_gravity().
struct SetGravity {
    Vec3 gravity; ///< [m/s^2], each component within 1000
};
/// See World::wake_body().
struct WakeBody {
    BodyId body; ///< wakes with its island
};
/// See World::create_joint().
struct CreateJoint {
    Indirect<JointDef> def; ///< the joint
};
/// See World::destroy().
struct DestroyJoint {
    JointId joint; ///< destroyed
};
/// Replaces limits, spring, motor and friction of one axis.
struct SetJointAxis {
    JointId joint;          ///< changed
    std::uint32_t index;    ///< JointAxisIndex, 0..5
    std::uint32_t reserved; ///< 0
    JointAxis axis;         ///< the new axis
};
/// Replaces both frames of a joint: moves the target of a mouse joint or of a motor joint.
struct SetJointFrames {
    JointId joint;     ///< changed
    Transform frame_a, ///< JointDef::frame_a
        frame_b;       ///< JointDef::frame_b
};
/// See World::create_vehicle().
struct CreateVehicle {
    Indirect<VehicleDef> def; ///< the vehicle
};
/// See World::destroy().
struct DestroyVehicle {
    VehicleId vehicle; ///< destroyed; its chassis remains
};
/// Sets the input of a vehicle until the next such command.
struct SetVehicleInput {
    VehicleId vehicle;  ///< driven
    VehicleInput input; ///< for all later ticks
};
/// Creates a character with its body and shape.
struct CreateCharacter {
    CharacterDef def; ///< the character
};
/// Destroys a character with its body.
struct DestroyCharacter {
    CharacterId character; ///< destroyed
};
/// Sets the input of a character until the next such command.
struct SetCharacterInput {
    CharacterId character; ///< moved
    CharacterInput input;  ///< for all later ticks
};
/// Replaces the definition of a force field.
struct SetField {
    FieldId field; ///< changed
    FieldDef def;  ///< the new definition
};
/// Changes the velocities of the bodies in reach at once, and wakes them.
struct Explode {
    ExplosionDef def; ///< the explosion
};
/// Writes a piece of a row of a game column. World::write() splits longer rows.
struct WriteGame {
    std::uint32_t column;              ///< index in the GameSchema
    std::uint32_t size;                ///< number of bytes, 0..64
    BodyId body;                       ///< row of a body column; ignored for records
    std::uint64_t offset;              ///< of the first byte in the canonical row
    std::array<std::uint8_t, 64> data; ///< [size] canonical bytes: little-endian, in field order
};

/// Any command. The order of the alternatives is that of the file format.
using Command =
    std::variant<CreateBody, DestroyBody, CreateShape, DestroyShape, CreateField, DestroyField, SetPose,
                 SetVelocity, AddForce, AddForceAt, AddImpulse, AddImpulseAt, SetBodyParameters, SetMaterial,
                 SetGravity, WriteGame, SetFilter, SetPairFilter, SetMass, CreateJoint, DestroyJoint,
                 SetJointAxis, SetJointFrames, WakeBody, CreateVehicle, DestroyVehicle, SetVehicleInput,
                 CreateCharacter, DestroyCharacter, SetCharacterInput, SetField, Explode>;
static_assert(sizeof(Command) <= 224, "a large definition goes into an Indirect");
/// Name of a command's kind, as in replay/FORMAT.md: "create_body". Static string.
const char* name_of(const Command& command);

// ---- field lists: the file order of every command ---------------------------------------------------------

/// Field list of a definition or command in file order, with ranges; see lockstone/row.h.
///@{
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
///@}

} // namespace lockstone
