#include "support/effort.h"

#include "math_oracle.h"

#include "math/tables.h"

#include <doctest/doctest.h>

#include <utility>

using namespace lockstone;
using namespace oracle;

namespace {

using MpfrFunction = int (*)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);

double steps(int thousandths) { return thousandths / 1000.0; }

/// Values of every magnitude up to 2^bits steps, and the edges of that range.
std::vector<Real> arguments(int count, int bits, bool positive = false) {
    std::vector<Real> all;
    const auto add = [&](std::int64_t raw) {
        if (positive)
            raw = static_cast<std::int64_t>(magnitude(raw) & static_cast<std::uint64_t>(Real::max().raw));
        if (bit_length(magnitude(raw)) <= bits && !(positive && raw == 0)) all.push_back(Real::from_raw(raw));
    };
    for (std::int64_t raw : edges<std::int64_t>()) add(raw);
    Random random = Random::seeded(20);
    for (int i = 0; i < count; ++i) add(any_magnitude(random, bits));
    return all;
}

/// The distance of f(x) + fault from the MPFR function, less the relative tolerance of 2^-relative_bits of the result.
Sweep against_mpfr(const std::vector<Real>& xs, Real (*f)(Real), MpfrFunction reference, int bound,
                   int relative_bits = 0, std::int64_t fault = 0) {
    Sweep sweep;
    Exact exact;
    for (Real x : xs) {
        const std::int64_t raw = add_saturated(f(x).raw, fault);
        exact.set(x.raw, Real::fraction_bits);
        reference(exact.value, exact.value, MPFR_RNDN);
        const double allowance =
            relative_bits == 0 ? 0 : std::ldexp(static_cast<double>(magnitude(raw)), -relative_bits);
        sweep.add(exact.steps_off(raw, Real::fraction_bits) - allowance, steps(bound));
    }
    return sweep;
}

/// The distance from a long double function, which is faster: valid where 64 bits leave bits below a step.
Sweep against_long_double(const std::vector<Real>& xs, Real (*f)(Real), long double (*reference)(long double),
                          int bound) {
    Sweep sweep;
    for (Real x : xs) {
        const long double exact = reference(value_of(x)) * 4294967296.0L;
        sweep.add(static_cast<double>(std::fabs(static_cast<long double>(f(x).raw) - exact)), steps(bound));
    }
    return sweep;
}

void check_function(const char* name, Real (*f)(Real), MpfrFunction reference, const std::vector<Real>& xs,
                    int bound, int relative_bits = 0) {
    CAPTURE(name);
    const Sweep sweep = against_mpfr(xs, f, reference, bound, relative_bits);
    INFO("worst " << sweep.worst << " steps in " << sweep.count);
    CHECK(sweep.failures == 0);
    // Planted fault: two steps too much must fail. Clamped results and large relative tolerances hide the fault.
    const Sweep faulty = against_mpfr(xs, f, reference, bound, relative_bits, 2);
    CHECK(faulty.failures > faulty.count / 2);
}

int mpfr_ln(mpfr_ptr r, mpfr_srcptr x, mpfr_rnd_t m) { return mpfr_log(r, x, m); }

} // namespace

TEST_CASE("sine and cosine are within their error bound for every Real near zero and far from it") {
    const std::vector<Real> xs = arguments(points(40000), 63);
    check_function("sin", sin, mpfr_sin, xs, error_bound::sin_cos);
    check_function("cos", cos, mpfr_cos, xs, error_bound::sin_cos);
    const std::vector<Real> many = arguments(points(500000), 40);
    CHECK(against_long_double(many, sin, std::sin, error_bound::sin_cos).failures == 0);
    CHECK(against_long_double(many, cos, std::cos, error_bound::sin_cos).failures == 0);
}

TEST_CASE("sin_cos() returns sine and cosine as Unit numbers within their error bound") {
    Sweep sweep;
    for (Real x : arguments(points(300000), 40)) {
        const SinCos t = sin_cos(x);
        sweep.add(static_cast<double>(std::fabs(t.sin.raw - std::sin(value_of(x)) * 1073741824.0L)),
                  steps(error_bound::sin_cos));
        sweep.add(static_cast<double>(std::fabs(t.cos.raw - std::cos(value_of(x)) * 1073741824.0L)),
                  steps(error_bound::sin_cos));
    }
    CHECK(sweep.failures == 0);
    CHECK(sin_cos(0_r).sin == Unit{});
    CHECK(sin_cos(0_r).cos == unit_one);
    CHECK(sin_cos(half_pi).sin == unit_one);
}

TEST_CASE(
    "symmetries hold within rounding: sine is odd and cosine is even and asin + acos is a right angle") {
    long bad = 0;
    for (Real x : arguments(points(200000), 62)) {
        bad += abs(sin(-x) + sin(x)) > Real::step() || abs(cos(-x) - cos(x)) > Real::step() ? 1 : 0;
        const Real u = Real::from_raw(x.raw % (Real(1).raw + 1));
        bad += abs(asin(u) + acos(u) - half_pi) > Real::from_raw(2) ? 1 : 0;
        bad += log2(exp2(Real(floor_to_int(u) * 30))) != Real(floor_to_int(u) * 30) ? 1 : 0;
    }
    CHECK(bad == 0);
}

