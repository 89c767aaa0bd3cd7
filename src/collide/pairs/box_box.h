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

/// Drops corners of a convex polygon, given in cyclic order, until four are left: each time the one that cuts off least
/// area, but never the last of those that are the lowest to within noise. Of faces that nearly coincide the corners
/// of the edges' crossings go, which lie anywhere along an edge: a tower held by those starts to rock.
/// A later corner goes instead of an earlier one only when it cuts off less by more than a sixteenth, so the choice
/// survives small motions. Returns how many there are, at most 4, in the order they had.
int reduce_points(ClipPoint* points, int count);

} // namespace lockstone::collide
