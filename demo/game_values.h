#pragma once
/// Reads a game's own columns by name. A viewer can thus show scores without the headers of the game, and also for a
/// recording of commands.

#include "lockstone/world.h"

#include <optional>
#include <vector>

namespace lockstone::demo {

/// The number in a field of a row; fixed point is rounded down. Empty if there is no such column, row or field.
std::optional<std::int64_t> game_value(const World& world, std::string_view column, std::uint32_t row,
                                       std::string_view field);

/// The score of rollback-arena, if the world has one.
struct MatchValues {
    std::vector<std::int64_t> scores; ///< by player
    std::size_t it = 0;               ///< index of the player who must tag another
};
std::optional<MatchValues> match_values(const World& world);

/// The player who owns the prop in this row of the bodies; empty if the prop has no owner.
std::optional<std::uint32_t> prop_owner(const World& world, std::uint32_t body_row);

} // namespace lockstone::demo
