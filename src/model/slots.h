// Creation and removal of objects: slots, to which ids refer, and the dense rows behind them. Also the lists of
// joints of each body.
#pragma once

#include "model/model.h"

namespace lockstone::sim {

/// Returns the slot of a new object in row `row`. `first_free`: the field of the header that begins the list of free
/// slots. May grow the table: views into the state become invalid.
std::uint32_t take_slot(Model& w, TableId table, Column<Slot> column, std::uint32_t Header::*first_free,
                        std::uint32_t row);
void free_slot(State& state, Column<Slot> column, std::uint32_t index, std::uint32_t& first_free);
/// Moves the last row of a table into `row`, and shortens the table by one row.
void remove_row(State& state, TableId table, std::uint32_t row);
/// Swaps two rows of a table, in all its columns.
void swap_rows(State& state, TableId table, std::uint32_t x, std::uint32_t y);
/// Swaps rows below `end`, one swap after the other, in all columns of a table but one. Marks all rows below `end` as
/// changed.
void swap_rows(State& state, TableId table, std::uint32_t except, std::uint32_t end,
               std::span<const RowSwap> swaps);

/// Adds the row of a joint to the lists of its bodies.
void enlist_joint(Model& w, std::uint32_t row);
void remove_joint(Model& w, std::uint32_t slot);

} // namespace lockstone::sim
