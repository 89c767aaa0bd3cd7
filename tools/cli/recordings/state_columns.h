// The columns of a world's state as tables for replay/FORMAT.md, generated from the engine's state layout.
#pragma once

#include "lockstone/state.h"

#include <string>
#include <vector>

namespace lockstone::cli {

/// A struct that replay/FORMAT.md describes elsewhere, or that has a name of its own.
struct NamedLeaves {
    std::string name;
    std::vector<LeafInfo> leaves;
};

/// A table of all columns in hash order, then the fields of each column's row. Fields that form one of the structs in
/// `known` are listed under its name.
std::string state_tables(const StateLayout& layout, const std::vector<NamedLeaves>& known);

} // namespace lockstone::cli
