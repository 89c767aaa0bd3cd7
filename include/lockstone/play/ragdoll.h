// Ragdolls: a human figure of 14 bodies and 13 joints, created by the commands of lockstone/world.h.
//
//   Ragdoll victim = make_ragdoll(world, {.place = {{0_r, 2_r, 0_r}, Quat::identity()}}).value();
//   set_ragdoll_drive(world, victim, ragdoll_t_pose(), {.frequency = 20_r, .torque_max = 100_r});
//
// Masses and lengths of the segments are fractions of the total. Source: Winter, Biomechanics and Motor
// Control of Human Movement, 4th edition, table 4.1 (masses, after Dempster) and figure 4.1 (lengths, after
// Drillis and Contini).
#pragma once

#include "lockstone/world.h"

#include <array>

namespace lockstone {

/// Part of a ragdoll; each follows its parent. A figure that looks along +z has its left side at +x.
enum class RagdollPart : std::uint32_t {
    pelvis,          ///< root
    abdomen,         ///< belly
    chest,           ///< upper trunk
    head,            ///< head and neck
    upper_arm_left,  ///< upper arm, left
    forearm_left,    ///< forearm and hand, left
    upper_arm_right, ///< upper arm, right
    forearm_right,   ///< forearm and hand, right
    thigh_left,      ///< thigh, left
    shin_left,       ///< lower leg, left
    foot_left,       ///< foot, left
    thigh_right,     ///< thigh, right
    shin_right,      ///< lower leg, right
    foot_right,      ///< foot, right
};
inline constexpr std::uint32_t ragdoll_part_count = 14; ///< number of parts
/// Name of a part; "unknown" for any other value. Static string.
const char* name_of(RagdollPart part);
/// The parent of a part; of the pelvis: itself. Any other value ends the program.
RagdollPart ragdoll_parent(RagdollPart part);

/// Rotation of each part relative to its parent [part]. Identity: standing with hanging arms. The entry of
/// the pelvis is ignored. Quaternions are normalised; none may be zero.
using RagdollPose = std::array<Quat, ragdoll_part_count>;
RagdollPose ragdoll_standing(); ///< Standing with hanging arms.
RagdollPose ragdoll_t_pose();   ///< Standing with arms stretched to the sides.

/// Definition of a ragdoll.
struct RagdollDef {
    /// Pose of the ground point between the feet when it stands [m]; up is y, it looks along z.
    Transform place = Transform::identity();
    Vec3 linear_velocity{};                ///< of all parts [m/s], at most 500 long
    Real height = decimal<Real>("1.8");    ///< [m], 0.5..3
    Real mass = Real(75);                  ///< of all parts together [kg], 5..500
    Real stiffness = Real(1);              ///< factor of the joint friction of a limp body, 0..100
    RagdollPose pose = ragdoll_standing(); ///< initial pose
    Real friction = decimal<Real>("0.6");  ///< ShapeDef::friction of all parts, 0..4
    std::uint32_t category = 1,            ///< ShapeDef::category of all parts
        mask = 0xffffffffu;                ///< ShapeDef::mask of all parts
    std::uint64_t user_key = 0;            ///< each body, shape and joint has this plus its RagdollPart
};

/// Ids of a ragdoll. It can be a row of a game column.
struct Ragdoll {
    std::array<BodyId, ragdoll_part_count> bodies;  ///< [part]
    std::array<JointId, ragdoll_part_count> joints; ///< [part] joint to the parent; null for the pelvis
    /// Equal ids.
    friend bool operator==(const Ragdoll&, const Ragdoll&) = default;
};
/// Field list of Ragdoll; see lockstone/row.h.
template <class V> constexpr void describe(Ragdoll& r, V&& v) {
    v("bodies", r.bodies), v("joints", r.joints);
}

/// Creates a ragdoll. Errors: a value out of range, a full table; the world is then as before and its journal
/// received nothing, because another world runs the commands first.
Result<Ragdoll> make_ragdoll(World& world, const RagdollDef& def);
/// Destroys all living bodies of a ragdoll with their joints.
void destroy_ragdoll(World& world, const Ragdoll& ragdoll);

/// Springs that pull the joints of a ragdoll towards a pose.
struct RagdollDrive {
    /// Frequency of each joint's spring with its part alone [Hz], 0..1000; 0: limp. Parts that hang on it
    /// lower the frequency, and joint friction remains: 10 to 30 Hz hold a pose.
    Real frequency{};
    Real damping_ratio = Real(1); ///< 0..100; 1: critical
    Real torque_max{};            ///< maximum torque of each joint [N m], 0..2e9; 0: unlimited
};
/// Sets the springs of all living joints towards `pose`. Errors: a zero quaternion in the pose, a value out
/// of range; no joint changes then.
Status set_ragdoll_drive(World& world, const Ragdoll& ragdoll, const RagdollPose& pose,
                         const RagdollDrive& drive);
/// The present pose. A part that was destroyed, or whose parent was, has the identity.
RagdollPose ragdoll_pose(const World& world, const Ragdoll& ragdoll);

} // namespace lockstone
