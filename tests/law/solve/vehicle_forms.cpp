// Vehicles compute equal values in 64 and in 128 bits, and their quotients are within the stated bounds.
#include "solve/vehicles/vehicle_tyre.h"
#include "support/sim_scenes.h"
#include "support/split_mix.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace lockstone;
using namespace lockstone::solve;
using Chance = lockstone::test::SplitMix;

namespace {

/// A value of any magnitude below `most`, sometimes 0.
Real below(Chance& random, Real most) {
    if (random.one_in(16)) return Real{};
    const std::int64_t raw = static_cast<std::int64_t>(random.next() >> 1) >> random.below(62);
    return raw < most.raw ? Real::from_raw(raw) : Real::from_raw(raw % most.raw);
}
Real either_way(Chance& random, Real most) {
    const Real x = below(random, most);
    return random.one_in(2) ? x : -x;
}

TyreCurve any_curve(Chance& random) {
    TyreCurve out{};
    Real x = random.one_in(2) ? Real{} : below(random, Real(10));
    for (std::size_t i = 0; i < out.x.size(); ++i) {
        out.x[i] = x, out.y[i] = i == 0 && out.x[0] == Real{} ? Real{} : below(random, Real(10));
        out.peak = max(out.peak, out.y[i]);
        x = min(x + below(random, Real(300)), Real(1000));
        if (i == 0) continue;
        out.run[i - 1] = out.x[i] - out.x[i - 1], out.rise[i - 1] = out.y[i] - out.y[i - 1];
    }
    out.from_zero = out.x[0] == Real{} && out.y[0] == Real{};
    return out;
}

/// A wheel whose constants are within the limits of the 64-bit form.
struct AnyRim {
    Wheel wheel{};
    SpinGroup group{};
    TyreCurve curve;
    Real free, patch, speed, own, other;
    TyreAsks asks;

    explicit AnyRim(Chance& random) : curve(any_curve(random)) {
        wheel.radius = below(random, Real(10)) + Real::step();
        wheel.arm = below(random, small_arm);
        wheel.along.kappa = below(random, small_kappa);
        wheel.kappa_rim = below(random, small_kappa_rim);
        wheel.load = below(random, small_load);
        wheel.most_along = wheel.load * curve.peak;
        wheel.arm_most = wheel.arm * wheel.most_along;
        group.brake_spin = below(random, Real(1 << 16));
        free = either_way(random, Real(1 << 16));
        patch = either_way(random, Real(1 << 15));
        speed = below(random, Real(1 << 14));
        own = below(random, Real(1 << 22)), other = below(random, Real(1 << 14));
        asks = static_cast<TyreAsks>(random.below(3));
    }
    template <class Number> RimAnswer<Real> turned() const {
        switch (asks) {
        case TyreAsks::impulse:
            return turned<Number, TyreAsks::impulse>();
        case TyreAsks::gain:
            return turned<Number, TyreAsks::gain>();
        default:
            return turned<Number, TyreAsks::slip>();
        }
    }
    template <class Number, TyreAsks asked> RimAnswer<Real> turned() const {
        const TyreQuestion<Number, asked> tyre{
            curve, number<Number>(wheel.load), number<Number>(wheel.most_along),
            TyreSlide<Number>::make(number<Number>(own), number<Number>(other)),
            number<Number>(wheel.along.kappa)};
        const RimAnswer<Number> a =
            turn_rim(group, wheel, number<Number>(free), number<Number>(patch), number<Number>(speed), tyre);
        return {real(a.impulse), real(a.spin), real(a.gain), a.slip, a.held};
    }
};
bool is_same(const RimAnswer<Real>& a, const RimAnswer<Real>& b) {
    return a.impulse == b.impulse && a.spin == b.spin && a.gain == b.gain && a.slip == b.slip &&
           a.held == b.held;
}

/// A chassis with speeds below these [m/s], and a line.
struct AnyLine {
    Chassis chassis{SolverBody{}};
    WheelLine line{};

