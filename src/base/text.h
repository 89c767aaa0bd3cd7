// Builds sentences from pieces: join("row ", 7, " of ", name). For errors, assertions and dumps; never on a hot path.
#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

namespace lockstone::base {

inline void append_text(std::string& out, std::string_view piece) { out += piece; }
inline void append_text(std::string& out, const char* piece) { out += piece; }
inline void append_text(std::string& out, bool piece) { out += piece ? "true" : "false"; }
template <std::integral N> void append_text(std::string& out, N piece) { out += std::to_string(piece); }

template <class... Pieces> std::string join(const Pieces&... pieces) {
    std::string out;
    (append_text(out, pieces), ...);
    return out;
}

/// 0x and the lower-case digits of v, without leading zeros: "0xfff60000", "0x0".
inline std::string hex(std::uint64_t v) {
    std::string digits;
    do {
        digits.insert(digits.begin(), "0123456789abcdef"[v & 15u]);
        v >>= 4;
    } while (v != 0);
    return "0x" + digits;
}

} // namespace lockstone::base
