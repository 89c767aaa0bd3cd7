#include "dynamics/followed_turn.h"

#include "lockstone/math.h"

#include <algorithm>

namespace lockstone::dynamics {

namespace {

constexpr int real_to_accumulator = accumulator_bits - Real::fraction_bits;

Vec3 to_real(const std::int64_t v[3]) {
    const auto one = [](std::int64_t x) {
        return Real::from_raw(shift_right_rounded(x, real_to_accumulator));
    };
    return {one(v[0]), one(v[1]), one(v[2])};
}

Vec3 scaled(Vec3 v, Vec3 by) { return {v.x * by.x, v.y * by.y, v.z * by.z}; }

/// R diag(radii^-2) R^T momentum with the body at `rotation`.
Vec3 spin_at(Quat rotation, const FollowedTurn& turn, Vec3 momentum) {
    const Rotation axes = to_rotation(rotation * turn.principal);
    const Vec3 inside = mul_transposed<Real>(axes, momentum);
    return mul<Real>(axes, scaled(scaled(inside, turn.radii_inv), turn.radii_inv));
}

/// Far beyond what a body keeps [m/s]: then |g| stays within this and the tip speed limit, and no sum leaves 64 bits.
constexpr std::int64_t own_max = std::int64_t{2048} << accumulator_bits;

struct OwnSpin {
    std::int64_t m[3]; ///< 47 fraction bits
};
OwnSpin own_spin(const SolverBody& b, const FollowedTurn& turn) {
    OwnSpin own;
    for (int i = 0; i < 3; ++i) own.m[i] = std::clamp(b.u[i] - turn.precession[i], -own_max, own_max);
    return own;
}

/// g by the midpoint rule. Two rounds more than the explicit rule: then a body that spins fast loses energy by what is
/// left of the error, where with one or three more it gains.
void precess(SolverBody& b, const BodyStep& s, FollowedTurn& turn, const StepConstants& step) {
    constexpr int rounds = 3;
    const Unit half_time = Unit::from_raw(step.substep_time.raw / 2);
    const OwnSpin own = own_spin(b, turn);
    const Vec3 momentum = mul<Real>(s.gyration, to_real(own.m));
    Vec3 w = mul<Real>(s.gyration_inv, to_real(b.u));
    for (int round = 0; round < rounds; ++round) {
        const Quat middle = integrate_rotation(turn.rotation, scale<Real>(w, half_time));
        w = spin_at(middle, turn, momentum);
    }
    const Vec3 u = mul<Real>(s.gyration, w);
    const Real most = to<Real>(step.tip_speed_max);
    for (int i = 0; i < 3; ++i) {
        b.u[i] = clamp(u[i], -most, most).raw << real_to_accumulator;
        turn.precession[i] = b.u[i] - own.m[i];
    }
}

/// Slower than this, arms of contacts, which are those of the start of the tick, are the larger error: a top on a floor
/// does better if all its turn is made after the tick.
constexpr int spin_parts = 2;
constexpr int held_parts = 4; ///< joints make their arms anew in every substep

/// Whether a body feels gyroscopic torque and turns by more than 1 / `parts` of a radian in the tick about some axis.
bool spins(const BodyColumns& columns, std::uint32_t row, const BodyStep& s, int parts,
           const StepConstants& step) {
    const Vec3 radii = columns.mass[row].gyration;
    if (!s.movable || s.turn != 0 || columns.info[row].gyroscopic == 0 || s.angular_mask != 7u) return false;
    if ((radii.x == radii.y && radii.y == radii.z) || s.radii != radii) return false;
    const Vec3 w = abs(to<Real>(columns.velocity[row].angular));
    return max(w.x, max(w.y, w.z)) * parts > Real(step.ticks_per_second);
}

void follow(const BodyColumns& columns, std::uint32_t row, const StepConstants& step, SolverBodies& bodies) {
    const auto inverse = [](Real r) { return r > Real{} ? Real(1) / r : Real{}; };
    BodyStep& s = bodies.step[row];
    bodies.turns.push_back({normalized(columns.pose[row].rotation),
                            columns.mass[row].principal,
                            {inverse(s.radii.x), inverse(s.radii.y), inverse(s.radii.z)},
                            {}});
    s.turn = static_cast<std::uint32_t>(bodies.turns.size());
    precess(bodies.body[row], s, bodies.turns.back(), step);
}

} // namespace

void follow_turns(std::span<const Joint> joints, const BodyColumns& columns, const StepConstants& step,
                  SolverBodies& bodies) {
    const std::uint32_t count = static_cast<std::uint32_t>(columns.info.size());
    for (std::uint32_t row = 0; row < count; ++row)
        if (spins(columns, row, bodies.step[row], spin_parts, step)) follow(columns, row, step, bodies);
    for (const Joint& joint : joints)
        for (const std::uint32_t row : {joint.body_a, joint.body_b})
            if (row != bodies.still() && spins(columns, row, bodies.step[row], held_parts, step))
                follow(columns, row, step, bodies);
}

void advance_turn(SolverBody& b, const BodyStep& s, FollowedTurn& turn, const StepConstants& step) {
    const Vec3 w = mul<Real>(s.gyration_inv, to_real(b.u));
    turn.rotation = integrate_rotation(turn.rotation, scale<Real>(w, step.substep_time));
    precess(b, s, turn, step);
}

Vec3 spin_of(const SolverBody& b, const BodyStep& s, const FollowedTurn& turn) {
    return spin_at(turn.rotation, turn, mul<Real>(s.gyration, to_real(own_spin(b, turn).m)));
}

} // namespace lockstone::dynamics
