// Draws pictures with gnuplot.
#pragma once

#include "lockstone/result.h"

#include <string>

namespace lockstone::cli {

/// Runs a gnuplot script that writes `file`, and drops gnuplot's messages. The caller has checked with check_outputs
/// that the file can be written.
Status draw(const std::string& script, const std::string& file);

} // namespace lockstone::cli
