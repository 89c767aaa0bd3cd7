// The angular momentum per mass of a body, which a turn without torque keeps, and the spin that follows from it. The
// quick form has room for most bodies; the wide form has room for all.
#pragma once

#include "lockstone/math/math.h"
#include "solve/bodies/solver_body.h"

#include <algorithm>

namespace lockstone::solve {

inline SpinForm spin_form(Vec3 radii_inv) {
    SpinForm form{};
    const auto set = [&form](int i, Wide square) { // 64 fraction bits
        const std::uint64_t high = static_cast<std::uint64_t>(square.high_bits());
        const int size = high != 0 ? 64 + bit_length(high) : bit_length(square.low_bits());
        const int drop = std::max(size - 30, 0);
        form.mantissa[i] = static_cast<std::int32_t>((square >> drop).low_bits());
        form.bits[i] = 2 * Real::fraction_bits - drop;
    };
    const auto square = [](Real x) { return Wide::product(x.raw, x.raw); };
    for (int i = 0; i < 3; ++i) set(i, square(radii_inv[i]));
    set(3, square(std::max({radii_inv.x, radii_inv.y, radii_inv.z})) -
               square(std::min({radii_inv.x, radii_inv.y, radii_inv.z})));
    return form;
}

class Momentum {
    Vec3 whole; ///< [m^2/s]
    Vec3 radii_inv;
    Quat principal;
    SpinForm form;
    std::int64_t parts[3]; ///< of `whole`, 30 bits
    std::int32_t dropped;  ///< number of bits by which they are shorter than a Real
    bool is_quick;         ///< the parts have enough bits

  public:
    Momentum(const BodyStep& s, SpeedVec3 u, Quat principal_axes)
        : whole(by_gyration<Real>(s, u)), radii_inv(s.radii_inv), principal(principal_axes),
          form(spin_form(s.radii_inv)) {
        const int bits = bit_length(magnitude(whole.x.raw) | magnitude(whole.y.raw) | magnitude(whole.z.raw));
        dropped = std::max(bits - 30, 0), is_quick = true;
        for (int i = 0; i < 3; ++i) {
            parts[i] = shift_right_rounded(whole[i].raw, dropped);
            is_quick = is_quick && shift(i) >= 1 && shift(i) <= 62;
        }
    }
    Vec3 per_mass() const { return whole; }
    /// True if a component of the momentum divided by the square of the least radius of gyration exceeds the same
    /// component divided by the square of the largest one by more than this [rad/s], spin_bits.
    bool spins_above(std::int64_t most) const {
        if (shift(3) < 1) return whole != Vec3{};
        for (const std::int64_t part : parts)
            if (shift(3) <= 62 &&
                shift_right_rounded(static_cast<std::int64_t>(magnitude(part)) * form.mantissa[3], shift(3)) >
                    most)
                return true;
        return false;
    }
    /// Angular velocity of the body at a rotation: K^-2 of the momentum, in world axes.
    Vec3 spin_at(Quat rotation) const {
        const Rotation axes = axes_at(rotation);
        Vec3 spin;
        return find_quickly(axes, spin) ? spin : wide_spin(axes);
    }
    Rotation axes_at(Quat rotation) const {
        return to_rotation(principal == Quat::identity() ? rotation : rotation * principal);
    }
    /// The spin in Real, for any momentum.
    Vec3 wide_spin(const Rotation& axes) const {
        Vec3 inside = mul_transposed<Real>(axes, whole);
        for (int i = 0; i < 3; ++i) inside[i] = inside[i] * radii_inv[i] * radii_inv[i];
        return mul<Real>(axes, inside);
    }
    /// The spin from 30 bits of the momentum, with spin_bits along the principal axes. Returns false where these
    /// formats have no room.
    bool find_quickly(const Rotation& axes, Vec3& out) const {
        if (!is_quick) return false;
        const UnitVec3* const along = &axes.x;
        std::int64_t spin[3];
        for (int i = 0; i < 3; ++i) {
            const std::int64_t inside = shift_right_rounded(
                along[i].x.raw * parts[0] + along[i].y.raw * parts[1] + along[i].z.raw * parts[2],
                Unit::fraction_bits);
            spin[i] = shift_right_rounded(inside * form.mantissa[i], shift(i));
            if (magnitude(spin[i]) >= std::uint64_t{1} << 31) return false;
        }
        constexpr int drop = Unit::fraction_bits + spin_bits - Real::fraction_bits;
        for (int i = 0; i < 3; ++i)
            out[i] = Real::from_raw(shift_right_rounded(
                axes.x[i].raw * spin[0] + axes.y[i].raw * spin[1] + axes.z[i].raw * spin[2], drop));
        return true;
    }

  private:
    int shift(int i) const { return form.bits[i] + Real::fraction_bits - spin_bits - dropped; }
};

} // namespace lockstone::solve
