#include "math_oracle.h"

#include "math/estimate.h"
#include "math/roots.h"

#include <doctest/doctest.h>

#include <cfenv>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

using namespace lockstone;
using namespace oracle;

namespace {

bool is_floor_root(std::uint64_t n, std::uint64_t s) {
    const Wide square = Wide::product_unsigned(s, s), next = Wide::product_unsigned(s + 1, s + 1);
    const Wide wide = Wide::product_unsigned(n, 1);
    return s <= 0xffffffffu && !(wide < square) && wide < next;
}
/// Valid for n below 2^127.
bool is_floor_root(Wide n, std::uint64_t s) {
    const Wide square = Wide::product_unsigned(s, s);
    const Wide rest = n - square;
    return !square.is_negative() && !rest.is_negative() && !(Wide::product_unsigned(s, 2) < rest);
}
/// floor(sqrt(n) + 1/2) = s exactly when s^2 - s < n <= s^2 + s.
bool is_nearest_root(Wide n, std::uint64_t s) {
    const Wide square = Wide::product_unsigned(s, s), w = Wide::product_unsigned(s, 1);
    return (s == 0 || square - w < n) && !(square + w < n);
}
Wide wide(std::uint64_t high, std::uint64_t low) {
    return (Wide::from(static_cast<std::int64_t>(high)) << 64) + Wide::product_unsigned(low, 1);
}
std::uint64_t normalised(std::uint64_t n) {
    return n == 0 ? std::uint64_t{1} << 62 : n << (std::countl_zero(n) & ~1);
}

/// Values around each perfect square, around each power of two, and random ones.
std::vector<std::uint64_t> operands(int count) {
    std::vector<std::uint64_t> all;
    for (std::int64_t v : edges<std::int64_t>()) all.push_back(static_cast<std::uint64_t>(v));
    Random random = Random::seeded(7);
    for (int i = 0; i < count; ++i) {
        const std::uint64_t root = random.next_u32() >> random.range(std::int32_t{0}, 31);
        all.push_back(root * root);
        all.push_back(root * root - 1);
        all.push_back(root * root + 2 * root);
        all.push_back(random.next_u64() >> random.range(std::int32_t{0}, 63));
    }
    return all;
}

} // namespace

TEST_CASE("the integer root is the exact floor from an estimate and in integers alone") {
    long bad = 0, planted = 0;
    for (std::uint64_t n : operands(points(500000))) {
        bad += is_floor_root(n, isqrt(n)) && is_floor_root(n, detail::isqrt_integer(n)) ? 0 : 1;
        planted += is_floor_root(n, detail::estimate_sqrt(n)) ? 0 : 1;
    }
    CHECK(bad == 0);
    CHECK(planted > 100); // planted fault: the estimate without its correction is sometimes wrong
}

TEST_CASE("roots that are computed in a batch equal roots that are computed alone") {
    std::vector<std::int64_t> numbers;
    for (const std::uint64_t n : operands(points(20000)))
        numbers.push_back(static_cast<std::int64_t>(n & INT64_MAX));
    std::vector<std::int64_t> roots = numbers;
    const auto differing = [&] {
        long count = 0;
        for (std::size_t i = 0; i < numbers.size(); ++i)
            count += static_cast<std::uint64_t>(roots[i]) !=
                     detail::isqrt_integer(static_cast<std::uint64_t>(numbers[i]));
        return count;
    };
    detail::take_roots(roots.data(), roots.size());
    CHECK(differing() == 0);
    roots.back() ^= 1; // planted fault
    CHECK(differing() == 1);
}

TEST_CASE("the integer root of 128 bits is the exact floor from an estimate and in integers alone") {
    long bad = 0, differing = 0;
    Random random = Random::seeded(8);
    for (std::uint64_t low : operands(points(500000))) {
        const std::uint64_t high = random.next_u64() >> random.range(std::int32_t{1}, 63),
                            root = random.next_u64() >> 1;
        const Wide square = Wide::product_unsigned(root, root);
        for (Wide n :
             {wide(high, low), square, square - Wide::from(1), square + Wide::product_unsigned(root, 2)}) {
            const std::uint64_t s = isqrt(n);
            bad += is_floor_root(n, s) ? 0 : 1;
            differing +=
                s != detail::isqrt_integer(static_cast<std::uint64_t>(n.high_bits()), n.low_bits()) ? 1 : 0;
        }
    }
    CHECK(bad == 0);
    CHECK(differing == 0);
    CHECK(isqrt(Wide::from(-1)) == 0);
    constexpr std::uint64_t all = ~std::uint64_t{0};
    CHECK(detail::isqrt(all, all) == all);
    CHECK(detail::isqrt_integer(all, 0) == all);
}

