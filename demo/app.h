#pragma once
/// The program: opens a surface, runs the pages, and prints a last line.

#include "options.h"

namespace lockstone::demo {

/// Runs the program. Exit status: 0 every comparison agrees, 1 a comparison differs, 2 bad input.
int run(const Options& options);

} // namespace lockstone::demo
