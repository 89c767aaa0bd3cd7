// Capacity of lists that are refilled in every tick.
#pragma once

#include <cstddef>
#include <vector>

namespace lockstone::base {

/// The capacity for `count` elements when the present one is too small: an eighth more, so that a list that grows
/// slowly seldom allocates.
constexpr std::size_t room_for(std::size_t count) { return count + count / 8 + 64; }
template <class T> void make_room(std::vector<T>& list, std::size_t count) {
    if (list.capacity() < count) list.reserve(room_for(count));
}

} // namespace lockstone::base