TEST_CASE("the root is the same from any initial guess") {
    long bad = 0, unproved = 0;
    Random random = Random::seeded(9);
    for (std::uint64_t n : operands(points(200000))) {
        const std::uint64_t root = isqrt(n), m = normalised(n), inverse = detail::inverse_root_integer(m);
        const std::uint64_t high = n >> 24, low = random.next_u64(),
                            root_128 = detail::isqrt_integer(high, low);
        for (std::uint64_t off : {std::uint64_t{0}, std::uint64_t{1}, ~std::uint64_t{0}, std::uint64_t{5},
                                  std::uint64_t{0} - 7, random.next_u64(), random.next_u64() >> 40}) {
            bad += detail::isqrt_from(root + off, n) != root ? 1 : 0;
            bad += detail::isqrt_from(root_128 + off, high, low) != root_128 ? 1 : 0;
            bad += detail::inverse_root_from(inverse + off, m) != inverse ? 1 : 0;
            unproved += root + off != root ? 1 : 0;
        }
        for (std::uint64_t guess :
             {std::uint64_t{0}, ~std::uint64_t{0}, std::uint64_t{1} << 32, std::uint64_t{1} << 63}) {
            bad += detail::isqrt_from(guess, n) != root ? 1 : 0;
            bad += detail::isqrt_from(guess, high, low) != root_128 ? 1 : 0;
            bad += detail::inverse_root_from(guess, m) != inverse ? 1 : 0;
        }
    }
    CHECK(bad == 0);
    CHECK(unproved > 100000); // planted fault: the guess itself is wrong
}

TEST_CASE("the inverse root is the exact floor from an estimate and in integers and has 61 bits after the "
          "Newton step") {
    long bad = 0, differing = 0, inexact = 0;
    for (std::uint64_t n : operands(points(500000))) {
        const std::uint64_t m = normalised(n), q = detail::inverse_root_integer(m);
        differing += q != detail::inverse_root_estimated(m) ? 1 : 0;
        const Wide one = Wide::from(1) << 126;
        bad += one < Wide::product_unsigned(q * q, m) ? 1 : 0;
        bad += q < 0xffffffffu && !(one < Wide::product_unsigned((q + 1) * (q + 1), m)) ? 1 : 0;
        const long double exact =
            std::sqrt(1.0L / static_cast<long double>(m)) * 9903520314283042199192993792.0L; // 2^93
        const long double off = exact - static_cast<long double>(detail::inverse_root(0, m).mantissa);
        inexact += off < -1.5L || off > 4.0L ? 1 : 0;
    }
    CHECK(bad == 0);
    CHECK(differing == 0);
    CHECK(inexact == 0);
}

namespace {
/// Counts the wrong square roots, inverse roots and reciprocals of one value.
template <FixedPoint T> int wrong_roots(T x, std::int64_t fault) {
    int bad = 0;
    const std::int64_t root = add_saturated(sqrt(x).raw, fault), inv = add_saturated(inv_sqrt(x).raw, fault);
    const Wide n = Wide::from(x.raw) << T::fraction_bits;
    const std::uint64_t largest = static_cast<std::uint64_t>(T::max().raw);
    const bool too_large = Wide::product_unsigned(largest, largest) < n;
    bad += (too_large ? root != T::max().raw : !is_nearest_root(n, static_cast<std::uint64_t>(root))) ? 1 : 0;
    // 2^(3f/2) / sqrt(raw) in long double: its 64 bits suffice for every result here.
    static const long double scale = std::exp2(1.5L * T::fraction_bits);
    const long double exact = scale / std::sqrt(static_cast<long double>(x.raw));
    const long double inverse = std::fmin(exact, static_cast<long double>(T::max().raw));
    const long double off = std::fabs(static_cast<long double>(inv) - inverse);
    bad += off > error_bound::inv_sqrt / 1000.0L + std::ldexp(inverse, -error_bound::inv_sqrt_relative_bits)
               ? 1
               : 0;
    bad += T::integer_bits >= 2 && reciprocal(x) != T(1) / x ? 1 : 0;
    return bad;
}
} // namespace

