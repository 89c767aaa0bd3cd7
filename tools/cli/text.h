// Small things that commands print and write.
#pragma once

#include "lockstone/world.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lockstone::cli {

/// 16 lower-case hex digits.
std::string hash_text(std::uint64_t hash);
/// Text from anywhere as a terminal may have it: control characters and bytes that are no UTF-8 as \x1b, and of more than `most`
/// characters the first ones and "...".
std::string shown(std::string_view text, std::size_t most = 40);
/// Prints one line to standard output. Names of files and what files hold go through shown().
void print_line(std::string_view text);
/// Prints a sentence to standard error as one line, after "lockstone: ", through shown().
void print_notice(std::string_view sentence);
/// 8 of them: packets carry no more of a hash.
std::string half_hash_text(std::uint32_t lower_half);
/// Replaces the file. The error names it and the reason.
Status write_file(const std::string& path, const std::string& text);
/// The bytes of a file, a pipe or a device of at most `most` bytes; the error of a longer one names the bound.
Result<std::string> read_file(const std::string& path, std::size_t most);
/// Before any of the outputs is touched: each can be written, none is a file that is read, and no two are one file. Empty names
/// are left out.
Status check_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& sources = {});
/// Checks that write_file and recorders can write it, and leaves the file as it is. Accepts pipes and devices.
Status check_writable(const std::string& path);

/// Accepts only digits whose value fits; returns nothing otherwise.
std::optional<std::uint64_t> number_of(std::string_view text);

/// Sets the instruction set of that name; of an empty one nothing. The error says what there is.
Status check_simd(const std::string& level); ///< a name of what this machine has
Status choose_simd(const std::string& level, World& world);

} // namespace lockstone::cli
