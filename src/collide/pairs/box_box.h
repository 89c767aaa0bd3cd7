// Two boxes in the frame of the first. Used by the axis search and the clipping.
#pragma once

#include "collide/integer.h"

namespace lockstone::collide {

struct BoxPair {
    Long3 a, b;   // half extents, 24 fraction bits
    Long3 t;      // B's centre, 24
    Long3 r[3];   // B's axes, 30
    Long3 abs[3]; // |r|
};

/// Fills the manifold: clips the incident face of one box against face `axis` of the reference box, which is A,
/// or B when `reference_is_b`. Adds no points when nothing within the margin is over that face.
void clip_faces(const BoxPair& g, bool reference_is_b, int axis, Length margin, Manifold& out);

/// A corner of the clipped polygon, before the reduction to four: its position in the reference face and its
/// height above it.
struct ClipPoint {
    std::int64_t p, q, height;      // 30 fraction bits
    std::uint8_t line_in, line_out; // the two lines that meet here: 0..3 incident edges, 4..7 reference sides
};

/// Removes corners of a convex polygon, given in cyclic order, until four remain. Each step removes the corner
/// that cuts off least area, but never the last of the corners that are lowest up to noise. For two nearly
/// equal faces this removes the crossings of edges, whose position along an edge is arbitrary: a tower that
/// rests on crossings starts to rock. A later corner is removed instead of an earlier one only when it cuts off
/// less by more than a sixteenth, so the choice is stable under small motions. Returns the number of corners,
/// at most 4, in their original order.
int reduce_points(ClipPoint* points, int count);

} // namespace lockstone::collide
