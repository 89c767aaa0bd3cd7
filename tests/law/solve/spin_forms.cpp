// The spin of a body from its momentum, computed in two forms: the quick one, which has room for most
// bodies, and the wide one, which has room for all.
#include "solve/bodies/momentum.h"
#include "support/rigs/joint_rig.h"
#include "support/split_mix.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

using namespace lockstone;
using namespace lockstone::test::rig;
using Chance = lockstone::test::SplitMix;

namespace {

double between(Chance& random, double least, double most) {
    return least + (most - least) * static_cast<double>(random.below(1u << 30)) * 0x1p-30;
}
/// 10^x for a random x between the two.
double size(Chance& random, double least, double most) {
    return std::pow(10.0, between(random, least, most));
}

/// A body of any shape that spins, with principal axes of its own or those of its pose.
struct Spinning {
    BodyStep step{};
    SpeedVec3 u;
    Quat rotation, principal = Quat::identity();

    explicit Spinning(Chance& random) {
        const double k = size(random, -2.5, 2), spin = size(random, -4, 3.3);
        const auto any_turn = [&] {
            return turn({between(random, -1, 1), 0.3, between(random, -1, 1)}, between(random, -3, 3));
        };
        rotation = any_turn();
        if (random.one_in(2)) principal = any_turn();
        step.radii = vec(k, k * size(random, -1, 1), k * size(random, -1, 1));
        for (int i = 0; i < 3; ++i) step.radii_inv[i] = Real(1) / step.radii[i];
        set_gyration(step, to_rotation(principal == Quat::identity() ? rotation : rotation * principal));
        for (int i = 0; i < 3; ++i)
            u[i] = quantize<Speed>(
                std::clamp(between(random, -spin, spin) * to_double(step.radii[i]), -170.0, 170.0));
    }
    /// Returns whether the quick form has room for this spin. `part`: the difference of the two forms, relative to the
    /// bound of their rounding. `off`: a relative error planted in radii_inv.
    bool compare(double& part, double off = 0) const {
        BodyStep other = step;
        for (int i = 0; i < 3; ++i)
            other.radii_inv[i] +=
                Real::from_raw(std::llround(static_cast<double>(step.radii_inv[i].raw) * off));
        const Momentum kept(step, u, principal), planted(other, u, principal);
        const Rotation axes = kept.axes_at(rotation);
        Vec3 quick;
        if (!planted.find_quickly(axes, quick)) return false;
        const Vec3 wide = kept.wide_spin(axes);
        const D3 most = rounding(axes);
        part = 0;
        for (int i = 0; i < 3; ++i)
            part =
                std::max(part, std::abs(to_double(quick[i] - wide[i])) / most[static_cast<std::size_t>(i)]);
        return true;
    }

  private:
    /// The bound of the difference of the two forms in world axes [rad/s], to first order. Along a principal axis, with
    /// g = radii_inv^2:
    /// quick:  the parts of the momentum have 30 bits, each within half a step s; so has its turn into the axes
    ///         (sqrt(3) / 2 + 1 / 2) s g;  g is cut to 30 bits, 2^-29 of the spin;  24 fraction bits, 2^-25
    /// wide:   rounded thrice to 2^-33: the turn, times g; the first product, times radii_inv; the second product
    /// Then each form is turned into world axes and rounded to 2^-33.
    D3 rounding(const Rotation& axes) const {
        const Vec3 whole = by_gyration<Real>(step, u);
        const Vec3 inside = mul_transposed<Real>(axes, whole);
        const std::uint64_t all = magnitude(whole.x.raw) | magnitude(whole.y.raw) | magnitude(whole.z.raw);
        const double s = std::exp2(std::max(bit_length(all) - 30, 0) - 32);
        const UnitVec3* const along = &axes.x;
        D3 most{0x1p-32, 0x1p-32, 0x1p-32};
        for (int i = 0; i < 3; ++i) {
            const double inv = to_double(step.radii_inv[i]), g = inv * inv,
                         spin = std::abs(to_double(inside[i])) * g;
            const double quick = 1.367 * s * g + spin * 0x1p-29 + 0x1p-25;
            const double wide = 0x1p-33 * (g + inv + 1);
            for (int j = 0; j < 3; ++j)
                most[static_cast<std::size_t>(j)] += std::abs(to_double(along[i][j])) * (quick + wide);
        }
        return most;
    }
};

constexpr int cases = 200000;

} // namespace

TEST_CASE("the quick and the wide form of a spin differ by at most their rounding") {
    Chance random(91);
    int quick = 0;
    double most = 0;
    for (int i = 0; i < cases; ++i) {
        double part;
        if (!Spinning(random).compare(part)) continue;
        ++quick;
        most = std::max(most, part);
        REQUIRE(part <= 1.001); // second order: 2^-29 of the bound, and the doubles' rounding
    }
    CHECK(quick > cases / 4);
    CHECK(cases - quick > cases / 100); // some spins are too large for the quick form
    CHECK(most > 0.2);                  // the bound is near the measured differences
}

TEST_CASE("planted fault: the comparison detects a quick spin with radii that are 2^-24 too small") {
    Chance random(91);
    int parted = 0;
    for (int i = 0; i < cases; ++i) {
        double part;
        if (Spinning(random).compare(part, 0x1p-24)) parted += part > 1.001 ? 1 : 0;
    }
    CHECK(parted > cases / 100);
}
