// Every kind of trouble that a match may have, drawn from a seed.
#pragma once

#include "cli/match/match.h"

#include <string>
#include <vector>

namespace lockstone::cli {

struct Chaos {
    std::uint32_t players;
    MatchDef def;
};

/// The names of the kinds of trouble that chaos_of can leave out. `lockstone match` uses them to shrink a match that
/// fails.
const std::vector<std::string>& chaos_kinds();
/// Draws a match. Equal arguments give equal matches; a kind in `without` is switched off and the rest stays as it was.
Chaos chaos_of(std::uint64_t seed, std::uint64_t ticks, const std::vector<std::string>& without);
/// A short description of the match and its trouble.
std::string told(const Chaos& chaos);

} // namespace lockstone::cli
