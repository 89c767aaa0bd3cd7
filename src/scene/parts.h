// The convex parts of a solid, one by one.
#pragma once

#include "shapes/asset/asset.h"

namespace lockstone::sim {

/// Calls visit(part, pose in the body, index) for the solid itself or for each part of a compound. Solids without
/// volume have no parts.
template <class Visit> void for_each_part(const shapes::Solid& solid, const Transform& local, Visit&& visit) {
    if (solid.geometry.kind == ShapeKind::compound) {
        for (std::size_t i = 0; i < solid.compound->parts.size(); ++i)
            visit(solid.compound->parts[i].solid, local * solid.compound->parts[i].local, i);
        return;
    }
    if (solid.geometry.kind < ShapeKind::compound) visit(solid, local, std::size_t{0});
}

} // namespace lockstone::sim
