// Values at and between the limits of a range, and definitions with such values.
#pragma once

#include "lockstone/math/math.h"
#include "lockstone/math/random.h"
#include "lockstone/world.h"

#include <vector>

namespace attack {

using namespace lockstone;

/// The source of a world's values. Each draw is a statement of its own, because the evaluation order of a call's
/// arguments is unspecified.
class Values {
  public:
    explicit Values(std::uint64_t seed) : random(Random::seeded(seed)) {}

    bool chance(std::uint32_t of) { return random.below(of) == 0; }
    std::uint32_t below(std::uint32_t n) { return random.below(n); }
    std::uint32_t bits() { return random.next_u32(); }
    std::uint64_t key() { return random.next_u64(); }
    /// How often a field differs from its usual value. Some worlds have few unusual fields, some only extreme values.
    void set_wildness(std::uint32_t of_eight) { wildness = of_eight; }
    std::uint32_t integer(std::uint32_t low, std::uint32_t high, std::uint32_t usual);
    /// The usual value, a limit, a value one step inside, or a value in between, uniform or by powers of two.
    Real between(Real low, Real high, Real usual);
    /// A uniform value between the two.
    Real range(Real low, Real high) { return random.range(low, high); }
    Vec3 each_within(Real most, Vec3 usual = {});
    /// A vector of at most this length.
    Vec3 as_long_as(Real most);
    Quat turn();
    UnitVec3 direction();
    Transform near(Vec3 center, Real reach);

  private:
    Random random;
    std::uint32_t wildness = 4;
};

WorldDef world_def(Values& v);
BodyDef body_def(Values& v, const Transform& pose);
/// A shape of any kind that a body of `kind` may have; assets are those of `assets_at_limits`.
Geometry geometry(Values& v, BodyKind kind, const AssetLibrary& assets);
ShapeDef shape_def(Values& v, BodyKind kind, const AssetLibrary& assets);
JointDef joint_def(Values& v);
VehicleDef vehicle_def(Values& v, BodyId chassis);
VehicleInput vehicle_input(Values& v);
CharacterDef character_def(Values& v, Vec3 at);
FieldDef field_def(Values& v, Vec3 at);
ExplosionDef explosion_def(Values& v, Vec3 at);

/// The smallest and the largest asset of each kind.
AssetLibrary assets_at_limits();

} // namespace attack
