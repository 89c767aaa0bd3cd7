#include "session/link/peer_link.h"

#include <algorithm>

namespace lockstone::session {

namespace {
constexpr std::uint32_t resend_polls = 30; ///< longer than most round trips at 60 polls a second
}

void HashLedger::receive(std::uint64_t tick, std::uint32_t hash) {
    if (tick < wanted || tick >= compared + history_ticks) return;
    remote[tick % history_ticks] = {tick, hash};
    while (remote[wanted % history_ticks].tick == wanted) ++wanted;
}

void HashLedger::acknowledge(std::uint64_t next_hash) {
    if (next_hash <= acked) return;
    acked = next_hash;
    sent = std::max(sent, acked);
    polls_without_progress = 0;
}

HashLedger::Range HashLedger::to_send(std::uint64_t local_end) {
    if (sent > acked && ++polls_without_progress >= resend_polls) {
        sent = acked;
        polls_without_progress = 0;
    }
    const std::uint64_t count = std::min<std::uint64_t>(hashes_per_packet, std::max(local_end, sent) - sent);
    const Range range{sent, static_cast<std::uint32_t>(count)};
    sent += count;
    return range;
}

void TimeSync::sample(std::int32_t local_ahead, std::int32_t remote_ahead) {
    const std::int32_t lead = local_ahead - remote_ahead;
    std::int32_t& slot = leads[count % window];
    sum += lead - slot;
    slot = lead;
    ++count;
}

std::int32_t TimeSync::ticks_ahead() const {
    if (count < static_cast<std::uint32_t>(window)) return 0;
    return sum / (2 * window);
}

} // namespace lockstone::session
