#pragma once
/// Reads a game's own columns by name, so that a viewer can show scores without the game's headers, also of a
/// replay that holds commands alone.

#include "lockstone/world.h"

#include <optional>
#include <vector>

namespace lockstone::demo {

/// The number in a field of a row; fixed point is rounded down. Nothing if there is no such column, row or
/// field.
std::optional<std::int64_t> game_value(const World& world, std::string_view column, std::uint32_t row,
                                       std::string_view field);

/// The arena's match, if this world has one.
struct MatchValues {
    std::vector<std::int64_t> scores; ///< by player
    std::size_t it = 0;               ///< the player who is "it"
};
std::optional<MatchValues> match_values(const World& world);

/// The player who owns the prop in this row of the bodies; nothing if nobody does.
std::optional<std::uint32_t> prop_owner(const World& world, std::uint32_t body_row);

} // namespace lockstone::demo
