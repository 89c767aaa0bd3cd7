#include "net/replay_window.h"

namespace lockstone::net {
namespace {

constexpr std::uint64_t words = replay_window_packets / 64;
constexpr std::uint64_t bit(std::uint64_t number) { return std::uint64_t{1} << number % 64; }

} // namespace

std::uint64_t ReplayWindow::restored(std::uint16_t low) const {
    constexpr std::uint64_t all = 0x10000, half = 0x8000;
    const std::uint64_t near = (end & ~(all - 1)) | low;
    if (near + half <= end && near <= ~all) return near + all;
    if (near > end + half && near >= all) return near - all;
    return near;
}

bool ReplayWindow::is_fresh(std::uint64_t number) const {
    if (number >= end) return true;
    // The word of the newest numbers has replaced the oldest word, so the numbers of the oldest word count
    // as too old.
    if (number / 64 + words <= (end - 1) / 64) return false;
    return (seen[number / 64 % words] & bit(number)) == 0;
}

void ReplayWindow::mark(std::uint64_t number) {
    if (number >= end) {
        const std::uint64_t newest = end == 0 ? 0 : (end - 1) / 64, wanted = number / 64;
        for (std::uint64_t word = newest + 1; word <= wanted && word <= newest + words; ++word)
            seen[word % words] = 0;
        end = number + 1;
    }
    seen[number / 64 % words] |= bit(number);
}

} // namespace lockstone::net
