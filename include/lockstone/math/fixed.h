// Fixed-point numbers: an integer that counts steps of 2^-FractionBits.
//
//   Real slop = 0.005_r, gravity = -9.81_r;         exact decimals, checked by the compiler
//   I2F30 ratio = to<I2F30>(a / b);                 a change of format is explicit
//
// Each operation rounds once, by floor(x + 1/2), and clamps its result to the range of the format. No
// operation is undefined, depends on the compiler or uses floating point. All functions are pure and
// thread-safe.
#pragma once

#include "lockstone/math/wide.h"

#include <compare>
#include <concepts>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>

namespace lockstone {

/// A fixed-point number of Rep (32 or 64 bits, signed) with FractionBits fraction bits.
template <class Rep, int FractionBits>
requires((std::same_as<Rep, std::int32_t> || std::same_as<Rep, std::int64_t>)&&FractionBits >= 0 &&
         FractionBits < std::numeric_limits<Rep>::digits + 1) struct Fixed {
    using rep = Rep;                                   ///< integer type
    static constexpr int fraction_bits = FractionBits; ///< number of fraction bits
    /// Number of integer bits, including the sign.
    static constexpr int integer_bits = std::numeric_limits<Rep>::digits + 1 - FractionBits;

    Rep raw; ///< value * 2^FractionBits

    Fixed() = default; ///< Trivial: a local is uninitialised, `Fixed{}` is zero.

    /// The integer n, clamped to the range.
    template <std::integral N> constexpr explicit Fixed(N n) : raw(from_integer(n)) {}
    /// No conversion from floating point; see quantize() in convert.h.
    Fixed(std::floating_point auto) = delete;

    /// The number r * 2^-FractionBits.
    static constexpr Fixed from_raw(Rep r) {
        Fixed f{};
        f.raw = r;
        return f;
    }
    static constexpr Fixed max() { return from_raw(std::numeric_limits<Rep>::max()); } ///< Largest number.
    /// Most negative number.
    static constexpr Fixed min() { return from_raw(std::numeric_limits<Rep>::min()); }
    /// Smallest positive number.
    static constexpr Fixed step() { return from_raw(1); }

    friend constexpr bool operator==(Fixed, Fixed) = default; ///< Equal numbers.
    /// Order of the numbers.
    friend constexpr std::strong_ordering operator<=>(Fixed a, Fixed b) { return a.raw <=> b.raw; }

    /// Sum, difference, negation: exact, clamped.
    ///@{
    friend constexpr Fixed operator+(Fixed a, Fixed b) {
        if constexpr (sizeof(Rep) == 8)
            return from_raw(add_saturated(a.raw, b.raw));
        else
            return from_raw(saturate_to_int32(static_cast<std::int64_t>(a.raw) + b.raw));
    }
    friend constexpr Fixed operator-(Fixed a, Fixed b) {
        if constexpr (sizeof(Rep) == 8)
            return from_raw(sub_saturated(a.raw, b.raw));
        else
            return from_raw(saturate_to_int32(static_cast<std::int64_t>(a.raw) - b.raw));
    }
    friend constexpr Fixed operator-(Fixed a) { return Fixed{} - a; }
    ///@}

    /// Product, rounded once, clamped.
    friend constexpr Fixed operator*(Fixed a, Fixed b) {
        if constexpr (sizeof(Rep) == 8)
            return from_raw(product_rounded(a.raw, b.raw, FractionBits));
        else
            return from_raw(saturate_to_int32(
                shift_right_rounded(static_cast<std::int64_t>(a.raw) * b.raw, FractionBits)));
    }
    /// Quotient, rounded once, clamped. x / 0 is max() or min() by the sign of x; 0 / 0 is 0.
    friend constexpr Fixed operator/(Fixed a, Fixed b) {
        const std::int64_t q = divide_shifted(a.raw, b.raw, FractionBits);
        if constexpr (sizeof(Rep) == 8)
            return from_raw(q);
        else
            return from_raw(saturate_to_int32(q));
    }
    /// Product with an integer: exact, clamped.
    ///@{
    friend constexpr Fixed operator*(Fixed a, std::integral auto n) { return scaled(a, n); }
    friend constexpr Fixed operator*(std::integral auto n, Fixed a) { return scaled(a, n); }
    ///@}

    /// The operation with assignment.
    ///@{
    constexpr Fixed& operator+=(Fixed b) { return *this = *this + b; }
    constexpr Fixed& operator-=(Fixed b) { return *this = *this - b; }
    constexpr Fixed& operator*=(Fixed b) { return *this = *this * b; }
    constexpr Fixed& operator/=(Fixed b) { return *this = *this / b; }
    ///@}

  private:
    template <std::integral N> static constexpr Rep from_integer(N n) {
        if (std::cmp_greater(n, std::numeric_limits<std::int64_t>::max())) return max().raw;
        const std::int64_t v = shift_left_saturated(static_cast<std::int64_t>(n), FractionBits);
        if constexpr (sizeof(Rep) == 8)
            return v;
        else
            return saturate_to_int32(v);
    }
    template <std::integral N> static constexpr Fixed scaled(Fixed a, N n) {
        static_assert(sizeof(N) < 8 || std::is_signed_v<N>, "scale by a signed 64-bit or smaller integer");
        const std::int64_t p = narrow_rounded(Wide::product(a.raw, static_cast<std::int64_t>(n)), 0);
        if constexpr (sizeof(Rep) == 8)
            return from_raw(p);
        else
            return from_raw(saturate_to_int32(p));
    }
};

/// True for each Fixed type.
///@{
template <class T> inline constexpr bool is_fixed = false;
template <class Rep, int F> inline constexpr bool is_fixed<Fixed<Rep, F>> = true;
///@}
/// A Fixed type.
template <class T>
concept FixedPoint = is_fixed<T>;

/// Formats, named by integer bits (with sign) and fraction bits. formats.h lists their use.
///@{
using I32F32 = Fixed<std::int64_t, 32>;
using I40F24 = Fixed<std::int64_t, 24>;
using I4F60 = Fixed<std::int64_t, 60>;
using I2F62 = Fixed<std::int64_t, 62>;
using I16F16 = Fixed<std::int32_t, 16>;
using I13F19 = Fixed<std::int32_t, 19>;
using I8F24 = Fixed<std::int32_t, 24>;
using I5F27 = Fixed<std::int32_t, 27>;
using I4F28 = Fixed<std::int32_t, 28>;
using I2F30 = Fixed<std::int32_t, 30>;
///@}

/// The scalar of the public interface: range 2.1e9, step 2.3e-10.
using Real = I32F32;

/// raw * 2^-fraction_bits, rounded once to the format To and clamped. fraction_bits - To::fraction_bits:
/// -63..62.
template <FixedPoint To> constexpr To round_from(std::int64_t raw, int fraction_bits) {
    const int shift = fraction_bits - To::fraction_bits;
    const std::int64_t v = shift >= 0 ? shift_right_rounded(raw, shift) : shift_left_saturated(raw, -shift);
    if constexpr (sizeof(typename To::rep) == 8)
        return To::from_raw(v);
    else
        return To::from_raw(saturate_to_int32(v));
}
/// raw * 2^-fraction_bits of a 128-bit integer, rounded once to the format To and clamped.
template <FixedPoint To, class W>
requires requires(W w) { w.high_bits(); }
constexpr To round_from(W raw, int fraction_bits) {
    const int shift = fraction_bits - To::fraction_bits;
    std::int64_t v = 0;
    if (shift >= 0)
        v = narrow_rounded(raw, shift);
    else
        v = shift_left_saturated(saturate_to_int64(raw), -shift);
    if constexpr (sizeof(typename To::rep) == 8)
        return To::from_raw(v);
    else
        return To::from_raw(saturate_to_int32(v));
}

/// Converts to another format: rounded once, clamped.
template <FixedPoint To, FixedPoint From> constexpr To to(From x) {
    return round_from<To>(static_cast<std::int64_t>(x.raw), From::fraction_bits);
}

/// A sum of products of formats A and B: exact until round() rounds it once. Two 32-bit formats use 64 bits,
/// others 128; the sum is clamped there.
template <FixedPoint A, FixedPoint B> class SumOfProducts {
    static constexpr bool narrow = sizeof(typename A::rep) == 4 && sizeof(typename B::rep) == 4;
    /// A product has 95 bits: 2^32 of them fit into 128.
    static constexpr bool mixed = !narrow && (sizeof(typename A::rep) == 4 || sizeof(typename B::rep) == 4);
    using Total = std::conditional_t<narrow, std::int64_t, Wide>;
    Total total{};

  public:
    /// Fraction bits of the sum.
    static constexpr int fraction_bits = A::fraction_bits + B::fraction_bits;

    /// Adds a * b.
    constexpr SumOfProducts& add(A a, B b) {
        if constexpr (narrow)
            total = add_saturated(total, static_cast<std::int64_t>(a.raw) * b.raw);
        else if constexpr (mixed)
            total = total + Wide::product(a.raw, b.raw);
        else
            total = add_saturated(total, Wide::product(a.raw, b.raw));
        return *this;
    }
    /// Subtracts a * b.
    constexpr SumOfProducts& sub(A a, B b) {
        if constexpr (narrow)
            total = sub_saturated(total, static_cast<std::int64_t>(a.raw) * b.raw);
        else if constexpr (mixed)
            total = total - Wide::product(a.raw, b.raw);
        else
            total = sub_saturated(total, Wide::product(a.raw, b.raw));
        return *this;
    }
    /// The sum, rounded once to the format To and clamped.
    template <FixedPoint To> constexpr To round() const { return round_from<To>(total, fraction_bits); }
    constexpr Total exact() const { return total; } ///< The sum as an integer with `fraction_bits`.
};

/// a * b of any two formats, rounded once to the format To and clamped.
template <FixedPoint To, FixedPoint A, FixedPoint B> constexpr To mul(A a, B b) {
    return SumOfProducts<A, B>{}.add(a, b).template round<To>();
}
/// a * b + c, rounded once, clamped.
template <FixedPoint T> constexpr T mul_add(T a, T b, T c) {
    if constexpr (sizeof(typename T::rep) == 8)
        return round_from<T>(Wide::product(a.raw, b.raw) + (Wide::from(c.raw) << T::fraction_bits),
                             2 * T::fraction_bits);
    else
        return round_from<T>(
            add_saturated(static_cast<std::int64_t>(a.raw) * b.raw,
                          static_cast<std::int64_t>(c.raw) * (std::int64_t{1} << T::fraction_bits)),
            2 * T::fraction_bits);
}

/// |x|, clamped.
template <FixedPoint T> constexpr T abs(T x) { return x.raw < 0 ? -x : x; }
/// The smaller one.
template <FixedPoint T> constexpr T min(T a, T b) { return b < a ? b : a; }
/// The larger one.
template <FixedPoint T> constexpr T max(T a, T b) { return a < b ? b : a; }
/// x limited to [low, high].
template <FixedPoint T> constexpr T clamp(T x, T low, T high) { return x < low ? low : high < x ? high : x; }
/// x / 2^n, rounded; n in 0..62.
template <FixedPoint T> constexpr T shift_right(T x, int n) {
    return T::from_raw(static_cast<typename T::rep>(shift_right_rounded(x.raw, n)));
}
/// x / 2, rounded.
template <FixedPoint T> constexpr T half(T x) { return shift_right(x, 1); }
/// The largest integer not above x, as a T.
template <FixedPoint T> constexpr T floor(T x) {
    constexpr std::int64_t fraction = static_cast<std::int64_t>((std::uint64_t{1} << T::fraction_bits) - 1);
    return T::from_raw(static_cast<typename T::rep>(x.raw & ~fraction));
}
/// The largest integer not above x, as an integer.
template <FixedPoint T> constexpr std::int64_t floor_to_int(T x) {
    return std::int64_t{x.raw} >> T::fraction_bits;
}
/// a + (b - a) * t, the product rounded once. t in 0..1.
template <FixedPoint T, FixedPoint U> constexpr T lerp(T a, T b, U t) { return a + mul<T>(b - a, t); }

// ---- exact decimals ---------------------------------------------------------------------------------------

/// Result of parse_decimal().
enum class DecimalError : std::uint8_t {
    none,          ///< valid
    empty,         ///< no digit
    bad_character, ///< a character that is not a digit, a separator, a sign or the point
    out_of_range,  ///< beyond the range of the format
    too_long       ///< more than decimal_digits_max digits behind the point
};

/// A parsed decimal.
template <FixedPoint T> struct DecimalResult {
    T value;            ///< 0 after an error
    DecimalError error; ///< none: valid
};

/// Maximum number of digits behind the point.
inline constexpr int decimal_digits_max = 64;

/// Parses [-+]digits[.digits] with optional separators ('). Rounds the exact decimal to nearest, ties to
/// even. Used for literals at compile time, and for files and command lines.
template <FixedPoint T> constexpr DecimalResult<T> parse_decimal(std::string_view text) {
    const bool negative = !text.empty() && text.front() == '-';
    if (!text.empty() && (text.front() == '-' || text.front() == '+')) text.remove_prefix(1);
    std::uint64_t whole = 0;
    std::uint8_t digits[decimal_digits_max] = {};
    int digit_count = 0, read = 0;
    bool fraction = false;
    for (char c : text) {
        if (c == '\'' && read > 0) continue;
        if (c == '.' && !fraction) {
            fraction = true;
            continue;
        }
        if (c < '0' || c > '9') return {T{}, DecimalError::bad_character};
        ++read;
        if (!fraction) {
            if (whole > 0xffffffffffffu) return {T{}, DecimalError::out_of_range};
            whole = whole * 10 + static_cast<std::uint64_t>(c - '0');
        } else {
            if (digit_count == decimal_digits_max) return {T{}, DecimalError::too_long};
            digits[digit_count++] = static_cast<std::uint8_t>(c - '0');
        }
    }
    if (read == 0) return {T{}, DecimalError::empty};
    constexpr int f = T::fraction_bits;
    if (whole > (std::uint64_t{1} << (63 - f))) return {T{}, DecimalError::out_of_range};
    std::uint64_t value = whole;
    // Doubling the decimal fraction pushes its next binary digit out on the left.
    for (int bit = 0; bit < f; ++bit) {
        int carry = 0;
        for (int i = digit_count - 1; i >= 0; --i) {
            const int doubled = digits[i] * 2 + carry;
            digits[i] = static_cast<std::uint8_t>(doubled % 10);
            carry = doubled / 10;
        }
        value = value * 2 + static_cast<std::uint64_t>(carry);
    }
    bool over_half = digit_count > 0 && digits[0] > 5, exactly_half = digit_count > 0 && digits[0] == 5;
    for (int i = 1; i < digit_count; ++i)
        if (digits[i] != 0 && exactly_half) over_half = true, exactly_half = false;
    const bool up = over_half || (exactly_half && (value & 1u) != 0);
    const std::uint64_t largest =
        static_cast<std::uint64_t>(std::numeric_limits<typename T::rep>::max()) + (negative ? 1u : 0u);
    if (value > largest || (up && value == largest)) return {T{}, DecimalError::out_of_range};
    if (up) ++value;
    const std::uint64_t bits = negative ? 0 - value : value;
    return {T::from_raw(static_cast<typename T::rep>(static_cast<std::int64_t>(bits))), DecimalError::none};
}

namespace detail {
/// Not defined and not constexpr: an invalid literal calls it, and the compiler stops with this name in its
/// message. An exception needs a build with exceptions.
void this_is_not_a_decimal_in_the_range_of_its_format();
} // namespace detail

/// A decimal constant of any format: `decimal<I2F30>("0.6")`. A malformed or out-of-range text does not
/// compile.
template <FixedPoint T> consteval T decimal(std::string_view text) {
    const DecimalResult<T> result = parse_decimal<T>(text);
    if (result.error != DecimalError::none) detail::this_is_not_a_decimal_in_the_range_of_its_format();
    return result.value;
}

namespace detail {
template <char... Characters> struct Literal {
    static constexpr char text[] = {Characters...};
    static constexpr DecimalResult<Real> result =
        parse_decimal<Real>(std::string_view(text, sizeof...(Characters)));
    static_assert(result.error == DecimalError::none, "this is not a decimal in the range of Real");
};
} // namespace detail

/// Decimal literals.
inline namespace literals {
/// 0.005_r is the Real nearest to 5/1000. A malformed or out-of-range literal does not compile. Not
/// consteval, because clang takes the address of a consteval function in templates and default member
/// initialisers.
template <char... Characters> constexpr Real operator""_r() {
    return detail::Literal<Characters...>::result.value;
}
} // namespace literals

} // namespace lockstone
