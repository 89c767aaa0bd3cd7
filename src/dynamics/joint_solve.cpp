// The passes over joints. See joint.h for the symbols.
#include "dynamics/joint_work.h"

#include <algorithm>

namespace lockstone::dynamics {

namespace {

/// Velocities of the two bodies of a joint: along, then about.
struct Motion {
    std::int64_t a[6], b[6]; ///< 47 fraction bits
};

constexpr std::int64_t impulse_change_max = std::int64_t{4} * joint_impulse_max;
constexpr std::int64_t motion_max = std::int64_t{joint_speed_max} << row_bits;

Motion read(const SolverBody& a, const SolverBody& b) {
    Motion m;
    for (int i = 0; i < 3; ++i) m.a[i] = a.v[i], m.a[i + 3] = a.u[i], m.b[i] = b.v[i], m.b[i + 3] = b.u[i];
    return m;
}
void write(const Motion& m, SolverBody& a, SolverBody& b) {
    for (int i = 0; i < 3; ++i) a.v[i] = m.a[i], a.u[i] = m.a[i + 3], b.v[i] = m.b[i], b.u[i] = m.b[i + 3];
}

/// Keeps what rows read within 1024 m/s. Nothing gets there but by impulses beyond all bounds.
void clamp_motion(Motion& m) {
    for (int i = 0; i < 6; ++i) {
        m.a[i] = std::clamp(m.a[i], -motion_max, motion_max);
        m.b[i] = std::clamp(m.b[i], -motion_max, motion_max);
    }
}

/// A change of impulse below this moves a body by less than 16 m/s: the 30 or so of one joint and pass leave what is
/// read below 2048 m/s without clamping.
constexpr std::int32_t small_impulse = 1 << 22;

/// The motion as rows read it, Speed.
struct Speeds {
    std::int32_t a[6], b[6];
    explicit Speeds(const Motion& m) {
        for (int i = 0; i < 6; ++i) {
            a[i] = static_cast<std::int32_t>((m.a[i] + half_step) >> row_bits);
            b[i] = static_cast<std::int32_t>((m.b[i] + half_step) >> row_bits);
        }
    }
    static constexpr std::int64_t half_step = std::int64_t{1} << (row_bits - 1);
};

/// J . (v, u), Speed: twelve products of 29 and 30 bits.
std::int32_t speed_along(const Row& row, const Speeds& now) {
    std::int64_t sum = 0;
    for (int i = 0; i < 6; ++i)
        sum += std::int64_t{row.ja[i]} * now.a[i] + std::int64_t{row.jb[i]} * now.b[i];
    const std::int64_t speed = shift_right_rounded(sum, row_bits);
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(speed, -joint_impulse_max, joint_impulse_max));
}

void add_rounded(std::int64_t (&v)[6], const std::int64_t (&sum)[6], int shift) {
    if (shift == 0)
        for (int i = 0; i < 6; ++i) v[i] += sum[i];
    else
        for (int i = 0; i < 6; ++i) v[i] += (sum[i] >> shift) + ((sum[i] >> (shift - 1)) & 1);
}

/// v += sum of r p over the rows of a part: 29 bits times 31, three times.
void push(const Row* rows, const std::int32_t* p, int count, Motion& m) {
    std::int64_t a[6] = {}, b[6] = {};
    std::uint32_t any = 0;
    for (int r = 0; r < count; ++r) {
        any |= static_cast<std::uint32_t>(p[r] < 0 ? -p[r] : p[r]);
        for (int i = 0; i < 6; ++i) {
            a[i] += std::int64_t{rows[r].ra[i]} * p[r];
            b[i] += std::int64_t{rows[r].rb[i]} * p[r];
        }
    }
    add_rounded(m.a, a, rows[0].shift_a);
    add_rounded(m.b, b, rows[0].shift_b);
    if (any >= small_impulse) clamp_motion(m);
}

std::int64_t shifted(std::int64_t v, int shift) {
    if (shift > 62) return 0;
    return shift >= 0 ? shift_right_rounded(v, shift) : shift_left_saturated(v, std::min(-shift, 63));
}

std::int32_t bounded(std::int64_t p, std::int64_t low, std::int64_t high) {
    return static_cast<std::int32_t>(std::clamp(p, low, high));
}

// ---- blocks -------------------------------------------------------------------------------------------------------

std::int64_t times_unit(std::int64_t x, Unit scale) {
    return shift_right_rounded(x * scale.raw, Unit::fraction_bits);
}

/// With bias softly, without it rigidly.
void solve_block(JointBlock& block, Motion& m, const StepConstants& step, bool bias, std::uint64_t& clamped) {
    std::int64_t speed[3] = {};
    const Speeds now(m);
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
    push(block.row, change, block.count, m);
}

// ---- axes ---------------------------------------------------------------------------------------------------------

/// The impulses of an axis, one after another along the same row.
struct AxisPass {
    const JointAxisPart& part;
    Motion& m;
    std::uint64_t& clamped;
    std::int64_t speed;

