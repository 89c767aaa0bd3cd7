#pragma once
/// What a session confirms, kept in memory as a recording.

#include "lockstone/session.h"
#include "replay/recorder.h"

#include <optional>
#include <vector>

namespace lockstone::demo {

/// The confirmed timeline of one machine, kept and recorded.
class ConfirmedLog final : public ConfirmedSink {
  public:
    /// Ticks from `ticks` on are left out, so that both peers' recordings end alike.
    Status begin(const Game& game, const World& start, std::uint64_t ticks);
    void on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) override;
    Status close(); ///< what is confirmed later is left out

    bool complete() const { return hashes_.size() == ticks_; }
    const std::vector<std::uint64_t>& hashes() const { return hashes_; }          ///< by tick
    const std::vector<std::vector<std::byte>>& inputs() const { return inputs_; } ///< by tick, all players
    const std::vector<std::byte>& replay() const { return sink_.bytes; }          ///< the file, after close()

  private:
    std::uint64_t ticks_ = 0;
    bool closed_ = false;
    std::vector<std::uint64_t> hashes_;
    std::vector<std::vector<std::byte>> inputs_;
    replay::MemorySink sink_;
    std::optional<replay::InputRecorder> recorder_;
    Status status_;
};

} // namespace lockstone::demo
