#include "session/sync_test.h"

#include "base/assert.h"

#include <algorithm>

namespace lockstone::session {

SyncTestSession::SyncTestSession(const SessionDef& session_def, std::uint32_t ticks)
    : def(session_def), depth(ticks), hashes(history_ticks) {
    for (std::uint32_t p = 0; p < def.players.size(); ++p) queues.emplace_back(p, def.input_size);
    counts.local_players = static_cast<std::uint32_t>(def.players.size());
    requests.reserve(2 * (depth + 2));
    inputs.reserve((depth + 2) * def.players.size());
}

void SyncTestSession::poll(std::uint64_t now_ms) { counts.last_poll_ms = now_ms; }

void SyncTestSession::add_local_input(std::uint32_t player, std::span<const std::byte> input) {
    LOCKSTONE_ASSERT(player < queues.size(), "player ", player);
    if (queues[player].next() == current) queues[player].confirm(input);
}

Step SyncTestSession::advance() {
    LOCKSTONE_ASSERT(!settled, "the test has ended: settle() was called at tick ", current);
    LOCKSTONE_ASSERT(confirmed + depth >= current, "take confirmed ticks first: ", confirmed);
    requests.clear();
    inputs.clear();
    for (const InputQueue& queue : queues) {
        if (queue.next() == current) return {Stall::local_input_missing, requests, 0};
    }
    // The present state is saved first: after the rollback, the ticks that run again must lead back to it.
    requests.push_back(Save{current});
    if (current >= depth) {
        requests.push_back(Load{current - depth, true});
        for (std::uint64_t tick = current - depth; tick < current; ++tick) {
            run(tick, InputStatus::confirmed);
            requests.push_back(Save{tick + 1});
        }
        ++counts.rollbacks;
        counts.resimulated += depth;
        counts.depth_max = depth;
    }
    run(current, InputStatus::predicted);
    ++current;
    ++counts.ticks;
    return {Stall::none, requests, 0};
}

Step SyncTestSession::settle() {
    settled = true;
    requests.clear();
    inputs.clear();
    return {Stall::none, requests, 0};
}

void SyncTestSession::run(std::uint64_t tick, InputStatus status) {
    const std::size_t first = inputs.size();
    for (const InputQueue& queue : queues) inputs.push_back({queue.confirmed(tick), status});
    requests.push_back(Advance{tick, std::span(inputs).subspan(first), status == InputStatus::confirmed});
}

HashCheck SyncTestSession::report_hash(std::uint64_t tick, std::uint64_t hash) {
    LOCKSTONE_ASSERT(tick < current && tick <= hashed_end, "tick ", tick, ", hashed up to ", hashed_end);
    std::uint64_t& first = hashes[tick % history_ticks];
    if (tick == hashed_end) {
        ++hashed_end;
        first = hash;
        return HashCheck::accepted;
    }
    ++counts.hashes_compared;
    return first == hash ? HashCheck::accepted : HashCheck::differs;
}

/// A tick has run `depth` further times as soon as the present tick is more than `depth` ticks ahead of it.
std::optional<ConfirmedTick> SyncTestSession::next_confirmed() {
    if (confirmed + (settled ? 0 : depth) >= current) return std::nullopt;
    inputs.clear();
    for (InputQueue& queue : queues) {
        inputs.push_back({queue.confirmed(confirmed), InputStatus::confirmed});
        queue.forget_before(confirmed);
    }
    const ConfirmedTick tick{confirmed, inputs, hashes[confirmed % history_ticks]};
    ++confirmed;
    return tick;
}

} // namespace lockstone::session
