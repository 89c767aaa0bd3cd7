// Converts definitions of bodies and shapes to rows of the state, and back. copy_named() copies the fields that both
// have by name; the code here handles the other fields.
#include "lockstone/math/math.h"
#include "model/fields.h"
#include "model/model.h"
#include "model/sleep.h"
#include "solve/bodies/locks.h"

namespace lockstone::sim {

void write_body(Model& w, std::uint32_t row, BodyId id, const BodyDef& d) {
    BodyInfo info{};
    copy_named(d, info);
    info.id = id;
    BodyTraits traits{};
    copy_named(d, traits);
    traits.mass_override = d.mass;
    traits.mass.principal = Quat::identity();
    std::uint32_t free = w.header().body_traits_free;
    info.traits = take_shared(w.state, w.m.body_traits, traits, free);
    w.edit_header().body_traits_free = free;
    w.state.edit_row(w.m.body_info, row) = info;
    w.state.edit_row(w.m.body_pose, row) = {d.pose.position, normalized(d.pose.rotation)};
    Velocity velocity{to<Speed>(d.linear_velocity), to<Speed>(d.angular_velocity)};
    solve::drop_locked(velocity, d.locks);
    w.state.edit_row(w.m.body_velocity, row) = velocity;
}

BodyDef body_def(const Model& w, std::uint32_t row) {
    const BodyInfo& info = w.state.rows(w.m.body_info)[row];
    const BodyTraits& traits = w.traits_of(info);
    const Velocity& velocity = w.state.rows(w.m.body_velocity)[row];
    BodyDef d;
    copy_named(info, d);
    copy_named(traits, d);
    d.mass = traits.mass_override;
    d.pose = body_origin(w, row);
    d.linear_velocity = to<Real>(velocity.linear);
    d.angular_velocity = to<Real>(velocity.angular);
    d.awake = d.kind != BodyKind::dynamic || is_awake(w, row) ? 1 : 0;
    return d;
}

Transform body_origin(const Model& w, std::uint32_t row) {
    const Transform& pose = w.state.rows(w.m.body_pose)[row];
    const Vec3 center = w.mass_of(row).center;
    if (center == Vec3{}) return pose; // games read many poses in a tick
    return {pose.position - rotate(pose.rotation, center), pose.rotation};
}

ShapeTraits traits_of(const ShapeDef& d) {
    ShapeTraits traits{};
    copy_named(d, traits);
    traits.local.rotation = normalized(d.local.rotation);
    return traits;
}

ShapeDef shape_def(const Model& w, std::uint32_t row) {
    const ShapeRow& shape = w.state.rows(w.m.shape)[row];
    ShapeDef d;
    copy_named(shape, d);
    copy_named(w.traits_of(shape), d);
    return d;
}

} // namespace lockstone::sim
