// Room for lists that are filled anew in every tick.
#pragma once

#include <cstddef>
#include <vector>

namespace lockstone::base {

/// For how many there is room where `count` were too many for what there was: an eighth more, so that a heap that grows seldom
/// allocates.
constexpr std::size_t room_for(std::size_t count) { return count + count / 8 + 64; }
template <class T> void make_room(std::vector<T>& list, std::size_t count) {
    if (list.capacity() < count) list.reserve(room_for(count));
}

} // namespace lockstone::base
