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

/// R diag(own^2) R^T w with the body where it is now.
Vec3 momentum_of(const FollowedTurn& turn, Vec3 w) {
    const Rotation axes = to_rotation(turn.rotation * turn.principal);
    return mul<Real>(axes, scaled(scaled(mul_transposed<Real>(axes, w), turn.own), turn.own));
}

/// The gyroscopic torque of the body as it is, in a substep, on the body as it answers. Three rounds of the midpoint rule lose
/// a little energy; two gain it.
void precess_stiff(SolverBody& b, const BodyStep& s, const FollowedTurn& turn, const StepConstants& step) {
    constexpr int rounds = 3;
    const Vec3 before = mul<Real>(s.gyration_inv, to_real(b.u));
    Vec3 w = before;
    for (int round = 0; round < rounds; ++round) {
        const Vec3 sum = before + w, middle{half(sum.x), half(sum.y), half(sum.z)};
        const Vec3 torque = cross(momentum_of(turn, middle), middle);
        w = before + scale<Real>(spin_at(turn.rotation, turn, torque), step.substep_time);
    }
    const Vec3 u = mul<Real>(s.gyration, w);
    const Real most = to<Real>(step.tip_speed_max);
    for (int i = 0; i < 3; ++i) b.u[i] = clamp(u[i], -most, most).raw << real_to_accumulator;
}

/// Slower than this, arms of contacts, which are those of the start of the tick, are the larger error: a top on a floor
/// does better if all its turn is made after the tick.
constexpr int spin_parts = 2;
/// Chains under load come apart with 4, and gain energy where they are snatched with 8.
constexpr int held_parts = 16;

/// Whether a body feels gyroscopic torque and turns by more than 1 / `parts` of a radian in the tick about some axis.
bool spins(const BodyColumns& columns, std::uint32_t row, const BodyStep& s, int parts,
           const StepConstants& step) {
    if (!s.movable || s.turn != 0 || columns.info[row].gyroscopic == 0 || s.angular_mask != 7u) return false;
    if (s.radii.x == s.radii.y && s.radii.y == s.radii.z) return false;
    const Vec3 w = abs(to<Real>(columns.velocity[row].angular));
    return max(w.x, max(w.y, w.z)) * parts > Real(step.ticks_per_second);
}

void follow(const BodyColumns& columns, std::uint32_t row, const StepConstants& step, SolverBodies& bodies) {
    const auto inverse = [](Real r) { return r > Real{} ? Real(1) / r : Real{}; };
    BodyStep& s = bodies.step[row];
    FollowedTurn turn{};
    turn.rotation = normalized(columns.pose[row].rotation);
    turn.principal = columns.mass[row].principal;
    turn.radii_inv = {inverse(s.radii.x), inverse(s.radii.y), inverse(s.radii.z)};
    turn.body = row;
    turn.own = columns.mass[row].gyration;
    turn.stiff = s.radii != turn.own;
    bodies.turns.push_back(turn);
    s.turn = static_cast<std::uint32_t>(bodies.turns.size());
    bodies.plain[row] = 0;
    if (!turn.stiff) precess(bodies.body[row], s, bodies.turns.back(), step);
}

} // namespace

void follow_turns(std::span<const Joint> joints, const BodyColumns& columns, const StepConstants& step,
                  SolverBodies& bodies) {
    const std::uint32_t count = static_cast<std::uint32_t>(columns.info.size());
    for (std::uint32_t row = 0; row < count; ++row)
        if (spins(columns, row, bodies.step[row], spin_parts, step)) follow(columns, row, step, bodies);
    for (const Joint& joint : joints)
        for (const std::uint32_t row : {joint.body_a, joint.body_b}) {
            if (row == bodies.still()) continue;
            if (spins(columns, row, bodies.step[row], held_parts, step)) follow(columns, row, step, bodies);
            if (bodies.step[row].turn != 0) bodies.turns[bodies.step[row].turn - 1].held = true;
        }
    for (FollowedTurn& turn : bodies.turns) turn.now = bodies.step[turn.body];
}

