// The scenes in which the two engines are compared (section 5): built-in scenes at a size that the thesis' engine can
// run, and a few that exist only here, so that the tables of hashes and the matrix of builds do not contain them.
#pragma once

#include "scenes/scenes.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace reference {

struct CompareScene {
    std::string_view name;
    std::string_view sentence; ///< a hint for the viewer
    std::uint32_t size;        ///< 0: the scene has one size
    std::uint64_t ticks;       ///< length of the comparison
};
/// two-blocks, stack, pile, domino, orbit, top, pyramid.
std::span<const CompareScene> compare_scenes();
/// Null for other names.
const CompareScene* find_compare_scene(std::string_view name);

/// One of these scenes, or one of lockstone::scenes(). The error lists all of them.
lockstone::Result<std::unique_ptr<lockstone::Game>> make_compare_scene(std::string_view name,
                                                                       lockstone::SceneOptions options = {});

} // namespace reference
