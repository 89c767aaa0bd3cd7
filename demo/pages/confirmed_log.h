#pragma once
/// Keeps the confirmed ticks of a session in memory as a recording.

#include "lockstone/session.h"
#include "replay/recorder.h"

#include <optional>
#include <vector>

namespace lockstone::demo {

/// The confirmed timeline of one machine.
class ConfirmedLog final : public ConfirmedSink {
  public:
    /// Starts the log. It ignores ticks from `ticks` on, so that the recordings of both peers end alike.
    Status begin(const Game& game, const World& start, std::uint64_t ticks);
    void on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) override;
    Status close(); ///< the log ignores ticks that are confirmed later

    bool complete() const { return hashes_.size() == ticks_; }
    const std::vector<std::uint64_t>& hashes() const { return hashes_; }          ///< by tick
    const std::vector<std::vector<std::byte>>& inputs() const { return inputs_; } ///< by tick, all players
    /// The recording file; valid after close().
    const std::vector<std::byte>& replay() const { return sink_.bytes; }

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
