#include "cli/text.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

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
    std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (!file.is_open() || file.bad()) return Error{path + ": cannot read: " + std::strerror(errno)};
    return text;
}

Status check_threads(std::uint32_t threads) {
    if (threads == 1) return {};
    return Error{"--threads " + std::to_string(threads) +
                 ": a tick of this build runs on one thread; leave it out or give 1"};
}

Status check_simd(const std::string& level) {
    if (level == "scalar") return {};
    return Error{"--simd " + level + ": this build has one level, scalar"};
}

} // namespace lockstone::cli
