// What a tick keeps of its joints: bodies as they stand, points, blocks of locks, axes with springs, motors and limits.
//
// Rows of no pack stay while neither body has turned by more than row_turn_max about an axis since they were made; errors follow the
// motion by the rows, C = C0 + J . (shift, theta). What a lever of length r so misses is r a^2 / 2 for a turn by a:
// 0.0001 mm for a metre. With 2^-7 rad a pendulum lost 87 % of its swing in five minutes, with 2^-11 it keeps it (the row
// "pendulum" of tests/quality). Single axes of a joint whose other rows a pack makes, its limits, motors, friction and springs, stay until
// a body has turned by 2^-4 rad since the tick began, which misses their angle by half the square of that, 0.002 rad: the pack holds the
// bodies, and a motor or a limit about a direction that is off by so much only pushes a little sideways. Angles and cones whose direction
// turns faster than the bodies do have rows that stay for less, or not at all. Rows whose directions also change with places
// (along an axis of A, lines, ropes), gears and racks are made anew whenever a body has moved, and so are those of trees (a bridge
// that is taut gains energy from rows that stay behind by a hundredth) and of bodies that are followed (followed_turn.h).
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

/// Bodies are assumed to approach no limit faster than this [m/s], [rad/s]: a limit that cannot be reached so in a substep is left out.
inline constexpr Real limit_speed_far = Real(100);

/// A body that joints hold, where it is in this substep. The first cache line is all that points and hinges in packs ask for.
struct alignas(64) JointBody {
    std::uint32_t body;
    bool given;                      ///< it has turned far or is followed: in JointTick::given
    bool motion_asked;               ///< by some joint that is more than a point or a hinge in a pack
    bool lever_asked;                ///< and that needs levers
    std::int32_t shift[3], theta[3]; ///< of the SolverBody, when this was made
    Quat rotation;
    std::int32_t radii_bits; ///< of the largest inverse of a radius, Real
    // Where levers are asked for:
    Rotation axes;
    Vec3 position;
    // Where motion is asked for:
    Vec3 w;
    Vec3 velocity;
    Vec3 moved;             ///< by the last update [m]
    std::int32_t turned[3]; ///< by the last update, of theta
};

/// Up to three locks solved together.
struct JointBlock {
    Row row[3];
    Inverse inverse;
    RowKind kind[3];
    std::uint8_t slot[3]; ///< axis of JointAxisImpulses
    std::uint8_t count;
    std::int32_t exponent;
    std::int32_t impulse[3]; ///< p', Speed
    std::int32_t bias[3];    ///< Speed
    std::int64_t error[3];   ///< 2^-e C, less J . (shift, theta) of when the rows were made; Separation
    std::int32_t ahead[3];   ///< of the bias: along the arc, Speed
    std::int32_t push_max;   ///< of the bias: by the error, Speed
    Real at[3];              ///< position that is kept
    Real sum[3];             ///< of the impulses of the substeps so far, unscaled
    Vec3 direction[3];
    bool is_force[3];
    bool turns; ///< its rows only turn
};

enum JointFeature : std::uint8_t {
    has_spring = 1,
    has_motor = 2,
    has_lower = 4,
    has_upper = 8,
    is_swing = 16
};

/// One axis: up to four impulses along the same row. The first cache line is all that is asked of limits out of reach.
struct alignas(64) JointAxisPart {
    RowKind kind;
    std::uint8_t slot;
    std::uint8_t features; ///< JointFeature
    bool turns;            ///< its row only turns
    bool idle;             ///< nothing but limits out of reach: passes leave it out
    bool unmade;           ///< and so far off that they stay so until rows are made again: there is no row
    std::int32_t exponent;
    std::int32_t spring, motor, lower, upper; ///< p', Speed
    Real lower_at, upper_at;
    Real sum;
    Row row;
    Inverse inverse;
    // spring: rate [1/s] and softness; its bound, in unscaled impulse
    Real rate, target;
    Unit mass_scale, impulse_scale;
    Real spring_max, motor_max, motor_speed;
    // as scaled by the last update
    std::int32_t spring_bias, spring_bound, motor_bias, motor_bound;
    std::int32_t lower_bias, lower_relax, upper_bias, upper_relax;
    // Separation, 2^-e of a length or an angle less J . (shift, theta) of when the row was made
    std::int64_t stretch; ///< of the spring
    /// To the lower and from the upper limit; the second falls with J . (shift, theta)
    std::int64_t room, room_up;
    std::int32_t ahead, ahead_up; ///< of their biases: along the arc, Speed
    std::int32_t push_max;        ///< of their biases, Speed
    std::int32_t far;             ///< Speed at which limits are out of reach in a substep
    Vec3 direction;
    bool is_force;
};

