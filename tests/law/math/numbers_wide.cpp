#include "math_oracle.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace oracle;

namespace {

#if LOCKSTONE_HAS_INT128

bool same(WidePortable p, WideNative n) {
    return p.low_bits() == n.low_bits() && p.high_bits() == n.high_bits();
}

/// Counts the disagreements of the two wide types over every operation on these operands.
template <class Portable> int disagreements(std::int64_t a, std::int64_t b, std::int64_t c, int shift) {
    int count = 0;
    const auto check = [&](Portable p, WideNative n) { count += same(p, n) ? 0 : 1; };
    const std::uint64_t ua = static_cast<std::uint64_t>(a), ub = static_cast<std::uint64_t>(b);
    const Portable p = Portable::product(a, b);
    const WideNative n = WideNative::product(a, b);
    check(p, n);
    check(Portable::product_unsigned(ua, ub), WideNative::product_unsigned(ua, ub));
    check(Portable::from(a), WideNative::from(a));
    const Portable p2 = p + (Portable::from(c) << 64), pd = p - Portable::from(c);
    const WideNative n2 = n + (WideNative::from(c) << 64), nd = n - WideNative::from(c);
    check(p2, n2);
    check(pd, nd);
    check(p2 << shift, n2 << shift);
    check(p2 >> shift, n2 >> shift);
    check(add_saturated(p2, p2), add_saturated(n2, n2));
    check(sub_saturated(p2, pd), sub_saturated(n2, nd));
    count +=
        (p2 < pd) != (n2 < nd) || (p2 == pd) != (n2 == nd) || p2.is_negative() != n2.is_negative() ? 1 : 0;
    const int narrow_shift = shift > 126 ? 126 : shift;
    count += narrow_rounded(p2, narrow_shift) != narrow_rounded(n2, narrow_shift) ? 1 : 0;
    count += saturate_to_int64(p2) != saturate_to_int64(n2) ? 1 : 0;
    return count;
}

/// The portable type with a lost carry.
struct LostCarry : WidePortable {
    constexpr LostCarry(WidePortable w) : WidePortable(w) {}
    friend constexpr LostCarry operator+(LostCarry a, LostCarry b) {
        return WidePortable{a.low + b.low, static_cast<std::int64_t>(static_cast<std::uint64_t>(a.high) +
                                                                     static_cast<std::uint64_t>(b.high))};
    }
    friend constexpr LostCarry operator-(LostCarry a, LostCarry b) {
        return static_cast<WidePortable>(a) - static_cast<WidePortable>(b);
    }
    friend constexpr LostCarry operator<<(LostCarry a, int n) { return static_cast<WidePortable>(a) << n; }
    friend constexpr LostCarry operator>>(LostCarry a, int n) { return static_cast<WidePortable>(a) >> n; }
    static constexpr LostCarry from(std::int64_t v) { return WidePortable::from(v); }
    static constexpr LostCarry product(std::int64_t a, std::int64_t b) { return WidePortable::product(a, b); }
    static constexpr LostCarry product_unsigned(std::uint64_t a, std::uint64_t b) {
        return WidePortable::product_unsigned(a, b);
    }
};

template <class Portable> long disagreements_at_random(int count) {
    Random random = Random::seeded(1);
    long bad = 0;
    for (int i = 0; i < count; ++i) {
        const std::int64_t a = any_magnitude(random), b = any_magnitude(random), c = any_magnitude(random);
        bad += disagreements<Portable>(a, b, c, random.range(std::int32_t{0}, 127));
    }
    return bad;
}

#endif

/// floor(w / 2^shift + 1/2), clamped, one operation at a time.
template <class W> std::int64_t narrowed(W w, int shift) {
    if (shift == 0) return saturate_to_int64(w);
    const bool up = ((w >> (shift - 1)).low_bits() & 1u) != 0;
    return saturate_to_int64((w >> shift) + W::from(up ? 1 : 0));
}

/// Counts the disagreements of a type with narrowed() for a compile-time shift.
template <class W, int shift> long misses_of_shift() {
    long bad = 0;
    for (const std::int64_t a : edges<std::int64_t>())
        for (const std::int64_t b : edges<std::int64_t>()) {
            const W product = W::product(a, b), ends = (W::from(a) << 64) + W::from(b);
            bad += narrow_rounded(product, shift) != narrowed(product, shift) ? 1 : 0;
            bad += narrow_rounded(ends, shift) != narrowed(ends, shift) ? 1 : 0;
            if constexpr (shift <= 63)
                bad += product_rounded(a, b, shift) != narrowed(product, shift) ? 1 : 0;
        }
    return bad;
}
template <class W> long misses_of_shifts() {
    return misses_of_shift<W, 0>() + misses_of_shift<W, 1>() + misses_of_shift<W, 2>() +
           misses_of_shift<W, 24>() + misses_of_shift<W, 32>() + misses_of_shift<W, 60>() +
           misses_of_shift<W, 63>() + misses_of_shift<W, 64>() + misses_of_shift<W, 94>() +
           misses_of_shift<W, 126>();
}

/// Returns whether q is floor(n 2^shift / d + 1/2), clamped, by the definition: 2 q d <= 2 n 2^shift + d < 2 (q + 1) d.
bool is_rounded_quotient(std::int64_t n, std::int64_t d, int shift, std::int64_t q) {
    if (d < 0) {
        if (n == std::numeric_limits<std::int64_t>::min() || d == std::numeric_limits<std::int64_t>::min())
            return true;
        n = -n;
        d = -d;
    }
    const Wide twice = (Wide::from(n) << (shift + 1)) + Wide::from(d);
    const Wide below = Wide::product(q, d) << 1, above = below + (Wide::from(d) << 1);
    const bool low_enough = !(twice < below), high_enough = twice < above;
    if (q == std::numeric_limits<std::int64_t>::max()) return low_enough;
    if (q == std::numeric_limits<std::int64_t>::min()) return high_enough;
    return low_enough && high_enough;
}

} // namespace

