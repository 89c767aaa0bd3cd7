#include "reference/engine/collision.h"

namespace reference::LOCKSTONE_REFERENCE_BUILD {

Collision::Collision(const Contact& contact, std::span<Rigidbody> all, const Resolver& settings)
    : bodies{&all[static_cast<std::size_t>(contact.a)], &all[static_cast<std::size_t>(contact.b)]},
      indices{contact.a, contact.b}, point(in(contact.point)), contact_normal(in(contact.normal)),
      penetration(Number(contact.depth)), friction(Number(contact.friction)),
      restitution(Number(contact.restitution)), bounce_speed_min(Number(settings.bounce_speed_min)),
      angular_limit(Number(settings.angular_limit)) {}

namespace {

/// A basis with the columns n and two tangents.
M3 basis_of(V3 n) {
    const V3 other = std::abs(n.x) > std::abs(n.y) ? V3{0, 1, 0} : V3{1, 0, 0};
    V3 t = cross(other, n);
    t *= 1 / length(t);
    return {n, t, cross(n, t)};
}

Number sign_of(std::size_t body) { return body == 0 ? Number(1) : Number(-1); }

} // namespace

void Collision::calculate_internals(Number duration) {
    contact_to_world = basis_of(contact_normal);
    for (std::size_t i = 0; i < 2; ++i) relative_contact_position[i] = point - bodies[i]->position;
    const V3 velocity = bodies[0]->velocity_at(relative_contact_position[0]) -
                        bodies[1]->velocity_at(relative_contact_position[1]);
    contact_velocity = transpose(contact_to_world) * velocity;
    calculate_desired_delta_velocity(duration);
}

/// v_d = -v_n - e (v_n - a_n h). The restitution e is "the ratio of the velocity after the contact and the initial
/// velocity" (section 2.3). The velocity that the last step's acceleration a has just added does not bounce
/// (Millington, section 15.2).
void Collision::calculate_desired_delta_velocity(Number duration) {
    const V3 from_acceleration =
        (bodies[0]->previous_acceleration - bodies[1]->previous_acceleration) * duration;
    const Number speed = contact_velocity.x;
    const Number e = std::abs(speed) < bounce_speed_min ? 0 : restitution;
    desired_delta_velocity = -speed - e * (speed - dot(from_acceleration, contact_normal));
}

/// Formula 4 and "the linear and angular change necessary to resolve the penetration" (section 4.3.2). The depth p is
/// shared among four motions, the linear and the angular one of each body, in proportion to their inverse inertia at
/// the contact: 1/m, and ((1/I (r x n)) x r) . n. If a turn exceeds the limit, the rest becomes linear motion
/// (Millington, section 14.4.3).
std::array<Change, 2> Collision::apply_position_change() {
    std::array<Number, 2> angular_inertia{};
    Number total = 0;
    for (std::size_t i = 0; i < 2; ++i) {
        const V3 r = relative_contact_position[i];
        const V3 turned = bodies[i]->inverse_world_inertia * cross(r, contact_normal);
        angular_inertia[i] = dot(cross(turned, r), contact_normal);
        total += angular_inertia[i] + bodies[i]->inverse_mass;
    }
    std::array<Change, 2> changes{};
    if (!(total > 0)) return changes;
    for (std::size_t i = 0; i < 2; ++i) {
        Rigidbody& body = *bodies[i];
        if (!body.is_movable()) continue;
        const V3 r = relative_contact_position[i];
        const Number share = sign_of(i) * penetration / total;
        Number angular = share * angular_inertia[i], linear = share * body.inverse_mass;
        const Number most = angular_limit * length(r - contact_normal * dot(r, contact_normal));
        const Number both = angular + linear;
        angular = std::abs(angular) > most ? (angular < 0 ? -most : most) : angular;
        linear = both - angular;
        if (angular_inertia[i] > 0)
            changes[i].angular =
                body.inverse_world_inertia * cross(r, contact_normal) * (angular / angular_inertia[i]);
        changes[i].linear = contact_normal * linear;
        body.position += changes[i].linear;
        body.orientation = body.orientation + rate_of(body.orientation, changes[i].angular);
        body.update_derived();
    }
    return changes;
}

/// The matrix that turns an impulse into the change of velocity at the contact, both in the contact's axes: sum over
/// the bodies of 1/m - r~ 1/I r~, where r~ b = r x b. Its first entry is v_i of formula 6, which listing 5 sums up.
M3 Collision::velocity_per_impulse() const {
    M3 world{};
    Number inverse_mass = 0;
    for (std::size_t i = 0; i < 2; ++i) {
        const M3 r = skew(relative_contact_position[i]);
        world = world + r * (bodies[i]->inverse_world_inertia * transpose(r));
        inverse_mass += bodies[i]->inverse_mass;
    }
    return transpose(contact_to_world) * world * contact_to_world +
           diagonal({inverse_mass, inverse_mass, inverse_mass});
}

/// Listing 5: i = v_d / v_i (formula 6), along n only.
V3 Collision::frictionless_impulse() const {
    Number delta_velocity = 0;
    for (std::size_t i = 0; i < 2; ++i) {
        const V3 r = relative_contact_position[i];
        const V3 turned = bodies[i]->inverse_world_inertia * cross(r, contact_normal);
        delta_velocity += dot(cross(turned, r), contact_normal) + bodies[i]->inverse_mass;
    }
    return {desired_delta_velocity / delta_velocity, 0, 0};
}

/// "If friction was taken into account the resulting impulse could be in a different direction" (section 4.3.2): the
/// impulse that also stops the sliding. If it lies outside of Coulomb's cone, the result lies on the edge of the cone,
/// against the sliding velocity s that exists or that the impulse along n would cause. Millington, section 15.3, uses
/// the edge in the direction of the stopping impulse, which loses 15 % of the friction at the corners of a box.
V3 Collision::friction_impulse() const {
    const M3 m = velocity_per_impulse();
    const V3 impulse = solve(m, {desired_delta_velocity, -contact_velocity.y, -contact_velocity.z});
    const Number planar = std::sqrt(impulse.y * impulse.y + impulse.z * impulse.z);
    const V3 s = contact_velocity + m.x * (desired_delta_velocity / m.x.x);
    const Number sliding = std::sqrt(s.y * s.y + s.z * s.z);
    if (!(planar > impulse.x * friction) || !(sliding > 0)) return impulse;
    const Number y = -s.y / sliding, z = -s.z / sliding;
    const Number along = desired_delta_velocity / (m.x.x + friction * (m.y.x * y + m.z.x * z));
    return {along, y * friction * along, z * friction * along};
}

/// Listing 6: i = m dv (formula 5) and 1/I (r x i); the second body gets the opposite impulse.
std::array<Change, 2> Collision::apply_velocity_change() {
    std::array<Change, 2> changes{};
    if (!bodies[0]->is_movable() && !bodies[1]->is_movable()) return changes;
    const V3 impulse = contact_to_world * (friction > 0 ? friction_impulse() : frictionless_impulse());
    for (std::size_t i = 0; i < 2; ++i) {
        const V3 on_body = impulse * sign_of(i);
        changes[i] = {on_body * bodies[i]->inverse_mass,
                      bodies[i]->inverse_world_inertia * cross(relative_contact_position[i], on_body)};
        bodies[i]->velocity += changes[i].linear;
        bodies[i]->rotation += changes[i].angular;
    }
    return changes;
}

} // namespace reference::LOCKSTONE_REFERENCE_BUILD
