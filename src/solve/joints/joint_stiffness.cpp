#include "solve/joints/joint_stiffness.h"

#include "lockstone/math/math.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

Real sum_of_sizes(Vec3 v) {
    const Vec3 a = abs(v);
    return a.x + a.y + a.z;
}

/// True where a b < c^2 m for certain, by their bits: 2^(n - 1) <= x < 2^n. All are Reals and not negative.
bool is_far_below(Real a, Real b, Real c, Real m) {
    const auto bits = [](Real x) { return bit_length(static_cast<std::uint64_t>(x.raw)); };
    constexpr int one = Real::fraction_bits, end = 62; // products are clamped at 2^63
    const int square = std::min(2 * (bits(c) - 1) - one, end),
              right = std::min(square + bits(m) - 1 - one, end);
    return square > 1 && right > 1 && bits(a) + bits(b) - one < right - 1;
}

/// Adds h^2 ((r . f) 1 - r f^T) / m of one side, its diagonal in principal axes [m^2]. False where it cannot matter.
bool add_pull(const BodyColumns& columns, std::uint32_t row, Vec3 force, Vec3 place,
              const StepConstants& step, BodyStep& s) {
    const BodyMass& mass = columns.mass[row];
    const Real rate = Real(step.substeps_per_second);
    const Vec3 lever = place - mass.center;
    const Vec3& k = mass.gyration;
    const Real least = min(k.x, min(k.y, k.z));
    const Real slow = least * rate;
    const Real pulls = sum_of_sizes(force), reach = sum_of_sizes(lever) * 32;
    if (is_far_below(pulls, reach, slow, mass.mass) || pulls * reach < slow * slow * mass.mass) return false;
    const Vec3 speed = force / mass.mass / rate; // per substep
    const Vec3 r = rotate(conjugate(mass.principal), lever);
    const Vec3 f = rotate(conjugate(columns.pose[row].rotation * mass.principal), speed);
    const Real all = dot(r, f);
    for (int i = 0; i < 3; ++i) s.pull[i] = s.pull[i] + (all - r[i] * f[i]) / rate;
    return true;
}

/// (k^2 + s)^(1/2), s twice the pull, beyond a quarter of k^2: the pull is that of the last tick, and in this one grows.
Real stiffened(Real k, Real pull) {
    const Real own = k * k, more = pull * Real(2) - own / Real(4);
    return more > Real{} ? sqrt(own + more) : k;
}

void stiffen(const BodyColumns& columns, std::uint32_t row, const StepConstants& step, SolverBodies& bodies) {
    BodyStep& s = bodies.step[row];
    const Vec3& k = columns.mass[row].gyration;
    const Vec3 radii{stiffened(k.x, s.pull.x), stiffened(k.y, s.pull.y), stiffened(k.z, s.pull.z)};
    s.pull = Vec3{};
    if (radii != k) set_radii(columns, row, radii, step, bodies);
}

} // namespace

void stiffen_bodies(std::span<const Joint> joints, std::span<const JointMemory> memory,
                    const BodyColumns& columns, const StepConstants& step, SolverBodies& bodies) {
    bool any = false;
    for (const Joint& joint : joints) {
        const Vec3 force = memory[joint.memory].force;
        if (force == Vec3{}) continue;
        if (bodies.step[joint.body_a].movable)
            any |= add_pull(columns, joint.body_a, -force, joint.frame_a.position, step,
                            bodies.step[joint.body_a]);
        if (bodies.step[joint.body_b].movable)
            any |= add_pull(columns, joint.body_b, force, joint.frame_b.position, step,
                            bodies.step[joint.body_b]);
    }
    if (!any) return;
    for (const Joint& joint : joints)
        for (const std::uint32_t row : {joint.body_a, joint.body_b})
            if (bodies.step[row].movable && bodies.step[row].pull != Vec3{})
                stiffen(columns, row, step, bodies);
}

} // namespace lockstone::solve