TEST_CASE_TEMPLATE("sqrt is nearest and inv_sqrt and reciprocal are within their bound", T, I32F32, I4F60,
                   I2F62, I16F16, I13F19, I8F24, I5F27, I4F28, I2F30) {
    long bad = 0, planted = 0;
    Random random = Random::seeded(10);
    constexpr int bits = std::numeric_limits<typename T::rep>::digits;
    const auto check = [&](std::int64_t raw) {
        if (raw <= 0) return;
        const T x = T::from_raw(static_cast<typename T::rep>(raw));
        bad += wrong_roots(x, 0);
        planted += wrong_roots(x, 1) > 0 ? 1 : 0;
    };
    for (auto raw : edges<typename T::rep>()) check(raw);
    for (int i = 0; i < points(500000); ++i) check(any_magnitude(random, bits));
    if (long_run() && bits == 31)
        for (std::int64_t raw = 1; raw <= T::max().raw; ++raw)
            bad += wrong_roots(T::from_raw(static_cast<typename T::rep>(raw)), 0);
    CHECK(bad == 0);
    CHECK(planted > 40000); // planted fault: one step too much
    CHECK(sqrt(T{}) == T{});
    CHECK(sqrt(T::min()) == T{});
    CHECK(inv_sqrt(T{}) == T::max());
    CHECK(inv_sqrt(T::min()) == T::max());
    CHECK(reciprocal(T{}) == T::max());
}

namespace {

template <FixedPoint T> Vector3<T> any_vector(Random& random) {
    constexpr int bits = std::numeric_limits<typename T::rep>::digits;
    Vector3<T> v{};
    const int shift = random.range(std::int32_t{0}, bits - 1); // also tiny values
    for (int i = 0; i < 3; ++i)
        v[i] = T::from_raw(static_cast<typename T::rep>(any_magnitude(random, bits) >> shift));
    return v;
}

struct VectorErrors {
    Sweep normalized;
    long wrong_lengths = 0;
};

template <FixedPoint T> void check_vector(Vector3<T> v, int fault, VectorErrors& errors) {
    const long double x = static_cast<long double>(v.x.raw), y = static_cast<long double>(v.y.raw),
                      z = static_cast<long double>(v.z.raw);
    const long double size = std::sqrt(x * x + y * y + z * z);
    if (size == 0) return;
    const T l = length(v);
    const Wide n =
        Wide::product(v.x.raw, v.x.raw) + Wide::product(v.y.raw, v.y.raw) + Wide::product(v.z.raw, v.z.raw);
    if (!n.is_negative() && l != T::max())
        errors.wrong_lengths += is_nearest_root(n, static_cast<std::uint64_t>(l.raw + fault)) ? 0 : 1;
    const UnitVec3 u = normalized(v);
    const long double scale = 1073741824.0L / size, steps_x = u.x.raw + fault - x * scale,
                      steps_y = u.y.raw - y * scale, steps_z = u.z.raw - z * scale;
    for (long double off : {steps_x, steps_y, steps_z})
        errors.normalized.add(static_cast<double>(std::fabs(off)), error_bound::normalized / 1000.0);
}

} // namespace

TEST_CASE_TEMPLATE(
    "length is nearest and normalized within half a step for the smallest and the largest vectors", T, I32F32,
    I4F60, I16F16, I13F19, I8F24, I5F27, I2F30) {
    VectorErrors errors, planted;
    Random random = Random::seeded(11);
    const auto corner = edges<typename T::rep>();
    for (auto x : corner)
        for (auto y : {corner[0], corner[1], corner[5], corner[20], typename T::rep{0}, typename T::rep{1}})
            for (auto z : {typename T::rep{0}, typename T::rep{-3}, corner[0]})
                check_vector(Vector3<T>{T::from_raw(x), T::from_raw(y), T::from_raw(z)}, 0, errors);
    for (int i = 0; i < points(500000); ++i) {
        const Vector3<T> v = any_vector<T>(random);
        check_vector(v, 0, errors);
        if (i < 1000) check_vector(v, 1, planted);
    }
    CHECK(errors.wrong_lengths == 0);
    INFO("worst component: " << errors.normalized.worst << " steps");
    CHECK(errors.normalized.failures == 0);
    CHECK(planted.wrong_lengths > 500); // planted fault: one step too long
    CHECK(planted.normalized.failures > 500);
}

TEST_CASE("the normalized form of a vector along an axis is that axis and of a zero vector the fallback") {
    long bad = 0;
    for (std::int64_t raw : edges<std::int64_t>()) {
        if (raw == 0) continue;
        const Unit sign = raw < 0 ? -unit_one : unit_one;
        bad +=
            normalized(Vec3{Real{}, Real::from_raw(raw), Real{}}) != UnitVec3{Unit{}, sign, Unit{}} ? 1 : 0;
    }
    CHECK(bad == 0);
    const UnitVec3 up{Unit{}, unit_one, Unit{}};
    CHECK(normalized(Vec3{}) == UnitVec3{});
    CHECK(normalized_or(Vec3{}, up) == up);
    CHECK(normalized(Quat{}) == Quat::identity());
    CHECK(normalized(Quat{Unit::min(), Unit::min(), Unit::min(), Unit::min()}).w.raw == -(1 << 29));
}

