// Prints the figures of --json as text.
#pragma once

#include "bench/contest.h"

namespace lockstone::bench {

void print_settings(const Json& settings);
/// Prints a row from run_parts; `key` is the row's key in the results.
void print_row(const std::string& key, const Json& row);
void print_instructions(const Json& rows);
/// Prints the microseconds of a tick by phase, the longest first.
void print_profile(const Json& scenes);

} // namespace lockstone::bench
