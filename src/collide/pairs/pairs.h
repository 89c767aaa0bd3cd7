// The routines that `collide` calls: for two convex shapes, for a plane and a convex shape, and for shapes of
// several parts.
#pragma once

#include "collide/narrow_phase.h"

namespace lockstone::collide {

/// Two convex shapes in any order of kinds, or a plane (A) and a convex shape. Overwrites `out`.
void collide_pair(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
                  Manifold& out);
/// A plane (A) and a convex shape B. Needs a zeroed `out`.
void collide_plane(const shapes::Solid& b, const RelativePose& pose, Length margin, Manifold& out);

/// At least one of A and B is a compound. Needs the preconditions of `collide`.
void collide_compound(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
                      NarrowScratch& scratch, Manifolds& out);
/// A is a height field or mesh, B is convex.
void collide_triangles(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                       Length margin, NarrowScratch& scratch, Manifolds& out);

} // namespace lockstone::collide
