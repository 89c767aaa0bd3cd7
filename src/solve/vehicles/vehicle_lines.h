// Numbers and lines of vehicles: the chassis during a pass, speeds along lines, impulses. See vehicle.h.
//
//   number                 format            range in which products fit 64 bits
//   v, u of the chassis    64 bits, 24       below 256 and 64 m/s: Chassis::has_room(); Chassis::look() for small
//                                            wheels
//   d, x of a line         32 bits, 30 and 24
//   impulse                Real              up to 1 m/s
//
// Larger numbers use products of 128 bits, which give the same bits.
#pragma once

#include "solve/vehicles/vehicle_work.h"

#include <algorithm>
#include <concepts>

namespace lockstone::solve {

/// floor(w / 2^shift + 1/2) for a w whose result is below 2^62. It clamps nothing.
constexpr std::int64_t narrow_small(Wide w, int shift) {
    return (static_cast<std::int64_t>((w >> (shift - 1)).low_bits()) + 1) >> 1;
}

/// A Real whose results stay far from the end of its range, so that its operations need no clamps.
struct Small {
    std::int64_t raw;

    friend Small operator+(Small a, Small b) { return {a.raw + b.raw}; }
    friend Small operator-(Small a, Small b) { return {a.raw - b.raw}; }
    friend Small operator-(Small a) { return {-a.raw}; }
    friend Small operator*(Small a, Small b) {
        return {narrow_small(Wide::product(a.raw, b.raw), Real::fraction_bits)};
    }
    friend bool operator==(Small, Small) = default;
    friend auto operator<=>(Small, Small) = default;
};
/// Valid where the divisor is not large.
inline Small operator/(Small x, const Divisor& d) { return x * Small{d.inverse.raw}; }
inline Small abs(Small x) { return {x.raw < 0 ? -x.raw : x.raw}; }

/// Limits of a small wheel: arm of its spin; mobility of its patch alone, and with its rim; load [m/s]. Below these,
/// kappa p stays below 2^11, speeds below 2^15 m/s, arm p below 2^19, and kappa_rim load y, speed x and slides times
/// impulses below 2^29.
inline constexpr Real small_arm = Real(1 << 14), small_kappa = Real(1 << 6), small_kappa_rim = Real(1 << 18),
                      small_load = Real(2);

/// Limits of a small train: the change of the engine's speed by its torque in a substep [rad/s]; reciprocals of
/// inertia; ratios; torque impulses [N m s]; and all groups are small. Six couplings then change a group's spin by less
/// than 2^21 rad/s in a substep, and the sum over eight groups with their ratios stays below 2^31.
inline constexpr Real small_push = Real(1 << 12), small_inverse = Real(1 << 4), small_ratio = Real(1 << 6),
                      small_torque = Real(1 << 8);

template <class Number> Number number(Real x) {
    if constexpr (std::same_as<Number, Real>)
        return x;
    else
        return {x.raw};
}
inline Real real(Real x) { return x; }
inline Real real(Small x) { return Real::from_raw(x.raw); }

/// n / d for n >= 0 and d >= 0, with a relative error below 2^-29, and clamped: it divides mantissas of 62 and of 31
/// bits. n / 0 is the largest Real.
constexpr Real quotient(Real n, Real d) {
    if (n.raw <= 0) return Real{};
    if (d.raw <= 0) return Real::max();
    const int up = std::countl_zero(static_cast<std::uint64_t>(n.raw)) - 1,
              bits = bit_length(static_cast<std::uint64_t>(d.raw));
    const std::int64_t divisor = bits > 31 ? d.raw >> (bits - 31) : d.raw << (31 - bits);
    const std::int64_t q = static_cast<std::int64_t>(static_cast<std::uint64_t>(n.raw << up) /
                                                     static_cast<std::uint64_t>(divisor));
    const int raise = 31 + Real::fraction_bits - up - bits;
    if (raise >= 0) return Real::from_raw(shift_left_saturated(q, raise));
    return Real::from_raw(raise > -62 ? shift_right_rounded(q, -raise) : 0);
}

/// x / Real(count) for count > 0, without the common shift of both.
constexpr Real divided(Real x, std::int64_t count) { return Real::from_raw(divide_shifted(x.raw, count, 0)); }

inline constexpr int share_bits = 31;
/// n / d for 0 <= n <= d and d > 0, with share_bits fraction bits, from their leading 32 bits.
constexpr std::int64_t share_of(std::int64_t n, std::int64_t d) {
    const int bits = bit_length(static_cast<std::uint64_t>(d));
    if (bits > 32) n >>= bits - 32, d >>= bits - 32;
    return static_cast<std::int64_t>((static_cast<std::uint64_t>(n) << share_bits) /
                                     static_cast<std::uint64_t>(d));
}
/// x times a share.
template <class Number> constexpr Number part_of(Number x, std::int64_t share) {
    x.raw = narrow_small(Wide::product(x.raw, share), share_bits);
    return x;
}

// ---- lines ---------------------------------------------------------------------------------------------------------

inline constexpr int chassis_bits = 24, chassis_to_accumulator = accumulator_bits - chassis_bits;
/// Bits that a product drops: to a speed in Real, and to the change of a velocity by an impulse.
inline constexpr int speed_d_shift = chassis_bits + Unit::fraction_bits - Real::fraction_bits,
                     speed_x_shift = chassis_bits + Arm::fraction_bits - Real::fraction_bits,
                     push_d_shift = Real::fraction_bits + Unit::fraction_bits - chassis_bits,
                     push_x_shift = Real::fraction_bits + Arm::fraction_bits - chassis_bits;

/// floor(x / 2^Shift + 1/2), where adding one half does not overflow.
template <int Shift> constexpr std::int64_t rounded(std::int64_t x) {
    return (x + (std::int64_t{1} << (Shift - 1))) >> Shift;
}

/// The chassis of a vehicle during a pass.
struct Chassis {
    std::int64_t v[3], u[3], keep[3];
    bool roomy = false; ///< has room for the small wheels of the current loop over wheels

