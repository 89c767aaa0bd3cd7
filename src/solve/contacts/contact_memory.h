// What a pair's manifolds keep of the tick before.
#pragma once

#include "solve/bodies/rows.h"

#include <cstdint>
#include <span>

namespace lockstone::solve {

/// Which impulses the fresh manifolds of a pair have taken already: a bit for each old point, four a manifold, and one for its friction.
struct Taken {
    std::uint32_t points = 0, friction = 0;
};

/// Hands the impulses of a pair's old manifolds to a fresh one. A point takes those of the old point with its feature;
/// if there is none, those of the nearest old point that is left, if that is near. When two edges nearly coincide, the
/// feature of a corner flips from one body's to the other's while the corner stays: a tower that forgets those impulses
/// rocks. Each impulse is taken once; friction goes to the manifold that takes the first point.
/// From old manifolds whose normal differs by more than 20 degrees nothing is taken.
void carry_impulses(std::span<const ContactMemory> old, Taken& taken, ContactMemory& fresh);

// ---- manifolds that are used again ----
// While B stands to A as when a manifold was made, but for a small move m and turn t, the manifold serves again, with its
// separations moved along to first order: s + n . (m + t x p). With u = |m| + |t| reach, where reach is the distance of B's furthest
// point from its origin, the error of that is
//   on a face of A     a point of B turns on an arc: |t|^2 reach / 2. A round B rolls: the same.
//   on a face of B     its normal turns, by |t|, while A's corner moves by |m|: |t| (|m| + |t| reach) in addition
//   merged manifolds   points whose own normals are off by up to half a degree: u / 114
//   crossing edges     a point of B's surface is followed, though another one would be found: u times the slope of the two
//                      faces; what slides off the end of a face is held on to by u
//   edges, corners     the normal itself depends on the place: all that is known is that |s' - s| <= u
// so manifolds on faces allow far larger moves than the others. With u <= reach / 256, |t| is at most 1 / 256 rad. Levers are off by u, so
// thin shapes allow less: with 2 mm for every size a house of cards falls.
inline constexpr Length recycling_on_face =
    decimal<Length>("0.001"); ///< [m] most of u, besides reach / 256 and thinnest / 128
inline constexpr Length recycling = decimal<Length>("0.0001"); ///< [m] most of u of other manifolds
inline constexpr int recycling_reach_shift = 8, recycling_thin_shift = 7;
/// The errors that follow from these limits: of the separation of a corner on a face [m], and of the face's normal [rad].
inline constexpr Length recycling_error = decimal<Length>("0.00003");
inline constexpr Unit recycling_turn = decimal<Unit>("0.00390625");

/// Whether nothing within `margin` was left out when a manifold was made.
inline bool covers(const ContactMemory& made, Length margin) { return margin <= made.margin; }
/// The largest u that the manifolds of a pair, which are all made at once, allow: that of the manifold that allows least. `reach`: of B's points from its
/// origin; `thinnest`: the inner radius of the thinner of the two. src/solve/pairs finds u, and moves separations along.
Length recycling_limit(std::span<const ContactMemory> rows, Coordinate reach, Length thinnest);

} // namespace lockstone::solve
