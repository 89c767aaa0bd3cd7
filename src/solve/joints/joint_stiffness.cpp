#include "solve/joints/joint_stiffness.h"

#include "base/prefetch.h"
#include "lockstone/math/math.h"
#include "solve/joints/joint_rows.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

/// m / 2^bits, entries within 2^30.
struct CutVector {
    std::int64_t m[3];
    int bits;
};
CutVector cut(const std::int64_t (&v)[3], int bits) {
    const std::uint64_t any = magnitude(v[0]) | magnitude(v[1]) | magnitude(v[2]);
    const int drop = std::max(bit_length(any) - 30, 0);
    return {{v[0] >> drop, v[1] >> drop, v[2] >> drop}, bits - drop};
}
CutVector cut(Vec3 v) { return cut({v.x.raw, v.y.raw, v.z.raw}, Real::fraction_bits); }

/// R^T v, not longer than v
CutVector turned_back(const Rotation& r, const CutVector& v) {
    const auto along = [&](const UnitVec3& e) {
        return (e.x.raw * v.m[0] + e.y.raw * v.m[1] + e.z.raw * v.m[2]) >> Unit::fraction_bits;
    };
    return {{along(r.x), along(r.y), along(r.z)}, v.bits};
}

/// h^2 / m as mantissa / 2^bits, the mantissa from 2^30 to 2^31. For rates up to 2^15 substeps a second, m rate^2 has
/// 62 bits.
struct Reciprocal {
    std::int64_t mantissa;
    int bits;
};
Reciprocal push_of(Real mass, std::int64_t rate) {
    const int length = bit_length(magnitude(mass.raw)), drop = std::max(length - 32, 0);
    const std::uint64_t all = magnitude(mass.raw >> drop) * magnitude(rate * rate);
    const int up = 64 - bit_length(all);
    const std::uint64_t q = (std::uint64_t{1} << 63) / ((all << up) >> 32); // in [2^31, 2^32]
    return {static_cast<std::int64_t>(q >> 1), 62 + drop - up};
}

/// A nonnegative number, mantissa 2^exponent: the mantissa has 16 bits, or is zero.
struct Size {
    std::int64_t mantissa;
    int exponent;
};
/// `v` 2^-bits, rounded down
Size size_of(std::uint64_t v, int bits) {
    const int drop = bit_length(v) - 16;
    return {static_cast<std::int64_t>(drop > 0 ? v >> drop : v << -drop), drop - bits};
}
Size length_of(Vec3 v) {
    Size size = size_of(length_above(v), Real::fraction_bits);
    ++size.mantissa;
    return size;
}

/// m (k rate)^2: the mantissa is below 2^32.
Size resistance_of(Real k, Real mass, std::int64_t rate) {
    const Size turns = size_of(magnitude(k.raw), Real::fraction_bits), often = size_of(magnitude(rate), 0),
               heavy = size_of(magnitude(mass.raw), Real::fraction_bits);
    const std::int64_t square = turns.mantissa * often.mantissa >> 16;
    return {(square * square >> 16) * heavy.mantissa,
            2 * (turns.exponent + often.exponent + 16) + 16 + heavy.exponent};
}

} // namespace

std::uint64_t length_above(Vec3 v) {
    std::uint64_t a = magnitude(v.x.raw), b = magnitude(v.y.raw), c = magnitude(v.z.raw);
    if (a < b) std::swap(a, b);
    if (a < c) std::swap(a, c);
    if (b < c) std::swap(b, c);
    return a + 7 * (b >> 4) + 6 * (c >> 4) + 13;
}

bool is_too_weak(Vec3 f, Vec3 r, Real k, Real mass, std::int64_t rate) {
    const Size a = length_of(f), b = length_of(r), right = resistance_of(k, mass, rate);
    const std::int64_t left = a.mantissa * b.mantissa << 5;
    const int apart = right.exponent - a.exponent - b.exponent;
    // Both mantissas are below 2^40, and that of `right` is above 2^27.
    return apart >= 0 ? apart > 12 || left < right.mantissa << apart
                      : apart >= -40 && left < right.mantissa >> -apart;
}

std::uint64_t weak_force(Vec3 r, Real k, Real mass, std::int64_t rate) {
    const Size b = length_of(r), right = resistance_of(k, mass, rate);
    // 1 / 128 smaller: is_too_weak() rounds up by 2^-15 and by one unit of a number above 2^35.
    const auto least = static_cast<std::uint64_t>(right.mantissa - (right.mantissa >> 7));
    const std::uint64_t force = (least << 28) / static_cast<std::uint64_t>(b.mantissa);
    const int up = right.exponent - b.exponent + Real::fraction_bits - 28 - 5;
    if (up <= 0) return -up < 64 ? force >> -up : 0;
    return bit_length(force) + up > 63 ? std::uint64_t{1} << 63 : force << up;
}

bool is_strong(std::uint64_t force, std::uint64_t weak) {
    return weak != 0 && weak < std::uint64_t{1} << 62 && force > weak + (weak >> 5) + 2;
}

void find_weak_forces(std::span<Joint> joints, const BodyColumns& columns, const StepConstants& step,
                      const SolverBodies& bodies) {
    const auto of = [&](std::uint32_t row, const Transform& frame) {
        if (!bodies.step[row].movable) return UINT64_MAX;
        const BodyMass& mass = columns.mass[row];
        return weak_force(frame.position - mass.center,
                          min(mass.gyration.x, min(mass.gyration.y, mass.gyration.z)), mass.mass,
                          step.substeps_per_second);
    };
    for (Joint& joint : joints)
        joint.weak_a = of(joint.body_a, joint.frame_a), joint.weak_b = of(joint.body_b, joint.frame_b);
}

