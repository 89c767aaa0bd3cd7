// The columns of a world's state as tables of replay/FORMAT.md, from the layout that the engine has.
#pragma once

#include "lockstone/state.h"

#include <string>
#include <vector>

namespace lockstone::cli {

/// A struct that the page names elsewhere, or that has a name of its own.
struct NamedLeaves {
    std::string name;
    std::vector<LeafInfo> leaves;
};

/// First all columns in hash order, then what a row of each is made of. Fields that are one of `known` are told by its name.
std::string state_tables(const StateLayout& layout, const std::vector<NamedLeaves>& known);

} // namespace lockstone::cli
