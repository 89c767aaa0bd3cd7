// Overwrites scratch memory with a byte before it is used again. Code that reads the memory before writing it then
// gives other results.
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
/// Overwrites the elements; the size stays.
template <class T> void poison_one(std::byte with, std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (!values.empty())
        std::memset(static_cast<void*>(values.data()), std::to_integer<int>(with), values.size() * sizeof(T));
}
template <class... Memory> void poison(std::byte with, Memory&... memory) { (poison_one(with, memory), ...); }

} // namespace lockstone::base