/// One side of a joint, constant within the tick.
struct JointWorkSide {
    std::uint32_t body;  ///< entry of SolverBodies
    std::uint32_t cache; ///< entry of JointTick::bodies
    bool world;          ///< stands still: the frame is in the world
    bool moved;          ///< by impulses; else it is read, never written: workers share it
};
struct JointFrame {
    LengthVec3 lever; ///< of the frame's origin from the centre of mass, in the body's axes
    Vec3 anchor;      ///< of a frame in the world
    Quat rotation;    ///< in the body's axes, or in the world
};

inline constexpr std::uint32_t no_pack = 0xffffffffu;

/// What an update asks of every joint: a few bytes in place of the rest of it.
struct JointGlance {
    std::uint32_t a, b;           ///< entries of JointTick::seen; 0 for the world
    std::uint8_t rows_ask;        ///< JointSeen by which its own rows become stale
    bool own_rows, places, stale; ///< it has own rows; bodies are placed where they are stale; they are
};

/// The first cache line is all that is asked of a hinge that its pack holds as a whole, limits out of reach.
struct alignas(64) JointWork {
    JointWorkSide a, b;
    Real mass; ///< mA mB / (mA + mB) [kg]
    Real twist;
    std::uint32_t memory;
    std::uint32_t first_axis;
    /// Entry of JointTick::packs that has its point part; no_pack: that is a block, if any
    std::uint32_t pack;
    std::uint8_t lane;                    ///< of the pack
    std::uint8_t axis_count, block_count; ///< blocks: of the point only where no pack has it
    bool turns_packed;                    ///< its block is in a pack of turns
    bool hinge;                           ///< and its rows are made there
    bool made;
    bool remade; ///< since trees were factorised
    bool stays;  ///< its rows change by turns alone, and slowly
    bool steady; ///< and they may stay behind where they are now
    bool needs_twist, needs_travel, counts_turns;
    // Of rows that no pack makes:
    const JointDef* def;
    Shares shares;
    Real travel;
    std::uint32_t first_block;
    std::uint32_t tree;   ///< that solves its locks; no_tree: they are solved by themselves
    std::uint32_t stage;  ///< the first after those of all earlier joints that move the same body
    std::uint32_t strand; ///< of JointTick::down and up
    bool is_inner;        ///< no joint of another strand moves one of its bodies
    bool point;           ///< it holds a point
    bool needs_target, needs_orientation, needs_slip;
    bool needs_lever; ///< some row of its own does not only turn
    bool framed;      ///< directions of its frames are asked for: it holds more than a point
    JointFrame frame_a, frame_b;
};

/// Joints of one stage, of one strand, at its border or within it: they share no body that impulses move. Step after step is the order of
/// solving, and steps backwards are that order backwards.
struct JointStep {
    std::uint32_t first_pack, last_pack, first_single, last_single;
    std::uint32_t first_joint, last_joint; ///< of JointTick::in_order
    std::uint32_t strand;
};

/// What a plan takes for granted of a body that joints hold.
struct PlannedBody {
    bool moves, movable, fits; ///< a pack can make its rows
    friend bool operator==(const PlannedBody&, const PlannedBody&) = default;
};

/// What a pack was like before its points were closed: exponents, impulses of its points and of what only turns.
struct ClosedPack {
    std::uint32_t pack;
    std::int32_t exponent[pack_lanes], point[3][pack_lanes], turn[3][pack_lanes];
};

