#include "cli/text.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace lockstone::cli {

std::string hash_text(std::uint64_t hash) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

namespace {

/// The number of bytes of the first character of `text`; 0 if a terminal must not receive it. Excluded are overlong
/// UTF-8 forms, surrogate halves and control characters.
std::size_t size_of_character(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
    const std::uint8_t first = byte(0);
    if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
    const std::size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    if (first < 0xc2 || first > 0xf4 || text.size() < size) return 0;
    std::uint32_t code = first & (0xffu >> (size + 1));
    for (std::size_t i = 1; i < size; ++i) {
        if ((byte(i) & 0xc0) != 0x80) return 0;
        code = code << 6 | (byte(i) & 0x3fu);
    }
    // The smallest code points of 2, 3 and 4 bytes; 0x80 to 0x9f are controls.
    constexpr std::uint32_t least[] = {0xa0, 0x800, 0x10000};
    const bool is_half = code >= 0xd800 && code < 0xe000;
    return code >= least[size - 2] && code <= 0x10ffff && !is_half ? size : 0;
}

} // namespace

std::string shown(std::string_view text, std::size_t most) {
    std::string out;
    for (; !text.empty() && most > 0; --most) {
        const std::size_t size = size_of_character(text);
        char code[5] = "";
        if (size == 0) std::snprintf(code, sizeof code, "\\x%02x", static_cast<unsigned char>(text[0]));
        out += size == 0 ? std::string_view(code) : text.substr(0, size);
        text.remove_prefix(std::max<std::size_t>(size, 1));
    }
    return text.empty() ? out : out + "...";
}

void print_line(std::string_view text) { std::printf("%s\n", shown(text, std::string_view::npos).c_str()); }

void print_notice(std::string_view sentence) {
    std::fprintf(stderr, "lockstone: %s\n", shown(sentence, std::string_view::npos).c_str());
}

std::string half_hash_text(std::uint32_t lower_half) { return hash_text(lower_half).substr(8); }

Status write_file(const std::string& path, const std::string& text) {
    errno = 0;
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file << text;
    file.close();
    if (!file) return Error{path + ": cannot write: " + std::strerror(errno)};
    return {};
}

Result<std::string> read_file(const std::string& path, std::size_t most) {
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    std::string text;
    char chunk[4096];
    while (text.size() <= most && (file.read(chunk, sizeof chunk), file.gcount() > 0))
        text.append(chunk, static_cast<std::size_t>(file.gcount()));
    if (text.size() > most) return Error{path + ": holds more than " + std::to_string(most) + " bytes"};
    if (!file.is_open() || file.bad()) return Error{path + ": cannot read: " + std::strerror(errno)};
    return text;
}

Status check_writable(const std::string& path) {
    std::error_code none;
    const std::filesystem::file_status there = std::filesystem::status(path, none);
    const bool is_new = there.type() == std::filesystem::file_type::not_found;
    if (!is_new && !std::filesystem::is_regular_file(there) && !std::filesystem::is_directory(there))
        return {};
    errno = 0;
    std::FILE* const file = std::fopen(path.c_str(), "ab");
    if (file == nullptr) return Error{path + ": cannot write: " + std::strerror(errno)};
    std::fclose(file);
    // The target of a dangling link stays as an empty file: removing the path would remove the user's link.
    if (is_new && !std::filesystem::is_symlink(std::filesystem::symlink_status(path, none)))
        std::filesystem::remove(path, none);
    return {};
}

namespace {

/// True for two names of one regular file; the files need not exist. /dev/null and a terminal may be named several
/// times.
bool is_same_file(const std::string& a, const std::string& b) {
    namespace fs = std::filesystem;
    std::error_code none;
    if (fs::exists(a, none) && fs::exists(b, none))
        return fs::is_regular_file(a, none) && fs::equivalent(a, b, none);
    return fs::weakly_canonical(fs::absolute(a, none), none) ==
           fs::weakly_canonical(fs::absolute(b, none), none);
}

} // namespace

Status check_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& sources) {
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        if (outputs[i].empty()) continue;
        for (const std::string& source : sources)
            if (!source.empty() && is_same_file(outputs[i], source))
                return Error{outputs[i] + ": is also an input file; write to another file"};
        for (std::size_t other = 0; other < i; ++other)
            if (!outputs[other].empty() && is_same_file(outputs[i], outputs[other]))
                return Error{outputs[i] + ": is given for two outputs; write each output to its own file"};
    }
    for (const std::string& output : outputs)
        if (Status s = output.empty() ? Status{} : check_writable(output); !s) return s;
    return {};
}

std::optional<std::uint64_t> number_of(std::string_view text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

static const Simd* simd_of(const std::string& level) {
    for (const Simd& known : every_simd)
        if (name_of(known) == level) return &known;
    return nullptr;
}

Status check_simd(const std::string& level) {
    const Simd* known = simd_of(level);
    if (known == nullptr)
        return Error{"--simd " + level +
                     ": is no instruction set; choose from scalar, sse41, avx2, avx512, neon and wasm128"};
    return has_simd(*known) ? Status{}
                            : Error{"--simd " + level + ": this machine does not have these instructions"};
}

Status choose_simd(const std::string& level, World& world) {
    if (level.empty()) return {};
    if (Status known = check_simd(level); !known) return known;
    world.set_simd(*simd_of(level));
    return {};
}

} // namespace lockstone::cli