    AxisPass(const JointAxisPart& axis, Motion& motion, std::uint64_t& clamps)
        : part(axis), m(motion), clamped(clamps), speed(speed_along(axis.row, Speeds(motion))) {}

    /// k^-1 (speed + bias)
    std::int64_t impulse_for(std::int64_t bias) const {
        return std::clamp<std::int64_t>(shifted(part.inverse.m[0] * (speed + bias), part.inverse.shift),
                                        -impulse_change_max, impulse_change_max);
    }
    void set(std::int32_t& p, std::int64_t wanted, std::int64_t low, std::int64_t high) {
        const std::int32_t next = bounded(wanted, low, high);
        if (next == p) return;
        if (next != wanted && (next == joint_impulse_max || next == -joint_impulse_max)) ++clamped;
        const std::int32_t change = next - p;
        push(&part.row, &change, 1, m);
        p = next;
        speed = speed_along(part.row, Speeds(m));
    }
};

void solve_axis(JointAxisPart& part, Motion& m, bool bias, std::uint64_t& clamped) {
    AxisPass pass(part, m, clamped);
    // A spring gives its impulse once a substep: relaxing undoes none of it.
    if ((part.features & has_spring) != 0 && bias) {
        const std::int64_t change = pass.impulse_for(part.spring_bias);
        const std::int64_t wanted =
            part.spring - times_unit(change, part.mass_scale) - times_unit(part.spring, part.impulse_scale);
        pass.set(part.spring, wanted, -part.spring_bound, part.spring_bound);
    }
    if (part.features & has_motor)
        pass.set(part.motor, part.motor - pass.impulse_for(part.motor_bias), -part.motor_bound,
                 part.motor_bound);
    if (part.features & has_lower)
        pass.set(part.lower, part.lower - pass.impulse_for(bias ? part.lower_bias : part.lower_relax), 0,
                 joint_impulse_max);
    if (part.features & has_upper)
        pass.set(part.upper, part.upper - pass.impulse_for(bias ? part.upper_bias : part.upper_relax),
                 -joint_impulse_max, 0);
}

} // namespace

void JointSolver::solve(const StepConstants& step, SolverBodies& bodies, bool bias) {
    JointTick& tick = *work;
    const std::size_t count = tick.joints.size();
    for (std::size_t k = 0; k < count; ++k) { // relaxing goes back the way the biased pass came
        const JointWork& w = tick.joints[bias ? k : count - 1 - k];
        SolverBody &a = bodies.body[w.a.body], &b = bodies.body[w.b.body];
        Motion m = read(a, b);
        clamp_motion(m);
        for (std::uint32_t i = 0; i < w.axis_count; ++i)
            solve_axis(tick.axes[w.first_axis + i], m, bias, tick.clamped);
        for (std::uint32_t i = 0; i < w.block_count; ++i)
            solve_block(tick.blocks[w.first_block + i], m, step, bias, tick.clamped);
        write(m, a, b);
    }
}

// ---- warm start ---------------------------------------------------------------------------------------------------

void JointSolver::warm_start(SolverBodies& bodies) {
    JointTick& tick = *work;
    for (const JointWork& w : tick.joints) {
        SolverBody &a = bodies.body[w.a.body], &b = bodies.body[w.b.body];
        Motion m = read(a, b);
        clamp_motion(m);
        for (std::uint32_t i = 0; i < w.axis_count; ++i) {
            JointAxisPart& part = tick.axes[w.first_axis + i];
            const std::int64_t sum = std::int64_t{part.spring} + part.motor + part.lower + part.upper;
            const std::int32_t p = bounded(sum, -joint_impulse_max, joint_impulse_max);
            if (!tick.first) part.sum += unscaled_impulse(p, part.exponent);
            push(&part.row, &p, 1, m);
        }
        for (std::uint32_t i = 0; i < w.block_count; ++i) {
            JointBlock& block = tick.blocks[w.first_block + i];
            for (int r = 0; r < block.count && !tick.first; ++r)
                block.sum[r] += unscaled_impulse(block.impulse[r], block.exponent);
            push(block.row, block.impulse, block.count, m);
        }
        write(m, a, b);
    }
    tick.first = false;
}

} // namespace lockstone::dynamics
