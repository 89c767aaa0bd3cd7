#include "math_oracle.h"

#include "lockstone/math/convert.h"

#include <doctest/doctest.h>

#include <cfenv>

using namespace lockstone;
using namespace oracle;

namespace {

double from_bits(std::uint64_t bits) { return std::bit_cast<double>(bits); }

/// Rounds to the nearest step, ties to even, by MPFR.
template <FixedPoint T> T quantized_by_mpfr(double value) {
    Exact exact;
    mpfr_set_d(exact.value, value, MPFR_RNDN);
    mpfr_mul_2si(exact.value, exact.value, T::fraction_bits, MPFR_RNDN);
    mpfr_rint(exact.value, exact.value, MPFR_RNDN);
    if (mpfr_cmp_si(exact.value, T::max().raw) > 0) return T::max();
    if (mpfr_cmp_si(exact.value, T::min().raw) < 0) return T::min();
    return T::from_raw(static_cast<typename T::rep>(mpfr_get_sj(exact.value, MPFR_RNDN)));
}

/// The usual conversion: it is wrong on ties, beyond the range and in other rounding modes.
template <FixedPoint T> T quantized_naively(double value) {
    const double scaled = std::ldexp(value, T::fraction_bits) + 0.5;
    if (!(scaled < 9.2e18 && scaled > -9.2e18)) return T{};
    return T::from_raw(static_cast<typename T::rep>(static_cast<std::int64_t>(std::floor(scaled))));
}

} // namespace

TEST_CASE_TEMPLATE(
    "quantize rounds to the nearest value with ties to even and clamps for every kind of number", T, I32F32,
    I2F62, I13F19, I2F30) {
    Random random = Random::seeded(50);
    long bad = 0, naive = 0;
    const auto check = [&](double value) {
        const T expected = quantized_by_mpfr<T>(value);
        bad += quantize<T>(value) != expected ? 1 : 0;
        naive += quantized_naively<T>(value) != expected ? 1 : 0;
    };
    for (int i = 0; i < points(100000); ++i) {
        const std::uint64_t mantissa =
            random.next_u64() & ~(~std::uint64_t{0} << random.range(std::int32_t{0}, 51));
        const std::uint64_t exponent = static_cast<std::uint64_t>(random.range(1023 - 70, 1023 + 70));
        check(from_bits(((mantissa & ((std::uint64_t{1} << 52) - 1)) | exponent << 52) ^
                        (random.next_u64() & (std::uint64_t{1} << 63))));
        // Half steps.
        check(std::ldexp(static_cast<double>(any_magnitude(random, 40)), -T::fraction_bits - 1));
    }
    for (std::uint64_t bits :
         {0ull, 1ull, 0x000fffffffffffffull, 0x0010000000000000ull, 0x7fefffffffffffffull})
        for (std::uint64_t sign : {0ull, 0x8000000000000000ull}) check(from_bits(bits | sign));
    CHECK(bad == 0);
    CHECK(naive > 1000); // planted fault: adding a half and truncating
}

TEST_CASE(
    "quantize() clamps infinities and returns zero for NaN under any floating-point option of the compiler") {
    CHECK(quantize<Real>(from_bits(0x7ff0000000000000u)) == Real::max());
    CHECK(quantize<Real>(from_bits(0xfff0000000000000u)) == Real::min());
    CHECK(quantize<Real>(from_bits(0x7ff8000000000000u)) == Real{});
    CHECK(quantize<Real>(from_bits(0xfff8000000000001u)) == Real{});
    CHECK(quantize<Real>(-2147483648.0) == Real::min());
    CHECK(quantize<Real>(2147483648.0) == Real::max());
    static_assert(quantize<Real>(0.1) == 0.1_r);
}

TEST_CASE("rounding modes of the host do not change a quantized value") {
    Random random = Random::seeded(51);
    const int before = std::fegetround();
    long bad = 0;
    for (int i = 0; i < 20000; ++i) {
        const double value = from_bits((random.next_u64() >> 12) | std::uint64_t{1020} << 52);
        const Real expected = quantize<Real>(value);
        for (int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
            std::fesetround(mode);
            bad += quantize<Real>(value) != expected ? 1 : 0;
        }
        std::fesetround(before);
    }
    CHECK(bad == 0);
}

TEST_CASE(
    "the double of a value converts back to it for 32-bit formats and for 64-bit formats below 2^53 steps") {
    Random random = Random::seeded(52);
    long bad = 0;
    for (int i = 0; i < points(100000); ++i) {
        const Unit u = Unit::from_raw(static_cast<std::int32_t>(random.next_u32()));
        const Real r = Real::from_raw(any_magnitude(random, 53));
        bad += quantize<Unit>(to_double(u)) != u || quantize<Real>(to_double(r)) != r ? 1 : 0;
        const double off = std::fabs(static_cast<double>(to_float(r)) - to_double(r));
        bad += off > std::fabs(to_double(r)) * 0x1p-24 ? 1 : 0;
    }
    CHECK(bad == 0);
    CHECK(to_double(0.5_r) == 0.5);
    CHECK(to_float(-2.25_r) == -2.25f);
    CHECK(to_double(Real::min()) == -2147483648.0);
}

TEST_CASE("vectors and quaternions and poses keep the order of their components in conversions") {
    const Vec3 v{1_r, -2_r, 0.5_r};
    CHECK(to_double(v) == std::array<double, 3>{1, -2, 0.5});
    CHECK(to_float(v) == std::array<float, 3>{1, -2, 0.5f});
    CHECK(quantize<Real>(to_double(v)) == v);
    CHECK(quantize<Real>(to_float(v)) == v);
    CHECK(to_double(Quat::identity()) == std::array<double, 4>{0, 0, 0, 1});
    CHECK(to_float(Quat::identity()) == std::array<float, 4>{0, 0, 0, 1});
    CHECK(quantize_quat({0, 0, 0, 1}) == Quat::identity());
    const Transform quarter_about_z{v, from_axis_angle({Unit{}, Unit{}, unit_one}, half_pi)};
    const std::array<float, 16> m = to_float_matrix(quarter_about_z);
    CHECK(m[1] == 1.0f); // x becomes y
    CHECK(m[4] == -1.0f);
    CHECK(m[12] == 1.0f);
    CHECK(m[13] == -2.0f);
    CHECK(m[15] == 1.0f);
}