/// While open points are closed (joint_close.cpp).
struct ClosedPoints {
    std::vector<std::uint8_t> of_body;          ///< flags, by SolverBodies
    std::vector<std::uint8_t> of_pack;          ///< 1: it is in `packs`
    std::vector<std::uint8_t> of_four;          ///< 1: these HeldBodies have been looked at in this pass
    std::vector<std::uint32_t> pushed, stopped; ///< bodies
    std::vector<std::int64_t> velocities;       ///< six of each that is stopped
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
    /// By stage, of a stage by strand, and of a strand those at its border first.
    std::vector<JointStep> steps;
    base::StrandPlan down, up;          ///< for workers: pieces are steps, in order and in the reverse order
    std::vector<std::uint32_t> singles; ///< joints of no pack that have parts, by step
    std::vector<std::uint32_t> with_rows;       ///< joints that are more than a point in a pack
    std::vector<std::uint32_t> framed_in_world; ///< joints with a side that stands still
    std::vector<JointGlance> glances;           ///< by joint
    std::vector<HeldBodies> held;               ///< of `bodies`
    std::vector<TurnedBody> turned;             ///< by body, after one of the world
    std::vector<std::uint8_t> seen;             ///< JointSeen, likewise
    std::vector<std::uint32_t> wanted;          ///< entries of `bodies` that are seen_wanted
    std::vector<std::uint32_t> given;           ///< entries of `bodies` whose turn theta does not tell
    std::vector<std::uint8_t> acts;    ///< of singles, by joint: 1, or 0 where passes have nothing to do
    std::vector<std::uint32_t> packed; ///< joints by pack and lane
    std::vector<std::uint32_t> last_stage, last_piece, counts; ///< while packs are filled
    std::vector<std::uint32_t> in_order, before_sort;          ///< joints by step
    std::vector<JointBody> bodies;
    /// The plan: which bodies joints hold, what parts joints have, where packs have them. While joints stay the same it serves again,
    /// but not with trees, which are found anew in every tick.
    std::vector<PlannedBody> planned;
    bool has_plan;
    std::uint32_t planned_for; ///< workers
    JointForest forest;
    std::vector<std::uint32_t> cache_of; ///< by body: entry of `bodies` + 1
    ClosedPoints closed;
    std::span<const Transform> pose;
    std::span<const JointMemory> memory; ///< of the last tick; read until rows are made
    std::uint64_t clamped;               ///< impulses that met joint_impulse_max
    std::int32_t ticks_per_second;
    bool first; ///< no substep is in the sums yet
    base::Paths paths;
    PassCounter counter; ///< in builds that check the order
};

/// Of a joint whose block is in a pack of turns.
inline TurnPack& turn_pack(JointTick& tick, const JointWork& work) {
    return tick.turn_packs[tick.packs[work.pack].turn];
}

/// Copy the axes of a joint in a pack to their lanes; only the biases, for rows that stay; and the impulses from the lanes.
void put_axes(JointTick& tick, const JointWork& work);
void put_axis_biases(JointTick& tick, const JointWork& work);
void take_axes(JointTick& tick, const JointWork& work);

/// Room for one more entry; where there is none, for an eighth more: entries are large.
template <class T> void make_room(std::vector<T>& v) {
    if (v.size() == v.capacity()) v.reserve(v.size() + v.size() / 8 + 16);
}

/// Joints per piece of work that workers take, and packs that stay in a cache.
inline constexpr std::uint32_t joint_chunk = 32, packs_in_cache = 128;
/// Chunks of few packs are small, so that all workers end at once. Chunks of many packs are as large as a cache, since inverses are found some at a time.
constexpr std::uint32_t pack_chunk_of(std::size_t packs) {
    return static_cast<std::uint32_t>(std::clamp<std::size_t>(packs / 16, 8, packs_in_cache));
}
/// Counts the joints of a step in a pass that goes through the steps forwards or backwards.
void count_step(JointTick& tick, const JointStep& step, std::uint32_t pass, bool forwards);
/// The first joint that the plan takes out of the order, in a sentence; empty: there is none.
std::string order_fault(const JointTick& tick);
/// Adds the paths of a plan to those of the tick.
void note_plan(const JointTick& tick, const Tasks* tasks);
JointPassData pass_data(JointTick& tick, const StepConstants& step, SolverBody* bodies);
/// After `pass` over a pack: larger exponents where entries have grown to 2, and rows by these.
void enlarge_exponents(JointTick& tick, std::uint32_t pack, decltype(JointKernel::refresh) pass,
                       const JointPassData& data, const StepConstants& step);