void advance_turn(SolverBody& b, const BodyStep& s, FollowedTurn& turn, const StepConstants& step) {
    const Vec3 w = mul<Real>(s.gyration_inv, to_real(b.u));
    turn.rotation = integrate_rotation(turn.rotation, scale<Real>(w, step.substep_time));
    if (turn.held) set_gyration(turn.now, turn.principal, turn.rotation);
    if (turn.stiff)
        precess_stiff(b, s, turn, step);
    else
        precess(b, s, turn, step);
}

// ---- rows of now and rows of the start ----------------------------------------------------------------------------

namespace {

template <class Visit> void for_each_held(SolverBodies& bodies, Visit&& visit) {
    for (FollowedTurn& turn : bodies.turns)
        if (turn.held) visit(turn, bodies.body[turn.body], bodies.step[turn.body]);
}

struct Change {
    std::int64_t m[3]; ///< 47 fraction bits
};
Change change_of(const SolverBody& b, const std::int64_t (&before)[3]) {
    Change change;
    for (int i = 0; i < 3; ++i) change.m[i] = b.u[i] - before[i];
    return change;
}
Change from_real(Vec3 v) {
    constexpr Real most(4096); // no sum leaves 64 bits
    Change change;
    for (int i = 0; i < 3; ++i) change.m[i] = clamp(v[i], -most, most).raw << real_to_accumulator;
    return change;
}

/// What was added to u without being momentum.
void add_precession(FollowedTurn& turn, const Change& u, const Change& momentum) {
    for (int i = 0; i < 3; ++i)
        turn.precession[i] =
            std::clamp(turn.precession[i] + u.m[i] - momentum.m[i], -2 * own_max, 2 * own_max);
}

} // namespace

TurnedK::TurnedK(const StepConstants& step, SolverBodies& solver_bodies) : bodies(solver_bodies) {
    const Real most = to<Real>(step.tip_speed_max);
    for_each_held(bodies, [&](FollowedTurn& turn, SolverBody& b, const BodyStep& s) {
        const Vec3 u = mul<Real>(turn.now.gyration, mul<Real>(s.gyration_inv, to_real(b.u)));
        for (int i = 0; i < 3; ++i) {
            turn.u_outside[i] = b.u[i];
            b.u[i] = turn.u_inside[i] = clamp(u[i], -most, most).raw << real_to_accumulator;
        }
    });
}

TurnedK::~TurnedK() {
    for_each_held(bodies, [](FollowedTurn& turn, SolverBody& b, const BodyStep& s) {
        const Vec3 change = to_real(change_of(b, turn.u_inside).m);
        const Change faster = from_real(mul<Real>(s.gyration, mul<Real>(turn.now.gyration_inv, change)));
        const Change momentum = from_real(mul<Real>(s.gyration_inv, mul<Real>(turn.now.gyration, change)));
        for (int i = 0; i < 3; ++i) b.u[i] = std::clamp(turn.u_outside[i] + faster.m[i], -own_max, own_max);
        if (!turn.stiff) add_precession(turn, faster, momentum);
    });
}

StartK::StartK(SolverBodies& solver_bodies) : bodies(solver_bodies) {
    for_each_held(bodies, [](FollowedTurn& turn, const SolverBody& b, const BodyStep&) {
        std::copy(b.u, b.u + 3, turn.u_outside);
    });
}

StartK::~StartK() {
    for_each_held(bodies, [](FollowedTurn& turn, const SolverBody& b, const BodyStep& s) {
        if (turn.stiff) return;
        const Change change = change_of(b, turn.u_outside);
        const Vec3 w = mul<Real>(s.gyration_inv, to_real(change.m));
        const Change momentum = from_real(
            mul<Real>(s.gyration_inv, mul<Real>(turn.now.gyration, mul<Real>(turn.now.gyration, w))));
        add_precession(turn, change, momentum);
    });
}

Vec3 spin_of(const SolverBody& b, const BodyStep& s, const FollowedTurn& turn) {
    if (turn.stiff) return mul<Real>(s.gyration_inv, to_real(b.u));
    return spin_at(turn.rotation, turn, mul<Real>(s.gyration, to_real(own_spin(b, turn).m)));
}

} // namespace lockstone::dynamics
