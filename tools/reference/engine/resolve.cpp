#include "reference/engine/resolve.h"

namespace reference::LOCKSTONE_REFERENCE_BUILD {
namespace {

/// Listing 8: the first of the greatest values; null if none is above epsilon.
Collision* worst(std::span<Collision> collisions, Number Collision::*measure, Number epsilon) {
    Collision* found = nullptr;
    for (Collision& collision : collisions)
        if (found == nullptr || collision.*measure > found->*measure) found = &collision;
    return found != nullptr && found->*measure < epsilon ? nullptr : found;
}

/// The search of listing 7: calls visit(secondary, index of its body, change) for each contact of a body that the
/// change moved.
template <class Visit>
void for_each_affected(std::span<Collision> collisions, const Collision& primary,
                       const std::array<Change, 2>& changes, Visit visit) {
    for (Collision& secondary : collisions)
        for (std::size_t mine = 0; mine < 2; ++mine)
            for (std::size_t theirs = 0; theirs < 2; ++theirs)
                if (primary.bodies[mine] == secondary.bodies[theirs]) visit(secondary, theirs, changes[mine]);
}

/// The motion of one body's contact point by a change, with the sign of that body in the contact.
V3 at_contact(const Collision& collision, std::size_t body, const Change& change) {
    const V3 moved = change.linear + cross(change.angular, collision.relative_contact_position[body]);
    return body == 0 ? moved : -moved;
}

/// Returns true once the deepest penetration is below epsilon.
bool adjust_positions(std::span<Collision> collisions, const Resolver& settings, std::vector<Resolved>& log) {
    Collision* primary = worst(collisions, &Collision::penetration, Number(settings.position_epsilon));
    if (primary == nullptr) return true;
    log.push_back({false, static_cast<int>(primary - collisions.data()), double(primary->penetration)});
    const std::array<Change, 2> changes = primary->apply_position_change();
    for_each_affected(collisions, *primary, changes,
                      [](Collision& c, std::size_t body, const Change& change) {
                          c.penetration -= dot(at_contact(c, body, change), c.contact_normal);
                      });
    return false;
}

/// Listings 7 and 8. Returns true once every desired change of velocity is below epsilon.
bool adjust_velocities(std::span<Collision> collisions, const Resolver& settings, Number duration,
                       std::vector<Resolved>& log) {
    Collision* primary =
        worst(collisions, &Collision::desired_delta_velocity, Number(settings.velocity_epsilon));
    if (primary == nullptr) return true;
    log.push_back(
        {true, static_cast<int>(primary - collisions.data()), double(primary->desired_delta_velocity)});
    const std::array<Change, 2> changes = primary->apply_velocity_change();
    for_each_affected(collisions, *primary, changes,
                      [&](Collision& c, std::size_t body, const Change& change) {
                          c.contact_velocity += transpose(c.contact_to_world) * at_contact(c, body, change);
                          c.calculate_desired_delta_velocity(duration);
                      });
    return false;
}

} // namespace

/// Listing 9.
void resolve(std::span<Collision> collisions, const Resolver& settings, Number duration,
             std::vector<Resolved>& log) {
    if (collisions.empty()) return;
    for (Collision& collision : collisions) collision.calculate_internals(duration);
    for (int i = 0; i < settings.position_iterations; ++i)
        if (adjust_positions(collisions, settings, log)) break;
    for (int i = 0; i < settings.velocity_iterations; ++i)
        if (adjust_velocities(collisions, settings, duration, log)) break;
}

} // namespace reference::LOCKSTONE_REFERENCE_BUILD