/// The next update goes by what the rows of now ask: JointPack::asks_next becomes JointPack::asks.
void settle_asks(JointPack& pack);
/// Inverses of the stale lanes of packs [first, last).
void invert_some(JointTick& tick, std::uint32_t first, std::uint32_t last, const JointKernel& kernel,
                 const JointPassData& data);
/// A pack of the last tick as it is when it has just been planned, but for numbers that are written before they are read.
void restart_pack(JointTick& tick, JointPack& pack);
/// Whether a pack can make the point rows of a body: one that impulses move must be free along and about all axes.
inline bool fits_pack(std::uint32_t body, const SolverBodies& bodies) {
    const BodyStep& s = bodies.step[body];
    const SolverBody& b = bodies.body[body];
    if (!s.moves) return true;
    // Beyond this the shifts of products with K^-1 would leave 1 .. 62.
    if (s.inv_exponent < 8 || s.inv_exponent > 58) return false;
    return !s.movable || (s.angular_mask == 7u && (b.keep[0] & b.keep[1] & b.keep[2]) == -1);
}
/// What JointKernel::start takes of the points of a pack besides bodies: impulses of the last tick, and how far bodies are apart.
void start_points(JointTick& tick, std::uint32_t pack);
/// K^-1 of the followed bodies of a packed joint, as it is now.
void give_gyration(JointTick& tick, const JointWork& work, const SolverBodies& bodies);
/// Held bodies as the tick begins.
void hold_bodies(JointTick& tick, const SolverBodies& bodies, Tasks* tasks);
/// Where held bodies are now: TurnedBody and JointSeen.
void turn_bodies(JointTick& tick, const JointKernel& kernel, const JointPassData& data,
                 const SolverBodies& bodies, Tasks* tasks);
/// The same of one HeldBodies.
void turn_four(JointTick& tick, std::uint32_t group, const JointKernel& kernel, const JointPassData& data,
               const SolverBodies& bodies);
/// Rows that a refreshed pack asks for, and whether it does: of hinges that have come apart, and limits that are in reach again.
void make_asked_rows(JointTick& tick, std::uint32_t pack, const StepConstants& step,
                     const SolverBodies& bodies);
