// The contact memory: the data that the manifolds of a pair keep from tick to tick.
#pragma once

#include "solve/bodies/rows.h"

#include <cstdint>
#include <span>

namespace lockstone::solve {

/// The old impulses that new manifolds of the pair have already taken. `points`: a bit for each old point, four bits a
/// manifold. `friction`: a bit for each old manifold.
struct Taken {
    std::uint32_t points = 0, friction = 0;
};

/// Copies the impulses of a pair's old manifolds to a new one. A point takes the impulse of the old point with its
/// feature. If there is none, it takes the impulse of the nearest old point that is not taken yet, up to 2 cm away.
/// When two edges nearly coincide, the feature of a corner flips from one body to the other while the corner stays: a
/// tower that forgets those impulses rocks. Each normal impulse is taken once; the friction of an old manifold goes to
/// the first manifold that takes one of its points. Rolling impulses come from the first old manifold with a similar
/// normal. Old manifolds whose normal differs by more than 20 degrees give nothing.
void carry_impulses(std::span<const ContactMemory> old, Taken& taken, ContactMemory& fresh);

// ---- recycled manifolds ----
// The pose of B relative to A may change by a small move m and a small turn t after a manifold was made. Then the
// manifold is recycled, and its separations are updated to first order: s + n . (m + t x p). With u = |m| + |t| reach,
// where reach is the distance of B's farthest point from its origin, the error of that update is
//   on a face of A     a point of B turns on an arc: |t|^2 reach / 2. A round B rolls, with the same error.
//   on a face of B     its normal turns by |t| while A's corner moves by |m|: |t| (|m| + |t| reach) in addition
//   merged manifolds   points whose own normals are off by up to half a degree: u / 114
//   crossing edges     the same point of B's surface is used, where a search finds another one: u times the slope of
//                      the two faces; a point that slides off the end of a face is kept for a distance of u
//   edges, corners     the normal itself depends on the place: the only bound is |s' - s| <= u
// So manifolds on faces allow far larger moves than the others. With u <= reach / 256, |t| is at most 1 / 256 rad.
// Levers are off by u, so thin shapes allow less: with 2 mm for every size a house of cards falls.
/// [m] largest u of manifolds on faces; reach / 256 and thinnest / 128 also limit it
inline constexpr Length recycling_on_face = decimal<Length>("0.001");
inline constexpr Length recycling = decimal<Length>("0.0001"); ///< [m] largest u of other manifolds
inline constexpr int recycling_reach_shift = 8, recycling_thin_shift = 7;
/// The errors that follow from these limits: of the separation of a corner on a face [m], and of the normal of the face
/// [rad].
inline constexpr Length recycling_error = decimal<Length>("0.00003");
inline constexpr Unit recycling_turn = decimal<Unit>("0.00390625");

/// True if the manifold was made with all points that are closer than `margin`.
inline bool covers(const ContactMemory& made, Length margin) { return margin <= made.margin; }
/// The largest u at which all manifolds of a pair may be recycled, which are always made together: the limit of the
/// manifold that allows least. `reach`: largest distance of B's points from its origin; `thinnest`: the smaller of the
/// inner radii of the two shapes. src/solve/pairs computes u and updates separations.
Length recycling_limit(std::span<const ContactMemory> rows, Coordinate reach, Length thinnest);

} // namespace lockstone::solve
