// Points of joints that an impact has opened are closed before the tick ends.
//
// A figure that lands on stretched legs is stopped at its feet within a substep, and a pass over its joints carries that no further than their
// order does: a hip opens by 3 cm and is pulled together over the next ticks. So what is open after the substeps is closed by moving
// bodies: passes over the points and hinges of packs, each from bodies at rest and from impulses of zero, that take the whole error out.
// Velocities and impulses are as before then. Bodies enter what they touch by that much, which contacts push out.
// source: errors of positions solved apart from velocities: Bender, Mueller, Macklin, A survey on position based dynamics (2017)
#include "solve/joints/joint_work.h"

#include "lockstone/math/math.h"

namespace lockstone::solve {

namespace {

/// Points that are nearer than this are left to the next substeps [m].
constexpr std::int32_t open_gap = decimal<Separation>("0.008").raw;
/// Passes at most: a joint that a load keeps open stays open by a part.
constexpr int passes_max = 4;

/// The speed that closes `open_gap` at a rate [1/s], joint_rate_bits.
std::int64_t open_speed(std::int32_t rate) {
    return (std::int64_t{open_gap} * rate) >>
           (joint_rate_bits + Separation::fraction_bits - Speed::fraction_bits);
}

/// Whether a point is off by more than open_gap, by the biases that packs have.
bool is_open(const JointPassData& data, std::size_t packs) {
    const std::int64_t most = open_speed(data.rate);
    for (std::size_t p = 0; p < packs; ++p) {
        const JointPack& pack = data.packs[p];
        for (std::uint32_t lane = 0; lane < pack.count; ++lane)
            for (const auto& bias : pack.bias)
                if (std::int64_t{bias[lane]} > (most >> pack.exponent[lane]) ||
                    -std::int64_t{bias[lane]} > (most >> pack.exponent[lane]))
                    return true;
    }
    return false;
}

void swap_impulses(JointTick& tick) {
    std::size_t at = 0;
    const auto swap = [&](auto& impulse) {
        for (auto& row : impulse)
            for (std::int32_t& p : row) std::swap(p, tick.kept_impulses[at++]);
    };
    for (JointPack& pack : tick.packs) swap(pack.impulse);
    for (TurnPack& turn : tick.turn_packs) swap(turn.impulse);
}

/// Velocities of all bodies that joints hold, in and out.
void swap_velocities(JointTick& tick, SolverBodies& bodies) {
    std::size_t at = 0;
    for (const JointBody& now : tick.bodies) {
        SolverBody& b = bodies.body[now.body];
        for (auto* x : {&b.v, &b.u})
            for (std::int64_t& part : *x) std::swap(part, tick.kept_velocities[at++]);
    }
}

/// Moves bodies for a substep and stops them. Those whose turn is followed only shift.
void move_and_stop(JointTick& tick, const StepConstants& step, SolverBodies& bodies) {
    constexpr int to_separation = accumulator_bits - Separation::fraction_bits;
    const auto way = [&](std::int64_t& v) {
        const std::int64_t out =
            shift_right_rounded((v >> to_separation) * step.substep_time.raw, Unit::fraction_bits);
        v = 0;
        return out;
    };
    for (const JointBody& now : tick.bodies) {
        SolverBody& b = bodies.body[now.body];
        const bool turns = bodies.step[now.body].turn == 0;
        for (int i = 0; i < 3; ++i) {
            b.shift[i] = saturate_to_int32(b.shift[i] + way(b.v[i]));
            const std::int64_t turn = way(b.u[i]);
            if (turns) b.theta[i] = saturate_to_int32(b.theta[i] + turn);
        }
    }
}

} // namespace

void JointSolver::close(const StepConstants& step, SolverBodies& bodies, Tasks* tasks) {
    JointTick& tick = *work;
    JointPassData data = pass_data(tick, step, bodies.body.data());
    if (!is_open(data, tick.packs.size())) return;
    tick.kept_velocities.assign(6 * tick.bodies.size(), 0);
    tick.kept_impulses.assign(3 * pack_lanes * (tick.packs.size() + tick.turn_packs.size()), 0);
    swap_velocities(tick, bodies);
    swap_impulses(tick);
    // The whole error within a substep.
    data.rate = saturate_to_int32(step.substeps_per_second << joint_rate_bits);
    data.mass_scale = unit_one.raw, data.impulse_scale = 0;
    const auto packs = static_cast<std::uint32_t>(tick.packs.size());
    for (int pass = 0; pass < passes_max; ++pass) {
        update(step, bodies, tasks); // rows, at the rate of the substeps
        kernel->refresh(data, 0, packs);
        if (!is_open(data, packs)) break;
        for (const JointStage& stage : tick.stages)
            tick.clamped += kernel->solve(data, stage.first_pack, stage.last_pack, true);
        move_and_stop(tick, step, bodies);
        for (JointPack& pack : tick.packs) std::fill_n(&pack.impulse[0][0], 3 * pack_lanes, 0);
        for (TurnPack& turn : tick.turn_packs) std::fill_n(&turn.impulse[0][0], 3 * pack_lanes, 0);
    }
    swap_impulses(tick);
    swap_velocities(tick, bodies);
}

} // namespace lockstone::solve