bool asks_for_rows(const JointTick& tick, std::uint32_t pack);
/// Notes for a single if passes have something to do: locks that they solve, or an axis that is not idle.
void set_acting(JointTick& tick, const JointWork& work);
/// Whether its block is a hinge's, with rows that its pack makes.
bool is_made_in_pack(const JointTick& tick, const JointWork& work);
/// Whether something of a joint is made by make_rows(): all but what packs make and limits that are out of reach.
bool has_own_rows(const JointTick& tick, const JointWork& work);
/// True if a pack makes all rows of a joint but those of single axes, which may stay behind by a turn of 2^-given_turn_bits rad.
bool has_axes_alone(const JointTick& tick, const JointWork& work);
/// Parts of one joint by its table of axes; appends to blocks and axes. Its point is no block yet: most are packed.
void assemble(JointTick& tick, JointWork& work, const StepConstants& step, const JointMemory& memory);
/// Parts of the last tick as assemble() and add_point_block() leave them, but for numbers that are written before they are read, and for
/// the block of a hinge.
void reassemble(JointTick& tick, const JointWork& work);
/// Impulses of the last tick into a block whose rows are to be made.
void restart_block(JointBlock& block, const JointMemory& memory);
/// Likewise of an axis, unscaled.
JointAxisImpulses impulses_of(const JointAxisPart& part, const JointMemory& memory);
/// The point of a joint that no pack takes, as its last block.
void add_point_block(JointTick& tick, JointWork& work);
/// Where x can swing freely, a swing past the back of A adds turns that nobody made, and a limit would wind them off.
bool counts_turns(const JointDef& def);
/// Of a joint that was assembled: whether its rows change by turns alone, and slowly.
bool may_stay(const JointTick& tick, const JointWork& work);
/// As normalized(), but what is one by a rounding is left as it is.
inline Quat unit_of(Quat q) {
    const std::int64_t x = q.x.raw, y = q.y.raw, z = q.z.raw, w = q.w.raw;
    constexpr std::uint64_t one = std::uint64_t{1} << (2 * Unit::fraction_bits), off = std::uint64_t{1} << 33;
    const auto size = static_cast<std::uint64_t>(x * x) + static_cast<std::uint64_t>(y * y) +
                      static_cast<std::uint64_t>(z * z) + static_cast<std::uint64_t>(w * w);
    return size - (one - off) <= 2 * off ? q : normalized(q);
}
void start_body(JointBody& now, const Transform& pose, const SolverBodies& bodies);
/// What is asked for besides its rotation, when a tick begins.
void start_motion(JointBody& now, const Transform& pose, const SolverBodies& bodies);
/// A body's rotation in this substep, of its pose when the tick began.
Quat rotation_now(const Transform& pose, std::uint32_t body, const SolverBodies& bodies);
void place_body(JointBody& now, const Transform& pose, const SolverBodies& bodies);
/// After its rows were made.
void set_glance(JointTick& tick, const JointWork& work);
/// Sets the glance of a joint by the results of has_own_rows() and has_axes_alone().
void set_glance(JointTick& tick, const JointWork& work, bool own_rows, bool axes_alone);
/// Rows, responses, inverses and targets of a joint's parts. Writes nothing that is another joint's.
void make_rows(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies);
/// The same of a hinge that its pack makes, with no axis but a twist. False, and nothing changes: it is not one.
bool make_hinge(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies);
/// The expected twist of a joint that counts turns, with A's frame at `a`: the last twist, or for a fast turn that of the start of the tick
/// plus the turn of B against A since. `before`: the stored twist of the last tick.
Real expected_twist(const JointTick& tick, const JointWork& work, Quat a, Real before,
                    const SolverBodies& bodies);
/// The twist to remember of a joint that counts turns.
Real twist_to_store(const JointTick& tick, const JointWork& work, Real before, const SolverBodies& bodies);
/// Nearer than this a limit of an angle may be in reach before rows are made again [rad]: by the speed of both bodies and 20 rad/s
/// more, which a substep may give them.
Real least_room(const JointTick& tick, const JointWork& work, const StepConstants& step);
/// Whether an axis has nothing but limits of an angle, which carry no impulse and stay out of reach until the rows are made again. Until
/// then each body turns by sqrt(3) / 1024 rad at most, and the angle by up to eight times that of both.
/// `last`: impulses of the last tick, while there are no others.
bool is_out_of_reach(const JointAxisPart& part, const JointAxisImpulses* last, Real position, Real least);
/// The row of an axis by its value, with response, inverse and targets. `last`: as is_out_of_reach() takes it.
void make_axis_row(JointAxisPart& part, const JointAxisImpulses* last, const JointWork& work,
                   const RowValue& value, const StepConstants& step, const SolverBodies& bodies);
/// A body's K^-1 in this substep.
const BodyInertia& inertia_now(std::uint32_t body, const SolverBodies& bodies);
/// Errors from where the bodies are, by the rows that there are.
void follow_errors(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies);
/// x h / 2, at most `most`: at a radian per substep the arc is no guide any more.
Real half_step(Real x, Real most, const StepConstants& step);
/// 2^-exponent of a length or an angle, Separation.
std::int64_t scaled_error(Real x, int exponent);
/// Inverses of a joint's blocks, which make_rows() leaves out where a tree solves them.
void invert_blocks(JointTick& tick, const JointWork& work);

} // namespace lockstone::solve
