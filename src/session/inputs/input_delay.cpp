// InputDelayTuner: chooses the input delay from the measured round trips.
#include "lockstone/session/input_delay.h"

#include <algorithm>

namespace lockstone {

namespace {
InputDelayDef within_ranges(InputDelayDef def) {
    def.tick_rate = std::clamp(def.tick_rate, 1u, 1000u);
    def.most = std::min(def.most, input_delay_limit);
    def.least = std::min(def.least, def.most);
    return def;
}
} // namespace

InputDelayTuner::InputDelayTuner(const InputDelayDef& wanted_def)
    : def(within_ranges(wanted_def)), now(def.least) {}

std::uint32_t InputDelayTuner::wanted(std::span<const PeerQuality> peers) const {
    std::uint64_t slowest_ms = 0;
    for (const PeerQuality& peer : peers)
        if (peer.connected) slowest_ms = std::max<std::uint64_t>(slowest_ms, peer.ping_ms);
    const std::uint64_t way = (slowest_ms * def.tick_rate + 1999) / 2000;
    return static_cast<std::uint32_t>(std::clamp<std::uint64_t>(
        way - std::min<std::uint64_t>(way, def.rollback_ticks), def.least, def.most));
}

std::uint32_t InputDelayTuner::update(std::span<const PeerQuality> peers) {
    const std::uint32_t want = wanted(peers);
    too_short = want > now ? too_short + 1 : too_short - std::min(too_short, 1u);
    too_long = want < now ? too_long + 1 : 0;
    if (2 * too_short >= def.tick_rate) {
        ++now;
        too_short = too_long = 0;
    } else if (too_long >= 5 * def.tick_rate) {
        --now;
        too_short = too_long = 0;
    }
    return now;
}

} // namespace lockstone
