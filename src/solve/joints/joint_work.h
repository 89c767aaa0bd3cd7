// Working data of one tick of joints: body placements, points, blocks of locks, and axes with springs, motors and
// limits.
//
// Rows outside packs are reused while neither body has turned by more than row_turn_max (2^-11 rad) about any axis
// since they were made. Meanwhile the error follows the motion through the rows: C = C0 + J . (shift, theta). For a
// lever of length r and a turn a this omits r a^2 / 2, which is 0.0001 mm for one metre. With 2^-7 rad a pendulum
// loses most of its swing within minutes (row "pendulum" of tests/quality).
//
// Single axes (limits, motors, friction, springs) of a joint whose other rows a pack makes are reused until a body
// has turned by 2^-4 rad since the tick began. Their angle is then off by half the square of that turn, 0.002 rad.
// This is enough because the pack holds the bodies together: a motor or limit whose direction is that far off only
// pushes slightly sideways. Angles and cones whose direction turns faster than the bodies get rows with a shorter
// lifetime, or new rows in every update.
//
// Rows are made again whenever a body has moved if their direction also depends on positions (along an axis of A,
// lines, ropes), if they belong to gears or racks, if a tree solves them (a taut bridge gains energy from rows that
// are a hundredth of a radian out of date), or if a body is followed (followed_turn.h).
#pragma once

#include "solve/bodies/solving_order.h"
#include "solve/joints/joint.h"
#include "solve/joints/joint_parts.h"
#include "solve/joints/pack/joint_pack.h"
#include "solve/joints/pack/joint_point.h"
#include "solve/joints/tree/joint_tree.h"

#include "base/strands.h"

#include <algorithm>
#include <vector>

