// Pictures for people, drawn by gnuplot.
#pragma once

#include "lockstone/result.h"

#include <string>

namespace lockstone::cli {

/// Runs a script that writes `file`; check_outputs has checked that it can be written. Drops the messages of gnuplot.
Status draw(const std::string& script, const std::string& file);

} // namespace lockstone::cli
