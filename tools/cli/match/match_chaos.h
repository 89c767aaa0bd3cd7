// Everything that may go wrong in a match at once, drawn from its seed.
#pragma once

#include "cli/match/match.h"

#include <string>
#include <vector>

namespace lockstone::cli {

struct Chaos {
    std::uint32_t players;
    MatchDef def;
};

/// What may be left out, by name: of a match that fails, whatever it fails without.
const std::vector<std::string>& chaos_kinds();
/// The same seed gives the same match, but for the kinds in `without`.
Chaos chaos_of(std::uint64_t seed, std::uint64_t ticks, const std::vector<std::string>& without);
/// A few words on what goes wrong in it.
std::string told(const Chaos& chaos);

} // namespace lockstone::cli