    explicit Chassis(const SolverBody& body) {
        for (int i = 0; i < 3; ++i) {
            v[i] = rounded<chassis_to_accumulator>(body.v[i]);
            u[i] = rounded<chassis_to_accumulator>(body.u[i]);
            keep[i] = body.keep[i];
        }
    }
    /// The condition of speed_along<Small>(): |v| is below 2^8 sqrt(3), and d has length 1; each component of u is
    /// below 2^6, and x is at most 2^6.
    bool has_room() const { return is_within<8>(v) && is_within<6>(u); }
    /// Sets `roomy`. Call it before a loop over wheels, and in the loop after each step except impulses of a small
    /// wheel of up to 1 m/s. A small wheel is ordinary, so its arms are below 8: two impulses of each of eight wheels
    /// add at most 16 to |v| and 128 to |u|.
    void look() { roomy = is_within<7>(v) && is_within<6>(u); }
    bool is_far() const { return !is_within<11>(v) || !is_within<11>(u); } ///< 2048 m/s or more

  private:
    template <int Bits> static bool is_within(const std::int64_t (&x)[3]) {
        constexpr std::int64_t most = std::int64_t{1} << (Bits + chassis_bits);
        return (static_cast<std::uint64_t>((x[0] + most) | (x[1] + most) | (x[2] + most)) >>
                (Bits + 1 + chassis_bits)) == 0;
    }
};

/// Speed of a point of a body along d [m/s], rounded twice.
template <class Number>
Number speed_along(const std::int64_t (&v)[3], const std::int64_t (&u)[3], const UnitVec3& d,
                   const Vector3<Arm>& x) {
    if constexpr (std::same_as<Number, Small>) {
        const std::int64_t along = v[0] * d.x.raw + v[1] * d.y.raw + v[2] * d.z.raw;
        const std::int64_t turning = u[0] * x.x.raw + u[1] * x.y.raw + u[2] * x.z.raw;
        return {rounded<speed_d_shift>(along) + rounded<speed_x_shift>(turning)};
    } else { // below 2^12 m/s, and arms below 2^6: sums stay below 2^85
        Wide along = Wide::from(0), turning = along;
        for (int i = 0; i < 3; ++i) {
            along = along + Wide::product(v[i], d[i].raw);
            turning = turning + Wide::product(u[i], x[i].raw);
        }
        return Real::from_raw(narrow_small(along, speed_d_shift) + narrow_small(turning, speed_x_shift));
    }
}

/// Speed of a moving ground at a patch.
Real ground_speed(const SolverBody& ground, const WheelLine& line);

/// Speed of the chassis' patch relative to the ground along a line [m/s].
template <class Number>
[[gnu::always_inline]] inline Number line_speed(const Chassis& chassis, const Wheel& wheel,
                                                const WheelLine& line, const SolverBodies& bodies) {
    const Number speed =
        speed_along<Number>(chassis.v, chassis.u, line.d, line.xc) - number<Number>(line.belt);
    if (!wheel.rides) [[likely]]
        return speed;
    return speed - number<Number>(ground_speed(bodies.body[wheel.ground], line));
}

void push_far(Chassis& chassis, const WheelLine& line, Real impulse);
void push_ground(const Wheel& wheel, const WheelLine& line, Real impulse, SolverBodies& bodies);

/// Adds an impulse along a line to the chassis, and the opposite impulse to the ground. A pass pushes the chassis at
/// most 40 times, so impulses of up to 1 m/s add at most 2560 m/s to the 2048 of push_far(): far from the end of an
/// accumulator.
inline void push_line(Chassis& chassis, const Wheel& wheel, const WheelLine& line, Real impulse,
                      SolverBodies& bodies) {
    constexpr std::uint64_t one = static_cast<std::uint64_t>(Real(1).raw);
    if (static_cast<std::uint64_t>(impulse.raw) + one <= 2 * one) [[likely]] {
        for (int i = 0; i < 3; ++i) {
            chassis.v[i] += rounded<push_d_shift>(impulse.raw * line.d[i].raw) & chassis.keep[i];
            chassis.u[i] += rounded<push_x_shift>(impulse.raw * line.xc[i].raw);
        }
    } else {
        push_far(chassis, line, impulse);
    }
    if (wheel.ratio > Real{}) [[unlikely]]
        push_ground(wheel, line, impulse, bodies);
}

/// Adds impulses along both lines of a tyre.
inline void push_tyre(Chassis& chassis, const Wheel& wheel, Real along, Real across, SolverBodies& bodies) {
    constexpr std::uint64_t one = static_cast<std::uint64_t>(Real(1).raw);
    const WheelLine &a = wheel.along, &s = wheel.across;
    const bool are_near = std::max(static_cast<std::uint64_t>(along.raw) + one,
                                   static_cast<std::uint64_t>(across.raw) + one) <= 2 * one;
    if (!are_near || wheel.ratio > Real{}) [[unlikely]] {
        push_line(chassis, wheel, a, along, bodies);
        return push_line(chassis, wheel, s, across, bodies);
    }
    for (int i = 0; i < 3; ++i) {
        chassis.v[i] +=
            (rounded<push_d_shift>(along.raw * a.d[i].raw) + rounded<push_d_shift>(across.raw * s.d[i].raw)) &
            chassis.keep[i];
        chassis.u[i] +=
            rounded<push_x_shift>(along.raw * a.xc[i].raw) + rounded<push_x_shift>(across.raw * s.xc[i].raw);
    }
}

/// Adds the impulses of all three lines of a wheel. Rounds once where they are up to 1 m/s together.
void push_lines(Chassis& chassis, const Wheel& wheel, SolverBodies& bodies);

/// Adds the changes of a pass to the body. Velocities stay within 2048 m/s, so that the rows of contacts can read them.
void write_back(const Chassis& chassis, SolverBody& body);

inline Real load_of(const Wheel& wheel) { return max(wheel.spring + wheel.stop + wheel.bars, Real{}); }

} // namespace lockstone::solve
