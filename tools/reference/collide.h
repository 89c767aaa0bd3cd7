// Collision detection by FCL, as the thesis has it: "an external library is used" (section 3.4).
#pragma once

#include "reference/start.h"

#include <memory>

namespace reference {

class Collider {
  public:
    /// Refuses by name what FCL has no shape for.
    static lockstone::Result<std::unique_ptr<Collider>>
    create(const Start& start, const lockstone::World& world, bool box_ground);
    virtual ~Collider() = default;
    /// Of all pairs that overlap and may touch, in order of bodies and shapes. `poses` are of the bodies' origins.
    virtual std::vector<Contact> contacts(std::span<const Pose> poses) = 0;
};

} // namespace reference
