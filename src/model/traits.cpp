// Traits of bodies and shapes, and forces on bodies: rows of tables of their own.
#include "lockstone/math/math.h"
#include "model/model.h"
#include "solve/bodies/locks.h"

namespace lockstone::sim {

void set_traits(Model& w, std::uint32_t body_row, const BodyTraits& traits) {
    std::uint32_t free = w.header().body_traits_free;
    const std::uint32_t now = w.state.rows(w.m.body_info)[body_row].traits;
    const std::uint32_t row = exchange_shared(w.state, w.m.body_traits, now, traits, free);
    w.state.edit_row(w.m.body_info, body_row).traits = row;
    w.edit_header().body_traits_free = free;
}

void set_shape_traits(Model& w, std::uint32_t shape_row, const ShapeTraits& traits) {
    std::uint32_t free = w.header().shape_traits_free;
    const std::uint32_t now = w.state.rows(w.m.shape)[shape_row].traits;
    const std::uint32_t row = exchange_shared(w.state, w.m.shape_traits, now, traits, free);
    w.state.edit_row(w.m.shape, shape_row).traits = row;
    w.edit_header().shape_traits_free = free;
}

BodyForce& force_on(Model& w, std::uint32_t body_row) {
    const std::uint32_t push = w.state.rows(w.m.body_push)[body_row], count = w.state.count(w.m.forces);
    if (push != 0 && push <= count) return w.state.edit_row(w.m.force, push - 1);
    const std::uint32_t row = count; // below bodies_max, as this body has no force row yet
    w.state.resize(w.m.forces, row + 1);
    w.state.edit_row(w.m.body_push, body_row) = row + 1;
    w.state.edit_row(w.m.pushed, row) = w.state.rows(w.m.body_info)[body_row].id.index;
    return w.state.edit_row(w.m.force, row);
}

void forget_force(Model& w, std::uint32_t body_row) {
    const std::uint32_t push = w.state.rows(w.m.body_push)[body_row];
    if (push == 0 || push > w.state.count(w.m.forces)) return;
    const std::uint32_t last = w.state.count(w.m.forces) - 1;
    if (push - 1 != last) {
        const std::uint32_t moved = w.state.rows(w.m.pushed)[last];
        w.state.edit_row(w.m.force, push - 1) = w.state.rows(w.m.force)[last];
        w.state.edit_row(w.m.pushed, push - 1) = moved;
        w.state.edit_row(w.m.body_push, w.state.rows(w.m.body_slot)[moved - 1].row) = push;
    }
    w.state.edit_row(w.m.body_push, body_row) = 0;
    w.state.resize(w.m.forces, last);
}

void forget_forces(Model& w) {
    const std::span<const Slot> slots = w.state.rows(w.m.body_slot);
    for (const std::uint32_t slot : w.state.rows(w.m.pushed))
        if (slot != 0 && slot <= slots.size() && slots[slot - 1].is_alive())
            w.state.edit_row(w.m.body_push, slots[slot - 1].row) = 0;
    w.state.resize(w.m.forces, 0);
}

void apply_impulse(Model& w, std::uint32_t row, Vec3 linear, Vec3 angular) {
    const BodyMass& mass = w.mass_of(row);
    if (mass.mass == Real{}) return;
    const std::uint32_t locks = w.traits_of(w.state.rows(w.m.body_info)[row]).locks;
    Velocity& velocity = w.state.edit_row(w.m.body_velocity, row);
    const Rotation axes = to_rotation(w.state.rows(w.m.body_pose)[row].rotation * mass.principal);
    const Vec3 local = mul_transposed<Real>(axes, angular / mass.mass);
    const auto turned = [](Real l, Real k) { return l / k / k; };
    const Vec3 spin =
        lockstone::mul<Real>(axes, Vec3{turned(local.x, mass.gyration.x), turned(local.y, mass.gyration.y),
                                        turned(local.z, mass.gyration.z)});
    const Vec3 dv = linear / mass.mass;
    for (int i = 0; i < 3; ++i) {
        if (!((locks >> i) & 1u)) velocity.linear[i] = velocity.linear[i] + to<Speed>(dv[i]);
        if (!((locks >> (3 + i)) & 1u)) velocity.angular[i] = velocity.angular[i] + to<Speed>(spin[i]);
    }
}

void set_mass(Model& w, std::uint32_t row, const BodyMass& fresh) {
    BodyTraits traits = w.traits_of(w.state.rows(w.m.body_info)[row]);
    const Vec3 moved = fresh.center - traits.mass.center;
    traits.mass = fresh;
    set_traits(w, row, traits);
    if (moved == Vec3{}) return;
    Transform& pose = w.state.edit_row(w.m.body_pose, row);
    Velocity& velocity = w.state.edit_row(w.m.body_velocity, row);
    const Vec3 arm = rotate(pose.rotation, moved);
    pose.position += arm;
    velocity.linear += cross<Speed>(velocity.angular, arm);
    solve::drop_locked(velocity, traits.locks);
}

} // namespace lockstone::sim
