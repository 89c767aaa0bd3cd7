// Where shapes are: world poses, how far ahead their contacts reach, their bounds in the broad phase.
#include "sim/phases.h"

#include "base/assert.h"
#include "lockstone/math.h"

#include <algorithm>

namespace lockstone::sim {

namespace {

Transform shape_pose(const ShapeRow& shape, const Transform& body, const BodyMass& mass) {
    return {body.position + rotate(body.rotation, shape.local.position - mass.center),
            normalized(body.rotation * shape.local.rotation)};
}

/// Contacts of a fast body are found before it arrives, as far ahead as its own size, so it lands on surfaces.
Length margin_of(const shapes::Solid& solid, const Velocity& velocity, std::uint32_t tick_rate) {
    const Speed speed = length(velocity.linear);
    const Length ahead = to<Length>(
        Real::from_raw(divide_shifted(speed.raw, tick_rate, Real::fraction_bits - Speed::fraction_bits)));
    return margin_base + min(ahead, shapes::inner_radius(solid));
}

/// How far any of its points is from its origin [m]; zero for a plane.
Coordinate reach_of(const shapes::Solid& solid) {
    if (solid.geometry.kind == ShapeKind::plane) return Coordinate{};
    const shapes::Extent e = shapes::extent_of(solid);
    return length(max(abs(e.lower), abs(e.upper)));
}

void set_proxy(Data& w, const ShapeRow& shape, std::uint32_t body_row) {
    Scratch& s = w.scratch;
    const std::uint32_t slot = shape.id.index - 1;
    const BodyKind kind = w.state.rows(w.m.body_info)[body_row].kind;
    const Config& config = w.state.rows(w.m.config)[0];
    const shapes::Solid& solid = solid_of(w, shape);
    Scratch::Shape& at = s.shape[slot];
    at.pose = shape_pose(shape, w.state.rows(w.m.body_pose)[body_row], w.state.rows(w.m.body_mass)[body_row]);
    at.margin = kind == BodyKind::static_
                    ? margin_base
                    : margin_of(solid, w.state.rows(w.m.body_velocity)[body_row], config.tick_rate);
    if (shape.geometry.kind == ShapeKind::plane) {
        // Before a restore this slot and generation may have held a shape with bounds.
        if (s.proxy_generation[slot] != 0) s.broad_phase.remove(slot);
        s.proxy_generation[slot] = 0;
        return;
    }
    s.broad_phase.set(slot,
                      collide::bounds_of(solid, at.pose, at.margin, static_cast<int>(config.bounds_shift)),
                      kind == BodyKind::static_);
    s.proxy_generation[slot] = shape.id.generation;
}

void drop_dead_proxies(Data& w) {
    Scratch& s = w.scratch;
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    for (std::uint32_t slot = 0; slot < s.proxy_generation.size(); ++slot) {
        if (s.proxy_generation[slot] == 0) continue;
        if (slot < slots.size() && slots[slot].alive != 0 &&
            slots[slot].generation == s.proxy_generation[slot])
            continue;
        s.broad_phase.remove(slot);
        s.proxy_generation[slot] = 0;
    }
    s.planes.clear();
    for (std::uint32_t slot = 0; slot < slots.size(); ++slot)
        if (slots[slot].alive != 0 &&
            w.state.rows(w.m.shape)[slots[slot].row].geometry.kind == ShapeKind::plane)
            s.planes.push_back(slot);
}

} // namespace

const shapes::Solid& solid_of(Data& w, const ShapeRow& shape) {
    Scratch::Shape& at = w.scratch.shape[shape.id.index - 1];
    if (at.solid.geometry == shape.geometry) return at.solid;
    Result<shapes::Solid> solid = w.scratch.solids.resolve(shape.geometry);
    LOCKSTONE_ASSERT(solid.ok(), "shape ", shape.id.index, ": ", solid.ok() ? "" : solid.error().message);
    at.solid = *solid;
    at.reach = reach_of(at.solid);
    return at.solid;
}

void update_bounds(Data& w) {
    Scratch& s = w.scratch;
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    if (s.structure_stale) drop_dead_proxies(w);
    for (const ShapeRow& shape : w.state.rows(w.m.shape)) {
        const std::uint32_t row = w.row_of(shape.body);
        if (info[row].kind == BodyKind::static_ && !s.structure_stale) continue;
        set_proxy(w, shape, row);
    }
    s.structure_stale = false;
}

} // namespace lockstone::sim