TEST_CASE("tangent is within its error bound which grows near the poles") {
    Exact exact;
    Sweep sweep, faulty;
    std::vector<Real> xs = arguments(points(40000), 63);
    for (int k = -300; k < 300; ++k) xs.push_back(half_pi + Real::from_raw(k)); // at the pole
    for (Real x : xs) {
        const Real t = tan(x);
        const double size = std::ldexp(static_cast<double>(t.raw), -32);
        const double bound =
            steps(error_bound::tan) + std::ldexp(size * size, 32 - error_bound::tan_relative_bits);
        exact.set(x.raw, 32);
        mpfr_tan(exact.value, exact.value, MPFR_RNDN);
        const double off = exact.steps_off(t.raw, 32);
        sweep.add(off, bound);
        faulty.add(off + 2, bound);
    }
    INFO("worst " << sweep.worst);
    CHECK(sweep.failures == 0);
    CHECK(faulty.failures > faulty.count / 2); // planted fault: two steps off
}

TEST_CASE("arc functions are within their error bound" * doctest::skip(test::is_too_long_here())) {
    check_function("atan", atan, mpfr_atan, arguments(points(20000), 63), error_bound::atan);
    std::vector<Real> xs;
    for (Real x : arguments(points(40000), 32)) {
        xs.push_back(x);
        xs.push_back(x.raw >= 0 ? Real(1) - x : Real(-1) - x); // close to the ends too
    }
    check_function("asin", asin, mpfr_asin, xs, error_bound::atan);
    check_function("acos", acos, mpfr_acos, xs, error_bound::atan);
    CHECK(asin(5_r) == half_pi);
    CHECK(acos(-5_r) == pi);
    CHECK(acos(1_r) == 0_r);
}

TEST_CASE("atan2 is within its error bound in all quadrants and for pairs of edge values") {
    Sweep sweep, faulty;
    Exact y, x;
    const auto check = [&](std::int64_t ry, std::int64_t rx) {
        if (ry == 0 && rx == 0) return;
        const Real angle = atan2(Real::from_raw(ry), Real::from_raw(rx));
        y.set(ry, 32);
        x.set(rx, 32);
        if (ry == 0) mpfr_set_zero(y.value, 1);
        mpfr_atan2(y.value, y.value, x.value, MPFR_RNDN);
        const double off = y.steps_off(angle.raw, 32);
        sweep.add(off, steps(error_bound::atan));
        faulty.add(off + 1, steps(error_bound::atan));
    };
    const std::vector<std::int64_t> corner = edges<std::int64_t>();
    for (std::size_t i = 0; i < corner.size(); i += 3)
        for (std::size_t j = 0; j < corner.size(); j += 4) check(corner[i], corner[j]);
    Random random = Random::seeded(21);
    for (int i = 0; i < points(30000); ++i) {
        const std::int64_t ry = any_magnitude(random), rx = any_magnitude(random);
        check(ry, rx);
    }
    CHECK(sweep.failures == 0);
    CHECK(faulty.failures == faulty.count);
    CHECK(atan2(0_r, 0_r) == 0_r);
    CHECK(atan2(0_r, -1_r) == pi);
    CHECK(atan2(-1_r, 0_r) == -half_pi);
}

TEST_CASE("exponentials and logarithms are within their error bound" *
          doctest::skip(test::is_too_long_here())) {
    const std::vector<Real> exponents = arguments(points(40000), 37),
                            positive = arguments(points(40000), 63, true);
    check_function("exp", exp, mpfr_exp, exponents, error_bound::exp, error_bound::exp_relative_bits);
    check_function("exp2", exp2, mpfr_exp2, exponents, error_bound::exp, error_bound::exp_relative_bits);
    check_function("log", log, mpfr_ln, positive, error_bound::log);
    check_function("log2", log2, mpfr_log2, positive, error_bound::log);
    const std::vector<Real> many = arguments(points(500000), 63, true);
    CHECK(against_long_double(many, log, std::log, error_bound::log).failures == 0);
    CHECK(against_long_double(many, log2, std::log2, error_bound::log).failures == 0);
}

TEST_CASE("exponentials and logarithms are exact for powers of two and clamp at the ends of the range") {
    long bad = 0;
    for (int n = -32; n <= 30; ++n) {
        const Real power = Real::from_raw(std::int64_t{1} << (n + 32));
        bad += exp2(Real(n)) != power || log2(power) != Real(n) || pow(2_r, Real(n)) != power ? 1 : 0;
    }
    CHECK(bad == 0);
    CHECK(exp(0_r) == 1_r);
    CHECK(log(1_r) == 0_r);
    CHECK(exp(Real::max()) == Real::max());
    CHECK(exp(Real::min()) == 0_r);
    CHECK(exp2(31_r) == Real::max());
    CHECK(exp2(Real::min()) == 0_r);
    CHECK(log(0_r) == Real::min());
    CHECK(log2(-1_r) == Real::min());
}

