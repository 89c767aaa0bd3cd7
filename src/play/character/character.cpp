// One tick of the mover: first the effects of the ground and of other bodies on a character, then its own motion.
// Both use the predicted poses at the end of the tick. At the end the mover converts the change of position to a
// velocity.
//
// source: collide and slide as in Fauerby, Improved Collision Detection and Response, 2003; the steps of walking as
// users know them from the character controllers of today's engines.
#include "play/character/character_mover.h"

#include "lockstone/math/math.h"
#include "model/sleep.h"

#include <algorithm>

namespace lockstone::sim {

Mover::Mover(Model& model, PlacedShapes& shapes, CharacterScratch& memory, std::uint32_t character_row)
    : w(model), placed(shapes), scratch(memory), row(w.state.rows(w.m.character)[character_row]),
      index(character_row), up(row.def.up), slope_cos(to<Unit>(cos(row.def.slope_max))),
      rate(w.config().tick_rate), space(w, placed, scratch, row) {
    const std::uint32_t body = w.row_of(row.body);
    const Transform& pose = w.state.rows(w.m.body_pose)[body];
    begin = feet = pose.position - rotate(pose.rotation, w.mass_of(body).center);
    stood_on = ground_body();
    was_in_air = row.state.ground != CharacterGround::walkable && row.state.air_ticks > 0;
}

void Mover::run() {
    CharacterState& s = row.state;
    scratch.pushes.clear();
    const Real height = s.crouched != 0 ? row.def.crouch_height : row.def.height;
    space.set_height(height);
    // Reads the present conveyor speed, since a command may have changed it.
    const std::uint32_t ground = w.row_of(s.ground_shape);
    Real belt{};
    if (ground != Model::dead) belt = length(w.traits_of(w.state.rows(w.m.shape)[ground]).surface_velocity);
    const Real speed = length(s.velocity) + length(row.input.velocity) + length(s.ground_velocity) + belt +
                       row.def.jump_speed + row.def.gravity / Real(rate);
    space.collect(feet, speed / Real(rate) + row.def.step_height + row.def.step_down +
                            (row.def.height - height) + scratch.motion_max + 0.5_r);
    ride();
    unstick();
    change_posture();
    start_jump();
    if (s.ground == CharacterGround::walkable)
        walk();
    else
        fall();
    apply_pushes();
    finish();
}

Vec3 Mover::per_tick(Vec3 v) const {
    const auto one = [this](Real x) { return Real::from_raw(divide_shifted(x.raw, rate, 0)); };
    return {one(v.x), one(v.y), one(v.z)};
}

Vec3 Mover::approached(Vec3 v, Vec3 wanted, Real rate_of_change) const {
    const Vec3 change = wanted - v;
    const Real most = rate_of_change / Real(rate);
    return length(change) <= most ? wanted : v + scale<Real>(normalized(change), most);
}

Vec3 Mover::velocity_of(BodyId body, Vec3 point) const {
    const std::uint32_t at = w.row_of(body);
    const Velocity& v = w.state.rows(w.m.body_velocity)[at];
    const Vec3 arm = point - w.state.rows(w.m.body_pose)[at].position;
    return to<Real>(v.linear) + cross<Real>(v.angular, arm);
}

Vec3 Mover::belt_below() const {
    const BodyId ground = ground_body();
    if (!ground) return {};
    for (std::uint32_t i = 0; i < space.neighbours().size(); ++i) {
        const Neighbour& n = space.neighbour(i);
        if (n.body != ground || n.slot + 1 != row.state.ground_shape.index || !space.has_conveyor(n))
            continue;
        SpaceHit hit{i, {}, {}, row.state.ground_normal, 0};
        const bool has_pieces = n.solid->mesh != nullptr || n.solid->height_field != nullptr;
        if (!has_pieces || (space.cast(feet, scale<Real>(up, skin * -2), hit) && hit.neighbour == i))
            return space.conveyor(hit);
    }
    return {};
}

BodyId Mover::ground_body() const {
    if (row.state.ground != CharacterGround::walkable) return {};
    return w.row_of(row.state.ground_body) == Model::dead ? BodyId{} : row.state.ground_body;
}

bool Mover::is_dynamic(BodyId body) const {
    return body && w.state.rows(w.m.body_info)[w.row_of(body)].kind == BodyKind::dynamic;
}

/// Moves with the ground and out of the way of moving bodies. Both motions stop at the rest of the world.
void Mover::ride() {
    const BodyId ground = ground_body();
    const bool moves = std::ranges::any_of(space.neighbours(),
                                           [&](const Neighbour& n) { return n.body == ground && n.moves; });
    if (moves) {
        const std::uint32_t body = w.row_of(ground);
        const Velocity& v = w.state.rows(w.m.body_velocity)[body];
        const Vec3 arm = feet - w.state.rows(w.m.body_pose)[body].position;
        const Quat turn = integrate_rotation(Quat::identity(), per_tick(to<Real>(v.angular)));
        carried = per_tick(to<Real>(v.linear)) + rotate(turn, arm) - arm;
        spin = dot<Real>(up, v.angular);
    }
    const Vec3 with_body = carried;
    belt_ridden = belt_below();
    carried += per_tick(belt_ridden);
    Vec3 away = carried;
    shove(away);
    slide(with_body, ground); // the character and its ground move together
    slide(carried - with_body, {});
    slide(away - carried, {});
}

/// Moves the character until other shapes stop it. Shapes of the body `ignored` do not stop it.
void Mover::slide(Vec3 way, BodyId ignored) {
    std::array<UnitVec3, 4> planes;
    for (std::size_t i = 0; i < planes.size() && way != Vec3{}; ++i) {
        SpaceHit hit{};
        Real part{};
        if (!space.advance(feet, way, hit, part, ignored)) return;
        planes[i] = hit.normal;
        way = clipped(way - way * part, std::span(planes).first(i + 1));
    }
}

/// Computes the correction that moves the character at least a skin away from all shapes. Returns false if no
/// correction is needed. Static bodies, which give way least, are processed last, so that they take precedence.
bool Mover::part_from_neighbours(Vec3& correction) {
    bool any = false;
    for (const BodyKind kind : {BodyKind::dynamic, BodyKind::kinematic, BodyKind::static_})
        space.for_each_contact(feet, skin, [&](const SpaceContact& c) {
            if (space.neighbour(c.neighbour).kind != kind) return;
            const Unit upward = dot<Unit>(c.normal, up);
            if (kind == BodyKind::dynamic && upward < -half(unit_one)) return; // body on the head
            const Real missing = skin - c.gap - dot<Real>(c.normal, correction);
            if (missing <= skin_slack) return;
            any = true;
            // Straight up from walkable ground: along the normal the character would creep downhill.
            correction += is_walkable(c.normal) ? scale<Real>(up, missing / to<Real>(upward))
                                                : scale<Real>(c.normal, missing);
        });
    return any;
}

void Mover::unstick() {
    constexpr int rounds = 6;
    row.state.squeezed = 0;
    for (int i = 0; i < rounds; ++i) {
        Vec3 correction{};
        if (!part_from_neighbours(correction)) return;
        SpaceHit hit{};
        Real part{};
        space.advance(feet, correction, hit, part);
    }
    space.for_each_contact(feet, Real{}, [&](const SpaceContact& c) {
        if (c.gap < -skin && space.neighbour(c.neighbour).kind != BodyKind::dynamic) row.state.squeezed = 1;
    });
}

/// Crouches at once. Stands up only if no shape is then nearer than the skin.
void Mover::change_posture() {
    const std::uint32_t wanted = row.input.crouch;
    if (wanted == row.state.crouched) return;
    const Real height = wanted != 0 ? row.def.crouch_height : row.def.height;
    space.set_height(height);
    if (wanted == 0) {
        bool has_room = true;
        space.for_each_contact(feet, skin, [&](const SpaceContact& c) {
            const bool is_above = dot<Unit>(c.normal, up) < Unit{} && c.gap < skin - skin_slack;
            if (is_above || c.gap < -skin) has_room = false;
        });
        if (!has_room) return space.set_height(row.def.crouch_height);
    }
    row.state.crouched = wanted;
    wake(w, row.body); // also wakes a body on its head
    set_capsule(w, placed, row, height);
}

void Mover::start_jump() {
    CharacterState& s = row.state;
    if (row.input.jump != 0 && s.jump_was_held == 0) s.jump_pending = row.def.jump_buffer_ticks + 1;
    s.jump_was_held = row.input.jump;
    if (s.jump_pending == 0) return;
    --s.jump_pending;
    const bool can =
        s.has_jumped == 0 && (s.ground == CharacterGround::walkable || s.air_ticks <= row.def.coyote_ticks);
    if (!can) return;
    if (s.ground == CharacterGround::walkable) leave_ground();
    const Real lifted = max(along(s.velocity), Real{}); // by a platform that moves up
    s.velocity = level(s.velocity) + scale<Real>(up, row.def.jump_speed + lifted);
    s.has_jumped = 1;
    s.jump_pending = 0;
    s.air_ticks = row.def.coyote_ticks;
}

namespace {
/// Clamps a velocity. Only spinning ground can cause such speeds.
Vec3 bounded(Vec3 v) {
    constexpr Real most = Real(4096);
    return {clamp(v.x, -most, most), clamp(v.y, -most, most), clamp(v.z, -most, most)};
}
} // namespace

/// Sets the body's velocity for this tick and its turn with the ground, and writes the character's state.
void Mover::finish() {
    CharacterState& s = row.state;
    if (s.ground == CharacterGround::walkable) {
        s.air_ticks = s.has_jumped = 0;
    } else {
        s.air_ticks = is_kept_up ? 0 : std::min(s.air_ticks + 1, 1u << 31);
        if (is_kept_up) s.has_jumped = 0;
    }
    s.velocity = bounded(s.velocity);
    s.ground_velocity = bounded(s.ground_velocity);
    const BodyId stands_on = ground_body();
    if (stands_on != stood_on)
        for (const BodyId body : {stands_on, stood_on})
            if (is_dynamic(body)) wake(w, body);
    if (is_dynamic(stands_on)) weigh();
    w.state.edit_row(w.m.character, index) = row;

    const Vec3 way = feet - begin;
    const Quat rotation = w.state.rows(w.m.body_pose)[w.row_of(row.body)].rotation;
    const UnitVec3 axis = to_rotation(rotation).y;
    const bool leans = dot<Unit>(axis, up) < unit_one - Unit::from_raw(16);
    const Velocity velocity{to<Speed>(way * Real(rate)), to<Speed>(scale<Real>(up, spin))};
    const bool moves = leans || velocity != Velocity{};
    const std::uint32_t body = moves ? wake(w, row.body) : w.row_of(row.body);
    if (w.state.rows(w.m.body_velocity)[body] != velocity)
        w.state.edit_row(w.m.body_velocity, body) = velocity;
    if (!leans) return;
    // Sets the body upright again after commands and rounding have tilted it.
    Transform& pose = w.state.edit_row(w.m.body_pose, body);
    pose.rotation = normalized(from_to(axis, up) * pose.rotation);
    pose.position = begin + rotate(pose.rotation, w.mass_of(body).center);
}

void move_characters(Model& w, PlacedShapes& placed, CharacterScratch& s, Tasks* tasks) {
    s.order_of_body.clear(), s.landings.clear();
    const std::uint32_t count = w.state.count(w.m.characters);
    if (count == 0) return;
    // Grows the tables once, and not for each pushed body. Movers keep no view of the state, because waking moves
    // rows.
    w.state.make_room({w.m.forces}, w.state.count(w.m.bodies));
    w.state.make_room({w.m.body_traits.table, w.m.shape_traits.table}, 4 * count);
    const std::span<const CharacterRow> rows = w.state.rows(w.m.character);
    update_bounds(w, placed, tasks);
    s.order_of_body.assign(w.state.count(w.m.body_slots), 0);
    for (std::uint32_t i = 0; i < rows.size(); ++i) s.order_of_body[rows[i].body.index - 1] = i + 1;
    Speed fastest{};
    for (const Velocity& v : w.state.rows(w.m.body_velocity).first(w.header().bodies_awake))
        fastest = max(fastest, length(v.linear));
    s.motion_max = min(to<Real>(fastest) / Real(w.state.rows(w.m.config)[0].tick_rate), Real(4));
    for (std::uint32_t i = 0; i < count; ++i) Mover(w, placed, s, i).run();
}

// ---- capsule -------------------------------------------------------------------------------------------------------

ShapeDef capsule_of(const CharacterDef& def, Real height) {
    ShapeDef shape;
    shape.geometry = capsule(def.radius, half(height) - def.radius);
    shape.local.position = {Real{}, half(height), Real{}};
    shape.category = def.category;
    shape.mask = def.mask;
    shape.group = def.group;
    shape.user_key = def.user_key;
    return shape;
}

void set_capsule(Model& w, PlacedShapes& placed, const CharacterRow& row, Real height) {
    const ShapeDef def = capsule_of(row.def, height);
    const std::uint32_t shape = w.row_of(row.shape);
    ShapeTraits traits = w.traits_of(w.state.rows(w.m.shape)[shape]);
    traits.geometry = def.geometry;
    traits.local = def.local;
    set_shape_traits(w, shape, traits);
    update_mass(w, placed, w.row_of(row.body));
}

bool is_characters_shape(const Model& w, ShapeId shape) {
    for (const CharacterRow& row : w.state.rows(w.m.character))
        if (row.shape == shape) return true;
    return false;
}

} // namespace lockstone::sim
