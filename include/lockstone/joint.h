// Joints: they hold two bodies together, axis by axis.
//
// Every joint stands between a frame on body A and a frame on body B. Most kinds are a table of six axes, three along
// and three about the axes of A's frame, each locked, limited or free, with a spring, a motor and friction of its own:
//
//   JointDef door = hinge_joint();
//   door.axis[about_x].mode = AxisMode::limited, door.axis[about_x].upper = 1.5_r;
//   world.create_joint(door, frame, leaf, {.position = hinge, .rotation = Quat::identity()});
//
// Where two bodies stand when the joint is made is the zero of its coordinates, if both frames are the same place.
#pragma once

#include "lockstone/ids.h"
#include "lockstone/math/math.h"
#include "lockstone/row.h"

#include <array>
#include <cstdint>

namespace lockstone {

enum class JointKind : std::uint32_t {
    six_dof,  ///< any table of axes
    ball,     ///< along x y z locked; about x is the twist, `swing` the cone that B's x axis stays in
    hinge,    ///< turns about x
    slider,   ///< slides along x
    weld,     ///< nothing moves; soft with a frequency on its axes
    wheel,    ///< slides along y (suspension), steers about y, spins about B's x
    motor,    ///< locks nothing; springs and motors drive B to a pose relative to A
    mouse,    ///< pulls a point of B to a point of A or the world with a bounded force
    distance, ///< axis[0] is the line between the origins of the frames: rigid, rope (limited above), spring
    pulley,   ///< |ground_a - A| + ratio |ground_b - B| is kept at axis[0].target, or below it when limited
    gear,     ///< turn of A about its x + ratio * turn of B about its x stays what it was
    rack_and_pinion, ///< turn of A about its x = ratio * way of B along its x
};

enum class AxisMode : std::uint32_t {
    locked,  ///< stays at zero; softly if it has a frequency
    limited, ///< stays between lower and upper
    free,
};

/// Index of JointDef::axis.
enum JointAxisIndex : std::uint32_t { along_x, along_y, along_z, about_x, about_y, about_z };
inline constexpr std::uint32_t joint_axis_count = 6;

/// One of six. Lengths in m and forces in N along an axis; angles in rad and torques in N m about it.
struct JointAxis {
    AxisMode mode = AxisMode::locked;
    /// 1: pulled to `target` with frequency and damping_ratio. Springs about all three axes pull to the rotation vector
    /// (target x, y, z) as a whole; fewer pull each angle alone.
    std::uint32_t spring = 0;
    Real lower{},
        upper{};      ///< of a limited axis: within 1e6 m; about x within 1e6 rad, about y and z within pi
    Real frequency{}; ///< [Hz], 0..1000: of the spring, or of a lock that is soft; 0: none, or rigid
    Real damping_ratio = Real(1); ///< 0..100
    Real target{};                ///< of the spring [m] or [rad]
    Real motor_speed{};           ///< [m/s] or [rad/s], within 500
    Real motor_force{};           ///< most that the motor pulls with [N] or [N m], 0: no motor
    Real friction{};     ///< brakes motion with at most this [N] or [N m]; not where there is a motor
    Real spring_force{}; ///< most of the spring [N] or [N m], 0: no bound
};

/// Bodies: A may be null, then frame_a is a place in the world. B never is.
struct JointDef {
    JointKind kind = JointKind::six_dof;
    std::uint32_t collide_connected = 0; ///< 1: the two bodies may touch each other
    BodyId body_a{}, body_b{};
    Transform frame_a =
        Transform::identity(); ///< in the body's axes, from its origin; within 1e6 m, in the world 1e9 m
    Transform frame_b = Transform::identity();
    std::array<JointAxis, joint_axis_count> axis{};
    Real swing{};         ///< ball: B's x axis stays within this angle of A's [rad], 0: anywhere; below pi
    Real ratio = Real(1); ///< pulley, gear [1], rack and pinion [rad/m]; 0.001..1000 in magnitude
    Vec3 ground_a{}, ground_b{}; ///< pulley: where the rope leaves A and B for its other end, world [m]
    Real break_force{};          ///< [N]: more for one tick breaks the joint, 0: unbreakable
    Real break_torque{};         ///< [N m]
    std::uint64_t user_key = 0;  ///< the game's own; hashed, never read
};

JointDef six_dof_joint(); ///< all axes free
JointDef ball_joint();
JointDef hinge_joint();
JointDef slider_joint();
JointDef weld_joint(Real frequency = {}, Real damping_ratio = Real(1)); ///< [Hz], 0: rigid
/// A suspension that gives with `frequency` [Hz] and steers only with axis[about_y] freed or limited.
JointDef wheel_joint(Real frequency, Real damping_ratio);
JointDef motor_joint(Real frequency, Real force_max, Real torque_max);
JointDef mouse_joint(Real frequency, Real force_max);
JointDef distance_joint(Real length);
JointDef rope_joint(Real length); ///< the bodies get no farther apart [m]
JointDef spring_joint(Real length, Real frequency, Real damping_ratio);
JointDef pulley_joint(Vec3 ground_a, Vec3 ground_b, Real total_length, Real ratio = Real(1));
JointDef gear_joint(Real ratio);
JointDef rack_and_pinion_joint(Real radians_per_metre);
const char* name_of(JointKind kind);

/// What a joint does after the last tick.
struct JointState {
    std::array<Real, joint_axis_count> position; ///< [m], [rad]: of the axes; about x counts whole turns
    Vec3 force;                                  ///< on B, at B's frame, world axes [N]
    Vec3 torque;                                 ///< on B, world axes [N m]
};

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
