// Bodies as the solver sees them, in gyration-scaled form.
//
//   K = (inertia / mass)^(1/2)   gyration matrix in world axes [m], symmetric
//   u = K w                      angular velocity as tip speed [m/s]; theta = K (rotation vector) [m]
//
// Then a row's Jacobian K^-1 (r x n) has no unit and stays below 4 whatever the size of the body, and mass enters
// only as the ratio of the two masses of a pair: no inverse inertia, no wide dynamic range anywhere.
// Velocities are accumulated with 47 fraction bits, so that a row's product (28 + 19 bits) is added unrounded.
#pragma once

#include "base/parallel.h"
#include "base/paths.h"
#include "solve/bodies/body_kernel.h"
#include "solve/bodies/followed_body.h"
#include "solve/bodies/rows.h"
#include "solve/bodies/step.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace lockstone::solve {

inline constexpr int accumulator_bits = 47;
inline constexpr int row_bits = Jacobian::fraction_bits; ///< 28: accumulator_bits - Speed::fraction_bits
static_assert(accumulator_bits == Speed::fraction_bits + row_bits);
inline constexpr int real_to_accumulator = accumulator_bits - Real::fraction_bits;

/// What rows read and write.
struct SolverBody {
    std::int64_t v[3], u[3]; ///< [m/s], 47 fraction bits
    std::int32_t shift[3],
        theta[3];         ///< moved and turned (times K) since the start of the tick [m], Separation
    std::int64_t keep[3]; ///< all ones where the body may move along the axis, zero where locked
};

/// What a tick needs of a body besides its SolverBody; constant within the tick, but for K^-1 of followed bodies when it begins. The first
/// cache line is all that preparing a contact reads of it.
struct BodyStep : BodyInertia {
    /// Of gyration in this tick [m]: the body's own, or more where joints pull hard; joint_stiffness.h
    Vec3 radii;
    Vec3 radii_inv;                                ///< [1/m]; zero where the radius is
    Symmetric<Real> gyration, gyration_inv;        ///< K [m] and K^-1 [1/m], world axes
    std::int32_t gyration_bits, gyration_inv_bits; ///< of their entries: |raw| < 2^bits
    Unit linear_keep, angular_keep;                ///< velocity kept per substep under damping
};

/// What changes velocities besides impulses and damping; constant within the tick. What plain_falls is pushed by is the same for all.
struct BodyPush {
    std::int64_t dv[3], du[3]; ///< per substep by gravity, force and torque, 47 fraction bits
    Vec3 acceleration;         ///< [m/s^2] of gravity and force, for the integrators
};
/// What the integrator adds to the move of this substep [m], 32 fraction bits.
using BodyDrift = std::array<std::int64_t, 3>;

/// K^-2 along the principal axes [1/m^2], and by how much the largest is above the least: mantissas below 2^30, and the fraction bits of
/// each.
struct SpinForm {
    std::int32_t mantissa[4], bits[4];
};
/// Of w in principal axes, where the turn of a tick changes it: within 128 rad/s; beyond, all is done in Real.
inline constexpr int spin_bits = 24;

/// What a tick finds once for all bodies of the same traits: of their K.
struct alignas(16) GyrationForm {
    /// Of radii of gyration and of their reciprocals: 31 bits of each, and the bits that an entry of K drops after the products
    std::int32_t radii[4], inverses[4];
    Quat principal;
    SpinForm spin;
    Vec3 radii_inv; ///< [1/m]; zero where the radius is
    bool is_round;
    bool has_room;       ///< for products of 32 bits
    std::uint32_t start; ///< entry of SolverBodies::starts + 1, 0: none
};

/// What bodies of the same traits are alike in when a tick begins: of a dynamic body that no force pushes.
struct BodyStart {
    BodyStep step; ///< with K where it does not depend on how the body is turned
    BodyPush push;
    std::int64_t keep[3];
    std::uint8_t plain; ///< PlainMotion
    bool has_gyration;  ///< K is there, and the body turns about all axes
};
/// Of so many traits at most: they are made anew each tick. Bodies of others begin one by one.
inline constexpr std::size_t starts_max = 64;

struct FieldRow {
    FieldId id;
    FieldDef def;
};
template <class V> constexpr void describe(FieldRow& f, V&& v) { v("id", f.id), v("def", f.def); }

/// The body columns, by row, as the tick hands them over.
struct BodyColumns {
    std::span<const BodyInfo> info;
    std::span<const BodyTraits> all_traits; ///< those that info names
    std::span<const std::uint32_t> pushes;  ///< row + 1 of forces, 0: none
    std::span<const BodyForce> forces;
    std::span<Transform> pose;
    std::span<Velocity> velocity;
    MassView mass{info, all_traits};
    ForceView force{pushes, forces};

    const BodyTraits& traits(std::size_t row) const { return all_traits[info[row].traits]; }
};

/// Counters of clamped values; added to the state's by the tick.
struct ClampCounts {
    std::uint64_t speed = 0, position = 0, impulse = 0;
};

