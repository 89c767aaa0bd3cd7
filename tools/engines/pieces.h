// Parts that several scenes use.
#pragma once

#include "engines/scene.h"

#include <cstdint>

namespace engines {

/// A small random generator for the placement of bodies. source: Steele, Lea, Flood, SplitMix, OOPSLA 2014
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

/// A wall of boxes of 1 m. The lowest row has `base` boxes, each row one less than the row below. `at`: middle of its
/// foot.
void add_pyramid(Scene& scene, int base, V3 at, double friction = 0.6);
/// Eleven capsules: two for the trunk, one for the head, two for each arm and leg; ten ball and hinge joints. `at`: the
/// soles.
void add_ragdoll(Scene& scene, V3 at);
/// A human of make_ragdoll (lockstone/play/ragdoll.h): 14 bodies, 13 joints. `at`: the ground between the feet.
void add_human(Scene& scene, V3 at, double heading, V3 velocity = {});
/// A floor 1 m thick, whose surface is at y = 0, and walls around |x|, |z| <= half: five boxes, one body each.
void add_pit(Scene& scene, double half, double height, double friction = 0.6);
/// A sphere, a box and a capsule in turn, each about a metre large.
Shape mixed_shape(int i);
/// A floor of 100 x 100 m whose top is at the origin. Box3D, from which the bounds stem, has no planes.
Body slab();
/// The height of the hills at a place [m], at most 1.8 up or down. The second function returns a mesh of them around
/// the origin, with quads of `spacing` [m].
double hill(double x, double z);
Shape hills(int quads, double spacing);
/// A drum with eight paddles about the z axis, its middle at the origin. Its ends turn with it.
Body turning_drum(double radius, double half_depth, double spin);
/// The convex hull of `vertices` points on an ellipsoid whose axes are at most 2 `radius` long.
Shape random_hull(Random& random, int vertices, double radius);

} // namespace engines
