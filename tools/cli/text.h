// Small helpers of the commands for printing text and writing files.
#pragma once

#include "lockstone/world.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lockstone::cli {

/// The hash as 16 lower-case hex digits.
std::string hash_text(std::uint64_t hash);
/// Text from an untrusted source in a form that is safe for a terminal. Control characters and bytes that are no UTF-8
/// become \x1b and the like. Of more than `most` characters the first `most` are kept, followed by "...".
std::string shown(std::string_view text, std::size_t most = 40);
/// Prints one line to standard output through shown(), so that names and texts from files cannot control the terminal.
void print_line(std::string_view text);
/// Prints a sentence to standard error as one line, after "lockstone: ", through shown().
void print_notice(std::string_view sentence);
/// The hash as 8 hex digits: packets carry only the lower half of a hash.
std::string half_hash_text(std::uint32_t lower_half);
/// Writes the text in place of the file's content. The error names the file and the reason.
Status write_file(const std::string& path, const std::string& text);
/// Reads a file, a pipe or a device of at most `most` bytes. If it is longer, the error names the limit.
Result<std::string> read_file(const std::string& path, std::size_t most);
/// Checks output files before any of them is written: each can be written, none is also a source, and no two are the
/// same file. Empty names are skipped.
Status check_outputs(const std::vector<std::string>& outputs, const std::vector<std::string>& sources = {});
/// Checks that write_file and recorders can write to the path, and leaves the file as it is. Accepts pipes and devices.
Status check_writable(const std::string& path);

/// Accepts only digits whose value fits; returns nothing otherwise.
std::optional<std::uint64_t> number_of(std::string_view text);

/// Returns an error if `level` is no instruction set, or one that this machine does not have.
Status check_simd(const std::string& level);
/// Selects the instruction set of that name; an empty name changes nothing. Errors are those of check_simd.
Status choose_simd(const std::string& level, World& world);

} // namespace lockstone::cli
