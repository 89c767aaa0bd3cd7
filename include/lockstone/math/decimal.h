// Values as decimal text, for dumps, reports and files. The other direction is parse_decimal in fixed.h.
#pragma once

#include "lockstone/math/vec.h"

#include <array>
#include <string>
#include <string_view>

namespace lockstone {

enum class DecimalForm : std::uint8_t {
    shortest, ///< the fewest digits that parse_decimal reads back as the same value; the nearest of those
    exact     ///< all digits of the value, which are finite: a step is a power of two
};

/// Text without an allocation.
struct DecimalText {
    std::array<char, 96> characters; ///< sign, 19 digits, point and 63 digits at most
    std::uint8_t size;

    operator std::string_view() const { return {characters.data(), size}; }
};

namespace detail {
DecimalText decimal_text(std::int64_t raw, int fraction_bits, DecimalForm form);
}

template <FixedPoint T> DecimalText decimal_text(T x, DecimalForm form = DecimalForm::shortest) {
    return detail::decimal_text(x.raw, T::fraction_bits, form);
}

/// "-9.81"
template <FixedPoint T> std::string to_string(T x) { return std::string(std::string_view(decimal_text(x))); }
/// "-9.8100000000558793544769287109375"
template <FixedPoint T> std::string to_exact_string(T x) {
    return std::string(std::string_view(decimal_text(x, DecimalForm::exact)));
}
/// "(1, 0.5, -2)"
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
/// "(x, y, z; w)"
inline std::string to_string(Quat q) {
    std::string text = to_string(UnitVec3{q.x, q.y, q.z});
    text.back() = ';';
    text.append(" ").append(to_string(q.w)).append(")");
    return text;
}

} // namespace lockstone