namespace {

/// Adds h^2 ((r . f) 1 - r f^T) / m of one side, the diagonal in principal axes [m^2]. Returns false if the pull is
/// too weak to matter. `strong`: the caller knows that it is not.
bool add_pull(const BodyColumns& columns, std::uint32_t row, Vec3 force, Vec3 place, bool strong,
              const StepConstants& step, Vec3& pull) {
    const BodyMass& mass = columns.mass[row];
    const Vec3 away = place - mass.center;
    if (!strong && is_too_weak(force, away, min(mass.gyration.x, min(mass.gyration.y, mass.gyration.z)),
                               mass.mass, step.substeps_per_second))
        return false;
    const CutVector pulls = cut(force), lever = cut(away);
    const bool turned = mass.principal != Quat::identity();
    const Quat pose = columns.pose[row].rotation;
    const CutVector f = turned_back(to_rotation(turned ? pose * mass.principal : pose), pulls);
    const CutVector r = turned ? turned_back(to_rotation(mass.principal), lever) : lever;
    const Reciprocal push = push_of(mass.mass, step.substeps_per_second);
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3; // r . f minus the part along the axis: 61 bits, twice
        const std::int64_t across = (r.m[j] * f.m[j] + r.m[k] * f.m[k]) >> 31;
        const int bits = r.bits + f.bits - 31 + push.bits;
        pull[i] += Real::from_raw(shifted(across * push.mantissa, bits - Real::fraction_bits));
    }
    return true;
}

/// (k^2 + s)^(1/2) with s = twice the pull minus a quarter of k^2, if positive. The factor 2 is there because the
/// pull is that of the last tick and may grow in this one.
Real stiffened(Real k, Real pull) {
    const Real own = k * k, more = pull + pull - Real::from_raw(shift_right_rounded(own.raw, 2));
    return more > Real{} ? sqrt(own + more) : k;
}

void stiffen(const BodyColumns& columns, std::uint32_t row, const StepConstants& step, SolverBodies& bodies,
             ClampCounts& clamps) {
    Vec3& pull = bodies.pull[row];
    const Vec3& k = columns.mass[row].gyration;
    const Vec3 radii{stiffened(k.x, pull.x), stiffened(k.y, pull.y), stiffened(k.z, pull.z)};
    pull = Vec3{};
    if (radii != k) set_radii(columns, row, radii, step, bodies, clamps);
}

} // namespace

namespace {

constexpr std::uint32_t stiffness_chunk = 64;

/// Calls visit(row, pull) for each body that joint `i` pulls at.
template <class Visit>
void pull_of(std::span<const Joint> joints, std::size_t i, std::span<const JointMemory> memory,
             const BodyColumns& columns, const StepConstants& step, const SolverBodies& bodies,
             Visit&& visit) {
    const Joint& joint = joints[i];
    if (i + 4 < joints.size()) base::prefetch(memory[joints[i + 4].memory].force);
    const Vec3 force = memory[joint.memory].force;
    if (force == Vec3{}) return;
    const std::uint64_t size = length_above(force);
    const auto of = [&](std::uint32_t row, Vec3 on_it, const Transform& frame, std::uint64_t weak) {
        Vec3 pull{};
        if (size > weak && bodies.step[row].movable &&
            add_pull(columns, row, on_it, frame.position, is_strong(size, weak), step, pull))
            visit(row, pull);
    };
    of(joint.body_a, -force, joint.frame_a, joint.weak_a);
    of(joint.body_b, force, joint.frame_b, joint.weak_b);
}

} // namespace

void stiffen_bodies(std::span<const Joint> joints, std::span<const JointMemory> memory,
                    const BodyColumns& columns, const StepConstants& step, SolverBodies& bodies,
                    Tasks* tasks) {
    bodies.pull.clear();
    const auto add = [&](std::uint32_t row, const Vec3& pull) {
        if (bodies.pull.empty()) bodies.pull.resize(bodies.body.size());
        bodies.pull[row] += pull;
    };
    const std::uint32_t count = static_cast<std::uint32_t>(joints.size());
    const bool by_one = tasks == nullptr || count < 4 * stiffness_chunk;
    bodies.paths.take(by_one, base::Path::stiffness_by_workers, base::Path::stiffness_by_one);
    if (by_one) {
        for (std::size_t i = 0; i < joints.size(); ++i)
            pull_of(joints, i, memory, columns, step, bodies, add);
    } else { // joints share bodies: workers compute the pulls, and one thread adds them
        using Pulls = SolverBodies::JointPulls;
        bodies.joint_pulls.resize(count);
        base::for_all_chunks(
            tasks, count, stiffness_chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                for (std::uint32_t i = first; i < last; ++i) {
                    Pulls& found = bodies.joint_pulls[i];
                    found.count = 0;
                    pull_of(joints, i, memory, columns, step, bodies,
                            [&](std::uint32_t row, const Vec3& pull) {
                                found.row[found.count] = row, found.pull[found.count++] = pull;
                            });
                }
            });
        for (const Pulls& found : bodies.joint_pulls)
            for (std::uint32_t k = 0; k < found.count; ++k) add(found.row[k], found.pull[k]);
    }
    base::for_chunks(tasks, static_cast<std::uint32_t>(bodies.pull.size()), body_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         ClampCounts clamps;
                         for (std::uint32_t row = first; row < last; ++row)
                             if (bodies.pull[row] != Vec3{}) stiffen(columns, row, step, bodies, clamps);
                         base::add_count(bodies.clamps.speed, clamps.speed);
                     });
}

} // namespace lockstone::solve
