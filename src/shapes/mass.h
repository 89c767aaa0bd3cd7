// Masses of primitives. mass_rounded.cpp has those of rounded primitives.
#pragma once

#include "lockstone/shape.h"
#include "shapes/scaled.h"

namespace lockstone::shapes {

inline constexpr Scaled scaled_pi = scaled(decimal<I4F60>("3.14159265358979323846264338327950288"));

/// mass_properties of a geometry that is known to be valid.
MassProperties mass_of_primitive(const Geometry& geometry, Real density);

/// These ignore `scale`. All moments are closed forms in 62 significant bits; the cone's angle has 32 fraction
/// bits.
MassProperties rounded_box_mass(const LengthVec3& half_extent, Length radius, Real density);
MassProperties rounded_cylinder_mass(Length core_radius, Length half_height, Length radius, Real density);
MassProperties rounded_cone_mass(Length base_radius, Length half_height, Length radius, Real density);

} // namespace lockstone::shapes
