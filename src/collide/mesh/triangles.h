// Meshes and height fields against convex shapes.
//
// A triangle has one face. Its edges are felt, that is, give contacts with normals of their own, only where the
// mesh is convex. A contact's normal is the triangle's own, or lies between it and the neighbour's normal at a
// sharp edge. Bodies slide over the seams of a flat surface, and over those between two adjacent meshes, as
// over a plane.
//
// The space behind the nearest triangle is solid. A shape whose core's centre is there is pushed out along the
// normals of the triangles around the nearest one, as long as a triangle is within the shape's bounds; below a
// height field, always.
#pragma once

#include "collide/narrow_phase.h"

namespace lockstone::collide {

/// Appends to scratch.pieces a manifold for each triangle of A (mesh or height field) that B (convex) touches,
/// in ascending order of triangle index. collide_triangles merges them. Uses scratch.triangles, parts and
/// order.
void append_triangle_pieces(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                            Length margin, NarrowScratch& scratch);

/// B's bounds, grown by the margin, in A's axes and rounded outward.
shapes::Extent extent_in(const shapes::Solid& b, const RelativePose& pose, Length margin);

} // namespace lockstone::collide
