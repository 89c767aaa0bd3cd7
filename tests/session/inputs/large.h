// Matches whose inputs are large and change in every tick. For the tests and for the planted faults.
#pragma once

#include "session/hostile_scenes.h"
#include "session/match.h"

namespace lockstone::test {

/// Plays two seconds in which the machines connect, then ten more. Returns a sentence if fewer than 58 ticks a second
/// ran: a lost packet may delay a tick, and a machine that is ahead pauses for single frames.
inline std::string keeps_up(MatchDef def) {
    def.input_delay = 3, def.prediction_max = 12;
    Match match(def);
    match.run(120);
    const std::uint64_t before = match.machine(0).session->current_tick();
    match.run(600);
    const std::uint64_t ticks = match.machine(0).session->current_tick() - before;
    if (!match.agree(0, 1) || !match.notices<Desync>(0).empty()) return "the machines differ";
    return ticks >= 580 ? "" : std::to_string(ticks) + " ticks ran in 600 frames";
}

inline std::vector<HostileScene> large_input_scenes() {
    constexpr std::uint32_t noise = input_bytes_max - input_size_of<Pad>;
    return {
        {"48 bytes, 40 ms one way",
         [] { return keeps_up({.link = {.latency_ms = 40, .jitter_ms = 5}, .noise_bytes = 44}); }},
        {"64 bytes, 150 ms one way, 5 % lost",
         [] {
             return keeps_up(
                 {.link = {.latency_ms = 150, .jitter_ms = 5, .loss_permille = 50}, .noise_bytes = noise});
         }},
        {"two players of 64 bytes on each machine, 110 ms one way, 5 % lost",
         [] {
             return keeps_up({.players = {0, 0, 1, 1},
                              .link = {.latency_ms = 110, .jitter_ms = 5, .loss_permille = 50},
                              .noise_bytes = noise});
         }},
    };
}

} // namespace lockstone::test
