#pragma once
/// The program: a surface, pages one after the other, the last line.

#include "options.h"

namespace lockstone::demo {

/// Exit status: 0 all that was compared agrees, 1 something differs, 2 bad input.
int run(const Options& options);

} // namespace lockstone::demo
