// Small things that commands print and write.
#pragma once

#include "lockstone/result.h"

#include <cstdint>
#include <string>

namespace lockstone::cli {

/// 16 lower-case hex digits.
std::string hash_text(std::uint64_t hash);
/// Replaces the file. The error names it and the reason.
Status write_file(const std::string& path, const std::string& text);
Result<std::string> read_file(const std::string& path);
/// Refuses to overwrite what is read.
Status check_output(const std::string& output, const std::string& source);

/// What is there to choose from, until there is more: scalar code. The error says so.
Status check_simd(const std::string& level);

} // namespace lockstone::cli
