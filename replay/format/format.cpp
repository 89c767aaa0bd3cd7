#include "replay/format/format.h"

#include "base/bytes.h"
#include "lockstone/state.h"

#include <algorithm>

namespace lockstone::replay {

std::string_view name_of(Mode mode) {
    switch (mode) {
    case Mode::inputs:
        return "inputs";
    case Mode::commands:
        return "commands";
    }
    return "unknown";
}

const std::string* find_option(const Header& header, std::string_view key) {
    for (const Option& option : header.options)
        if (option.key == key) return &option.value;
    return nullptr;
}

std::string chunk_name(std::uint32_t type) {
    std::string name;
    for (std::uint32_t i = 0; i < 4; ++i) {
        const auto c = static_cast<char>(type >> (8 * i) & 0x7fu);
        name += (type >> (8 * i) & 0x80u) == 0 && c > ' ' && c < 0x7f ? c : '?';
    }
    return name;
}

std::array<std::byte, preamble_bytes> preamble() {
    constexpr std::array<std::uint8_t, 8> magic = {0x89, 'L', 'S', 'R', '\r', '\n', 0x1a, '\n'};
    std::array<std::byte, preamble_bytes> out{};
    std::ranges::transform(magic, out.begin(), [](std::uint8_t b) { return std::byte{b}; });
    base::store_little_endian(version_major, out.data() + 8);
    base::store_little_endian(version_minor, out.data() + 10);
    return out;
}

std::uint64_t chain_start(const std::array<std::byte, preamble_bytes>& first_bytes) {
    return hash_bytes(first_bytes);
}

} // namespace lockstone::replay