#if LOCKSTONE_HAS_INT128
TEST_CASE("the portable 128-bit type and the compiler's agree on every pair of edge operands") {
    long bad = 0;
    const std::vector<std::int64_t> all = edges<std::int64_t>();
    int shift = 0;
    for (std::int64_t a : all)
        for (std::int64_t b : all) bad += disagreements<WidePortable>(a, b, a ^ b, (shift += 7) & 127);
    CHECK(bad == 0);
}

TEST_CASE("the portable 128-bit type and the compiler's agree on random operands of all sizes") {
    CHECK(disagreements_at_random<WidePortable>(points(4000000)) == 0);
}

TEST_CASE("planted fault: the comparison reports a lost carry between the halves of the 128-bit type") {
    CHECK(disagreements_at_random<LostCarry>(10000) > 100);
}
#endif

TEST_CASE("both versions of the 128 by 64 bit division return a quotient and remainder that multiply back") {
    Random random = Random::seeded(2);
    const std::vector<std::int64_t> special = edges<std::int64_t>();
    long bad = 0, differing = 0;
    const auto check = [&](std::uint64_t high, std::uint64_t low, std::uint64_t divisor) {
        if (divisor == 0) return;
        high %= divisor;
        const QuotientRemainder a = divide_128_by_64_portable(high, low, divisor),
                                b = divide_128_by_64(high, low, divisor);
        differing += a.quotient != b.quotient || a.remainder != b.remainder ? 1 : 0;
        const WidePortable back =
            WidePortable::product_unsigned(a.quotient, divisor) + WidePortable{a.remainder, 0};
        bad += back.low != low || static_cast<std::uint64_t>(back.high) != high || a.remainder >= divisor ? 1
                                                                                                          : 0;
    };
    for (std::int64_t a : special)
        for (std::int64_t b : special)
            for (std::int64_t c : {std::int64_t{0}, std::int64_t{-1}, a})
                check(static_cast<std::uint64_t>(a), static_cast<std::uint64_t>(c),
                      static_cast<std::uint64_t>(b));
    for (int i = 0; i < points(2000000); ++i) {
        const std::uint64_t high = static_cast<std::uint64_t>(any_magnitude(random)), low = random.next_u64();
        check(high, low, static_cast<std::uint64_t>(any_magnitude(random)));
    }
    CHECK(bad == 0);
    CHECK(differing == 0);
}