namespace lockstone::solve {

/// Assumed upper bound of the speed at which bodies approach a limit [m/s] or [rad/s]. The solver skips limits that
/// cannot be reached within a substep at this speed.
inline constexpr Real limit_speed_far = Real(100);

/// A body with joints, at its place in this substep. Points and hinges in packs read only the first cache line.
struct alignas(64) JointBody {
    std::uint32_t body;
    bool given;                      ///< it turned far or is followed; listed in JointTick::given
    bool motion_asked;               ///< a joint with more than a point or hinge in a pack reads the motion
    bool lever_asked;                ///< one of these joints also reads levers
    std::int32_t shift[3], theta[3]; ///< of the SolverBody, when this entry was computed
    Quat rotation;
    std::int32_t radii_bits; ///< bit length of the largest raw value in radii_inv (Real)
    // Valid if lever_asked:
    Rotation axes;
    Vec3 position;
    // Valid if motion_asked:
    Vec3 w;
    Vec3 velocity;
    Vec3 moved;             ///< change of shift in the last update [m]
    std::int32_t turned[3]; ///< change of theta in the last update
};

/// Up to three locks that are solved together.
struct JointBlock {
    Row row[3];
    Inverse inverse;
    RowKind kind[3];
    std::uint8_t slot[3]; ///< axis in JointMemory::axis that stores the impulse
    std::uint8_t count;
    std::int32_t exponent;
    std::int32_t impulse[3]; ///< p', Speed
    std::int32_t bias[3];    ///< Speed
    std::int64_t error[3]; ///< 2^-e C minus the J . (shift, theta) at the time the rows were made; Separation
    std::int32_t ahead[3]; ///< part of the bias: look-ahead along the arc, Speed
    std::int32_t push_max; ///< limit of the part of the bias that corrects the error, Speed
    Real at[3];            ///< position that the lock keeps
    Real sum[3];           ///< impulses of the earlier substeps, unscaled
    Vec3 direction[3];
    bool is_force[3];
    bool turns; ///< the rows have no linear part
};

/// Features of a JointAxisPart. `is_swing`: the axis is the cone of a ball joint, which has only an upper limit.
enum JointFeature : std::uint8_t {
    has_spring = 1,
    has_motor = 2,
    has_lower = 4,
    has_upper = 8,
    is_swing = 16
};

/// One axis: up to four impulses along the same row. For limits out of reach, passes read only the first cache line.
struct alignas(64) JointAxisPart {
    RowKind kind;
    std::uint8_t slot;
    std::uint8_t features; ///< JointFeature
    bool turns;            ///< the row has no linear part
    bool idle;             ///< only limits, all out of reach: passes skip the axis
    bool unmade;           ///< out of reach until rows are made again: `row` is not computed
    std::int32_t exponent;
    std::int32_t spring, motor, lower, upper; ///< p', Speed
    Real lower_at, upper_at;
    Real sum;
    Row row;
    Inverse inverse;
    // spring: rate [1/s], softness, and the largest impulse, unscaled
    Real rate, target;
    Unit mass_scale, impulse_scale;
    Real spring_max, motor_max, motor_speed;
    // scaled by the last update
    std::int32_t spring_bias, spring_bound, motor_bias, motor_bound;
    std::int32_t lower_bias, lower_relax, upper_bias, upper_relax;
    // 2^-e of a length or angle, minus the J . (shift, theta) at the time the row was made; Separation
    std::int64_t stretch; ///< error of the spring
    /// Distance above the lower limit and below the upper limit. J . (shift, theta) adds to `room` and is subtracted
    /// from `room_up`.
    std::int64_t room, room_up;
    std::int32_t ahead, ahead_up; ///< look-ahead along the arc in the biases of the limits, Speed
    std::int32_t push_max;        ///< limit of the error part of these biases, Speed
    std::int32_t far;             ///< limits need a faster approach than this: out of reach; Speed
    Vec3 direction;
    bool is_force;
};

/// One side of a joint, constant within the tick.
struct JointWorkSide {
    std::uint32_t body;  ///< entry of SolverBodies
    std::uint32_t cache; ///< entry of JointTick::bodies
    bool world;          ///< the body does not move: the frame is in world axes
    bool moved;          ///< impulses change the body; otherwise it is read-only and workers share it
};
struct JointFrame {
    LengthVec3 lever; ///< from the centre of mass to the frame's origin, in the body's axes
    Vec3 anchor;      ///< origin of a frame in world axes
    Quat rotation;    ///< in the body's axes, or in the world's
};

inline constexpr std::uint32_t no_pack = 0xffffffffu;

/// The few bytes that update() reads of every joint instead of its whole JointWork.
struct JointGlance {
    std::uint32_t a, b;           ///< entries of JointTick::seen; 0 for the world
    std::uint8_t rows_ask;        ///< JointSeen bits that make the joint's own rows stale
    bool own_rows, places, stale; ///< has rows of its own; its bodies need placing; is stale
};

/// For a hinge that its pack solves completely, with limits out of reach, the tick reads only the first cache line.
struct alignas(64) JointWork {
    JointWorkSide a, b;
    Real mass; ///< mA mB / (mA + mB) [kg]
    Real twist;
    std::uint32_t memory;
    std::uint32_t first_axis;
    /// Entry of JointTick::packs with the joint's point part. no_pack: the point, if there is one, is a block.
    std::uint32_t pack;
    std::uint8_t lane;                    ///< lane of the pack
    std::uint8_t axis_count, block_count; ///< the point counts as a block only outside packs
    bool turns_packed;                    ///< its block is in a TurnPack
    bool hinge;                           ///< it is also a hinge whose rows the pack makes
    bool made;
    bool remade; ///< its rows changed since trees were last factorised
    bool stays;  ///< its rows depend on turns alone, and change slowly
    bool steady; ///< `stays`, and the rows can be reused at the present angles
    bool needs_twist, needs_travel, counts_turns;
    // Read only for rows outside packs:
    const JointDef* def;
    Shares shares;
    Real travel;
    std::uint32_t first_block;
    std::uint32_t tree;   ///< the tree that solves its locks, or no_tree
    std::uint32_t stage;  ///< first stage after all earlier joints that move the same body
    std::uint32_t strand; ///< entry of JointTick::down and up
    bool is_inner;        ///< no joint of another strand moves one of its bodies
    bool point;           ///< it locks all three linear axes
    bool needs_target, needs_orientation, needs_slip;
    bool needs_lever; ///< it has a row of its own with a linear part
    bool framed;      ///< it is more than a point, so the axes of its frames are needed
    JointFrame frame_a, frame_b;
};

/// Joints of one stage and one strand, either at the border of the strand or inside it. They share no body that
/// impulses move. The solver processes the steps in order, or in reverse order.
struct JointStep {
    std::uint32_t first_pack, last_pack, first_single, last_single;
    std::uint32_t first_joint, last_joint; ///< range in JointTick::in_order
    std::uint32_t strand;
};

/// Properties of a body that the plan depends on; if one changes, the plan is made again.
struct PlannedBody {
    bool moves, movable, fits; ///< `fits`: a pack can make its rows
    friend bool operator==(const PlannedBody&, const PlannedBody&) = default;
};

/// State of a pack before its points are closed: exponents, and impulses of points and of rows without linear part.
struct ClosedPack {
    std::uint32_t pack;
    std::int32_t exponent[pack_lanes], point[3][pack_lanes], turn[3][pack_lanes];
};

/// Working data of joint_close.cpp, which closes open points.
struct ClosedPoints {
    std::vector<std::uint8_t> of_body;          ///< flags, by entry of SolverBodies
    std::vector<std::uint8_t> of_pack;          ///< 1: it is in `packs`
    std::vector<std::uint8_t> of_four;          ///< 1: this pass has already turned these HeldBodies
    std::vector<std::uint32_t> pushed, stopped; ///< entries of SolverBodies
    std::vector<std::int64_t> velocities;       ///< six for each entry of `stopped`
    std::vector<ClosedPack> packs;
};

/// All joints of a tick in solving order.
struct JointTick {
    std::vector<JointWork> joints;
    std::vector<JointBlock> blocks;
    std::vector<JointAxisPart> axes;
    std::vector<JointPack> packs;
    std::vector<TurnPack> turn_packs;
    std::vector<AxisPack> axis_packs;
    /// Sorted by stage, then by strand; border joints of a strand come before its inner joints.
    std::vector<JointStep> steps;
    base::StrandPlan down, up;            ///< for workers: pieces are steps, in forward and in reverse order
    std::vector<std::uint32_t> singles;   ///< joints with parts but without a pack, by step
    std::vector<std::uint32_t> with_rows; ///< joints that are more than a point in a pack
    std::vector<std::uint32_t> framed_in_world; ///< joints with a side that does not move
    std::vector<JointGlance> glances;           ///< by joint
    std::vector<HeldBodies> held;               ///< entries of `bodies` in groups of four
    std::vector<TurnedBody> turned;    ///< [1 + body]: entry 0 is the world, then one for each of `bodies`
    std::vector<std::uint8_t> seen;    ///< JointSeen bits, indexed like `turned`
    std::vector<std::uint32_t> wanted; ///< entries of `bodies` with the flag seen_wanted
    std::vector<std::uint32_t> given;  ///< entries of `bodies` whose turn theta cannot represent
    std::vector<std::uint8_t> acts;    ///< by joint, for singles: 0 if passes can skip the joint, else 1
    std::vector<std::uint32_t> packed; ///< joints by pack and lane
    std::vector<std::uint32_t> last_stage, last_piece, counts; ///< scratch for plan_packs()
    std::vector<std::uint32_t> in_order, before_sort;          ///< joints by step
    std::vector<JointBody> bodies;
    /// The plan: bodies with joints, the parts of each joint, and the place of each pack. It is reused while joints
    /// stay the same, except with trees, which are found again in every tick.
    std::vector<PlannedBody> planned;
    bool has_plan;
    std::uint32_t planned_for; ///< number of workers
    JointForest forest;
    std::vector<std::uint32_t> cache_of; ///< by body: entry of `bodies` + 1, 0: none
    ClosedPoints closed;
    std::span<const Transform> pose;
    std::span<const JointMemory> memory; ///< of the last tick; valid until rows are made
    std::uint64_t clamped;               ///< impulses clamped to joint_impulse_max
    std::int32_t ticks_per_second;
    bool first; ///< no substep has been added to the sums yet
    base::Paths paths;
    PassCounter counter; ///< used only in builds that check the order
};

/// The TurnPack of a joint with turns_packed.
inline TurnPack& turn_pack(JointTick& tick, const JointWork& work) {
    return tick.turn_packs[tick.packs[work.pack].turn];
}

/// Copy data between the axes of a joint in a pack and their lanes. put_axes() copies everything to the lanes,
/// put_axis_biases() only biases and flags (for reused rows), and take_axes() copies impulses back.
void put_axes(JointTick& tick, const JointWork& work);
void put_axis_biases(JointTick& tick, const JointWork& work);
void take_axes(JointTick& tick, const JointWork& work);

/// Reserves room for one more entry. A full vector grows by only an eighth, because entries are large.
template <class T> void make_room(std::vector<T>& v) {
    if (v.size() == v.capacity()) v.reserve(v.size() + v.size() / 8 + 16);
}

/// Joints per chunk of work of a worker; number of packs that fit into a cache.
inline constexpr std::uint32_t joint_chunk = 32, packs_in_cache = 128;
/// Packs per chunk. With few packs chunks are small, so that all workers finish together. With many packs a chunk
/// fills the cache, since the inverses of several packs are computed together.
constexpr std::uint32_t pack_chunk_of(std::size_t packs) {
    return static_cast<std::uint32_t>(std::clamp<std::size_t>(packs / 16, 8, packs_in_cache));
}
/// Counts the joints of a step in a pass over the steps, forward or in reverse.
void count_step(JointTick& tick, const JointStep& step, std::uint32_t pass, bool forwards);
/// Describes the first joint whose place in the plan breaks the solving order, in a sentence. Empty: the plan is
/// correct.
std::string order_fault(const JointTick& tick);
/// Adds the execution paths of a plan to those of the tick.
void note_plan(const JointTick& tick, const Tasks* tasks);
JointPassData pass_data(JointTick& tick, const StepConstants& step, SolverBody* bodies);
/// Call after `pass` over a pack. Raises the exponent of each lane with an entry of 2 or more, and makes its rows
/// again.
void enlarge_exponents(JointTick& tick, std::uint32_t pack, decltype(JointKernel::refresh) pass,
                       const JointPassData& data, const StepConstants& step);
/// Replaces the staleness flags of a pack by its asks_next, so that the next update uses those of the present rows.
void settle_asks(JointPack& pack);
/// Computes the inverses of the stale lanes of packs [first, last).
void invert_some(JointTick& tick, std::uint32_t first, std::uint32_t last, const JointKernel& kernel,
                 const JointPassData& data);
/// Resets a pack of the last tick to its freshly planned state, except numbers that are written before they are read.
void restart_pack(JointTick& tick, JointPack& pack);
/// True if a pack can make the point rows of a body. A body that impulses move must be free along and about all axes.
inline bool fits_pack(std::uint32_t body, const SolverBodies& bodies) {
    const BodyStep& s = bodies.step[body];
    const SolverBody& b = bodies.body[body];
    if (!s.moves) return true;
    // Beyond this range the shifts of products with K^-1 would leave 1 .. 62.
    if (s.inv_exponent < 8 || s.inv_exponent > 58) return false;
    return !s.movable || (s.angular_mask == 7u && (b.keep[0] & b.keep[1] & b.keep[2]) == -1);
}
/// Writes the input of JointKernel::start for the points of a pack: last tick's impulses and the distance of the
/// bodies.
void start_points(JointTick& tick, std::uint32_t pack);
/// Copies the present K^-1 of followed bodies to the lane of a packed joint.
void give_gyration(JointTick& tick, const JointWork& work, const SolverBodies& bodies);
/// Fills JointTick::held with the state of the bodies when the tick begins.
void hold_bodies(JointTick& tick, const SolverBodies& bodies, Tasks* tasks);
/// Computes TurnedBody and JointSeen of all bodies with joints from their present state.
void turn_bodies(JointTick& tick, const JointKernel& kernel, const JointPassData& data,
                 const SolverBodies& bodies, Tasks* tasks);
/// As turn_bodies(), for one HeldBodies.
void turn_four(JointTick& tick, std::uint32_t group, const JointKernel& kernel, const JointPassData& data,
               const SolverBodies& bodies);
/// asks_for_rows(): true if lanes of a refreshed pack need rows that do not exist: the axes of a hinge are too far
/// apart, or its limits came within reach. make_asked_rows() makes them.
void make_asked_rows(JointTick& tick, std::uint32_t pack, const StepConstants& step,
                     const SolverBodies& bodies);
bool asks_for_rows(const JointTick& tick, std::uint32_t pack);
/// Sets JointTick::acts of a joint outside packs: 1 if it has locks that passes solve, or an axis that is not idle.
void set_acting(JointTick& tick, const JointWork& work);
/// True if the joint's block belongs to a hinge whose rows the pack makes.
bool is_made_in_pack(const JointTick& tick, const JointWork& work);
/// True if make_rows() makes rows for the joint, beyond those of packs and apart from limits out of reach.
bool has_own_rows(const JointTick& tick, const JointWork& work);
/// True if a pack makes all rows of a joint except single axes, and these may be reused up to a turn of
/// 2^-given_turn_bits rad.
bool has_axes_alone(const JointTick& tick, const JointWork& work);
/// Appends the parts of one joint to blocks and axes, by its table of axes. The point gets no block yet, because most
/// points go into packs.
void assemble(JointTick& tick, JointWork& work, const StepConstants& step, const JointMemory& memory);
/// Resets the parts of the last tick to the state after assemble() and add_point_block(), except numbers that are
/// written before they are read, and the block of a hinge.
void reassemble(JointTick& tick, const JointWork& work);
/// Copies the impulses of the last tick into a block before its rows are made.
void restart_block(JointBlock& block, const JointMemory& memory);
/// Returns the impulses of the last tick of an axis, unscaled.
JointAxisImpulses impulses_of(const JointAxisPart& part, const JointMemory& memory);
/// Adds the point of a joint outside packs as the joint's last block.
void add_point_block(JointTick& tick, JointWork& work);
/// True if the joint counts whole turns of the twist: wheels, and joints with both other angles locked. If x can
/// swing freely, a swing past the back of A adds turns that no rotation about x made, and a limit would unwind them.
bool counts_turns(const JointDef& def);
/// For an assembled joint: true if its rows depend on turns alone and change slowly.
bool may_stay(const JointTick& tick, const JointWork& work);
/// As normalized(), but returns q unchanged if its length is 1 up to rounding.
inline Quat unit_of(Quat q) {
    const std::int64_t x = q.x.raw, y = q.y.raw, z = q.z.raw, w = q.w.raw;
    constexpr std::uint64_t one = std::uint64_t{1} << (2 * Unit::fraction_bits), off = std::uint64_t{1} << 33;
    const auto size = static_cast<std::uint64_t>(x * x) + static_cast<std::uint64_t>(y * y) +
                      static_cast<std::uint64_t>(z * z) + static_cast<std::uint64_t>(w * w);
    return size - (one - off) <= 2 * off ? q : normalized(q);
}
void start_body(JointBody& now, const Transform& pose, const SolverBodies& bodies);
/// Fills the members that depend on motion_asked and lever_asked when a tick begins.
void start_motion(JointBody& now, const Transform& pose, const SolverBodies& bodies);
/// Rotation of a body in this substep. `pose`: when the tick began.
Quat rotation_now(const Transform& pose, std::uint32_t body, const SolverBodies& bodies);
void place_body(JointBody& now, const Transform& pose, const SolverBodies& bodies);
/// Sets JointTick::glances of a joint and the asks_next of its lane. Call after its rows were made.
void set_glance(JointTick& tick, const JointWork& work);
/// As above, with the results of has_own_rows() and has_axes_alone().
void set_glance(JointTick& tick, const JointWork& work, bool own_rows, bool axes_alone);
/// Makes rows, responses, inverses and targets of a joint's parts. Thread-safe: writes only data of this joint.
void make_rows(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies);
/// As make_rows(), for a hinge that its pack makes and that has at most one axis, a twist. Returns false for all
/// other joints, without a change.
bool make_hinge(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies);
/// Expected twist of a joint that counts turns, with A's frame at `a`: the last twist, or after a fast turn the twist
/// at the start of the tick plus the turn of B relative to A since. `before`: stored twist of the last tick.
Real expected_twist(const JointTick& tick, const JointWork& work, Quat a, Real before,
                    const SolverBodies& bodies);
/// The twist to store in JointMemory, for a joint that counts turns.
Real twist_to_store(const JointTick& tick, const JointWork& work, Real before, const SolverBodies& bodies);
/// Distance below which a limit of an angle may come within reach before rows are made again [rad]. It assumes the
/// speed of both bodies plus 20 rad/s that a substep may add.
Real least_room(const JointTick& tick, const JointWork& work, const StepConstants& step);
/// True if an axis has only limits of an angle, without impulse, that stay out of reach until the rows are made
/// again. Until then each body turns by at most sqrt(3) / 1024 rad, and the angle by up to eight times the sum of
/// both. `last`: impulses of the last tick, or nullptr if `part` has its own.
bool is_out_of_reach(const JointAxisPart& part, const JointAxisImpulses* last, Real position, Real least);
/// Makes the row of an axis from its value, with response, inverse and targets. `last`: see is_out_of_reach().
void make_axis_row(JointAxisPart& part, const JointAxisImpulses* last, const JointWork& work,
                   const RowValue& value, const StepConstants& step, const SolverBodies& bodies);
/// K^-1 of a body in this substep.
const BodyInertia& inertia_now(std::uint32_t body, const SolverBodies& bodies);
/// Updates errors and biases from the present state of the bodies, with the rows unchanged.
void follow_errors(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies);
/// x h / 2, clamped to `most`: at one radian per substep the arc no longer predicts the motion.
Real half_step(Real x, Real most, const StepConstants& step);
/// 2^-exponent x as Separation; x is a length or an angle.
std::int64_t scaled_error(Real x, int exponent);
/// Computes the inverses of a joint's blocks. make_rows() omits them for joints of trees.
void invert_blocks(JointTick& tick, const JointWork& work);

} // namespace lockstone::solve
