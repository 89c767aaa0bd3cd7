// Measures of joint rows: functions from the poses of two frames to an error and its Jacobian.
#pragma once

#include "solve/joints/joint_rows.h"

namespace lockstone::solve {

/// The quantity that a row locks, limits, drives or brakes. Axes are columns of the frames; s = pB - pA; w_AB = wB -
/// wA.
enum class RowKind : std::uint8_t {
    point_x,
    point_y,
    point_z, ///< s along the axes of the world
    along_x,
    along_y,
    along_z, ///< s along the axes of A's frame
    orientation_x,
    orientation_y,
    orientation_z, ///< 2 vec(qB qA^-1), world axes
    target_x,
    target_y,
    target_z, ///< rotation vector from the target to B, axes of A's frame
    twist,    ///< angle about x, with whole turns
    lock_y,
    lock_z, ///< - xB . zA, xB . yA: zero while xB is in the plane of A's x and y, x and z
    angle_y,
    angle_z, ///< atan2(-xB . zA, xB . xA), atan2(xB . yA, xB . xA)
    spin,    ///< as twist, but acts about B's x: a wheel
    swing,   ///< angle between the two x axes
    line,    ///< |s|
    pulley,  ///< |pA - ground_a| + ratio |pB - ground_b|
    gear,    ///< turn of A about its x + ratio * turn of B about its x
    rack,    ///< turn of A about its x - ratio * way of B along its x
};

/// Present state of one body of a joint.
struct JointSide {
    const BodyInertia* body;
    Vec3 anchor;   ///< origin of the frame, world [m]
    Vec3 lever;    ///< from the centre of mass, world [m]; within 128 m, zero for a body that does not move
    Quat rotation; ///< of the frame, world
    Rotation axes; ///< the same as a matrix
    Vec3 w;        ///< angular velocity [rad/s]
    Vec3 velocity; ///< of the centre of mass [m/s]
    Vec3 centripetal; ///< w x (w x lever) [m/s^2]
};

/// Present state of a joint.
struct JointPlace {
    const JointDef* def;
    JointSide a, b;
    Vec3 s;                 ///< pB - pA [m]
    Vec3 arc;               ///< s'' of free motion, world axes [m/s^2]
    Vec3 arc_in_a;          ///< s'' along the axes of A's frame, as A turns
    Real twist;             ///< unwrapped
    Real travel;            ///< accumulated error of gears and racks
    Vec3 target_error;      ///< rotation vector from the target, axes of A's frame
    Vec3 orientation_error; ///< 2 vec(qB qA^-1)
};

/// As operator* of vec.h, for unit quaternions: sums need no clamping.
inline Quat quat_product(Quat a, Quat b) {
    const std::int64_t ax = a.x.raw, ay = a.y.raw, az = a.z.raw, aw = a.w.raw;
    const auto one = [](std::int64_t sum) {
        return Unit::from_raw(static_cast<std::int32_t>(shift_right_rounded(sum, Unit::fraction_bits)));
    };
    return {one(aw * b.x.raw + ax * b.w.raw + ay * b.z.raw - az * b.y.raw),
            one(aw * b.y.raw - ax * b.z.raw + ay * b.w.raw + az * b.x.raw),
            one(aw * b.z.raw + ax * b.y.raw - ay * b.x.raw + az * b.w.raw),
            one(aw * b.w.raw - ax * b.x.raw - ay * b.y.raw - az * b.z.raw)};
}

/// True if rows of this kind have no linear part.
constexpr bool only_turns(RowKind kind) { return kind >= RowKind::orientation_x && kind <= RowKind::swing; }

struct RowValue {
    Real position; ///< [m] or [rad]
    Real arc;      ///< second derivative of free motion [m/s^2] or [rad/s^2]
    WideRow row;
    Vec3 direction; ///< of the force, or of the torque, on B
    bool is_force;
};

RowValue row_value(RowKind kind, const JointPlace& place);
/// The value of a `twist` row, from the x axes of both frames.
RowValue twist_value(Real twist, UnitVec3 xa, UnitVec3 xb, const BodyInertia& a, const BodyInertia& b);
/// The values of point_x, point_y and point_z together.
void point_values(const JointPlace& place, RowValue out[3]);

/// 2 atan2(x, w) of qA^-1 qB, plus the whole turns that bring it nearest to `near`.
Real twist_between(Quat a, Quat b, Real near);
/// 2 vec(qB qA^-1), the shorter way round
Vec3 orientation_between(Quat a, Quat b);
/// Rotation vector of qA^-1 qB target^-1
Vec3 target_between(Quat a, Quat b, Vec3 target);
/// atan2(-xB . zA, xB . xA) and atan2(xB . yA, xB . xA)
Real angle_y_between(const Rotation& a, const Rotation& b);
Real angle_z_between(const Rotation& a, const Rotation& b);
/// Angle between the two x axes
Real swing_between(const Rotation& a, const Rotation& b);

} // namespace lockstone::solve
