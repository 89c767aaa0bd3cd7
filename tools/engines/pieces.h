// Pieces that several scenes have.
#pragma once

#include "engines/scene.h"

#include <cstdint>

namespace engines {

/// A small generator for placing things. source: Steele, Lea, Flood, SplitMix, OOPSLA 2014
class Random {
  public:
    explicit Random(std::uint64_t seed) : state(seed) {}
    double between(double low, double high) {
        state += 0x9e3779b97f4a7c15u;
        std::uint64_t z = state;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        z ^= z >> 31;
        return low + (high - low) * static_cast<double>(z >> 11) * 0x1p-53;
    }
    Turn turn() {
        const V3 axis{between(-1, 1), between(-1, 1), between(-1, 1)};
        const double size = length(axis);
        return size < 0.1 ? Turn{} : about(axis / size, between(0, pi));
    }

  private:
    std::uint64_t state;
};

/// A wall of boxes of 1 m, as many in the lowest row as `base`, each row one less; its foot's middle is at `at`.
void add_pyramid(Scene& scene, int base, V3 at, double friction = 0.6);
/// Eleven capsules: trunk of two, head, arms and legs of two each; ten ball and hinge joints. Its soles are at `at`.
void add_ragdoll(Scene& scene, V3 at);
/// A human of make_ragdoll (lockstone/play/ragdoll.h): 14 bodies, 13 joints. It stands with the ground between its feet at `at`.
void add_human(Scene& scene, V3 at, double heading, V3 velocity = {});
/// A floor of 1 m thickness, its surface at y = 0, and walls around |x|, |z| <= half: boxes, five bodies.
void add_pit(Scene& scene, double half, double height, double friction = 0.6);
/// By turns a sphere, a box and a capsule, each about a metre.
Shape mixed_shape(int i);
/// A floor of 100 x 100 m whose top is at the origin: Box3D, which bounds stem from, has no planes.
Body slab();
/// Height of hills at a place [m], within 1.8; and a mesh of them, quads of `spacing` [m], its middle at the origin.
double hill(double x, double z);
Shape hills(int quads, double spacing);
/// A drum about the z axis with eight paddles, its middle at the origin. Its ends turn with it.
Body turning_drum(double radius, double half_depth, double spin);
/// The convex hull of so many points on an ellipsoid, none of its axes longer than 2 `radius`.
Shape random_hull(Random& random, int vertices, double radius);

} // namespace engines
