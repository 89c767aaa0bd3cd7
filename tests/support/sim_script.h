// Scenes with objects of all kinds: piles, compounds, sensors, fields, ids that are created and destroyed, commands of
// all kinds, game columns. The commands before a tick depend on the world and its tick only, so a restored world
// continues equally.
#pragma once

#include "support/sim_scenes.h"

namespace lockstone::test::scene {

struct Tally {
    std::uint64_t begun, ended;
    std::array<BodyId, 4> thrown;
};
template <class V> constexpr void describe(Tally& t, V&& v) {
    v("begun", t.begun), v("ended", t.ended), v("thrown", t.thrown);
}
struct Health {
    Real points;
    std::int16_t hits;
    std::uint16_t team;
    std::uint32_t last_tick;
};
template <class V> constexpr void describe(Health& h, V&& v) {
    v("points", h.points), v("hits", h.hits), v("team", h.team), v("last_tick", h.last_tick);
}
inline constexpr Column<Tally> tally_record{0};
inline constexpr Column<Health> health_column{1};

inline GameSchema script_schema() {
    GameSchema schema;
    schema.add_record<Tally>("game.tally");
    schema.add_body_column<Health>("game.health");
    return schema;
}

enum class Scenery { stack, pile, fields };
inline constexpr Scenery sceneries[] = {Scenery::stack, Scenery::pile, Scenery::fields};
inline const char* name_of(Scenery s) {
    return s == Scenery::stack ? "stack" : s == Scenery::pile ? "pile" : "fields";
}

/// Three kinds of shapes in turn, and a dumbbell of three shapes.
inline BodyId add_something(World& w, int i, const BodyDef& body) {
    const BodyId b = made(w.create_body(body));
    const Real bounce = real(0.1 * (i % 4));
    if (i % 4 == 0)
        made(w.create_shape(b, {.geometry = box(real(0.4), real(0.3), real(0.5)), .friction = Real(1)}));
    if (i % 4 == 1) made(w.create_shape(b, {.geometry = sphere(real(0.35)), .restitution = bounce}));
    if (i % 4 == 2)
        made(w.create_shape(b, {.geometry = capsule(real(0.2), real(0.3)), .density = Real(300)}));
    if (i % 4 == 3) {
        for (double end : {-0.4, 0.4})
            made(w.create_shape(b, {.geometry = sphere(real(0.25)), .local = at(end, 0.05, 0)}));
        made(w.create_shape(
            b, {.geometry = capsule(real(0.1), real(0.4)), .local = at(0, 0, 0, turned(axis_z, 90))}));
    }
    done(w.write(health_column, b, {real(100 - i), static_cast<std::int16_t>(-i), 7, 0}));
    return b;
}

inline World start_script(Scenery scenery, Integrator integrator = Integrator::semi_implicit_euler) {
    WorldDef def = drowsy_def();
    def.bodies_max = 48, def.shapes_max = 96;
    def.integrator = integrator;
    World w = made(World::create(def, script_schema()));
    if (scenery == Scenery::fields) {
        done(w.set_gravity({}));
        made(w.create_field({.center = vec(0, 3, 0), .strength = Real(30), .softening = Real(1)}));
        made(w.create_field({.kind = FieldKind::spring, .center = vec(0, 2, 0), .strength = real(0.5)}));
        for (int i = 0; i < 16; ++i)
            add_something(w, i,
                          {.pose = at(i % 4 - 1.5, 1 + 1.1 * (i / 4), i % 3 - 1, turned(axis_x, 20 * i)),
                           .angular_velocity = vec(1, i % 3, 0)});
        return w;
    }
    add_floor(w);
    if (scenery == Scenery::stack) add_stack(w, 6);
    const int loose = scenery == Scenery::pile ? 20 : 4;
    for (double side : {-2.2, 2.2}) {
        add_wall(w, at(side, 1, 0), vec(0.3, 2, 2.5));
        add_wall(w, at(0, 1, side), vec(2.5, 2, 0.3));
    }
    for (int i = 0; i < loose; ++i)
        add_something(
            w, i,
            {.pose = at(1.3 - 0.6 * (i % 3), 1 + 0.7 * i, 0.9 - 0.5 * (i % 4), turned(axis_z, 31 * i)),
             .linear_damping = real(0.05 * (i % 2))});
    const BodyId gate = made(w.create_body({.kind = BodyKind::static_, .pose = at(0.5, 1, 0.5)}));
    made(w.create_shape(gate, {.geometry = box(real(0.8), real(0.5), real(0.8)), .sensor = 1}));
    add(w, {.kind = BodyKind::kinematic, .pose = at(0, 0.4, -1.2), .angular_velocity = vec(0, 2, 0)},
        {.geometry = box(real(0.7), real(0.2), real(0.1))});
    return w;
}

namespace detail {
/// The first dynamic body at or after a row; null: none.
inline BodyId dynamic_from(const World& w, std::uint64_t start) {
    for (std::uint32_t i = 0; i < w.body_count(); ++i) {
        const BodyId b = w.body_at(static_cast<std::uint32_t>((start + i) % w.body_count()));
        if (w.kind(b) == BodyKind::dynamic) return b;
    }
    return {};
}

inline void throw_one(World& w, std::uint64_t tick, Tally& tally) {
    BodyId& slot = tally.thrown[tick / 9 % tally.thrown.size()];
    if (w.is_alive(slot)) done(w.destroy(slot));
    const int i = static_cast<int>(tick % 1000);
    slot = add_something(w, i / 3,
                         {.pose = at(0.3 * (i % 5) - 0.6, 4.5, 0.2 * (i % 7) - 0.6, turned(axis_y, 7 * i)),
                          .linear_velocity = vec(1 - i % 3, -4, 0.5 * (i % 2))});
}

inline void command_one(World& w, std::uint64_t tick, BodyId b) {
    switch (tick % 23) {
    case 2:
        done(w.add_force(b, vec(900, 2000, -300), vec(10, 0, 30)));
        break;
    case 5:
        done(w.add_impulse(b, vec(0, 300, 100), vec(5, 5, 5)));
        break;
    case 8:
        done(w.set_body_parameters({b, real(0.1), real(0.2), real(1.1), lock_angular_y, 1, 0}));
        break;
    case 9:
        done(w.add_impulse_at(b, vec(40, 0, 0), w.center_of_mass(b) + vec(0, 0.2, 0.1)));
        break;
    case 13:
        done(w.set_velocity(b, vec(1, 3, -1), vec(4, 0, 2)));
        break;
    case 15:
        done(w.set_body_parameters({b, {}, {}, Real(1), 0, 0, 1}));
        break;
    case 17:
        done(w.add_force_at(b, vec(0, 3000, 0), w.center_of_mass(b) + vec(0.3, 0, 0)));
        break;
    case 19:
        done(w.set_pose(b, at(0.1, 5, 0.1, turned(axis_x, 33))));
        break;
    case 21:
        done(w.set_material({w.shapes(b).front(), real(0.3), real(0.4), real(0.02), vec(0.5, 0, 0)}));
        break;
    default:
        break;
    }
}
} // namespace detail

/// Applies the script's commands before the next tick, then the tick, then the game's reaction to its events.
inline void step_script(World& w) {
    const std::uint64_t tick = w.tick_count();
    Tally tally = w.read(tally_record);
    if (tick % 9 == 4) detail::throw_one(w, tick, tally);
    if (const BodyId b = detail::dynamic_from(w, tick * 7)) detail::command_one(w, tick, b);
    if (tick % 61 == 30) {
        const std::vector<ShapeId> shapes = w.shapes(detail::dynamic_from(w, tick));
        if (shapes.size() > 1) done(w.destroy(shapes[1]));
    }
    if (tick % 47 == 11) done(w.set_gravity(vec(0.5, tick % 2 == 0 ? -9.81 : -6, 0)));
    if (tick % 53 == 20) done(w.destroy(made(w.create_field({.center = vec(1, 1, 1), .strength = Real(5)}))));
    w.tick();
    for (const Event& e : w.events()) {
        const bool begin = e.kind == EventKind::contact_begin || e.kind == EventKind::sensor_begin;
        ++(begin ? tally.begun : tally.ended);
        if (!begin || !w.is_alive(e.body_a)) continue;
        Health health = w.read(health_column, e.body_a);
        health.points -= to<Real>(e.approach_speed), ++health.hits;
        health.last_tick = static_cast<std::uint32_t>(tick);
        done(w.write(health_column, e.body_a, health));
    }
    done(w.write(tally_record, tally));
}

} // namespace lockstone::test::scene
