// The passes over joints. See joint.h for the symbols.
#include "solve/joints/axis_with_point.h"
#include "solve/joints/followed_turn.h"
#include "solve/joints/joint_motion.h"
#include "solve/joints/joint_work.h"

#include <algorithm>
#include <type_traits>

namespace lockstone::solve {

namespace {

/// As push(), then clamps the velocities to the range that rows can read.
template <class Now> void push_clamped(const Row* rows, const std::int32_t* p, int count, Motion& m) {
    std::uint32_t any;
    if constexpr (std::is_same_v<Now, Turning>)
        any = push_turning(rows, p, count, m);
    else
        any = push(rows, p, count, m);
    if (any >= static_cast<std::uint32_t>(small_impulse)) clamp_motion(m);
}

std::int32_t bounded(std::int64_t p, std::int64_t low, std::int64_t high) {
    return static_cast<std::int32_t>(std::clamp(p, low, high));
}

// ---- blocks -------------------------------------------------------------------------------------------------------

std::int64_t times_unit(std::int64_t x, Unit scale) {
    return shift_right_rounded(x * scale.raw, Unit::fraction_bits);
}

/// Solves a block: softly with bias, rigidly without. Now: Speeds, or Turning for rows without linear part.
template <class Now>
void solve_block(JointBlock& block, Motion& m, const StepConstants& step, bool bias, std::uint64_t& clamped) {
    std::int64_t speed[3] = {};
    const Now now(m);
    for (int i = 0; i < block.count; ++i)
        speed[i] = std::int64_t{speed_along(block.row[i], now)} + (bias ? block.bias[i] : 0);
    std::int32_t change[3];
    for (int i = 0; i < block.count; ++i) {
        std::int64_t sum = 0; // 30 bits times 31, three times
        for (int j = 0; j < block.count; ++j) sum += block.inverse.m[inverse_index[i][j]] * speed[j];
        std::int64_t change_wanted = std::clamp<std::int64_t>(shifted(sum, block.inverse.shift),
                                                              -impulse_change_max, impulse_change_max);
        if (bias)
            change_wanted = times_unit(change_wanted, step.joint.mass_scale) +
                            times_unit(block.impulse[i], step.joint.impulse_scale);
        const std::int64_t wanted = block.impulse[i] - change_wanted;
        const std::int32_t p = bounded(wanted, -joint_impulse_max, joint_impulse_max);
        clamped += p != wanted ? 1u : 0u;
        change[i] = p - block.impulse[i];
        block.impulse[i] = p;
    }
    push_clamped<Now>(block.row, change, block.count, m);
}

// ---- axes ---------------------------------------------------------------------------------------------------------

/// Solves the impulses of an axis in sequence, along the same row. `point`: point of the same joint, which motors and
/// limits include.
template <class Now> struct AxisPass {
    const JointAxisPart& part;
    Motion& m;
    std::uint64_t& clamped;
    const JointPoint point;
    const bool biased;
    std::int64_t speed;

    AxisPass(const JointAxisPart& axis, JointPoint of, bool bias, Motion& motion, std::uint64_t& clamps)
        : part(axis), m(motion), clamped(clamps), point(of), biased(bias), speed(0) {
        look();
    }
    void look() { speed = speed_along(part.row, Now(m)); }

    /// k^-1 speed
    static std::int64_t impulse_for(std::int64_t speed, const Inverse& inverse) {
        return std::clamp<std::int64_t>(shifted(inverse.m[0] * speed, inverse.shift), -impulse_change_max,
                                        impulse_change_max);
    }
    /// Sets `p` to `wanted` clamped to the bounds, and returns the change.
    std::int32_t change_to(std::int32_t& p, std::int64_t wanted, std::int64_t low, std::int64_t high) {
        const std::int32_t next = bounded(wanted, low, high), change = next - p;
        if (change != 0 && next != wanted && (next == joint_impulse_max || next == -joint_impulse_max))
            ++clamped;
        p = next;
        return change;
    }
    void push(std::int32_t change) {
        if (change == 0) return;
        push_clamped<Now>(&part.row, &change, 1, m);
        look();
    }
    void spring(std::int32_t& p) {
        const std::int64_t change = impulse_for(speed + part.spring_bias, part.inverse);
        const std::int64_t wanted =
            p - times_unit(change, part.mass_scale) - times_unit(p, part.impulse_scale);
        push(change_to(p, wanted, -part.spring_bound, part.spring_bound));
    }
    /// Drives the speed towards -bias. Returns early if the impulse is at a bound and the speed would push it
    /// further. If a limit is exceeded, the push back uses the axis without the point: arms on arms gain energy if
    /// they are pushed as hard as they are stopped.
    void lead(std::int32_t& p, std::int64_t bias, std::int64_t low, std::int64_t high) {
        if ((p <= low && speed + bias >= 0) || (p >= high && speed + bias <= 0)) return;
        if (!point.exists())
            return push(change_to(p, p - impulse_for(speed + bias, part.inverse), low, high));
        const AxisWithPoint both(point, part.row, part.inverse);
        const bool is_beyond = low == 0 ? bias < 0 : high == 0 && bias > 0;
        const std::int64_t by =
            is_beyond ? impulse_for(both.speed(m), both.inverse()) + impulse_for(bias, part.inverse)
                      : impulse_for(both.speed(m) + bias, both.inverse());
        const std::int32_t change = change_to(p, p - by, low, high);
        if (change == 0) return;
        clamped += both.push(change, m);
        look();
    }
    void motor(std::int32_t& p) { lead(p, part.motor_bias, -part.motor_bound, part.motor_bound); }
    void lower(std::int32_t& p) {
        lead(p, biased ? part.lower_bias : part.lower_relax, 0, joint_impulse_max);
    }
    void upper(std::int32_t& p) {
        lead(p, biased ? part.upper_bias : part.upper_relax, -joint_impulse_max, 0);
    }
};

template <class Now>
void solve_axis(JointAxisPart& part, JointPoint point, Motion& m, bool bias, std::uint64_t& clamped) {
    AxisPass<Now> pass(part, point, bias, m, clamped);
    // A spring applies its impulse once per substep; the relaxation does not change it.
    if ((part.features & has_spring) != 0 && bias) pass.spring(part.spring);
    if (part.features & has_motor) pass.motor(part.motor);
    if (part.features & has_lower) pass.lower(part.lower);
    if (part.features & has_upper) pass.upper(part.upper);
}

} // namespace

namespace {

/// Reads only the angular velocities of both bodies. Returns false if some have to be clamped first.
bool read_turning(const SolverBody& a, const SolverBody& b, Motion& m) {
    std::uint64_t any = 0; // see clamp_motion()
    for (int i = 3; i < 6; ++i) {
        m.a[i] = a.u[i - 3], m.b[i] = b.u[i - 3];
        any |=
            static_cast<std::uint64_t>(m.a[i] + motion_max) | static_cast<std::uint64_t>(m.b[i] + motion_max);
    }
    return any < static_cast<std::uint64_t>(2 * motion_max);
}
void write(const Motion& m, const JointWork& w, SolverBodies& bodies) {
    if (w.a.moved) write(m.a, bodies.body[w.a.body]);
    if (w.b.moved) write(m.b, bodies.body[w.b.body]);
}
/// True if an axis has only limits, without an impulse and too far away to get one in this pass.
bool stays_free(const JointAxisPart& part, const SolverBody& a, const SolverBody& b, bool bias) {
    if (part.idle) return true;
    if (!part.turns || (part.features & (has_spring | has_motor)) != 0 || (part.lower | part.upper) != 0)
        return false;
    Motion m{};
    if (!read_turning(a, b, m)) return false;
    const std::int64_t speed = speed_along(part.row, Turning(m));
    const bool low = (part.features & has_lower) != 0, up = (part.features & has_upper) != 0;
    return (!low || speed + (bias ? part.lower_bias : part.lower_relax) >= 0) &&
           (!up || speed + (bias ? part.upper_bias : part.upper_relax) <= 0);
}

bool has_locks(const JointTick& tick, const JointWork& w) {
    return w.block_count != 0 && (w.tree == no_tree || !tick.forest.trees[w.tree].direct);
}

/// Solves one joint outside packs: its axes, and its locks if no tree solves them.
void pass_joint(JointTick& tick, const JointWork& w, const StepConstants& step, SolverBodies& bodies,
                bool bias, std::uint64_t& clamped) {
    const bool locks = has_locks(tick, w);
    const SolverBody &a = bodies.body[w.a.body], &b = bodies.body[w.b.body];
    bool busy = locks;
    for (std::uint32_t i = 0; i < w.axis_count && !busy; ++i)
        busy = !stays_free(tick.axes[w.first_axis + i], a, b, bias);
    if (!busy) return;
    Motion m = read(a, b);
    clamp_motion(m);
    for (std::uint32_t i = 0; i < w.axis_count; ++i) {
        JointAxisPart& part = tick.axes[w.first_axis + i];
        if (part.idle) continue;
        if (part.turns)
            solve_axis<Turning>(part, point_of(tick, w, bodies), m, bias, clamped);
        else
            solve_axis<Speeds>(part, {}, m, bias, clamped);
    }
    for (std::uint32_t i = 0; locks && i < w.block_count; ++i) {
        JointBlock& block = tick.blocks[w.first_block + i];
        if (block.turns)
            solve_block<Turning>(block, m, step, bias, clamped);
        else
            solve_block<Speeds>(block, m, step, bias, clamped);
    }
    write(m, w, bodies);
}

} // namespace

void set_acting(JointTick& tick, const JointWork& w) {
    const auto i = static_cast<std::size_t>(&w - tick.joints.data());
    const JointAxisPart* const axes = tick.axes.data() + w.first_axis;
    std::uint8_t acts = w.block_count != 0 ? 1 : 0; // warm starts apply the impulses of trees as well
    for (std::uint32_t k = 0; k < w.axis_count; ++k)
        if (!axes[k].idle) acts = 1;
    tick.acts[i] = acts;
}

/// Calls visit(step) in forward or reverse order. With workers, steps of different strands run in parallel.
template <class Visit>
static void for_each_step(const JointTick& tick, Tasks* tasks, bool forwards, const Visit& visit) {
    const std::size_t count = tick.steps.size();
    if (tasks != nullptr && tick.down.strands != 0)
        base::for_strands(tasks, forwards ? tick.down : tick.up, 1,
                          [&](const base::Piece& piece, base::PieceAt) { visit(tick.steps[piece.first]); });
    else
        for (std::size_t k = 0; k < count; ++k) visit(tick.steps[forwards ? k : count - 1 - k]);
}

void JointSolver::solve(const StepConstants& step, SolverBodies& bodies, bool bias, Tasks* tasks) {
    JointTick& tick = *work;
    if (tick.joints.empty()) return;
    turn_in(step, bodies);
    const JointPassData data = pass_data(tick, step, bodies.body.data());
    const std::uint32_t* const singles = tick.singles.data();
    const std::uint8_t* const all_acts = tick.acts.data();
    const std::uint32_t pass = tick.counter.next_pass();
    for_each_step(tick, tasks, bias,
                  [&](const JointStep& now) { // the relaxation runs in reverse order
                      count_step(tick, now, pass, bias);
                      std::uint64_t clamped = 0;
                      for (std::uint32_t i = now.first_single; i < now.last_single; ++i) {
                          if (all_acts[singles[i]] == 0) continue;
                          const JointWork& w = tick.joints[singles[i]];
                          pass_joint(tick, w, step, bodies, bias, clamped);
                      }
                      clamped += kernel->solve(data, now.first_pack, now.last_pack, bias);
                      base::add_count(tick.clamped, clamped);
                  });
    const std::vector<JointTree>& trees = tick.forest.trees;
    base::for_chunks(tasks, static_cast<std::uint32_t>(trees.size()), tree_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i)
                             if (trees[i].direct) solve_tree(tick, trees[i], bodies, bias);
                     });
    turn_out(bodies);
}

