// Meshes and height fields against convex shapes.
//
// A triangle has one face, and its edges are felt only where the mesh is bent outward: a contact's normal is the
// triangle's own, or lies between it and the neighbour's normal at a sharp edge. Bodies slide over the seams of a
// flat surface, and over those between two meshes side by side, as over a plane.
//
// Solid is what lies behind the nearest triangle. A shape whose core's centre is there is pushed out along the
// normals of the triangles about the nearest one, as long as a triangle is within the shape's bounds; under a
// height field, always.
#pragma once

#include "collide/narrow_phase.h"

namespace lockstone::collide {

/// Appends a manifold for each triangle of A (mesh or height field) that B (convex) touches to scratch.pieces, by
/// ascending index: what collide_triangles merges. Uses scratch.triangles, parts and order.
void append_triangle_pieces(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                            Length margin, NarrowScratch& scratch);

/// B's bounds grown by the margin in A's axes, rounded outward.
shapes::Extent extent_in(const shapes::Solid& b, const RelativePose& pose, Length margin);

} // namespace lockstone::collide
