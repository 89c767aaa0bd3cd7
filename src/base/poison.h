// Scratch memory is filled with a byte before it is used again: what reads before it writes then shows.
#pragma once

#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

namespace lockstone::base {

template <class T> void poison_one(std::byte with, T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memset(static_cast<void*>(&value), std::to_integer<int>(with), sizeof value);
}
/// The elements; how many there are stays.
template <class T> void poison_one(std::byte with, std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (!values.empty())
        std::memset(static_cast<void*>(values.data()), std::to_integer<int>(with), values.size() * sizeof(T));
}
template <class... Memory> void poison(std::byte with, Memory&... memory) { (poison_one(with, memory), ...); }

} // namespace lockstone::base
