#include "confirmed_log.h"

#include <utility>

namespace lockstone::demo {

Status ConfirmedLog::begin(const Game& game, const World& start, std::uint64_t ticks) {
    ticks_ = ticks;
    replay::RecorderOptions options;
    // The world is ahead of the confirmed ticks, so it has no confirmed state for a keyframe.
    options.keyframe_ticks = 0;
    Result<replay::InputRecorder> begun = replay::InputRecorder::begin(sink_, game, start, options);
    if (!begun) return begun.error();
    recorder_ = std::move(*begun);
    return {};
}

void ConfirmedLog::on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) {
    if (tick >= ticks_ || closed_) return;
    std::vector<std::byte>& bytes = inputs_.emplace_back();
    for (const PlayerInput& input : inputs) bytes.insert(bytes.end(), input.bytes.begin(), input.bytes.end());
    hashes_.push_back(hash);
    if (const Status status = recorder_->on_tick(tick, inputs, hash); !status && status_) status_ = status;
}

Status ConfirmedLog::close() {
    if (std::exchange(closed_, true)) return status_;
    if (const Status status = recorder_->close(); !status && status_) status_ = status;
    return status_;
}

} // namespace lockstone::demo
