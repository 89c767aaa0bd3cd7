#include "math_oracle.h"

#include "lockstone/math/decimal.h"

#include <doctest/doctest.h>

#include <type_traits>

using namespace lockstone;
using namespace oracle;

// The compiler rounds literals to the nearest value, ties to even.
static_assert((1_r).raw == std::int64_t{1} << 32);
static_assert((0.5_r).raw == std::int64_t{1} << 31);
static_assert((0.1_r).raw == 429496730);
static_assert((0.00000000011641532182693481445312_r).raw == 0);  // slightly below half a step
static_assert((0.000000000116415321826934814453125_r).raw == 0); // 2^-33: half a step, rounds to the even 0
static_assert((0.00000000011641532182693481445313_r).raw == 1);
static_assert((0.000000000349245965480804443359375_r).raw == 2); // one and a half steps: rounds to the even 2
static_assert((2'147'483'647.99999999976716935634613037109375_r) == Real::max());
static_assert(parse_decimal<Real>("-2147483648").value == Real::min());
static_assert(decimal<Unit>("-2") == Unit::min());
static_assert(decimal<Unit>("1.9999999990686774253845214843750") == Unit::max());
static_assert(!std::is_constructible_v<Real, double> && !std::is_constructible_v<Real, float>);
static_assert(!std::is_convertible_v<int, Real>);
static_assert(std::is_trivial_v<Real> && sizeof(Real) == 8 && sizeof(Unit) == 4);
static_assert(pi.raw == 13493037705 && half_pi.raw == 6746518852 && two_pi.raw == 26986075409);
static_assert(constants::e.raw == 11674931555);

namespace {

/// Counts the differences of T's operators from their definition in 128 bits, on (a, b).
template <FixedPoint T> int wrong_operators(T a, T b, T product) {
    constexpr int f = T::fraction_bits;
    const auto clamped = [](std::int64_t v) {
        if constexpr (sizeof(typename T::rep) == 8)
            return T::from_raw(v);
        else
            return T::from_raw(saturate_to_int32(v));
    };
    const Wide wa = Wide::from(a.raw), wb = Wide::from(b.raw), exact = Wide::product(a.raw, b.raw);
    int bad = 0;
    bad += a + b != clamped(saturate_to_int64(wa + wb)) ? 1 : 0;
    bad += a - b != clamped(saturate_to_int64(wa - wb)) ? 1 : 0;
    bad += -a != clamped(saturate_to_int64(Wide::from(0) - wa)) ? 1 : 0;
    bad += product != clamped(saturate_to_int64((exact + (Wide::from(1) << (f - 1))) >> f)) ? 1 : 0;
    bad += a / b != clamped(divide_shifted(a.raw, b.raw, f)) ? 1 : 0;
    bad += (a < b) != (a.raw < b.raw) ? 1 : 0;
    // Laws that remain true with clamping.
    bad += a * b != b * a || a + b != b + a || a * T::from_raw(0) != T{} ? 1 : 0;
    bad += abs(a) < T{} || max(a, b) < min(a, b) || clamp(a, min(a, b), max(a, b)) != a ? 1 : 0;
    bad += mul_add(a, b, T{}) != a * b || mul<T>(a, b) != a * b ? 1 : 0;
    const std::uint64_t cut = static_cast<std::uint64_t>(a.raw) - static_cast<std::uint64_t>(floor(a).raw);
    bad += floor(a) > a || cut >> f != 0 ? 1 : 0;
    if constexpr (T::integer_bits >= 2) bad += a * T(1) != a || a / T(1) != a ? 1 : 0;
    return bad;
}

template <FixedPoint T> long wrong_operators_everywhere(int count, std::int64_t fault) {
    long bad = 0;
    const auto check = [&](T a, T b) {
        const T p = a * b;
        bad += wrong_operators(a, b, T::from_raw(static_cast<typename T::rep>(p.raw - fault)));
    };
    using Rep = typename T::rep;
    for (Rep a : edges<Rep>())
        for (Rep b : edges<Rep>())
            if (fault == 0) check(T::from_raw(a), T::from_raw(b));
    Random random = Random::seeded(4);
    constexpr int bits = std::numeric_limits<Rep>::digits;
    for (int i = 0; i < count; ++i) {
        const std::int64_t a = any_magnitude(random, fault == 0 ? bits : bits / 2),
                           b = any_magnitude(random, fault == 0 ? bits : bits / 2);
        check(T::from_raw(static_cast<Rep>(a)), T::from_raw(static_cast<Rep>(b)));
    }
    return bad;
}

} // namespace

TEST_CASE_TEMPLATE("operators round once and clamp on all edge pairs and random operands", T, I32F32, I4F60,
                   I2F62, I16F16, I13F19, I8F24, I5F27, I4F28, I2F30) {
    CHECK(wrong_operators_everywhere<T>(points(300000), 0) == 0);
    CHECK(wrong_operators_everywhere<T>(1000, 1) >= 1000); // planted fault: a product one step too small
}

TEST_CASE("products round ties towards plus infinity") {
    const Real step = Real::step();
    CHECK(0.5_r * step == step);
    CHECK(-0.5_r * step == Real{});
    CHECK(1.5_r * step == Real::from_raw(2));
    CHECK(-1.5_r * step == -step);
}

TEST_CASE("floor() rounds down in every format even in formats without spare integer bits") {
    CHECK(floor(1.75_r) == 1_r);
    CHECK(floor(-1.25_r) == -2_r);
    CHECK(floor(Real::min()) == Real::min());
    CHECK(floor(Fixed<std::int32_t, 31>::from_raw(-5)) == Fixed<std::int32_t, 31>::min());
    CHECK(floor(Fixed<std::int64_t, 63>::from_raw(-5)) == Fixed<std::int64_t, 63>::min());
    CHECK(floor(Fixed<std::int64_t, 63>::from_raw(5)) == Fixed<std::int64_t, 63>{});
    CHECK(floor_to_int(-0.5_r) == -1);
}

TEST_CASE("conversions from integers clamp") {
    CHECK(Real(3) == 3_r);
    CHECK(Real(-2147483648LL) == Real::min());
    CHECK(Real(2147483648LL) == Real::max());
    CHECK(Real(std::numeric_limits<std::uint64_t>::max()) == Real::max());
    CHECK(Unit(2) == Unit::max());
    CHECK(Unit(-5) == Unit::min());
    CHECK(2_r * 3 == 6_r);
    CHECK(Real::max() * -2 == Real::min());
}

TEST_CASE("a change of format rounds once and clamps") {
    long bad = 0;
    Random random = Random::seeded(5);
    for (int i = 0; i < points(200000); ++i) {
        const Real x = Real::from_raw(any_magnitude(random));
        const std::int64_t nearest = saturate_to_int64((Wide::from(x.raw) + Wide::from(2)) >> 2);
        bad += to<Unit>(x).raw != saturate_to_int32(nearest) ? 1 : 0;
        const Unit u = Unit::from_raw(static_cast<std::int32_t>(any_magnitude(random, 31)));
        bad += to<Unit>(to<Real>(u)) != u ? 1 : 0; // a conversion to a finer format is reversible
    }
    CHECK(bad == 0);
}

TEST_CASE("sums of products clamp and do not wrap even for three squares of the farthest positions") {
    const Vec3 far{Real::min(), Real::min(), Real::min()};
    CHECK(dot(far, far) == Real::max());
    CHECK(dot(far, -far) == Real::min());
    CHECK(length_squared(far) == Real::max());
    CHECK(length(far) == Real::max());
    const UnitVec3 large{Unit::min(), Unit::min(), Unit::min()};
    CHECK(dot(large, large) == Unit::max());
}

TEST_CASE("parse_decimal() rejects text that is malformed or too long or out of range with the reason") {
    CHECK(parse_decimal<Real>("").error == DecimalError::empty);
    CHECK(parse_decimal<Real>("-").error == DecimalError::empty);
    CHECK(parse_decimal<Real>(".").error == DecimalError::empty);
    CHECK(parse_decimal<Real>("1e5").error == DecimalError::bad_character);
    CHECK(parse_decimal<Real>("1.2.3").error == DecimalError::bad_character);
    CHECK(parse_decimal<Real>("--1").error == DecimalError::bad_character);
    CHECK(parse_decimal<Real>("nan").error == DecimalError::bad_character);
    CHECK(parse_decimal<Real>("2147483648").error == DecimalError::out_of_range);
    CHECK(parse_decimal<Real>("-2147483648.0000000002").error == DecimalError::out_of_range);
    CHECK(parse_decimal<Real>("2147483647.9999999999").error ==
          DecimalError::out_of_range); // would round to 2^31
    CHECK(parse_decimal<Real>("99999999999999999999999999").error == DecimalError::out_of_range);
    CHECK(parse_decimal<Unit>("2").error == DecimalError::out_of_range);
    CHECK(parse_decimal<Unit>("1.9999999996").error == DecimalError::out_of_range);
    CHECK(parse_decimal<Fixed<std::int64_t, 63>>("0.99999999999999999999999").error ==
          DecimalError::out_of_range);
    CHECK(parse_decimal<Real>(std::string("0.").append(65, '0')).error == DecimalError::too_long);
    CHECK(parse_decimal<Real>(std::string("0.").append(63, '0').append("1")).error == DecimalError::none);
    CHECK(parse_decimal<Real>("+1'000.5").value == 1000.5_r);
    CHECK(parse_decimal<Real>("-.5").value == -0.5_r);
}

TEST_CASE_TEMPLATE("the exact text has all digits and the shortest one reads back and cannot lose a digit", T,
                   I32F32, I4F60, I2F62, I16F16, I13F19, I2F30) {
    using Rep = typename T::rep;
    std::vector<Rep> raws = edges<Rep>();
    Random random = Random::seeded(6);
    for (int i = 0; i < points(10000); ++i)
        raws.push_back(static_cast<Rep>(any_magnitude(random, std::numeric_limits<Rep>::digits)));
    long bad = 0, too_long = 0;
    for (Rep raw : raws) {
        const T x = T::from_raw(raw);
        const std::string exact = to_exact_string(x), shortest = to_string(x);
        for (const std::string& text : {exact, shortest}) {
            const DecimalResult<T> read = parse_decimal<T>(text);
            bad += read.error != DecimalError::none || read.value != x ? 1 : 0;
        }
        if (shortest.size() > exact.size()) ++too_long;
        const std::size_t point = shortest.find('.');
        if (point == std::string::npos) continue;
        // A text without its last digit, or with the digit before it one higher, must not read back.
        std::string shorter = shortest.substr(0, shortest.size() - 1);
        too_long += parse_decimal<T>(shorter).value == x ? 1 : 0;
        if (shorter.back() >= '0' && shorter.back() < '9') {
            ++shorter.back();
            too_long += parse_decimal<T>(shorter).value == x ? 1 : 0;
        }
    }
    CHECK(bad == 0);
    CHECK(too_long == 0);
}

TEST_CASE("to_string() writes decimals in the usual notation") {
    CHECK(to_string(-9.81_r) == "-9.81");
    CHECK(to_string(0_r) == "0");
    CHECK(to_string(42_r) == "42");
    CHECK(to_string(Real::step()) == "0.0000000002");
    CHECK(to_exact_string(Real::step()) == "0.00000000023283064365386962890625");
    CHECK(to_exact_string(Real::min()) == "-2147483648");
    CHECK(to_string(Vec3{1_r, 0.5_r, -2_r}) == "(1, 0.5, -2)");
    CHECK(to_string(Quat::identity()) == "(0, 0, 0; 1)");
    CHECK(to_exact_string(Fixed<std::int64_t, 63>::min()) == "-1");
}
