// Bodies in the form that the solver uses, scaled by their gyration.
//
//   K = (inertia / mass)^(1/2)   gyration matrix in world axes [m], symmetric
//   u = K w                      angular velocity as tip speed [m/s]; theta = K (rotation vector) [m]
//
// So the Jacobian of a row, K^-1 (r x n), has no unit and stays below 4 for bodies of any size, and mass enters only as
// the ratio of the two masses of a pair: no formula needs an inverse inertia or a wide dynamic range. Velocities are
// accumulated with 47 fraction bits, so that the product of a row (28 + 19 bits) is added without rounding.
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

/// The part of a body that rows read and write.
struct SolverBody {
    std::int64_t v[3], u[3]; ///< [m/s], 47 fraction bits
    /// motion and turn (times K) since the start of the tick [m], Separation
    std::int32_t shift[3], theta[3];
    std::int64_t keep[3]; ///< all ones where the body may move along the axis, zero where it is locked
};

/// The other data of a body in a tick. It is constant within the tick, except K^-1 of followed bodies, which changes
/// before passes begin. Preparing a contact reads the first cache line only.
struct BodyStep : BodyInertia {
    /// Radii of gyration in this tick [m]: the body's own, or larger where joints pull hard; joint_stiffness.h
    Vec3 radii;
    Vec3 radii_inv;                                ///< [1/m]; zero where the radius is zero
    Symmetric<Real> gyration, gyration_inv;        ///< K [m] and K^-1 [1/m], world axes
    std::int32_t gyration_bits, gyration_inv_bits; ///< of their entries: |raw| < 2^bits
    Unit linear_keep, angular_keep;                ///< factor of the velocity per substep by damping
};

/// The changes of velocities besides impulses and damping; constant within the tick. Bodies with plain_falls share
/// SolverBodies::fall instead.
struct BodyPush {
    std::int64_t dv[3], du[3]; ///< per substep by gravity, force and torque, 47 fraction bits
    Vec3 acceleration;         ///< [m/s^2] of gravity and force, for the integrators
};
/// The move that the integrator adds to the velocity's move in this substep [m], 32 fraction bits.
using BodyDrift = std::array<std::int64_t, 3>;

/// K^-2 along the principal axes [1/m^2], and the difference between the largest and the least of them: mantissas below
/// 2^30, and the fraction bits of each.
struct SpinForm {
    std::int32_t mantissa[4], bits[4];
};
/// Fraction bits of w in principal axes, where the turn of a tick changes w: within 128 rad/s. Faster spins are
/// computed in Real.
inline constexpr int spin_bits = 24;

/// Data about K that a tick computes once for all bodies with the same traits.
struct alignas(16) GyrationForm {
    /// Radii of gyration, and their reciprocals: 31 bits of each, then the bits that an entry of K drops after the
    /// products
    std::int32_t radii[4], inverses[4];
    Quat principal;
    SpinForm spin;
    Vec3 radii_inv; ///< [1/m]; zero where the radius is zero
    bool is_round;
    bool has_room;       ///< products of 32 bits have room
    std::uint32_t start; ///< entry of SolverBodies::starts + 1, 0: none
};

/// The data that dynamic bodies with the same traits share at the start of a tick, if no force pushes them.
struct BodyStart {
    BodyStep step; ///< with K where K does not depend on the rotation of the body
    BodyPush push;
    std::int64_t keep[3];
    std::uint8_t plain; ///< PlainMotion
    bool has_gyration;  ///< `step` has K, and the body turns about all axes
};
/// The largest number of traits with a BodyStart, which every tick computes again. Bodies with other traits begin one
/// by one.
inline constexpr std::size_t starts_max = 64;

struct FieldRow {
    FieldId id;
    FieldDef def;
};
template <class V> constexpr void describe(FieldRow& f, V&& v) { v("id", f.id), v("def", f.def); }

/// The body columns, by row, as the tick passes them.
struct BodyColumns {
    std::span<const BodyInfo> info;
    std::span<const BodyTraits> all_traits; ///< the traits that info refers to
    std::span<const std::uint32_t> pushes;  ///< row + 1 of forces, 0: none
    std::span<const BodyForce> forces;
    std::span<Transform> pose;
    std::span<Velocity> velocity;
    MassView mass{info, all_traits};
    ForceView force{pushes, forces};

    const BodyTraits& traits(std::size_t row) const { return all_traits[info[row].traits]; }
};

/// Counts of clamped values; the tick adds them to those of the state.
struct ClampCounts {
    std::uint64_t speed = 0, position = 0, impulse = 0;
};

/// The bodies of one tick: entry i is row i of the columns. One more entry at the end, the still body, does not move.
/// It is the static side of a pair and the body of empty lanes; values written to it have no effect.
struct SolverBodies {
    std::vector<SolverBody> body;
    std::vector<BodyStep> step;
    std::vector<BodyPush> push;   ///< by body; set for bodies without plain_falls
    std::vector<BodyDrift> drift; ///< by body, where an integrator adds to moves; otherwise empty
    /// by body: the change of its radii that joints request [m^2], while it is computed
    std::vector<Vec3> pull;
    /// The pull of one joint: its part of the pulls of up to two bodies.
    struct JointPulls {
        std::uint32_t count, row[2];
        Vec3 pull[2];
    };
    std::vector<JointPulls> joint_pulls; ///< by joint, where workers compute them
    std::vector<FollowedTurn> turns;     ///< of followed bodies, with empty entries up to a multiple of four
    std::vector<FollowedFour> fours;     ///< the same bodies, four side by side
    std::vector<std::uint8_t> plain;     ///< PlainMotion, by body
    std::vector<GyrationForm> forms;     ///< of the traits that bodies have
    std::vector<std::uint32_t> form_of;  ///< by row of traits: entry of forms + 1, 0: no body has them
    std::vector<BodyStart> starts;       ///< of the first of these forms
    BodyPush fall;                       ///< the push of bodies that gravity alone pushes
    ClampCounts clamps;
    const BodyKernel* kernel = nullptr; ///< null: all bodies are moved one by one, with the same bits
    base::Paths paths;                  ///< of the tick