// ---- warm start ---------------------------------------------------------------------------------------------------

static void warm_joint(JointTick& tick, const JointWork& w, SolverBodies& bodies) {
    bool busy = w.block_count != 0;
    for (std::uint32_t i = 0; i < w.axis_count; ++i) {
        const JointAxisPart& part = tick.axes[w.first_axis + i];
        busy = busy || (part.spring | part.motor | part.lower | part.upper) != 0;
    }
    if (!busy) return;
    const SolverBody &a = bodies.body[w.a.body], &b = bodies.body[w.b.body];
    Motion m = read(a, b);
    clamp_motion(m);
    for (std::uint32_t i = 0; i < w.axis_count; ++i) {
        JointAxisPart& part = tick.axes[w.first_axis + i];
        if (part.idle) continue;
        const std::int64_t sum = std::int64_t{part.spring} + part.motor + part.lower + part.upper;
        const std::int32_t p = bounded(sum, -joint_impulse_max, joint_impulse_max);
        if (!tick.first) part.sum += unscaled_impulse(p, part.exponent);
        push_clamped<Speeds>(&part.row, &p, 1, m);
    }
    for (std::uint32_t i = 0; i < w.block_count; ++i) {
        JointBlock& block = tick.blocks[w.first_block + i];
        for (int r = 0; r < block.count && !tick.first; ++r)
            block.sum[r] += unscaled_impulse(block.impulse[r], block.exponent);
        if (block.turns)
            push_clamped<Turning>(block.row, block.impulse, block.count, m);
        else
            push_clamped<Speeds>(block.row, block.impulse, block.count, m);
    }
    write(m, w, bodies);
}

void JointSolver::warm_start(const StepConstants& step, SolverBodies& bodies, Tasks* tasks) {
    JointTick& tick = *work;
    if (tick.joints.empty()) return;
    turn_in(step, bodies);
    const JointPassData data = pass_data(tick, step, bodies.body.data());
    const std::uint32_t* const singles = tick.singles.data();
    const std::uint8_t* const all_acts = tick.acts.data();
    const std::uint32_t pass = tick.counter.next_pass();
    for_each_step(tick, tasks, /*forwards=*/true, [&](const JointStep& now) {
        count_step(tick, now, pass, /*forwards=*/true);
        for (std::uint32_t i = now.first_single; i < now.last_single; ++i) {
            if (all_acts[singles[i]] == 0) continue;
            const JointWork& w = tick.joints[singles[i]];
            warm_joint(tick, w, bodies);
        }
        kernel->warm_start(data, now.first_pack, now.last_pack, !tick.first);
    });
    turn_out(bodies);
    tick.first = false;
}

} // namespace lockstone::solve
