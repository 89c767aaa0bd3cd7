// Disjoint sets of numbers (union-find). A list holds the parent of each number. A number that is its own parent is
// the root of a set, and the root is the least number of its set.
// source: Tarjan, van Leeuwen, Worst-case analysis of set union algorithms (1984): path halving
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace lockstone::base {

/// Makes `count` sets of one number each.
inline void start_sets(std::vector<std::uint32_t>& parent, std::size_t count) {
    parent.resize(count);
    std::iota(parent.begin(), parent.end(), 0u);
}
inline std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t x) {
    while (parent[x] != x) x = parent[x] = parent[parent[x]];
    return x;
}
inline void join(std::vector<std::uint32_t>& parent, std::uint32_t x, std::uint32_t y) {
    const std::uint32_t a = root_of(parent, x), b = root_of(parent, y);
    parent[std::max(a, b)] = std::min(a, b);
}

} // namespace lockstone::base
