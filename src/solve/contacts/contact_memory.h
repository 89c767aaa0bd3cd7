// What a pair's manifolds keep of the tick before.
#pragma once

#include "solve/bodies/rows.h"

#include <cstdint>
#include <span>

namespace lockstone::solve {

/// What the fresh manifolds of a pair have taken: a bit for each old point, four a manifold, and one for its friction.
struct Taken {
    std::uint32_t points = 0, friction = 0;
};

/// Hands the impulses of a pair's old manifolds to a fresh one. A point takes those of the old point with its feature;
/// if there is none, those of the nearest old point that is left, if that is near. When two edges nearly coincide, the
/// feature of a corner flips from one body's to the other's while the corner stays: a tower that forgets those impulses
/// rocks. What is taken once is not taken again; friction goes with the first point.
/// Old manifolds whose normal differs by more than 20 degrees have nothing to give.
void carry_impulses(std::span<const ContactMemory> old, Taken& taken, ContactMemory& fresh);

// ---- manifolds that are used again ----
// While B stands to A as when a manifold was made, but for a small move m and turn t, the manifold serves again, with its
// separations moved along to first order: s + n . (m + t x p). Of what turns and moves by u = |m| + |t| reach, reach
// being that of B's furthest point from its origin, that is wrong by
//   on a face of A     a point of B turns on an arc: |t|^2 reach / 2. A round B rolls: the same.
//   on a face of B     its normal turns, by |t|, while A's corner moves by |m|: |t| (|m| + |t| reach) in addition
//   merged manifolds   points whose own normals are off by up to half a degree: u / 114
//   crossing edges     a point of B's surface is followed, though another one would be found: u times the slope of the two
//                      faces; what slides off the end of a face is held on to by u
//   edges, corners     the normal itself depends on the place: all that is known is that |s' - s| <= u
// so faces may move by a lot more than the rest. With u <= reach / 256, |t| is at most 1 / 256 rad. Levers are off by u, so
// what is thin bears less: with 2 mm whatever the size a house of cards falls.
inline constexpr Length recycling_on_face =
    decimal<Length>("0.001"); ///< [m] most of u, besides reach / 256 and thinnest / 128
inline constexpr Length recycling = decimal<Length>("0.0001"); ///< [m] most of u elsewhere
inline constexpr int recycling_reach_shift = 8, recycling_thin_shift = 7;
/// What follows of it: how far the separation of a corner on a face is off [m], and the face's normal [rad].
inline constexpr Length recycling_error = decimal<Length>("0.00003");
inline constexpr Unit recycling_turn = decimal<Unit>("0.00390625");

/// Whether nothing within `margin` was left out when a manifold was made.
inline bool covers(const ContactMemory& made, Length margin) { return margin <= made.margin; }
/// Most of u for the manifolds of a pair, all made at once: that of the row that bears least. `reach`: of B's points from its
/// origin; `thinnest`: the inner radius of the thinner of the two. src/solve/pairs finds u, and moves separations along.
Length recycling_limit(std::span<const ContactMemory> rows, Coordinate reach, Length thinnest);

} // namespace lockstone::solve
