// Costs of whole games: verifying a recording, cars in an arena, the built-in scenes.
#pragma once

#include "bench/contest.h"
#include "lockstone/result.h"

namespace lockstone::bench {

/// Records rollback-arena with four players, and measures how many times faster than real time the recording is
/// verified.
Result<Json> verify_speed(bool quick);

/// Four cars and a ball on the mesh of an arena, at 120 ticks a second.
Result<Json> arena_cost(bool quick);

/// The cost of a scene from the list of `lockstone scenes`, with its game's rules and scripted inputs. The error lists
/// the scenes.
Result<Json> game_cost(const std::string& name, bool quick);

} // namespace lockstone::bench
