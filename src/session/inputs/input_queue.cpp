#include "session/inputs/input_queue.h"

#include "base/assert.h"

#include <algorithm>

namespace lockstone::session {

namespace {
constexpr std::array<std::byte, input_bytes_max> zeros{};
} // namespace

InputQueue::InputQueue(std::uint32_t of_player, std::uint32_t input_size)
    : player_index(of_player), size(input_size), ring(history_ticks * input_size) {}

std::span<std::byte> InputQueue::slot(std::uint64_t tick) {
    return std::span(ring).subspan(tick % history_ticks * size, size);
}
std::span<const std::byte> InputQueue::slot(std::uint64_t tick) const {
    return std::span(ring).subspan(tick % history_ticks * size, size);
}

void InputQueue::confirm(std::span<const std::byte> input) {
    LOCKSTONE_ASSERT(input.size() == size, "input of ", input.size(), " bytes, expected ", size);
    LOCKSTONE_ASSERT(room() > 0, "player ", player_index, ", tick ", first_unknown);
    if (first_unknown >= cut) return;
    const std::span<std::byte> to = slot(first_unknown);
    const bool guessed = first_unknown < used_end;
    if (guessed && !std::ranges::equal(to, input)) first_wrong = std::min(first_wrong, first_unknown);
    std::ranges::copy(input, to.begin());
    ++first_unknown;
}

std::optional<std::span<const std::byte>> InputQueue::before(std::uint64_t tick) const {
    if (tick == 0) return std::span(zeros).first(size);
    if (tick < begin || (tick == begin && !has_before_begin)) return std::nullopt;
    if (tick > first_unknown || tick + history_confirmed_max < first_unknown) return std::nullopt;
    return slot(tick - 1);
}

PlayerInput InputQueue::use(std::uint64_t tick, const InputPredictor& predictor) {
    used_end = std::max(used_end, tick + 1);
    if (tick < first_unknown || is_absent(tick)) return settled(tick);
    LOCKSTONE_ASSERT(tick < first_kept + history_ticks, "player ", player_index, ", tick ", tick, ", oldest ",
                     first_kept);
    const std::span<const std::byte> last = first_unknown == 0
                                                ? std::span(zeros).first(size)
                                                : std::span<const std::byte>(slot(first_unknown - 1));
    predictor.predict(player_index, last, tick + 1 - first_unknown, slot(tick));
    return {slot(tick), InputStatus::predicted};
}

InputStatus InputQueue::foresee(std::uint64_t tick, const InputPredictor& predictor, bool held,
                                std::span<std::byte> out) const {
    if (tick < first_unknown || is_absent(tick)) {
        const PlayerInput known = settled(tick);
        std::ranges::copy(known.bytes, out.begin());
        return known.status;
    }
    const std::span<const std::byte> last =
        first_unknown == 0 ? std::span(zeros).first(size) : slot(first_unknown - 1);
    if (held)
        std::ranges::copy(last, out.begin());
    else
        predictor.predict(player_index, last, tick + 1 - first_unknown, out);
    return InputStatus::predicted;
}

PlayerInput InputQueue::settled(std::uint64_t tick) const {
    if (is_absent(tick)) return {std::span(zeros).first(size), InputStatus::disconnected};
    LOCKSTONE_ASSERT(tick >= first_kept && tick < first_unknown, "player ", player_index, ", tick ", tick,
                     " of [", first_kept, ", ", first_unknown, ")");
    return {slot(tick), InputStatus::confirmed};
}

std::uint64_t InputQueue::take_first_wrong() { return std::exchange(first_wrong, never); }

void InputQueue::disconnect_at(std::uint64_t tick) {
    LOCKSTONE_ASSERT(tick >= first_kept && cut == never, "player ", player_index, ", tick ", tick);
    cut = tick;
    // It ran on an input of the player, not on `disconnected`.
    if (tick < used_end) first_wrong = std::min(first_wrong, tick);
}

void InputQueue::begin_at(std::uint64_t tick) {
    begin = first_kept = first_unknown = used_end = tick;
    has_before_begin = tick == 0;
}

void InputQueue::set_before_begin(std::span<const std::byte> input) {
    if (begin == 0) return;
    std::ranges::copy(input, slot(begin - 1).begin());
    has_before_begin = true;
}

void InputQueue::return_at(std::uint64_t tick) {
    LOCKSTONE_ASSERT(disconnected() && tick > 0, "player ", player_index, ", tick ", tick);
    left_at = std::exchange(cut, never);
    begin = first_kept = first_unknown = tick;
    set_before_begin(std::span(zeros).first(size));
    if (tick < used_end) first_wrong = std::min(first_wrong, tick); // it ran on `disconnected`
}

void InputQueue::forget_before(std::uint64_t tick) {
    const std::uint64_t newest = first_unknown == 0 ? 0 : first_unknown - 1;
    first_kept = std::max(first_kept, std::min(tick, newest));
}

} // namespace lockstone::session
