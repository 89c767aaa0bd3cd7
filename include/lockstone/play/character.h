// Characters: upright capsules that walk, climb steps, ride platforms, push, crouch and jump. A game sets the
// input, the tick moves them.
//
//   CharacterDef def;
//   def.position = {0_r, 0_r, 0_r};                                     of the feet
//   CharacterId hero = world.create_character(def).value();
//   world.set_character_input(hero, {.velocity = {3_r, 0_r, 0_r}, .jump = 1});
//   world.tick();
//   CharacterState state = world.character_state(hero);                 ground, velocity, flags
//
// A character is a kinematic body with one capsule. At the start of each tick the mover computes its path and
// sets the velocity of the body accordingly. CharacterState is part of the world's state.
//
//   walking    horizontal speed is equal uphill and downhill; ground steeper than slope_max cannot be climbed
//   steps      it walks up edges up to step_height, and down to ground at most step_down below
//   platforms  it moves with its ground, with rotation and surface_velocity, and keeps this velocity when it
//              leaves
//   pushing    it pushes dynamic bodies beside it with at most push_force, and stops bodies that hit it as a
//              body of `mass` does; its weight acts on its ground. Bodies on its head have ordinary contacts
//   crouching  the feet remain in place; it stands up as soon as there is space
//   filters    category, mask, group and pair filters apply; sensors detect it and do not stop it
//   others     characters are obstacles to each other; they move in row order
#pragma once

#include "lockstone/ids.h"
#include "lockstone/row.h"

#include <cstdint>

namespace lockstone {

inline constexpr Real character_speed_max = Real(100); ///< limit of CharacterInput::velocity [m/s]

/// Definition of a character. World::create_character() checks the ranges.
struct CharacterDef {
    Vec3 position{};                       ///< of the feet, world [m], within 1e9 on each axis
    UnitVec3 up{Unit{}, unit_one, Unit{}}; ///< up direction, of unit length; constant
    std::uint32_t category = 1;            ///< ShapeDef::category of its capsule
    std::uint32_t mask = 0xffffffffu;      ///< ShapeDef::mask of its capsule
    std::int32_t group = 0;                ///< ShapeDef::group of its capsule
    /// Number of ticks after walking off an edge in which it can still jump, 0..1000.
    std::uint32_t coyote_ticks = 6;
    std::uint32_t jump_buffer_ticks = 6;   ///< ticks for which an early press of jump is stored, 0..1000
    Real radius = 0.3_r;                   ///< of the capsule [m], 0.05..10
    Real height = 1.8_r;                   ///< of the whole capsule [m], 2 radius + 0.01 .. 50
    Real crouch_height = 1_r;              ///< height when crouched [m], 2 radius + 0.01 .. height
    Real slope_max = 0.8726646259971648_r; ///< steepest walkable ground [rad], 0..1.3; default: 50 degrees
    Real step_height = 0.35_r;             ///< highest step up [m], 0..10
    Real step_down = 0.35_r;               ///< deepest step down [m], 0..10
    Real mass = Real(80);                  ///< for its weight and for bodies that hit it [kg], 0.001..1e6
    Real push_force = Real(500);           ///< maximum force on bodies beside it [N], 0..1e8
    Real gravity = 9.81_r;                 ///< along -up [m/s^2], 0..1000; the world's gravity has no effect
    Real fall_speed_max = Real(60);        ///< [m/s], 0.1..400
    Real jump_speed = Real(5);             ///< speed of a jump along up [m/s], 0..100
    Real acceleration = Real(60);          ///< towards the input velocity, on the ground [m/s^2], 0..1e6
    Real air_acceleration = Real(15);      ///< towards the input velocity, in the air [m/s^2], 0..1e6
    std::uint64_t user_key = 0;            ///< of its body and shape
};

/// Input of a character. It applies until the next World::set_character_input().
struct CharacterInput {
    Vec3 velocity{};          ///< desired velocity [m/s], at most 100 long; the part along `up` is ignored
    std::uint32_t jump = 0;   ///< 1: the button is held; each press gives one jump
    std::uint32_t crouch = 0; ///< 1: crouch
};

/// Ground of a character.
enum class CharacterGround : std::uint32_t {
    none,     ///< in the air
    steep,    ///< slides on ground steeper than slope_max
    walkable, ///< stands or walks
};

/// State of a character after a tick.
struct CharacterState {
    Vec3 velocity;               ///< [m/s], relative to its ground if that is walkable, else to the world
    Vec3 ground_velocity;        ///< of the ground's surface below it [m/s]
    BodyId ground_body;          ///< null in the air
    ShapeId ground_shape;        ///< null in the air
    UnitVec3 ground_normal;      ///< zero in the air
    CharacterGround ground;      ///< none, steep or walkable
    std::uint32_t crouched;      ///< 1: crouched
    std::uint32_t squeezed;      ///< 1: it overlaps a shape and could not be moved out
    std::uint32_t air_ticks;     ///< ticks since it last stood, at most 2^31
    std::uint32_t jump_pending;  ///< remaining ticks of a stored jump press
    std::uint32_t jump_was_held; ///< 1: jump was held in the last tick
    std::uint32_t has_jumped;    ///< 1: it has jumped since it last stood
};

/// Field list with ranges; see lockstone/row.h.
///@{
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
///@}

} // namespace lockstone
