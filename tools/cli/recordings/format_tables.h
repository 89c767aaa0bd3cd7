// The tables of replay/FORMAT.md, from the descriptions of commands, definitions and the state. A program of its own
// prints them too (tests/tidy/tables.py), so the sources of this file need only src/base, src/state/layout.cpp and src/model.
#pragma once

#include <string>

namespace lockstone::cli {

/// Each table between the lines <!-- NAME --> and <!-- end of NAME -->. The state is that of a world without columns of a game.
std::string format_tables();

} // namespace lockstone::cli
