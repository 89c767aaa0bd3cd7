// Numbers as decimal text, for dumps, reports and files. parse_decimal() in fixed.h reads it.
#pragma once

#include "lockstone/math/vec.h"

#include <array>
#include <string>
#include <string_view>

namespace lockstone {

/// Number of digits of decimal_text().
enum class DecimalForm : std::uint8_t {
    shortest, ///< fewest digits that parse_decimal() reads back as the same number, nearest to it
    exact     ///< all digits of the number
};

/// Text without an allocation.
struct DecimalText {
    std::array<char, 96> characters; ///< [size] at most: sign, 19 digits, point, 63 digits
    std::uint8_t size;               ///< number of characters

    /// The text; valid as long as this object.
    operator std::string_view() const { return {characters.data(), size}; }
};

namespace detail {
DecimalText decimal_text(std::int64_t raw, int fraction_bits, DecimalForm form);
}

/// The decimal text of a number.
template <FixedPoint T> DecimalText decimal_text(T x, DecimalForm form = DecimalForm::shortest) {
    return detail::decimal_text(x.raw, T::fraction_bits, form);
}

/// The shortest text: "-9.81".
template <FixedPoint T> std::string to_string(T x) { return std::string(std::string_view(decimal_text(x))); }
/// The exact text: "-9.8100000000558793544769287109375".
template <FixedPoint T> std::string to_exact_string(T x) {
    return std::string(std::string_view(decimal_text(x, DecimalForm::exact)));
}
/// "(1, 0.5, -2)".
template <FixedPoint T> std::string to_string(Vector3<T> v) {
    std::string text = "(";
    text.append(to_string(v.x))
        .append(", ")
        .append(to_string(v.y))
        .append(", ")
        .append(to_string(v.z))
        .append(")");
    return text;
}
/// "(x, y, z; w)".
inline std::string to_string(Quat q) {
    std::string text = to_string(UnitVec3{q.x, q.y, q.z});
    text.back() = ';';
    text.append(" ").append(to_string(q.w)).append(")");
    return text;
}

} // namespace lockstone
