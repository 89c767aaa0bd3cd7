// Small worlds for the thesis' engine, and settings without tolerances.
#pragma once

#include "reference/reference.h"
#include "reference/start.h"

#include "lockstone/math/convert.h"

#include <cmath>
#include <memory>

namespace reference_tests {

using namespace lockstone;

/// A world to which the test adds bodies. An error ends the test.
struct Stage {
    explicit Stage(const WorldDef& def = {}, std::shared_ptr<const AssetLibrary> assets = {})
        : world(World::create(def, {}, std::move(assets)).value()) {}
    BodyId add(const BodyDef& body, const ShapeDef& shape) {
        const BodyId id = world.create_body(body).value();
        world.create_shape(id, shape).value();
        return id;
    }
    BodyId ground(const ShapeDef& surface = {}) {
        ShapeDef shape = surface;
        shape.geometry = plane();
        return add({.kind = BodyKind::static_}, shape);
    }
    World world;
};

inline WorldDef weightless() { return {.gravity = {}, .sleeping = 0}; }
inline Transform at(Real x, Real y, Real z) { return {{x, y, z}, Quat::identity()}; }

/// One step per tick, epsilons of zero, and a bounce for every impact.
inline reference::Settings strict() {
    return {.substeps = 1, .position_epsilon = 0, .velocity_epsilon = 0, .bounce_speed_min = 0};
}

inline double length(const reference::Vec& v) { return std::sqrt(reference::dot(v, v)); }

} // namespace reference_tests
