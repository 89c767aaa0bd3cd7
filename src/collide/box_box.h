// Two boxes in the frame of the first, shared by the axis search and the clipping.
#pragma once

#include "collide/integer.h"

namespace lockstone::collide {

struct BoxPair {
    Long3 a, b;   // half extents, 24 fraction bits
    Long3 t;      // B's centre, 24
    Long3 r[3];   // B's axes, 30
    Long3 abs[3]; // |r|
};

/// Fills the manifold from the incident face of one box clipped against face `axis` of the other, the reference:
/// A, or B when `reference_is_b`. No points when nothing within the margin is over that face.
void clip_faces(const BoxPair& g, bool reference_is_b, int axis, Length margin, Manifold& out);

/// A corner of the clipped polygon before the choice of four: place in the reference face, and height above it.
struct ClipPoint {
    std::int64_t p, q, height;      // 30 fraction bits
    std::uint8_t line_in, line_out; // the two lines that meet here: 0..3 incident edges, 4..7 reference sides
};

/// Moves four well-spread points of `count` to the front, in a fixed order; a pure function of the points.
///   1 the lowest   2 the furthest from it   3 and 4 those that span most area on the two sides of the line 1 - 2
/// A later point replaces an earlier one only when it is better by more than noise, so the choice survives small
/// motions. Returns how many there are, at most 4.
int reduce_points(ClipPoint* points, int count);

} // namespace lockstone::collide
