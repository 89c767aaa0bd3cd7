// Where shapes are: world poses, how far ahead their contacts reach, their bounds in the broad phase.
#include "sim/phases.h"
#include "sim/sleep.h"

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

/// Where a shape is whose solid is known. Writes nothing but `at`.
void place(const Data& w, const ShapeRow& shape, std::uint32_t body_row, Scratch::Shape& at) {
    const Config& config = w.state.rows(w.m.config)[0];
    at.pose = shape_pose(shape, w.state.rows(w.m.body_pose)[body_row], w.state.rows(w.m.body_mass)[body_row]);
    at.margin = w.state.rows(w.m.body_info)[body_row].kind == BodyKind::static_
                    ? margin_base
                    : margin_of(at.solid, w.state.rows(w.m.body_velocity)[body_row], config.tick_rate);
    if (shape.geometry.kind != ShapeKind::plane)
        at.bounds = collide::bounds_of(at.solid, at.pose, at.margin, static_cast<int>(config.bounds_shift));
}

/// Tells the broad phase. Shapes of what rests lie in its still tree; no two of them meet.
void hand_over(Data& w, const ShapeRow& shape, std::uint32_t body_row) {
    Scratch& s = w.scratch;
    const std::uint32_t slot = shape.id.index - 1;
    Scratch::Shape& at = s.shape[slot];
    at.rests = false;
    if (shape.geometry.kind == ShapeKind::plane) {
        // Before a restore this slot and generation may have held a shape with bounds.
        if (s.proxy_generation[slot] != 0) s.broad_phase.remove(slot);
        s.proxy_generation[slot] = 0;
        return;
    }
    const bool rests = !is_awake(w, body_row);
    s.broad_phase.set(slot, at.bounds, rests);
    s.proxy_generation[slot] = shape.id.generation;
    if (!rests) return;
    at.resting_local = shape.local;
    at.resting_at = w.state.rows(w.m.body_pose)[body_row];
    at.resting_center = w.state.rows(w.m.body_mass)[body_row].center;
    at.rests = true;
}

void set_proxy(Data& w, const ShapeRow& shape, std::uint32_t body_row) {
    solid_of(w, shape);
    place(w, shape, body_row, w.scratch.shape[shape.id.index - 1]);
    hand_over(w, shape, body_row);
}

/// As set_proxy, when the shape has not lain there since before.
void set_resting_proxy(Data& w, const ShapeRow& shape, std::uint32_t body_row) {
    const Scratch::Shape& at = w.scratch.shape[shape.id.index - 1];
    const bool is_there = at.rests && w.scratch.proxy_generation[shape.id.index - 1] == shape.id.generation &&
                          at.solid.geometry == shape.geometry && at.resting_local == shape.local &&
                          at.resting_at == w.state.rows(w.m.body_pose)[body_row] &&
                          at.resting_center == w.state.rows(w.m.body_mass)[body_row].center;
    if (!is_there) set_proxy(w, shape, body_row);
}

template <class Visit> void for_each_shape(const Data& w, std::uint32_t body_row, Visit&& visit) {
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    for (std::uint32_t slot = w.state.rows(w.m.body_info)[body_row].first_shape; slot != 0;) {
        const ShapeRow& shape = shapes[slots[slot - 1].row];
        slot = shape.next_shape;
        visit(shape);
    }
}

constexpr std::uint32_t bodies_per_chunk = 32;

/// Where the shapes of the awake bodies are, by workers; then the broad phase hears of it, by one and in order. A solid that
/// is not known is found then too: finding one changes what all share.
void update_awake(Data& w) {
    const std::uint32_t awake = w.header().bodies_awake;
    const Data& seen = w;
    base::for_chunks(w.tasks, awake, bodies_per_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t row = first; row < last; ++row)
                             for_each_shape(seen, row, [&](const ShapeRow& shape) {
                                 Scratch::Shape& at = w.scratch.shape[shape.id.index - 1];
                                 at.is_placed = at.solid.geometry == shape.geometry;
                                 if (at.is_placed) place(seen, shape, row, at);
                             });
                     });
    for (std::uint32_t row = 0; row < awake; ++row)
        for_each_shape(w, row, [&](const ShapeRow& shape) {
            if (w.scratch.shape[shape.id.index - 1].is_placed)
                hand_over(w, shape, row);
            else
                set_proxy(w, shape, row);
        });
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
    if (s.structure_stale) {
        drop_dead_proxies(w);
        for (std::uint32_t row = w.header().bodies_awake; row < w.state.count(w.m.bodies); ++row)
            for_each_shape(w, row, [&](const ShapeRow& shape) { set_resting_proxy(w, shape, row); });
        s.structure_stale = false;
    }
    update_awake(w);
}

} // namespace lockstone::sim
