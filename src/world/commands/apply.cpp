// Applies the commands that change existing bodies, shapes, filters, gravity and game columns.
#include "world/commands/applier.h"

#include "lockstone/math/decimal.h"
#include "lockstone/math/math.h"
#include "model/fields.h"
#include "model/sleep.h"
#include "solve/bodies/locks.h"

#include <algorithm>
#include <cstring>

namespace lockstone::sim {

using Applied = World::Applied;
using base::join;

// ---- waking --------------------------------------------------------------------------------------------------

std::uint32_t Applier::wake(BodyId body) {
    if (!is_awake(w, w.row_of(body))) keep_contact_points(); // waking moves rows
    return sim::wake(w, body);
}

void Applier::wake_all() {
    if (w.header().bodies_awake != w.state.count(w.m.bodies)) keep_contact_points();
    sim::wake_all(w);
}

// ---- bodies --------------------------------------------------------------------------------------------------

static Vec3 center_offset(const Model& w, std::uint32_t row, Quat rotation) {
    return rotate(rotation, w.mass_of(row).center);
}

Result<World::Applied> Applier::operator()(const SetPose& c) {
    std::uint32_t row = w.row_of(c.body);
    if (row == Model::dead) return dead_body("set_pose", c.body);
    if (std::string e = check_pose("pose", c.pose, position_max); !e.empty()) return Error{"set_pose: " + e};
    row = wake(c.body);
    const Quat rotation = normalized(c.pose.rotation);
    w.state.edit_row(w.m.body_pose, row) = {c.pose.position + center_offset(w, row, rotation), rotation};
    placed.structure_stale = true;
    return Applied{};
}

Result<World::Applied> Applier::operator()(const SetVelocity& c) {
    std::uint32_t row = w.row_of(c.body);
    if (row == Model::dead) return dead_body("set_velocity", c.body);
    if (length(c.linear) > speed_max) return Error{"set_velocity: linear must be at most 500 m/s long"};
    if (!within(c.angular, spin_max))
        return Error{"set_velocity: angular must be within 4095 rad/s on each axis"};
    row = wake(c.body);
    Velocity& velocity = w.state.edit_row(w.m.body_velocity, row);
    velocity = {to<Speed>(c.linear), to<Speed>(c.angular)};
    solve::drop_locked(velocity, w.traits_of(w.state.rows(w.m.body_info)[row]).locks);
    return Applied{};
}

Result<World::Applied> Applier::operator()(const AddForce& c) {
    std::uint32_t row = w.row_of(c.body);
    if (row == Model::dead) return dead_body("add_force", c.body);
    if (!within(c.force, force_max) || !within(c.torque, force_max))
        return Error{"add_force: force and torque must be within 2e9 on each axis"};
    row = wake(c.body);
    BodyForce& force = force_on(w, row);
    force.force += c.force;
    force.torque += c.torque;
    return Applied{};
}

Result<World::Applied> Applier::operator()(const AddForceAt& c) {
    std::uint32_t row = w.row_of(c.body);
    if (row == Model::dead) return dead_body("add_force_at", c.body);
    if (!within(c.force, force_max) || !within(c.point, position_max))
        return Error{"add_force_at: force must be within 2e9 N, point within 1e9 m on each axis"};
    row = wake(c.body);
    BodyForce& force = force_on(w, row);
    force.force += c.force;
    force.torque += cross(c.point - w.state.rows(w.m.body_pose)[row].position, c.force);
    return Applied{};
}

Result<World::Applied> Applier::operator()(const AddImpulse& c) {
    std::uint32_t row = w.row_of(c.body);
    if (row == Model::dead) return dead_body("add_impulse", c.body);
    if (!within(c.linear, force_max) || !within(c.angular, force_max))
        return Error{"add_impulse: linear and angular must be within 2e9 on each axis"};
    row = wake(c.body);
    apply_impulse(w, row, c.linear, c.angular);
    return Applied{};
}

Result<World::Applied> Applier::operator()(const AddImpulseAt& c) {
    std::uint32_t row = w.row_of(c.body);
    if (row == Model::dead) return dead_body("add_impulse_at", c.body);
    if (!within(c.impulse, force_max) || !within(c.point, position_max))
        return Error{"add_impulse_at: impulse must be within 2e9 N s, point within 1e9 m on each axis"};
    row = wake(c.body);
    apply_impulse(w, row, c.impulse, cross(c.point - w.state.rows(w.m.body_pose)[row].position, c.impulse));
    return Applied{};
}

Result<World::Applied> Applier::operator()(const WakeBody& c) {
    if (w.row_of(c.body) == Model::dead) return dead_body("wake_body", c.body);
    wake(c.body);
    return Applied{};
}

Result<World::Applied> Applier::operator()(const SetBodyParameters& c) {
    std::uint32_t row = w.row_of(c.body);
    if (row == Model::dead) return dead_body("set_body_parameters", c.body);
    if (std::string e = check_changes(c); !e.empty()) return Error{"set_body_parameters: " + e};
    BodyDef d{};
    copy_named(w.traits_of(w.state.rows(w.m.body_info)[row]), d);
    apply_changes(c, d);
    if (std::string e = check(d); !e.empty()) return Error{"set_body_parameters: " + e};
    row = wake(c.body);
    BodyTraits traits = w.traits_of(w.state.rows(w.m.body_info)[row]);
    copy_named(d, traits);
    set_traits(w, row, traits);
    solve::drop_locked(w.state.edit_row(w.m.body_velocity, row), d.locks);
    return Applied{};
}

// ---- surfaces, filters, gravity, game columns ----------------------------------------------------------------

Result<World::Applied> Applier::operator()(const SetMaterial& c) {
    const std::uint32_t row = w.row_of(c.shape);
    if (row == Model::dead) return dead_shape("set_material", c.shape);
    if (std::string e = check_changes(c); !e.empty()) return Error{"set_material: " + e};
    ShapeTraits traits = w.traits_of(w.state.rows(w.m.shape)[row]);
    ShapeDef d{};
    copy_named(traits, d);
    apply_changes(c, d);
    if (std::string e = check_ranges(d); !e.empty()) return Error{"set_material: " + e};
    wake(w.state.rows(w.m.shape)[row].body);
    copy_named(d, traits);
    set_shape_traits(w, row, traits);
    return Applied{};
}

Result<World::Applied> Applier::operator()(const SetFilter& c) {
    const std::uint32_t row = w.row_of(c.shape);
    if (row == Model::dead) return dead_shape("set_filter", c.shape);
    if (std::string e = check_changes(c); !e.empty()) return Error{"set_filter: " + e};
    wake(w.state.rows(w.m.shape)[row].body);
    ShapeTraits traits = w.traits_of(w.state.rows(w.m.shape)[row]);
    apply_changes(c, traits);
    set_shape_traits(w, row, traits);
    return Applied{};
}

Result<World::Applied> Applier::operator()(const SetPairFilter& c) {
    for (BodyId body : {c.a, c.b})
        if (w.row_of(body) == Model::dead) return dead_body("set_pair_filter", body);
    if (c.a == c.b) return Error{"set_pair_filter: a and b are the same body"};
    if (c.collide > 1) return Error{join("set_pair_filter: collide is ", c.collide, ", must be 0 or 1")};
    wake(c.a);
    wake(c.b);
    const PairFilterRow fresh{std::min(c.a, c.b), std::max(c.a, c.b)};
    const std::span<const PairFilterRow> rows = w.state.rows(w.m.pair_filter);
    const std::uint32_t count = static_cast<std::uint32_t>(rows.size());
    const auto at = std::lower_bound(rows.begin(), rows.end(), fresh);
    const std::uint32_t index = static_cast<std::uint32_t>(at - rows.begin());
    const bool is_there = at != rows.end() && *at == fresh;
    if (is_there == (c.collide == 0)) return Applied{};
    if (is_there) {
        const std::span<PairFilterRow> from = w.state.edit(w.m.pair_filter, index, count - index);
        std::copy(from.begin() + 1, from.end(), from.begin());
        w.state.resize(w.m.pair_filters, count - 1);
        return Applied{};
    }
    if (count == w.state.rows_max(w.m.pair_filters))
        return Error{join("set_pair_filter: the world is full: pair_filters_max is ", count)};
    w.state.resize(w.m.pair_filters, count + 1);
    const std::span<PairFilterRow> from = w.state.edit(w.m.pair_filter, index, count + 1 - index);
    std::copy_backward(from.begin(), from.end() - 1, from.end());
    from[0] = fresh;
    return Applied{};
}

void Applier::forget_filters_of(BodyId body) {
    const auto is_of = [body](const PairFilterRow& r) { return r.a == body || r.b == body; };
    if (std::ranges::none_of(w.state.rows(w.m.pair_filter), is_of)) return;
    const std::span<PairFilterRow> rows = w.state.edit(w.m.pair_filter);
    const auto end = std::remove_if(rows.begin(), rows.end(), is_of);
    w.state.resize(w.m.pair_filters, static_cast<std::uint32_t>(end - rows.begin()));
}

Result<World::Applied> Applier::operator()(const SetGravity& c) {
    if (!within(c.gravity, Real(1000)))
        return Error{"set_gravity: gravity must be within 1000 m/s^2 on each axis"};
    wake_all();
    w.edit_header().gravity = c.gravity;
    return Applied{};
}

Result<World::Applied> Applier::operator()(const WriteGame& c) {
    if (c.column >= w.m.game.size())
        return Error{
            join("write_game: game column ", c.column, " does not exist, the schema has ", w.m.game.size())};
    const GameSchema::Entry& entry = w.schema.entries()[c.column];
    if (c.size > c.data.size() || c.offset > entry.row_size || c.size > entry.row_size - c.offset)
        return Error{join("write_game: ", c.size, " bytes at ", c.offset, " do not fit a row of ", entry.name,
                          ", which has ", entry.row_size)};
    const std::uint32_t row = entry.per_body ? w.row_of(c.body) : 0;
    if (row == Model::dead) return dead_body("write_game", c.body);
    const std::uint32_t column = w.m.game[c.column];
    const std::span<std::byte> bytes = w.state.edit_bytes(column, row, 1);
    // Writes through the canonical form, so that a piece may end inside a field on any byte order.
    std::vector<std::byte>& canonical = canonical_row;
    canonical.clear();
    append_canonical(bytes, entry.leaves, canonical);
    std::memcpy(canonical.data() + c.offset, c.data.data(), c.size);
    read_canonical(canonical, entry.leaves, bytes);
    return Applied{};
}

namespace {

/// True for commands that change no row, pose or material of a body with a contact, except if they wake a body.
struct LeavesContactPoints {
    template <class T> bool operator()(const T&) const { return false; }
    bool operator()(const CreateBody&) const { return true; }  // only resting bodies move to other rows
    bool operator()(const CreateShape&) const { return true; } // a body without shapes has no contact
    bool operator()(const SetVelocity&) const { return true; }
    bool operator()(const AddForce&) const { return true; }
    bool operator()(const AddForceAt&) const { return true; }
    bool operator()(const AddImpulse&) const { return true; }
    bool operator()(const AddImpulseAt&) const { return true; }
    bool operator()(const SetGravity&) const { return true; }
    bool operator()(const WakeBody&) const { return true; }
    bool operator()(const SetVehicleInput&) const { return true; }
    bool operator()(const SetCharacterInput&) const { return true; }
    bool operator()(const SetField&) const { return true; }
    bool operator()(const Explode&) const { return true; }
    bool operator()(const WriteGame&) const { return true; }
};

} // namespace

Result<World::Applied> apply(Data& w, const Command& command) {
    Applier applier{w, w.placed, w.scratch, w.output.contact_points, w.canonical_row};
    if (!std::visit(LeavesContactPoints{}, command)) applier.keep_contact_points();
    Result<Applied> result = std::visit(applier, command);
    if (!result) return result;
    ++w.edit_header().commands;
    w.placed.is_current = false;
    if (w.journal != nullptr) w.journal->on_command(w.header().tick, command);
    return result;
}

} // namespace lockstone::sim
