// What whole games cost: a recording that is verified, cars in an arena, the built-in scenes.
#pragma once

#include "bench/contest.h"
#include "lockstone/result.h"

namespace lockstone::bench {

/// A recording of rollback-arena with four players, and how many times faster than play it is verified.
Result<Json> verify_speed(bool quick);

/// Four cars and a ball on an arena's mesh at 120 ticks a second.
Result<Json> arena_cost(bool quick);

/// Of a scene that `lockstone scenes` lists, with its game's rules and scripted inputs; the error names the scenes there are.
Result<Json> game_cost(const std::string& name, bool quick);

} // namespace lockstone::bench
