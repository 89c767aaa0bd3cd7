// Exact and shortest decimal text.
#include "lockstone/math/decimal.h"

#include <charconv>

namespace lockstone::detail {
namespace {

/// The fraction `rest` / 2^bits, digit by digit: each multiplication by ten moves the next digit in front of the
/// point.
struct DigitSource {
    std::uint64_t rest;
    int bits;

    int next() {
        const Wide scaled = Wide::product_unsigned(rest, 10);
        rest = scaled.low_bits() & (bits == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1);
        return static_cast<int>((scaled >> bits).low_bits());
    }
};

} // namespace

// source: G. L. Steele, J. L. White, How to Print Floating-Point Numbers Accurately, 1990, algorithm (FP)^3
DecimalText decimal_text(std::int64_t raw, int fraction_bits, DecimalForm form) {
    DecimalText text{};
    char* out = text.characters.data();
    const std::uint64_t size = magnitude(raw), whole = size >> fraction_bits;
    if (raw < 0) *out++ = '-';
    out = std::to_chars(out, out + 20, whole).ptr;
    // One bit more than the value has, so that half a step is an integer too.
    const int bits = fraction_bits + 1;
    const std::uint64_t one = std::uint64_t{1} << fraction_bits << 1; // 0 for 63 fraction bits: 2^64
    DigitSource digits{(size << 1) & (one - 1), bits};
    const bool inclusive = (size & 1) == 0; // half a step away, a decimal reads back as the even neighbour
    Wide half_step = Wide::from(1);
    if (digits.rest != 0) *out++ = '.';
    while (digits.rest != 0) {
        int digit = digits.next();
        if (form == DecimalForm::shortest) {
            half_step = (half_step << 3) + (half_step << 1);
            const Wide below = Wide::product_unsigned(digits.rest, 1),
                       above = (Wide::from(1) << bits) - below;
            const bool can_end = below < half_step || (inclusive && below == half_step);
            const bool can_end_above = above < half_step || (inclusive && above == half_step);
            if (can_end_above && (!can_end || above < below)) ++digit;
            if (can_end || can_end_above) digits.rest = 0;
        }
        *out++ = static_cast<char>('0' + digit);
    }
    text.size = static_cast<std::uint8_t>(out - text.characters.data());
    return text;
}

} // namespace lockstone::detail