TEST_CASE("a shifted division is rounded by its definition and clamped") {
    Random random = Random::seeded(3);
    long bad = 0, planted = 0;
    const auto check = [&](std::int64_t n, std::int64_t d, int shift) {
        if (d == 0) return;
        const std::int64_t q = divide_shifted(n, d, shift);
        bad += is_rounded_quotient(n, d, shift, q) ? 0 : 1;
        planted += is_rounded_quotient(n, d, shift, add_saturated(q, q < 0 ? 1 : -1)) ? 0 : 1;
    };
    const std::vector<std::int64_t> special = edges<std::int64_t>();
    for (std::int64_t n : special)
        for (std::int64_t d : special)
            for (int shift : {0, 1, 19, 30, 32, 62}) check(n, d, shift);
    for (int i = 0; i < points(2000000); ++i) {
        const std::int64_t n = any_magnitude(random), d = any_magnitude(random);
        check(n, d, random.range(std::int32_t{0}, 61));
    }
    CHECK(bad == 0);
    CHECK(planted > 100000); // planted fault: one off must fail
    CHECK(divide_shifted(5, 0, 32) == std::numeric_limits<std::int64_t>::max());
    CHECK(divide_shifted(-5, 0, 32) == std::numeric_limits<std::int64_t>::min());
    CHECK(divide_shifted(0, 0, 32) == 0);
    CHECK(divide_shifted(std::numeric_limits<std::int64_t>::min(), -1, 0) ==
          std::numeric_limits<std::int64_t>::max());
    CHECK(divide_shifted(3, 2, 0) == 2); // ties go up
    CHECK(divide_shifted(-3, 2, 0) == -1);
}

TEST_CASE("a right shift rounds to nearest with ties up and without overflow") {
    CHECK(shift_right_rounded(3, 1) == 2);
    CHECK(shift_right_rounded(-3, 1) == -1);
    CHECK(shift_right_rounded(-5, 1) == -2);
    CHECK(shift_right_rounded(std::numeric_limits<std::int64_t>::max(), 1) == std::int64_t{1} << 62);
    CHECK(shift_right_rounded(std::numeric_limits<std::int64_t>::max(), 62) == 2);
    CHECK(shift_right_rounded(std::numeric_limits<std::int64_t>::min(), 62) == -2);
    long bad = 0;
    for (std::int64_t v : edges<std::int64_t>())
        for (int shift = 1; shift <= 62; ++shift) {
            const Wide sum = Wide::from(v) + Wide::from(std::int64_t{1} << (shift - 1));
            bad +=
                shift_right_rounded(v, shift) != static_cast<std::int64_t>((sum >> shift).low_bits()) ? 1 : 0;
        }
    CHECK(bad == 0);
}

TEST_CASE("shifts that are known at compile time round and clamp a wide value by the definition") {
    CHECK(misses_of_shifts<Wide>() == 0);
    CHECK(misses_of_shifts<WidePortable>() == 0);
}

TEST_CASE("saturated sums and differences and left shifts clamp to 64 bits") {
    long bad = 0;
    for (std::int64_t a : edges<std::int64_t>())
        for (std::int64_t b : edges<std::int64_t>()) {
            bad += add_saturated(a, b) != saturate_to_int64(Wide::from(a) + Wide::from(b)) ? 1 : 0;
            bad += sub_saturated(a, b) != saturate_to_int64(Wide::from(a) - Wide::from(b)) ? 1 : 0;
        }
    for (std::int64_t a : edges<std::int64_t>())
        for (int shift = 0; shift <= 63; ++shift)
            bad += shift_left_saturated(a, shift) != saturate_to_int64(Wide::from(a) << shift) ? 1 : 0;
    CHECK(bad == 0);
}
