// Pictures for people, drawn by gnuplot.
#pragma once

#include "lockstone/result.h"

#include <string>

namespace lockstone::cli {

/// Runs a script that writes `file`; check_outputs has looked whether that can be written. What gnuplot prints besides the picture is
/// nobody's.
Status draw(const std::string& script, const std::string& file);

} // namespace lockstone::cli
