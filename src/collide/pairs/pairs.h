// The pairs that `collide` hands out: between two convex shapes, a plane and a convex shape, and shapes of many parts.
#pragma once

#include "collide/narrow_phase.h"

namespace lockstone::collide {

/// Two convex shapes, or a plane (A) and a convex shape, in any order of kinds but that one. Overwrites `out`.
void collide_pair(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
                  Manifold& out);
/// B, convex, above a plane. `out` is zeroed.
void collide_plane(const shapes::Solid& b, const RelativePose& pose, Length margin, Manifold& out);

/// At least one of A and B is a compound; what `collide` needs.
void collide_compound(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
                      NarrowScratch& scratch, Manifolds& out);
/// A is a height field or mesh, B convex.
void collide_triangles(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                       Length margin, NarrowScratch& scratch, Manifolds& out);

} // namespace lockstone::collide
