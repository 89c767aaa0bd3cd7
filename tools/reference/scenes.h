// The scenes in which the two engines are compared (section 5): built-in ones at a size that the thesis' engine can carry, and a few
// that are known here alone, so that the tables of hashes and the matrix of builds need not hold them.
#pragma once

#include "scenes/scenes.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace reference {

struct CompareScene {
    std::string_view name;
    std::string_view sentence; ///< what to look for
    std::uint32_t size;        ///< 0: it comes in one
    std::uint64_t ticks;       ///< that show it
};
/// two-blocks, stack, pile, domino, orbit, top, pyramid.
std::span<const CompareScene> compare_scenes();
/// Null for what is not one of them.
const CompareScene* find_compare_scene(std::string_view name);

/// One of these, else one of lockstone::scenes(). The error names all.
lockstone::Result<std::unique_ptr<lockstone::Game>> make_compare_scene(std::string_view name,
                                                                       lockstone::SceneOptions options = {});

} // namespace reference