    AnyLine(Chance& random, Real v_most, Real u_most) {
        const auto speed = [&](Real most) { return either_way(random, most).raw >> (32 - chassis_bits); };
        D3 d = {double(random.below(201)) - 100, double(random.below(201)) - 100, 101};
        const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (int i = 0; i < 3; ++i) {
            chassis.v[i] = speed(v_most), chassis.u[i] = speed(u_most), chassis.keep[i] = -1;
            line.d[i] = quantize<Unit>(d[static_cast<std::size_t>(i)] / length);
            line.xc[i] = to<Arm>(either_way(random, Real(64)));
        }
    }
    using D3 = std::array<double, 3>;
    template <class Number> Real speed() const {
        return real(speed_along<Number>(chassis.v, chassis.u, line.d, line.xc));
    }
    bool is_alike() const { return speed<Small>() == speed<Real>(); }
};

constexpr int cases = 200000;

} // namespace

TEST_CASE("a rim and its tyre turn alike in 64 and 128 bits within the range of small values") {
    Chance random(41);
    int held = 0, slid = 0, clung = 0;
    for (int i = 0; i < cases; ++i) {
        const AnyRim rim(random);
        REQUIRE(is_same(rim.turned<Small>(), rim.turned<Real>()));
        const RimAnswer<Real> a = rim.turned<Real>();
        ++(a.held ? held : a.gain > Real{} ? clung : slid);
    }
    CHECK(std::min(held, std::min(slid, clung)) > cases / 100); // each branch was taken
}

TEST_CASE("planted fault: the comparison detects a rim whose mobility is off by a step") {
    Chance random(42);
    int parted = 0;
    for (int i = 0; i < cases; ++i) {
        const AnyRim rim(random);
        AnyRim off = rim;
        off.wheel.kappa_rim += Real::step() * 64, off.wheel.along.kappa += Real::step() * 64;
        parted += is_same(rim.turned<Small>(), off.turned<Real>()) ? 0 : 1;
    }
    CHECK(parted > cases / 100);
}

TEST_CASE("lines read a chassis alike in 64 and 128 bits if the chassis has room") {
    Chance random(43);
    for (int i = 0; i < cases; ++i) {
        const AnyLine any(random, Real(256), Real(64));
        REQUIRE(any.chassis.has_room());
        REQUIRE(any.is_alike());
    }
    int with = 0, without = 0, parted = 0;
    for (int i = 0; i < cases; ++i) {
        const AnyLine any(random, Real(2048), Real(2048));
        ++(any.chassis.has_room() ? with : without);
        if (!any.chassis.has_room()) continue; // 64 bits overflow
        REQUIRE(any.is_alike());
        AnyLine off = any; // planted: a wrong arm
        off.line.xc.x += to<Arm>(0.5_r);
        parted += any.speed<Small>() == off.speed<Real>() ? 0 : 1;
    }
    CHECK(std::min(with, without) > cases / 100);
    CHECK(parted > with / 2);
}

namespace {

/// A chassis for which look() found room, after the largest changes that small wheels can make before the next look;
/// arms below `arm_most`.
Chassis after_small_wheels(Chance& random, Real arm_most) {
    AnyLine any(random, Real(128), Real(64));
    any.chassis.look();
    REQUIRE(any.chassis.roomy);
    Wheel wheel{};
    wheel.along = wheel.across = any.line;
    for (int i = 0; i < 3; ++i) wheel.along.xc[i] = wheel.across.xc[i] = to<Arm>(arm_most) - Arm::step();
    solve::SolverBodies none;
    for (std::uint32_t i = 0; i < vehicle_wheels_max; ++i)
        push_tyre(any.chassis, wheel, Real(1), Real(1), none);
    return any.chassis;
}
bool has_small_room(const Chassis& chassis) {
    bool good = true;
    for (int i = 0; i < 3; ++i)
        good = good && std::abs(chassis.v[i]) <= std::int64_t{144} << chassis_bits &&
               std::abs(chassis.u[i]) <= std::int64_t{192} << chassis_bits;
    return good;
}

} // namespace

TEST_CASE("small wheels leave a chassis enough room for the 64-bit arithmetic of other small wheels") {
    Chance random(45);
    int taken = 0;
    for (int i = 0; i < cases / 10; ++i) {
        REQUIRE(has_small_room(after_small_wheels(random, Real(8))));
        taken += has_small_room(after_small_wheels(random, Real(64)))
                     ? 0
                     : 1; // planted: arms of wheels that are not small
    }
    CHECK(taken > cases / 20);
    // That room suffices: 64 and 128 bits agree at the largest speeds and at arms below 8.
    for (int i = 0; i < cases / 10; ++i) {
        AnyLine any(random, Real(144), Real(192));
        for (int k = 0; k < 3; ++k) any.line.xc[k] = to<Arm>(either_way(random, Real(8)));
        REQUIRE(any.is_alike());
    }
}

