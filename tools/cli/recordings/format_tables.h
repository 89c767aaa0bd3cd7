// The tables of replay/FORMAT.md, generated from the descriptions of commands, definitions and the state. The check
// tests/tidy/tables.py builds a small program from this file as well, so its sources may use only src/base,
// src/state/layout.cpp and src/model.
#pragma once

#include <string>

namespace lockstone::cli {

/// Returns each table between the lines <!-- NAME --> and <!-- end of NAME -->. The state is that of a world without
/// game columns.
std::string format_tables();

} // namespace lockstone::cli