/// The bodies of one tick: row i of the columns is entry i; one more at the end stands still and takes what is
/// written to it, for the static side of a pair and for empty lanes.
struct SolverBodies {
    std::vector<SolverBody> body;
    std::vector<BodyStep> step;
    std::vector<BodyPush> push;   ///< by body, of those that are not plain_falls
    std::vector<BodyDrift> drift; ///< by body, where an integrator adds to moves; or empty
    std::vector<Vec3> pull;       ///< by body, what joints ask of its radii [m^2], while that is found
    /// The same of a joint: its part of the pull of up to two bodies.
    struct JointPulls {
        std::uint32_t count, row[2];
        Vec3 pull[2];
    };
    std::vector<JointPulls> joint_pulls; ///< by joint, where workers find them
    std::vector<FollowedTurn> turns;     ///< of some bodies, filled up to fours
    std::vector<FollowedFour> fours;     ///< the same four side by side
    std::vector<std::uint8_t> plain;     ///< PlainMotion, by body
    std::vector<GyrationForm> forms;     ///< of the traits that bodies have
    std::vector<std::uint32_t> form_of;  ///< by row of traits: entry of forms + 1, 0: no body has them
    std::vector<BodyStart> starts;       ///< of the first of these forms
    BodyPush fall;                       ///< of what gravity alone pushes
    ClampCounts clamps;
    const BodyKernel* kernel = nullptr; ///< null: all bodies are moved one by one, to the same bits
    base::Paths paths;                  ///< of the tick

    void reserve(std::size_t bodies) {
        body.reserve(bodies + 1), step.reserve(bodies + 1), push.reserve(bodies), turns.reserve(bodies),
            fours.reserve(bodies / followed_lanes + 1), plain.reserve(bodies);
        forms.reserve(bodies), form_of.reserve(bodies), starts.reserve(starts_max);
    }
    std::uint32_t still() const { return static_cast<std::uint32_t>(body.size() - 1); }
};

/// m v rounded once per component.
template <FixedPoint To, FixedPoint B> constexpr Vector3<To> mul(const Symmetric<Real>& m, Vector3<B> v) {
    using Sum = SumOfProducts<Real, B>;
    return {Sum{}.add(m.xx, v.x).add(m.xy, v.y).add(m.xz, v.z).template round<To>(),
            Sum{}.add(m.xy, v.x).add(m.yy, v.y).add(m.yz, v.z).template round<To>(),
            Sum{}.add(m.xz, v.x).add(m.yz, v.y).add(m.zz, v.z).template round<To>()};
}

/// The same, quick where m and v are small: every |entry| of m is below 2^bits.
template <FixedPoint To, FixedPoint B>
Vector3<To> mul(const Symmetric<Real>& m, std::int32_t bits, Vector3<B> v) {
    constexpr int drop = Real::fraction_bits + B::fraction_bits - To::fraction_bits;
    static_assert(drop > 0);
    const std::int64_t x = v.x.raw, y = v.y.raw, z = v.z.raw;
    const std::uint64_t any = static_cast<std::uint64_t>((x ^ (x >> 63)) | (y ^ (y >> 63)) | (z ^ (z >> 63)));
    // Three products below 2^61, and half of a step of the result.
    if (bits > 61 || (any >> (61 - bits)) != 0) return mul<To>(m, v);
    const auto round = [](std::int64_t sum) {
        return round_from<To>((sum + (std::int64_t{1} << (drop - 1))) >> drop, To::fraction_bits);
    };
    return {round(m.xx.raw * x + m.xy.raw * y + m.xz.raw * z),
            round(m.xy.raw * x + m.yy.raw * y + m.yz.raw * z),
            round(m.xz.raw * x + m.yz.raw * y + m.zz.raw * z)};
}
/// K v and K^-1 v.
template <FixedPoint To, FixedPoint B> Vector3<To> by_gyration(const BodyStep& s, Vector3<B> v) {
    return mul<To>(s.gyration, s.gyration_bits, v);
}
template <FixedPoint To, FixedPoint B> Vector3<To> over_gyration(const BodyStep& s, Vector3<B> v) {
    return mul<To>(s.gyration_inv, s.gyration_inv_bits, v);
}

/// R diag(d) R^T. Equal entries give a multiple of the unit matrix without rounding.
Symmetric<Real> rotated_diagonal(const Rotation& r, Vec3 d);

/// Shortens v (47 fraction bits) to `limit` when it is longer. True when it was.
bool clamp_long(std::int64_t v[3], Speed limit);
/// A greatest length, and the k with which |x| < 2^k along each axis is for certain within it: 3 * 2^2k is not above its square.
struct LengthLimit {
    Speed most;
    int k;
    explicit LengthLimit(Speed limit)
        : most(limit), k(std::max(bit_length(static_cast<std::uint32_t>(limit.raw)) - 2, 0) + row_bits) {}
};
/// The same, quick for what is far within.
inline bool clamp_length(std::int64_t v[3], LengthLimit limit) {
    const std::int64_t any = (v[0] ^ (v[0] >> 63)) | (v[1] ^ (v[1] >> 63)) | (v[2] ^ (v[2] >> 63));
    return (any >> limit.k) != 0 && clamp_long(v, limit.most);
}
inline bool clamp_length(std::int64_t v[3], Speed limit) { return clamp_length(v, LengthLimit(limit)); }

/// Bodies per piece of work that workers take.
inline constexpr std::uint32_t body_chunk = 64;

/// Reads the columns into `out`: K of each pose, u of each velocity, the constant changes per substep.
void begin_step(const BodyColumns& columns, Vec3 gravity, const StepConstants& step, SolverBodies& out,
                Tasks* tasks = nullptr);
/// K of a body whose radii differ, at these principal axes.
void set_gyration(BodyStep& s, const Rotation& axes);
/// Turning parts of a dynamic body's entries for other radii of gyration, its angular velocity kept.
void set_radii(const BodyColumns& columns, std::uint32_t row, Vec3 radii, const StepConstants& step,
               SolverBodies& bodies, ClampCounts& clamps);
/// Writes poses and velocities back: moves by `shift`, turns by K^-1 theta, keeps angular momentum through the turn. `before` takes the
/// poses as they were, by row, or is empty.
void finish_step(const StepConstants& step, SolverBodies& bodies, const BodyColumns& columns,
                 Tasks* tasks = nullptr, std::span<Transform> before = {});

} // namespace lockstone::solve
