// Ragdolls: a human of fourteen bodies and thirteen joints, made of the commands of lockstone/world.h alone.
//
//   Ragdoll victim = make_ragdoll(world, {.place = {{0_r, 2_r, 0_r}, Quat::identity()}}).value();
//   set_ragdoll_drive(world, victim, ragdoll_t_pose(), {.frequency = 20_r, .torque_max = 100_r});
//
// Masses and lengths of segments are fractions of the whole. source: Winter, Biomechanics and Motor Control of Human
// Movement, 4th edition, table 4.1 (masses, after Dempster) and figure 4.1 (lengths, after Drillis and Contini).
#pragma once

#include "lockstone/world.h"

#include <array>

namespace lockstone {

/// The root first; every other part comes after its parent. Left is +x where the human looks along +z.
enum class RagdollPart : std::uint32_t {
    pelvis,
    abdomen,
    chest,
    head, ///< and neck
    upper_arm_left,
    forearm_left, ///< and hand
    upper_arm_right,
    forearm_right,
    thigh_left,
    shin_left,
    foot_left,
    thigh_right,
    shin_right,
    foot_right,
};
inline constexpr std::uint32_t ragdoll_part_count = 14;
const char* name_of(RagdollPart part);
RagdollPart ragdoll_parent(RagdollPart part); ///< of the pelvis: itself; of no part: asserted

/// How each part is turned against its parent; all identity: standing, arms hanging. That of the pelvis is not read. Any length
/// but 0 will do.
using RagdollPose = std::array<Quat, ragdoll_part_count>;
RagdollPose ragdoll_standing();
RagdollPose ragdoll_t_pose(); ///< arms stretched out to the sides

struct RagdollDef {
    Transform place =
        Transform::identity(); ///< of the ground between the feet when it stands; up is y, it looks along z
    Vec3 linear_velocity{};    ///< of all parts [m/s]
    Real height = decimal<Real>("1.8"); ///< [m], 0.5..3
    Real mass = Real(75);               ///< [kg], 5..500
    Real stiffness = Real(1);           ///< of the joints' friction: times that of a limp body, 0..100
    RagdollPose pose = ragdoll_standing();
    Real friction = decimal<Real>("0.6"); ///< of the skin
    std::uint32_t category = 1, mask = 0xffffffffu;
    std::uint64_t user_key = 0; ///< of every body and joint, plus the number of its part
};

/// Plain ids: can be a row of a game's own columns.
struct Ragdoll {
    std::array<BodyId, ragdoll_part_count> bodies;
    std::array<JointId, ragdoll_part_count> joints; ///< to the part's parent; null for the pelvis
    friend bool operator==(const Ragdoll&, const Ragdoll&) = default;
};
template <class V> constexpr void describe(Ragdoll& r, V&& v) {
    v("bodies", r.bodies), v("joints", r.joints);
}

/// On an error the world is as it was and its journal was told nothing: all is tried on another world first.
Result<Ragdoll> make_ragdoll(World& world, const RagdollDef& def);
/// What of it is still alive.
void destroy_ragdoll(World& world, const Ragdoll& ragdoll);

/// How hard the joints pull towards a pose.
struct RagdollDrive {
    /// [Hz] of each joint's spring with the part alone, 0: limp. What hangs on it swings slower, and friction of the joint stays:
    /// 10 to 30 hold a pose
    Real frequency{};
    Real damping_ratio = Real(1); ///< 0..100
    Real torque_max{};            ///< [N m] of every joint, 0: no bound
};
/// Springs of all joints towards `pose`; parts without a living joint are left out. A pose with a quaternion of zeros is an
/// error, and nothing is changed.
Status set_ragdoll_drive(World& world, const Ragdoll& ragdoll, const RagdollPose& pose,
                         const RagdollDrive& drive);
/// As it is now; parts that were destroyed are as in standing.
RagdollPose ragdoll_pose(const World& world, const Ragdoll& ragdoll);

} // namespace lockstone
