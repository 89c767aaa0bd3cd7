// Characters: upright capsules that walk, climb steps, ride, push, crouch and jump. The world moves them; a game says
// where they want to go.
//
//   CharacterDef def;
//   def.position = {0_r, 0_r, 0_r};                                     where its feet are
//   CharacterId hero = world.create_character(def).value();
//   world.set_character_input(hero, {.velocity = {3_r, 0_r, 0_r}, .jump = 1});
//   world.tick();
//   CharacterState state = world.character_state(hero);                 on what it stands, how fast it goes
//
// A character is a kinematic body with one capsule, whose velocity the mover sets at the beginning of each tick so that
// the body ends where the character goes. All that the mover remembers is CharacterState, a row of the world's state.
//
//   walking      horizontal speed is kept uphill and downhill; steeper ground than slope_max cannot be climbed
//   steps        edges up to step_height are walked up, ground up to step_down below is walked down to
//   platforms    its ground carries it along, turning and conveyors (surface_velocity) included; a character that leaves it
//                keeps its velocity
//   pushing      dynamic bodies beside it are pushed with at most push_force, what hits it is stopped as if it had
//                `mass`; it weighs on what it stands on. What lies on its head is held by ordinary contacts.
//   crouching    the feet stay; it stands up where there is room
//   filters      category, mask, group and pair filters of its shape, as with any pair; sensors see it and let it pass
//   others       characters are obstacles to each other, moved one after the other in the order of their rows
#pragma once

#include "lockstone/ids.h"
#include "lockstone/row.h"

#include <cstdint>

namespace lockstone {

inline constexpr Real character_speed_max = Real(100); ///< [m/s]: of CharacterInput::velocity

struct CharacterDef {
    Vec3 position{}; ///< of the feet [m]
    UnitVec3 up{Unit{}, unit_one, Unit{}};
    std::uint32_t category = 1; ///< of its shape, as are mask and group; see ShapeDef
    std::uint32_t mask = 0xffffffffu;
    std::int32_t group = 0;
    std::uint32_t coyote_ticks = 6; ///< how long after walking off an edge it can still jump, at most 1000
    std::uint32_t jump_buffer_ticks = 6;   ///< how long a jump pressed too early is kept, at most 1000
    Real radius = 0.3_r;                   ///< [m], 0.05..10
    Real height = 1.8_r;                   ///< [m], 2 radius + 0.01..50
    Real crouch_height = 1_r;              ///< [m], 2 radius + 0.01..height
    Real slope_max = 0.8726646259971648_r; ///< 50 degrees [rad], 0..1.3
    Real step_height = 0.35_r;             ///< [m], 0..10
    Real step_down = 0.35_r;               ///< [m], 0..10
    Real mass = Real(80);        ///< [kg], 0.001..1e6: its weight, and its inertia against bodies that hit it
    Real push_force = Real(500); ///< [N], 0..1e8
    Real gravity = 9.81_r;       ///< [m/s^2] along -up, 0..1000; the world's is not used
    Real fall_speed_max = Real(60);   ///< [m/s], 0.1..400
    Real jump_speed = Real(5);        ///< [m/s], 0..100
    Real acceleration = Real(60);     ///< on the ground, to the wanted velocity [m/s^2], 0..1e6
    Real air_acceleration = Real(15); ///< [m/s^2], 0..1e6
    std::uint64_t user_key = 0;       ///< of its body and shape
};

/// What the character is to do until another input comes.
struct CharacterInput {
    Vec3 velocity{};          ///< wanted [m/s], at most 100 long; what is along `up` is left out
    std::uint32_t jump = 0;   ///< 1: the button is held; a jump needs it pressed anew
    std::uint32_t crouch = 0; ///< 1: held
};

enum class CharacterGround : std::uint32_t {
    none,     ///< in the air
    steep,    ///< slides down something too steep to stand on
    walkable, ///< stands or walks
};

struct CharacterState {
    Vec3 velocity;        ///< [m/s]: against its ground while that is walkable, else against the world
    Vec3 ground_velocity; ///< of the ground's surface where it stands [m/s]
    BodyId ground_body;   ///< null in the air, like the rest of the ground's
    ShapeId ground_shape;
    UnitVec3 ground_normal;
    CharacterGround ground;
    std::uint32_t crouched;      ///< 0 or 1
    std::uint32_t squeezed;      ///< 1: it overlaps something that it could not get out of
    std::uint32_t air_ticks;     ///< since it last stood, stops at 2^31
    std::uint32_t jump_pending;  ///< ticks for which a jump that was pressed still counts
    std::uint32_t jump_was_held; ///< 1: by the input of the last tick
    std::uint32_t has_jumped;    ///< 1: since it last stood
};

template <class V> constexpr void describe(CharacterDef& d, V&& v) {
    field(v, "position", d.position, EachIn{Real(1000000000), "m"});
    field(v, "up", d.up, UnitLong{});
    v("category", d.category), v("mask", d.mask), v("group", d.group);
    field(v, "coyote_ticks", d.coyote_ticks, in(0, 1000));
    field(v, "jump_buffer_ticks", d.jump_buffer_ticks, in(0, 1000));
    field(v, "radius", d.radius, in(0.05_r, 10_r, " m"));
    v("height", d.height), v("crouch_height", d.crouch_height);
    field(v, "slope_max", d.slope_max, in(0_r, 1.3_r, " rad"));
    field(v, "step_height", d.step_height, in(0_r, 10_r, " m"));
    field(v, "step_down", d.step_down, in(0_r, 10_r, " m"));
    field(v, "mass", d.mass, in(0.001_r, 1000000_r, " kg"));
    field(v, "push_force", d.push_force, in(0_r, 100000000_r, " N"));
    field(v, "gravity", d.gravity, in(0_r, 1000_r, " m/s^2"));
    field(v, "fall_speed_max", d.fall_speed_max, in(0.1_r, 400_r, " m/s"));
    field(v, "jump_speed", d.jump_speed, in(0_r, 100_r, " m/s"));
    field(v, "acceleration", d.acceleration, in(0_r, 1000000_r, " m/s^2"));
    field(v, "air_acceleration", d.air_acceleration, in(0_r, 1000000_r, " m/s^2"));
    v("user_key", d.user_key);
}
template <class V> constexpr void describe(CharacterInput& i, V&& v) {
    field(v, "velocity", i.velocity, LongAtMost{character_speed_max, "100 m/s"});
    field(v, "jump", i.jump, no_or_yes);
    field(v, "crouch", i.crouch, no_or_yes);
}
template <class V> constexpr void describe(CharacterState& s, V&& v) {
    v("velocity", s.velocity), v("ground_velocity", s.ground_velocity), v("ground_body", s.ground_body);
    v("ground_shape", s.ground_shape), v("ground_normal", s.ground_normal), v("ground", s.ground);
    v("crouched", s.crouched), v("squeezed", s.squeezed), v("air_ticks", s.air_ticks);
    v("jump_pending", s.jump_pending), v("jump_was_held", s.jump_was_held), v("has_jumped", s.has_jumped);
}

} // namespace lockstone
