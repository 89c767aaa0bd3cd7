// Numbers and lines of vehicles: the chassis within a pass, speeds along lines, impulses. See vehicle.h.
//
//   number                 format            products of 64 bits have room
//   v, u of the chassis    64 bits, 24       below 256 and 64 m/s: Chassis::has_room(); or a chassis' small wheels
//   d, x of a line         32 bits, 30 and 24
//   impulse                Real              up to 1 m/s
//
// Numbers beyond that take products of 128 bits, which give the same bits.
#pragma once

#include "solve/vehicles/vehicle_work.h"

#include <algorithm>
#include <concepts>

namespace lockstone::solve {

/// floor(w / 2^shift + 1/2) of a w whose result is below 2^62: nothing is clamped.
constexpr std::int64_t narrow_small(Wide w, int shift) {
    return (static_cast<std::int64_t>((w >> (shift - 1)).low_bits()) + 1) >> 1;
}

/// A Real whose results are known to stay far from the end of its range, so that nothing has to be clamped.
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
inline Small operator/(Small x, const Divisor& d) {
    return x * Small{d.inverse.raw};
} ///< of a divisor that is not large
inline Small abs(Small x) { return {x.raw < 0 ? -x.raw : x.raw}; }

/// A wheel is small below these: arms of its spin and mobilities, of its patch alone and with its rim; its load [m/s]. Then kappa p stays
/// below 2^11, speeds below 2^15 m/s, arm p below 2^19, and kappa_rim load y, speed x and slides times impulses below 2^29.
inline constexpr Real small_arm = Real(1 << 14), small_kappa = Real(1 << 6), small_kappa_rim = Real(1 << 18),
                      small_load = Real(2);

/// A train is small below these: what the engine's torque gives it in a substep [rad/s]; reciprocals of inertia; ratios; torque
/// impulses [N m s]; and where all groups are. Six couplings give a group less than 2^21 rad/s in a substep, and eight groups through
/// their ratios stay below 2^31.
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

/// n / d of n >= 0 and d >= 0, within 2^-29 of it and clamped: mantissas of 62 and of 31 bits are divided. n / 0 is the largest Real.
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

/// x / Real(count) of count > 0, without the bits that both are shifted by.
constexpr Real divided(Real x, std::int64_t count) { return Real::from_raw(divide_shifted(x.raw, count, 0)); }

inline constexpr int share_bits = 31;
/// n / d of 0 <= n <= d, d > 0, with share_bits fraction bits: of their leading 32 bits.
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
/// Bits that a product drops: to a Real of speed, and to what an impulse changes.
inline constexpr int speed_d_shift = chassis_bits + Unit::fraction_bits - Real::fraction_bits,
                     speed_x_shift = chassis_bits + Arm::fraction_bits - Real::fraction_bits,
                     push_d_shift = Real::fraction_bits + Unit::fraction_bits - chassis_bits,
                     push_x_shift = Real::fraction_bits + Arm::fraction_bits - chassis_bits;

/// floor(x / 2^Shift + 1/2), where half a step has room.
template <int Shift> constexpr std::int64_t rounded(std::int64_t x) {
    return (x + (std::int64_t{1} << (Shift - 1))) >> Shift;
}

/// The chassis of a vehicle while a pass works on it.
struct Chassis {
    std::int64_t v[3], u[3], keep[3];
    bool roomy = false; ///< for the small wheels of this loop over them

    explicit Chassis(const SolverBody& body) {
        for (int i = 0; i < 3; ++i) {
            v[i] = rounded<chassis_to_accumulator>(body.v[i]);
            u[i] = rounded<chassis_to_accumulator>(body.u[i]);
            keep[i] = body.keep[i];
        }
    }
    /// For speed_along<Small>(): |v| below 2^8 sqrt(3), and d has the length 1; |u| below 2^6 by component, and x at most 2^6.
    bool has_room() const { return is_within<8>(v) && is_within<6>(u); }
    /// Before a loop over wheels, and in it after anything but a small wheel's impulses of up to 1 m/s. Arms of a small wheel are
    /// below 8, for it is ordinary: two impulses of each of eight wheels add at most 16 to |v| and 128 to |u|.
    void look() { roomy = is_within<7>(v) && is_within<6>(u); }
    bool is_far() const { return !is_within<11>(v) || !is_within<11>(u); } ///< at 2048 m/s or beyond

  private:
    template <int Bits> static bool is_within(const std::int64_t (&x)[3]) {
        constexpr std::int64_t most = std::int64_t{1} << (Bits + chassis_bits);
        return (static_cast<std::uint64_t>((x[0] + most) | (x[1] + most) | (x[2] + most)) >>
                (Bits + 1 + chassis_bits)) == 0;
    }
};

/// Speed of a place of a body along d [m/s], rounded twice.
template <class Number>
Number speed_along(const std::int64_t (&v)[3], const std::int64_t (&u)[3], const UnitVec3& d,
                   const Vector3<Arm>& x) {
    if constexpr (std::same_as<Number, Small>) {
        const std::int64_t along = v[0] * d.x.raw + v[1] * d.y.raw + v[2] * d.z.raw;
        const std::int64_t turning = u[0] * x.x.raw + u[1] * x.y.raw + u[2] * x.z.raw;
        return {rounded<speed_d_shift>(along) + rounded<speed_x_shift>(turning)};
    } else { // below 2^12 m/s and arms below 2^6: sums stay below 2^85
        Wide along = Wide::from(0), turning = along;
        for (int i = 0; i < 3; ++i) {
            along = along + Wide::product(v[i], d[i].raw);
            turning = turning + Wide::product(u[i], x[i].raw);
        }
        return Real::from_raw(narrow_small(along, speed_d_shift) + narrow_small(turning, speed_x_shift));
    }
}

/// Speed of a ground that moves, at a patch.
Real ground_speed(const SolverBody& ground, const WheelLine& line);

/// Speed of the chassis' patch over the ground along a line [m/s].
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

/// Adds an impulse along a line to the chassis, and its reverse to the ground. A pass pushes the chassis 40 times at most, so impulses of
/// up to 1 m/s add at most 2560 m/s to the 2048 of push_far(): far from the end of an accumulator.
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

/// The same along both lines of a tyre.
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

/// The impulses of all three lines of a wheel, rounded once where they are up to 1 m/s together.
void push_lines(Chassis& chassis, const Wheel& wheel, SolverBodies& bodies);

/// Adds to a body what a pass changed of it. Velocities stay within 2048 m/s, where the rows of contacts can read them.
void write_back(const Chassis& chassis, SolverBody& body);

inline Real load_of(const Wheel& wheel) { return max(wheel.spring + wheel.stop + wheel.bars, Real{}); }

} // namespace lockstone::solve