TEST_CASE("any_perpendicular() returns a unit vector at a right angle to its argument") {
    long bad = 0;
    Random random = Random::seeded(12);
    for (int i = 0; i < points(500000); ++i) {
        const UnitVec3 n = random.unit_vector(), p = any_perpendicular(n);
        bad += std::abs(dot(n, p).raw) > 2 || std::abs(dot(p, p).raw - (1 << 30)) > 2 ? 1 : 0;
    }
    for (int axis = 0; axis < 3; ++axis) {
        UnitVec3 n{};
        n[axis] = unit_one;
        bad += dot(n, any_perpendicular(n)).raw != 0 ||
                       dot(any_perpendicular(n), any_perpendicular(n)) != unit_one
                   ? 1
                   : 0;
    }
    CHECK(bad == 0);
}

TEST_CASE("roots at compile time equal roots at run time") {
    constexpr Real a = sqrt(2_r), b = inv_sqrt(3_r), c = length(Vec3{1_r, 2_r, 3_r});
    constexpr UnitVec3 n = normalized(Vec3{1_r, 2_r, 3_r});
    Real two = 2_r, three = 3_r;
    CHECK(sqrt(two) == a);
    CHECK(inv_sqrt(three) == b);
    CHECK(length(Vec3{1_r, two, three}) == c);
    CHECK(normalized(Vec3{1_r, two, three}) == n);
}

namespace {

/// A digest of roots and functions over fixed operands.
std::uint64_t digest() {
    Random random = Random::seeded(13);
    std::uint64_t hash = 0;
    const auto mix = [&](std::int64_t v) {
        hash = (hash ^ static_cast<std::uint64_t>(v)) * 0x100000001b3u + (hash >> 29);
    };
    for (int i = 0; i < 20000; ++i) {
        const Vec3 v = any_vector<Real>(random);
        const UnitVec3 u = normalized(v);
        mix(isqrt(static_cast<std::uint64_t>(v.x.raw)));
        mix(sqrt(abs(v.x)).raw ^ inv_sqrt(abs(v.y)).raw ^ length(v).raw);
        mix(u.x.raw ^ u.y.raw ^ u.z.raw);
        mix(sin(v.x).raw ^ atan2(v.x, v.y).raw ^ exp(v.z).raw);
        const Quat q = integrate_rotation(Quat::identity(), v);
        mix(q.x.raw ^ q.w.raw);
        mix(tan(v.y).raw ^ log(abs(v.x)).raw ^ pow(abs(v.y), shift_right(v.z, 24)).raw);
        const Quat s = slerp(q, from_euler(v), shift_right(abs(v.z), 31));
        mix(s.y.raw ^ from_to(u, any_perpendicular(u)).z.raw ^ from_rotation(to_rotation(s)).w.raw);
        const Mat3 m{v, {v.y, v.x, v.z}, {v.z, v.z, v.y}};
        const Diagonal d = diagonalize(m);
        mix(determinant(m).raw ^ inverse(m).y.x.raw ^ d.values.x.raw ^ d.axes.w.raw);
    }
    return hash;
}

/// A digest of hardware floating point, which depends on the rounding mode.
std::uint64_t hardware_digest() {
    volatile double three = 3.0;
    double sum = 0;
    for (int i = 1; i < 1000; ++i) sum += i / three;
    return std::bit_cast<std::uint64_t>(sum);
}

} // namespace

TEST_CASE("rounding modes and flushed denormals of the host change no root and no function") {
    const std::uint64_t expected = digest(), hardware = hardware_digest();
    bool hardware_differs = false;
    const int before = std::fegetround();
    for (int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO, FE_TONEAREST}) {
        std::fesetround(mode);
        const std::uint64_t here = digest();
        hardware_differs |= hardware_digest() != hardware;
        std::fesetround(before);
        CHECK(here == expected);
    }
    CHECK(hardware_differs); // planted fault: the modes took effect
#if defined(__SSE2__)
    const unsigned control = _mm_getcsr();
    _mm_setcsr(control | 0x8040u); // flush to zero, denormals are zero
    const std::uint64_t flushed = digest();
    _mm_setcsr(control);
    CHECK(flushed == expected);
#endif
}

TEST_CASE("the digest of roots and functions equals the recorded one on every compiler and processor") {
    CHECK(digest() == 110123937194235003u);
}
