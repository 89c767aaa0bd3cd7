#include "cli/text.h"

#include <cerrno>
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

Status write_file(const std::string& path, const std::string& text) {
    errno = 0;
    std::ofstream file(path, std::ios::binary | std::ios::trunc);
    file << text;
    file.close();
    if (!file) return Error{path + ": cannot write: " + std::strerror(errno)};
    return {};
}

Result<std::string> read_file(const std::string& path) {
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    std::string text;
    char chunk[4096];
    while (file.read(chunk, sizeof chunk), file.gcount() > 0)
        text.append(chunk, static_cast<std::size_t>(file.gcount()));
    if (!file.is_open() || file.bad()) return Error{path + ": cannot read: " + std::strerror(errno)};
    return text;
}

Status check_output(const std::string& output, const std::string& source) {
    std::error_code none;
    if (output.empty() || source.empty() || !std::filesystem::equivalent(output, source, none)) return {};
    return Error{output + ": is what is read from; write to another file"};
}

static const Simd* simd_of(const std::string& level) {
    for (const Simd& known : every_simd)
        if (name_of(known) == level) return &known;
    return nullptr;
}

Status check_simd(const std::string& level) {
    const Simd* known = simd_of(level);
    if (known == nullptr)
        return Error{"--simd " + level + ": there are scalar, sse41, avx2, avx512, neon and wasm128"};
    return has_simd(*known) ? Status{} : Error{"--simd " + level + ": this machine has none"};
}

Status choose_simd(const std::string& level, World& world) {
    if (level.empty()) return {};
    if (Status known = check_simd(level); !known) return known;
    world.set_simd(*simd_of(level));
    return {};
}

} // namespace lockstone::cli
