// The sync test session: rolls back a fixed number of ticks in every tick, with the true inputs, so every
// hash must repeat.
#pragma once

#include "session/inputs/input_queue.h"

namespace lockstone::session {

class SyncTestSession final : public Session {
  public:
    SyncTestSession(const SessionDef& def, std::uint32_t depth);

    void poll(std::uint64_t now_ms) override;
    void add_local_input(std::uint32_t player, std::span<const std::byte> input) override;
    Step advance() override;
    /// Ends the test: the last `depth` ticks are confirmed without a rollback across them.
    Step settle() override;
    HashCheck report_hash(std::uint64_t tick, std::uint64_t hash) override;
    std::optional<ConfirmedTick> next_confirmed() override;
    std::optional<Notice> next_notice() override { return std::nullopt; }
    Status drop_peer(PeerId) override { return Error{"session: a sync test has no peers to drop"}; }
    std::uint64_t current_tick() const override { return current; }
    std::uint32_t images_max() const override { return static_cast<std::uint32_t>(depth) + 1; }
    void set_input_delay(std::uint32_t) override {}
    PeerQuality quality(PeerId) const override { return {}; }
    const SessionStats& stats() const override { return counts; }

  private:
    void run(std::uint64_t tick, InputStatus status);

    SessionDef def;
    std::uint64_t depth; ///< [ticks]
    std::vector<InputQueue> queues;
    std::uint64_t current = 0;
    std::uint64_t confirmed = 0;
    bool settled = false;
    std::uint64_t hashed_end = 0;      ///< ticks below have a first hash
    std::vector<std::uint64_t> hashes; ///< of first runs, by tick modulo history_ticks
    std::vector<Request> requests;
    std::vector<PlayerInput> inputs;
    SessionStats counts;
};

} // namespace lockstone::session
