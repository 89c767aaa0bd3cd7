#include "solve/bodies/free_turn.h"

#include "lockstone/math/math.h"

#include <algorithm>
#include <utility>

namespace lockstone::solve {

namespace {

constexpr int steps_max = 64;
/// The error of a step is about the product of its turns about e_a and e_c. This is the inverse of the largest allowed
/// product [1/rad^2].
constexpr int steps_per_product = 16;
/// An energy that is larger by up to 2^-noise_bits of itself counts as equal.
constexpr int noise_bits = 20;

int bits_of(Vec3 v) { return bit_length(magnitude(v.x.raw) | magnitude(v.y.raw) | magnitude(v.z.raw)); }
std::int64_t times(std::int64_t a, Real part) {
    return narrow_rounded(Wide::product(a, part.raw), Real::fraction_bits);
}

/// The squares of three numbers below 2^bits, after a shift to 30 bits.
struct Squares {
    std::int64_t of[3], sum = 0;

    Squares(Vec3 v, int bits) : of{} {
        for (int i = 0; i < 3; ++i) {
            const std::int64_t x = bits > 30 ? shift_right_rounded(v[i].raw, bits - 30)
                                             : v[i].raw * (std::int64_t{1} << (30 - bits));
            sum += of[i] = x * x;
        }
    }
    /// Changes the sum by `change`, and keeps the sum of squares / rates. Moves parts from the first axis of `order`,
    /// and then from the second, to the third.
    void move(std::int64_t change, Vec3 rates, const int (&order)[3]) {
        const Real to_rate = rates[order[2]];
        for (const int i : {order[0], order[1]}) {
            if (rates[i] == to_rate || rates[i] == Real{} || of[i] == 0) continue;
            const Real part = to_rate / rates[i], each = abs(part - Real(1)),
                       share = min(Real(1),
                                   Real::from_raw(divide_shifted(change, of[i], Real::fraction_bits)) / each);
            const std::int64_t moved = times(of[i], share);
            of[i] -= moved, change -= times(moved, each);
            of[order[2]] = add_saturated(of[order[2]], times(moved, part));
            if (share < Real(1)) return;
        }
    }
    std::int64_t root(int i, int bits) const {
        const auto x = static_cast<std::int64_t>(isqrt(static_cast<std::uint64_t>(of[i])));
        return bits > 30 ? shift_left_saturated(x, bits - 30) : x >> (30 - bits);
    }
};

} // namespace

FreeTurn::FreeTurn(Vec3 radii_inverses, Quat principal_axes)
    : radii_inv(radii_inverses), rates(times_each(radii_inverses, radii_inverses)), principal(principal_axes),
      a(0), b(1), c(2) {
    const Real apart[3] = {abs(rates.y - rates.z), abs(rates.z - rates.x), abs(rates.x - rates.y)};
    if (apart[1] < apart[0]) a = 1;
    if (apart[2] < apart[a]) a = 2;
    b = (a + 1) % 3, c = (a + 2) % 3;
}

Rotation FreeTurn::axes_at(Quat rotation) const {
    return to_rotation(principal == Quat::identity() ? rotation : rotation * principal);
}

Vec3 FreeTurn::spin_at(Quat rotation, Vec3 momentum) const {
    const Rotation axes = axes_at(rotation);
    return mul<Real>(axes, times_each(mul_transposed<Real>(axes, momentum), rates));
}

int FreeTurn::steps_of(Vec3 momentum, Real per_second) const {
    const Real size = length(momentum) / per_second, product = (size * abs(rates[c] - rates[b])) *
                                                               (size * abs(rates[a] - rates[b])) *
                                                               Real(steps_per_product);
    if (product >= Real(steps_max) * steps_max) return steps_max;
    const std::int64_t steps = (sqrt(product).raw >> Real::fraction_bits) + 1;
    return static_cast<int>(std::min<std::int64_t>(steps, steps_max));
}

Quat FreeTurn::turned(Quat rotation, Vec3 momentum, Real per_second) const {
    const int steps = steps_of(momentum, per_second);
    const Real time = per_second * steps;
    const auto about = [&](int axis, Real rate) { // the turn of a step about an axis of the body
        const Rotation axes = axes_at(rotation);
        const UnitVec3 direction = axis == 0 ? axes.x : axis == 1 ? axes.y : axes.z;
        return scale<Real>(direction, rate * dot<Real>(direction, momentum) / time);
    };
    const Vec3 whole = scale<Real>(momentum, rates[b]) / time;
    const Real rest = half(rates[c] - rates[b]);
    for (int i = 0; i < steps; ++i) {
        if (rest != Real{}) rotation = integrate_rotation(rotation, about(c, rest));
        rotation = integrate_rotation(rotation, about(a, rates[a] - rates[b]));
        rotation = integrate_rotation(rotation, whole);
        if (rest != Real{}) rotation = integrate_rotation(rotation, about(c, rest));
    }
    return rotation;
}

/// Radius times spin along the principal axes.
Vec3 FreeTurn::tip_speeds(const Rotation& axes, Vec3 momentum) const {
    return times_each(mul_transposed<Real>(axes, momentum), radii_inv);
}

Wide FreeTurn::energy(Quat rotation, Vec3 momentum) const {
    return square_of(tip_speeds(axes_at(rotation), momentum));
}

Vec3 FreeTurn::with_energy(Wide energy, Quat rotation, Vec3 momentum, Keep keep) const {
    const Rotation axes = axes_at(rotation);
    const Vec3 now = tip_speeds(axes, momentum);
    const Wide excess = square_of(now) - energy;
    if (excess.is_negative() && keep == Keep::not_above) return momentum;
    const int bits = bits_of(now);
    Squares s(now, bits);
    const Wide size = excess.is_negative() ? Wide::from(0) - excess : excess;
    const std::int64_t change = bits > 30   ? saturate_to_int64(size >> (2 * (bits - 30)))
                                : bits > 16 ? saturate_to_int64(size) << (2 * (30 - bits))
                                            : 0;
    if (change <= s.sum >> noise_bits) return momentum;
    int order[3] = {0, 1, 2}; // by rates: energy falls towards the last axis
    std::sort(order, order + 3, [&](int i, int j) { return rates[i] > rates[j]; });
    if (excess.is_negative()) std::swap(order[0], order[2]);
    s.move(change, rates, order);
    Vec3 inside;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t root = s.root(i, bits);
        if (radii_inv[i] > Real{}) inside[i] = Real::from_raw(now[i].raw < 0 ? -root : root) / radii_inv[i];
    }
    return mul<Real>(axes, inside);
}

Vec3 FreeTurn::shortened_to_energy(Wide most, Quat rotation, Vec3 momentum, Keep keep) const {
    if (most.is_negative()) most = Wide{};
    const Vec3 near = with_energy(most, rotation, momentum, keep);
    const Real now = Real::from_raw(narrow_rounded(energy(rotation, near), Real::fraction_bits)),
               allowed = Real::from_raw(narrow_rounded(most, Real::fraction_bits));
    return now > allowed ? near * sqrt(allowed / now) : near;
}

Quat FreeTurn::turned_exactly(Quat rotation, Vec3 momentum, Real per_second) const {
    const Quat to = turned(rotation, momentum, per_second);
    const Vec3 other = with_energy(energy(rotation, momentum), to, momentum, Keep::all);
    if (other == momentum) return to;
    return normalized(from_to(normalized(other), normalized(momentum)) * to);
}

} // namespace lockstone::solve