TEST_CASE("a power is within its error bound which grows with the exponent") {
    Random random = Random::seeded(22);
    Exact x, y;
    Sweep sweep, faulty;
    for (int i = 0; i < points(60000); ++i) {
        const std::int64_t size = any_magnitude(random) & Real::max().raw, rx = size == 0 ? 1 : size;
        const std::int64_t ry = any_magnitude(random, i % 3 == 0 ? 63 : 36);
        const Real p = pow(Real::from_raw(rx), Real::from_raw(ry));
        x.set(rx, 32);
        y.set(ry, 32);
        mpfr_pow(x.value, x.value, y.value, MPFR_RNDN);
        const double off = x.steps_off(p.raw, 32),
                     exponent = std::fabs(std::ldexp(static_cast<double>(ry), -32));
        const double bound =
            steps(error_bound::exp) + std::ldexp(static_cast<double>(p.raw) * (exponent > 1 ? exponent : 1),
                                                 -error_bound::exp_relative_bits);
        sweep.add(off, bound);
        faulty.add(off + 2, bound);
    }
    CHECK(sweep.failures == 0);
    CHECK(faulty.failures > faulty.count / 2); // planted fault: two steps off
}

TEST_CASE("powers of zero and of negative numbers have defined results") {
    CHECK(pow(3_r, 2_r) == 9_r);
    CHECK(pow(10_r, 5_r) == 100'000_r);
    CHECK(pow(0_r, 0_r) == 1_r);
    CHECK(pow(0_r, 2_r) == 0_r);
    CHECK(pow(0_r, -2_r) == Real::max());
    CHECK(pow(-2_r, 3_r) == -8_r);
    CHECK(pow(-2_r, 4_r) == 16_r);
    CHECK(pow(-2_r, -1_r) == -0.5_r);
    CHECK(pow(-2_r, 0.5_r) == 0_r);
    CHECK(pow(2_r, 1000_r) == Real::max());
    CHECK(pow(0.5_r, 1000_r) == 0_r);
    CHECK(pow(1_r, Real::max()) == 1_r);
}

namespace {

/// The distance of a table entry from f(numerator / denominator), in its own steps.
double table_error(std::int64_t entry, MpfrFunction f, long numerator, long denominator) {
    Exact exact;
    mpfr_set_si(exact.value, numerator, MPFR_RNDN);
    mpfr_div_si(exact.value, exact.value, denominator, MPFR_RNDN);
    f(exact.value, exact.value, MPFR_RNDN);
    return exact.steps_off(entry, detail::table::fraction_bits);
}

} // namespace

TEST_CASE("every table entry is the nearest 62-bit number to its function") {
    namespace table = detail::table;
    double worst = 0;
    const auto note = [&](double error) { worst = error > worst ? error : worst; };
    for (long i = 0; i <= 16; ++i) note(table_error(table::atan_16ths[i], mpfr_atan, i, 16));
    for (long i = 0; i < 16; ++i) note(table_error(table::exp2_16ths[i], mpfr_exp2, i, 16));
    for (long i = 0; i < 25; ++i)
        note(table_error(table::ln_32nds[i], mpfr_ln, i + table::ln_32nds_first, 32));
    note(table_error(table::ln2, mpfr_ln, 2, 1));
    note(table_error(table::sqrt2, mpfr_sqrt, 2, 1));
    CHECK(worst <= 0.5);
    CHECK(table_error(table::ln2 + 1, mpfr_ln, 2, 1) > 0.5); // planted fault
}

TEST_CASE("the constants in two words have 124 correct bits") {
    namespace table = detail::table;
    Exact exact, sum;
    const auto check = [&](std::int64_t high, std::int64_t rest) {
        sum.set(rest, 124);
        Exact top;
        top.set(high, 62);
        mpfr_add(sum.value, sum.value, top.value, MPFR_RNDN);
        mpfr_sub(sum.value, sum.value, exact.value, MPFR_RNDN);
        mpfr_mul_2si(sum.value, sum.value, 124, MPFR_RNDN);
        CHECK(std::fabs(mpfr_get_d(sum.value, MPFR_RNDN)) <= 0.5);
    };
    mpfr_const_pi(exact.value, MPFR_RNDN);
    mpfr_div_2si(exact.value, exact.value, 1, MPFR_RNDN);
    check(table::half_pi, table::half_pi_rest);
    mpfr_ui_div(exact.value, 1, exact.value, MPFR_RNDN);
    CHECK(exact.steps_off(table::two_over_pi, 62) <= 0.5);
    mpfr_const_log2(exact.value, MPFR_RNDN);
    mpfr_div_2si(exact.value, exact.value, 4, MPFR_RNDN);
    check(table::ln2_16th, table::ln2_16th_rest);
    mpfr_const_log2(exact.value, MPFR_RNDN);
    mpfr_ui_div(exact.value, 1, exact.value, MPFR_RNDN);
    CHECK(exact.steps_off(table::log2_e, 62) <= 0.5);
}
