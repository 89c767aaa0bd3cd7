// Joints: constraints between two bodies, defined axis by axis.
//
// Every joint connects a frame on body A with a frame on body B. Most kinds are a table of six axes, three
// along and three about the axes of A's frame. Each axis is locked, limited or free, and can have a spring, a
// motor and friction:
//
//   JointDef door = hinge_joint();
//   door.axis[about_x].mode = AxisMode::limited, door.axis[about_x].upper = 1.5_r;
//   world.create_joint(door, frame, leaf, {.position = hinge, .rotation = Quat::identity()});
//
// Coordinates measure frame B relative to frame A: they are zero where both frames coincide.
#pragma once

#include "lockstone/ids.h"
#include "lockstone/math/math.h"
#include "lockstone/row.h"

#include <array>
#include <cstdint>

namespace lockstone {

/// Kind of a joint. Directions are those of the joint's frames.
enum class JointKind : std::uint32_t {
    six_dof, ///< any combination of axes
    /// Position locked. Twist about x; `swing` is the maximum angle between the x axes of A and B.
    ball,
    hinge,    ///< rotation about x
    slider,   ///< translation along x
    weld,     ///< all axes locked; soft if they have a frequency
    wheel,    ///< translation along y (suspension), rotation about y (steering) and about B's x (spin)
    motor,    ///< no locks; springs and motors drive B to a pose relative to A
    mouse,    ///< pulls a point of B to a point of A or of the world with limited force
    distance, ///< axis[0] is the distance of the frames' origins: rod, rope (upper limit) or spring
    /// |ground_a - A| + ratio |ground_b - B| is equal to axis[0].target, or limited by axis[0].upper
    pulley,
    gear,            ///< keeps (angle of A about its x) + ratio * (angle of B about its x)
    rack_and_pinion, ///< angle of A about its x = ratio * (translation of B along its x)
};

/// Constraint of a joint axis.
enum class AxisMode : std::uint32_t {
    locked,  ///< held at zero (distance, pulley: at `target`); soft if it has a frequency
    limited, ///< held between `lower` and `upper`
    free,    ///< not constrained; spring, motor and friction may act
};

/// Index of JointDef::axis.
enum JointAxisIndex : std::uint32_t {
    along_x, ///< translation along x
    along_y, ///< translation along y
    along_z, ///< translation along z
    about_x, ///< rotation about x
    about_y, ///< rotation about y
    about_z  ///< rotation about z
};
inline constexpr std::uint32_t joint_axis_count = 6; ///< length of JointDef::axis

/// One axis of a joint. Along an axis: lengths [m] and forces [N]. About an axis: angles [rad] and torques [N
/// m].
struct JointAxis {
    AxisMode mode = AxisMode::locked; ///< locked, limited or free
    /// 1: a spring pulls to `target`; it needs a frequency above 0. Springs about all three axes pull to the
    /// rotation vector (target x, y, z); one or two pull each angle separately.
    std::uint32_t spring = 0;
    Real lower{},                 ///< lower limit of a limited axis, within 1e6; about y and z within pi
        upper{};                  ///< upper limit, not below `lower`, same range
    Real frequency{};             ///< of the spring or of a soft lock [Hz], 0..1000; 0: no spring, rigid lock
    Real damping_ratio = Real(1); ///< of the spring or soft lock, 0..100; 1: critical
    Real target{};                ///< of the spring; distance and pulley: the length. Same range as limits
    Real motor_speed{};           ///< target speed of the motor [m/s] or [rad/s], within 500
    Real motor_force{};           ///< maximum force of the motor [N] or [N m], 0..2e9; 0: no motor
    Real friction{};              ///< maximum friction [N] or [N m], 0..2e9; ignored with a motor
    Real spring_force{};          ///< maximum force of the spring [N] or [N m], 0..2e9; 0: unlimited
};

/// Definition of a joint.
struct JointDef {
    JointKind kind = JointKind::six_dof; ///< kind of the joint
    std::uint32_t collide_connected = 0; ///< 1: the two bodies collide with each other
    /// First body; null: the world (not for pulley, gear, rack and pinion).
    BodyId body_a{}, body_b{}; ///< second body; not null, not body_a
    /// Frame on A, from the body's origin in its axes [m], within 1e6; without body_a in the world, within
    /// 1e9.
    Transform frame_a = Transform::identity();
    Transform frame_b = Transform::identity();      ///< frame on B, as frame_a
    std::array<JointAxis, joint_axis_count> axis{}; ///< [JointAxisIndex]; default: all locked
    Real swing{};         ///< ball: maximum angle between the x axes [rad], below pi; 0: no limit
    Real ratio = Real(1); ///< pulley, gear [1], rack and pinion [rad/m]; magnitude 0.001..1000
    Vec3 ground_a{},      ///< pulley: fixed point of the rope to A, world [m], within 1e9
        ground_b{};       ///< pulley: fixed point of the rope to B, world [m], within 1e9
    Real break_force{};   ///< a larger force in a tick destroys the joint [N], 0..2e9; 0: unbreakable
    /// a larger torque in a tick destroys the joint [N m], 0..2e9; 0: unbreakable
    Real break_torque{};
    std::uint64_t user_key = 0; ///< value for the game; hashed, not used
};

// Definitions of each kind, without bodies and frames. World::create_joint() checks the ranges.
JointDef six_dof_joint(); ///< All axes free.
JointDef ball_joint();    ///< Position locked, rotation free.
JointDef hinge_joint();   ///< All locked except rotation about x.
JointDef slider_joint();  ///< All locked except translation along x.
/// All axes locked; soft for a frequency [Hz] above 0.
JointDef weld_joint(Real frequency = {}, Real damping_ratio = Real(1));
/// A spring suspension along y with `frequency` [Hz], and free spin about x. To steer, set axis[about_y] to
/// free or limited.
JointDef wheel_joint(Real frequency, Real damping_ratio);
/// Springs on all axes with `frequency` [Hz], limited to force_max [N] and torque_max [N m].
JointDef motor_joint(Real frequency, Real force_max, Real torque_max);
/// Springs along all axes with `frequency` [Hz], limited to force_max [N]; rotation free.
JointDef mouse_joint(Real frequency, Real force_max);
JointDef distance_joint(Real length); ///< A rod: constant distance [m].
JointDef rope_joint(Real length);     ///< A rope: maximum distance [m].
/// A spring of rest length [m] with `frequency` [Hz].
JointDef spring_joint(Real length, Real frequency, Real damping_ratio);
/// A pulley with a rope of total_length [m].
JointDef pulley_joint(Vec3 ground_a, Vec3 ground_b, Real total_length, Real ratio = Real(1));
JointDef gear_joint(Real ratio);                        ///< A gear.
JointDef rack_and_pinion_joint(Real radians_per_metre); ///< A rack (B) and a pinion (A) [rad/m].
/// "rack_and_pinion"; "unknown" for any other value. Static string.
const char* name_of(JointKind kind);

/// Coordinates and load of a joint: World::joint_state().
struct JointState {
    /// Coordinates in the present poses [JointAxisIndex, m or rad]. about_x counts whole turns. Distance and
    /// pulley: [along_x] is the length. Gear, rack and pinion: [about_x] is the error.
    std::array<Real, joint_axis_count> position;
    Vec3 force;  ///< force of the last tick on B, at B's frame, world axes [N]
    Vec3 torque; ///< torque of the last tick on B, world axes [N m]
};

/// Field list of JointAxis with ranges; see lockstone/row.h.
template <class V> constexpr void describe(JointAxis& a, V&& v) {
    constexpr In<Real> reach = in(-1000000_r, 1000000_r, " m or rad"),
                       force = in(0_r, 2000000000_r, " N or N m");
    field(v, "mode", a.mode, in(0, 2));
    field(v, "spring", a.spring, no_or_yes);
    field(v, "lower", a.lower, reach);
    field(v, "upper", a.upper, reach);
    field(v, "frequency", a.frequency, in(0_r, 1000_r, " Hz"));
    field(v, "damping_ratio", a.damping_ratio, in(0_r, 100_r));
    field(v, "target", a.target, reach);
    field(v, "motor_speed", a.motor_speed, in(-500_r, 500_r, " m/s or rad/s"));
    field(v, "motor_force", a.motor_force, force);
    field(v, "friction", a.friction, force);
    field(v, "spring_force", a.spring_force, force);
}
/// Field list of JointDef with ranges; see lockstone/row.h.
template <class V> constexpr void describe(JointDef& d, V&& v) {
    field(v, "kind", d.kind, in(0, 11));
    field(v, "collide_connected", d.collide_connected, no_or_yes);
    v("body_a", d.body_a), v("body_b", d.body_b);
    field(v, "frame_a", d.frame_a, PoseIn{Real(1000000000)});
    field(v, "frame_b", d.frame_b, PoseIn{Real(1000000)});
    v("axis", d.axis);
    field(v, "swing", d.swing, Below{pi, "pi"});
    field(v, "ratio", d.ratio, EitherSign{0.001_r, 1000_r});
    field(v, "ground_a", d.ground_a, EachIn{Real(1000000000), "m"});
    field(v, "ground_b", d.ground_b, EachIn{Real(1000000000), "m"});
    field(v, "break_force", d.break_force, in(0_r, 2000000000_r, " N"));
    field(v, "break_torque", d.break_torque, in(0_r, 2000000000_r, " N m"));
    v("user_key", d.user_key);
}

} // namespace lockstone