TEST_CASE("a tyre's two impulses move a chassis alike whether they are applied at once or in sequence") {
    Chance random(46);
    solve::SolverBodies none;
    int parted = 0;
    for (int i = 0; i < cases / 10; ++i) {
        const AnyLine any(random, Real(500), Real(170)), other(random, Real(1), Real(1));
        Wheel wheel{};
        wheel.along = any.line, wheel.across = other.line;
        const Real most = random.one_in(4) ? Real(4) : Real(1), along = either_way(random, most),
                   across = either_way(random, most);
        const auto speeds = [](const Chassis& c) {
            return std::array{c.v[0], c.v[1], c.v[2], c.u[0], c.u[1], c.u[2]};
        };
        Chassis at_once = any.chassis, in_turn = any.chassis, off = any.chassis;
        push_tyre(at_once, wheel, along, across, none);
        push_line(in_turn, wheel, wheel.along, along, none);
        push_line(in_turn, wheel, wheel.across, across, none);
        REQUIRE(speeds(at_once) == speeds(in_turn));
        push_tyre(off, wheel, along, across + decimal<Real>("0.001"), none); // planted: 0.001 more across
        parted += speeds(at_once) == speeds(off) ? 0 : 1;
    }
    CHECK(parted > cases / 20);
}

TEST_CASE("push_line() and push_far() move a chassis alike for impulses of up to 1 m/s") {
    Chance random(44);
    SolverBodies none;
    const auto gives = [&](AnyLine any, Real impulse, bool far) {
        Wheel wheel{};
        if (far)
            push_far(any.chassis, any.line, impulse);
        else
            push_line(any.chassis, wheel, any.line, impulse, none);
        return std::array{any.chassis.v[0], any.chassis.v[1], any.chassis.v[2],
                          any.chassis.u[0], any.chassis.u[1], any.chassis.u[2]};
    };
    for (int i = 0; i < cases / 10; ++i) {
        const AnyLine any(random, Real(500), Real(170));
        const Real impulse = either_way(random, Real(1));
        REQUIRE(gives(any, impulse, false) == gives(any, impulse, true));
        // planted: twice the impulse
        REQUIRE((abs(impulse) < 0.001_r || gives(any, impulse, false) != gives(any, impulse * 2, true)));
    }
}

TEST_CASE("quotients of vehicles are within 2^-29 and one step of the exact value") {
    Chance random(45);
    const auto off = [](Real n, Real d, Real q) {
        const long double exact = static_cast<long double>(n.raw) / static_cast<long double>(d.raw) * 0x1p32L;
        const long double most = static_cast<long double>(Real::max().raw);
        return std::abs(static_cast<long double>(q.raw) - std::min(exact, most)) > exact * 0x1p-29L + 1;
    };
    int planted = 0;
    for (int i = 0; i < cases; ++i) {
        const Real n = below(random, Real::max()), d = below(random, Real::max()) + Real::step();
        REQUIRE_FALSE(off(n, d, quotient(n, d)));
        planted += off(n, d, quotient(n, d + shift_right(d, 20))) ? 1 : 0; // planted: 2^-20 too large
        const Real part = min(n, d);
        const std::int64_t share = share_of(part.raw, d.raw);
        REQUIRE(share <= std::int64_t{1} << share_bits);
        const long double exact = static_cast<long double>(part.raw) / static_cast<long double>(d.raw);
        REQUIRE(std::abs(static_cast<long double>(share) * 0x1p-31L - exact) <= 0x1p-30L);
    }
    CHECK(planted > cases / 4);
}

TEST_CASE("a product with a reciprocal equals the quotient to 22 bits and large divisors use division") {
    Chance random(46);
    int planted = 0;
    for (int i = 0; i < cases; ++i) {
        const Real of = below(random, Real(1 << 24)) + Real::from_raw(1 << 12),
                   x = below(random, Real(1 << 6));
        const Divisor d = Divisor::make(of);
        const long double exact =
            static_cast<long double>(x.raw) / static_cast<long double>(of.raw) * 0x1p32L;
        const auto off = [&](Real q) {
            return std::abs(static_cast<long double>(q.raw) - exact) > exact * 0x1p-22L + 1;
        };
        REQUIRE_FALSE(off(x / d));
        planted += off(x * d.inverse) ? 1 : 0; // planted: the reciprocal of a large divisor
    }
    CHECK(planted > 0);
}
