// The same figures as --json, for people.
#pragma once

#include "bench/contest.h"

namespace lockstone::bench {

void print_settings(const Json& settings);
/// A row as run_parts hands it over, under the key it has there.
void print_row(const std::string& key, const Json& row);
void print_instructions(const Json& rows);
/// Microseconds a tick by phase, the longest first.
void print_profile(const Json& scenes);

} // namespace lockstone::bench
