#include "reference/engine/rigid_body.h"

namespace reference::LOCKSTONE_REFERENCE_BUILD {

Rigidbody::Rigidbody(const BodyStart& start)
    : inverse_mass(Number(start.mass_inv)), inverse_inertia(in(start.inertia_inv)),
      principal(in(start.principal)), linear_damping(Number(start.linear_damping)),
      angular_damping(Number(start.angular_damping)), gravity_scale(Number(start.gravity_scale)),
      in_fields(start.in_fields), position(in(start.position)), orientation(in(start.orientation)),
      velocity(in(start.velocity)), rotation(in(start.rotation)) {
    update_derived();
}

void Rigidbody::add_force_at_point(V3 force, V3 point) {
    force_accum += force;
    torque_accum += cross(point - position, force);
}

void Rigidbody::update_derived() {
    orientation = normalize(orientation);
    const M3 axes = matrix_of(orientation * principal);
    inverse_world_inertia = axes * diagonal(inverse_inertia) * transpose(axes);
}

namespace {

V3 pull_of(const Pull& field, V3 place) {
    if (field.kind == Attraction::uniform) return field.acceleration;
    const V3 towards = field.center - place;
    if (field.kind == Attraction::spring) return towards * field.strength;
    const Number square = dot(towards, towards) + field.softening * field.softening;
    if (!(square > 0)) return {};
    const Number distance = length(towards);
    return distance > 0 ? towards * (field.strength / (square * distance)) : V3{};
}

} // namespace

V3 Rigidbody::acceleration_at(V3 place, const Forces& forces) const {
    V3 a = forces.gravity * gravity_scale + force_accum * inverse_mass;
    if (in_fields)
        for (const Pull& field : forces.fields) a += pull_of(field, place);
    return a;
}

V3 Rigidbody::angular_acceleration_at(Q4 turn, V3 spin, const Forces& forces) const {
    const M3 axes = matrix_of(turn * principal);
    V3 torque = transpose(axes) * torque_accum;
    if (forces.gyroscopic && inverse_inertia.x > 0 && inverse_inertia.y > 0 && inverse_inertia.z > 0) {
        const V3 w = transpose(axes) * spin;
        const V3 momentum{w.x / inverse_inertia.x, w.y / inverse_inertia.y, w.z / inverse_inertia.z};
        torque -= cross(w, momentum);
    }
    return axes * (diagonal(inverse_inertia) * torque);
}

} // namespace reference::LOCKSTONE_REFERENCE_BUILD
