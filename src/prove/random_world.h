#pragma once

#include "lockstone/math/random.h"
#include "lockstone/world.h"

#include <optional>
#include <vector>

namespace lockstone::proofs {

/// A small world and the commands before each of its ticks, both generated from a seed: primitives of every kind,
/// joints, fields, a kinematic body, axis locks, bodies that sleep.
class RandomWorld {
  public:
    /// Returns the error of the first command that the world refuses; there is none if the library is compiled
    /// correctly.
    static Result<RandomWorld> make(std::uint64_t seed);
    /// Returns to the first tick; step() then repeats the same commands.
    void rewind();
    /// Applies a few commands, then runs a tick. Returns the error of the first command that the world refuses.
    Status step();

    World world;

  private:
    RandomWorld(World made, Random draws) : world(std::move(made)), random(draws) {}

    Real between(Real low, Real high) { return random.range(low, high); }
    bool one_of(std::uint32_t count) { return random.below(count) == 0; }
    Vec3 within(Real most);
    Quat turn();
    BodyId any_body() { return bodies[random.below(static_cast<std::uint32_t>(bodies.size()))]; }
    template <class T> T taken(Result<T> result);
    void taken(const Status& status);

    void add_scenery(std::uint64_t seed);
    void add_fields(std::uint64_t seed);
    void add_bodies(std::uint64_t seed);
    void add_joints(std::uint64_t seed);
    void add_body(const Transform& pose);
    void add_shapes(BodyId body);
    ShapeDef shape();
    void join(JointDef def, BodyId a, BodyId b);
    void command();

    Random random;
    std::vector<BodyId> bodies;   ///< the dynamic bodies
    std::optional<Error> refusal; ///< the error of the first command that the world refused
    struct {
        Image image;
        Random random;
        std::vector<BodyId> bodies;
    } start; ///< data from before the first tick
};

} // namespace lockstone::proofs
