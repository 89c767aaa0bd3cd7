// Small things that commands print and write.
#pragma once

#include "lockstone/world.h"

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

/// Sets the instruction set of that name; of an empty one nothing. The error says what there is.
Status check_simd(const std::string& level); ///< a name of what this machine has
Status choose_simd(const std::string& level, World& world);

} // namespace lockstone::cli
