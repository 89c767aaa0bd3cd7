// Collision detection by FCL, as in the thesis: "an external library is used" (section 3.4).
#pragma once

#include "reference/start.h"

#include <memory>

namespace reference {

class Collider {
  public:
    /// Returns an error that names a shape which FCL does not have.
    static lockstone::Result<std::unique_ptr<Collider>>
    create(const Start& start, const lockstone::World& world, bool box_ground);
    virtual ~Collider() = default;
    /// The contacts of all pairs that overlap and may touch, in the order of bodies and shapes. `poses`: of the bodies'
    /// origins, one for each body.
    virtual std::vector<Contact> contacts(std::span<const Pose> poses) = 0;
};

} // namespace reference