    void reserve(std::size_t bodies) {
        body.reserve(bodies + 1), step.reserve(bodies + 1), push.reserve(bodies), turns.reserve(bodies),
            fours.reserve(bodies / followed_lanes + 1), plain.reserve(bodies);
        forms.reserve(bodies), form_of.reserve(bodies), starts.reserve(starts_max);
    }
    std::uint32_t still() const { return static_cast<std::uint32_t>(body.size() - 1); }
};

/// m v, each component rounded once.
template <FixedPoint To, FixedPoint B> constexpr Vector3<To> mul(const Symmetric<Real>& m, Vector3<B> v) {
    using Sum = SumOfProducts<Real, B>;
    return {Sum{}.add(m.xx, v.x).add(m.xy, v.y).add(m.xz, v.z).template round<To>(),
            Sum{}.add(m.xy, v.x).add(m.yy, v.y).add(m.yz, v.z).template round<To>(),
            Sum{}.add(m.xz, v.x).add(m.yz, v.y).add(m.zz, v.z).template round<To>()};
}

/// This product, quick for small m and v: every |entry| of m is below 2^bits.
template <FixedPoint To, FixedPoint B>
Vector3<To> mul(const Symmetric<Real>& m, std::int32_t bits, Vector3<B> v) {
    constexpr int drop = Real::fraction_bits + B::fraction_bits - To::fraction_bits;
    static_assert(drop > 0);
    const std::int64_t x = v.x.raw, y = v.y.raw, z = v.z.raw;
    const std::uint64_t any = static_cast<std::uint64_t>((x ^ (x >> 63)) | (y ^ (y >> 63)) | (z ^ (z >> 63)));
    // Three products below 2^61, and half of a unit of the result.
    if (bits > 61 || (any >> (61 - bits)) != 0) return mul<To>(m, v);
    const auto round = [](std::int64_t sum) {
        return round_from<To>((sum + (std::int64_t{1} << (drop - 1))) >> drop, To::fraction_bits);
    };
    return {round(m.xx.raw * x + m.xy.raw * y + m.xz.raw * z),
            round(m.xy.raw * x + m.yy.raw * y + m.yz.raw * z),
            round(m.xz.raw * x + m.yz.raw * y + m.zz.raw * z)};
}
/// K v, and K^-1 v.
template <FixedPoint To, FixedPoint B> Vector3<To> by_gyration(const BodyStep& s, Vector3<B> v) {
    return mul<To>(s.gyration, s.gyration_bits, v);
}
template <FixedPoint To, FixedPoint B> Vector3<To> over_gyration(const BodyStep& s, Vector3<B> v) {
    return mul<To>(s.gyration_inv, s.gyration_inv_bits, v);
}

/// R diag(d) R^T. Equal entries give a multiple of the unit matrix without rounding.
Symmetric<Real> rotated_diagonal(const Rotation& r, Vec3 d);

/// Shortens v (47 fraction bits) to `limit` if it is longer, and then returns true.
bool clamp_long(std::int64_t v[3], Speed limit);
/// A limit of lengths, and a k such that a vector with |x| < 2^k along each axis is within the limit: 3 * 2^2k is at
/// most its square.
struct LengthLimit {
    Speed most;
    int k;
    explicit LengthLimit(Speed limit)
        : most(limit), k(std::max(bit_length(static_cast<std::uint32_t>(limit.raw)) - 2, 0) + row_bits) {}
};
/// Like clamp_long(), and quick for vectors far within the limit.
inline bool clamp_length(std::int64_t v[3], LengthLimit limit) {
    const std::int64_t any = (v[0] ^ (v[0] >> 63)) | (v[1] ^ (v[1] >> 63)) | (v[2] ^ (v[2] >> 63));
    return (any >> limit.k) != 0 && clamp_long(v, limit.most);
}
inline bool clamp_length(std::int64_t v[3], Speed limit) { return clamp_length(v, LengthLimit(limit)); }

/// Bodies per piece of work that a worker takes.
inline constexpr std::uint32_t body_chunk = 64;

/// Reads the columns into `out`: K of each pose, u of each velocity, the constant changes per substep.
void begin_step(const BodyColumns& columns, Vec3 gravity, const StepConstants& step, SolverBodies& out,
                Tasks* tasks = nullptr);
/// Sets K of a body whose radii differ, for these principal axes.
void set_gyration(BodyStep& s, const Rotation& axes);
/// Sets the angular data of a dynamic body for other radii of gyration; its angular velocity stays.
void set_radii(const BodyColumns& columns, std::uint32_t row, Vec3 radii, const StepConstants& step,
               SolverBodies& bodies, ClampCounts& clamps);
/// Writes poses and velocities back: moves by `shift`, turns by K^-1 theta, and keeps angular momentum through the
/// turn. `before` gets the poses before this, by row, unless it is empty.
void finish_step(const StepConstants& step, SolverBodies& bodies, const BodyColumns& columns,
                 Tasks* tasks = nullptr, std::span<Transform> before = {});

} // namespace lockstone::solve
